#include "firmware_models/rzt1/settings.h"

#include <algorithm>
#include <cstddef>

namespace virtdrive::rzt1 {
namespace {

// What the successor's published example keeps, and beyond it PIOFFS, gear, PVT, PORIGIN and the
// interlocks' limits.
constexpr SavedSetting kSaved[] = {
    {"TYPE", 60, &Settings::type},
    {"ETYPE", 117, &Settings::etype},
    {"HTYPE", 61, &Settings::htype},
    {"HINVERT", 50, &Settings::hinvert},
    {"HSHIFT", 51, &Settings::hshift},
    {"PCMODE", 31, &Settings::pcmode},
    {"ASTOP", 25, &Settings::astop},
    {"SIM", 76, &Settings::sim},
    {"PCT", 47, &Settings::pct},
    {"PINVERT", 114, &Settings::pinvert},
    {"PRO", 13, &Settings::pro},
    {"BRAKE", 72, &Settings::brake},
    {"PHASES", 71, &Settings::phases},
    {"PPAIRS", 33, &Settings::pole_pairs},
    {"PMAP", 29, &Settings::pmap},
    {"ECPR", 35, &Settings::ecpr},
    {"PCOUNTS", 34, &Settings::pcounts},
    {"ACC", 9, &Settings::acc},
    {"DEC", 10, &Settings::dec},
    {"AJERK", 11, &Settings::ajerk},
    {"DJERK", 12, &Settings::djerk},
    {"INVERT", 49, &Settings::invert},
    {"HMASK", 48, &Settings::hmask},
    {"HOFFS", 62, &Settings::hoffs},
    {"EMASK", 53, &Settings::emask},
    {"DATA0", 63, &Settings::data0},
    {"DATA1", 64, &Settings::data1},
    {"DATA2", 65, &Settings::data2},
    {"DATA3", 66, &Settings::data3},
    {"DATA4", 67, &Settings::data4},
    {"DATA5", 68, &Settings::data5},
    {"DATA6", 69, &Settings::data6},
    {"DATA7", 70, &Settings::data7},
    {"PLIMIT", 109, &Settings::plimit},
    {"PTIME", 110, &Settings::ptime},
    {"CLIMIT", 40, &Settings::climit},
    {"CTIME", 41, &Settings::ctime},
    {"MAX", 20, &Settings::max_error},
    {"ETIME", 21, &Settings::etime},
    {"DS", 22, &Settings::ds},
    {"BIAS", 24, &Settings::bias},
    {"KP", 14, &Settings::kp},
    {"KI", 15, &Settings::ki},
    {"KD", 16, &Settings::kd},
    {"VFF", 18, &Settings::vff},
    {"AFF", 19, &Settings::aff},
    {"IL", 17, &Settings::il},
    {"MLIMIT", 23, &Settings::mlimit},
    {"QKP", 45, &Settings::qkp},
    {"QKI", 46, &Settings::qki},
    {"QKD", 127, &Settings::qkd},
    {"PIMODE", 26, &Settings::pimode},
    {"PITIME", 27, &Settings::pitime},
    {"PIOUT", 28, &Settings::piout},
    {"PIOFFS", 36, &Settings::pioffs},
    {"PADV", 38, &Settings::padv},
    {"VCOMP", 39, &Settings::vcomp},
    {"EBAUDRATE", 121, &Settings::ebaudrate},
    {"ADDR", 123, &Settings::address},
    {"GROUP", 124, &Settings::group},
    {"VKP", 128, &Settings::vkp},
    {"VKI", 129, &Settings::vki},
    {"VKD", 130, &Settings::vkd},
    {"GEARIN", 111, &Settings::gear_in},
    {"GEAROUT", 112, &Settings::gear_out},
    {"ITIME", 7, &Settings::itime},
    {"WMARK", 126, &Settings::wmark},
    {"PORIGIN", 30, &Settings::porigin},
    {"ELVOLT", 131, &Settings::elvolt},
    {"EHVOLT", 132, &Settings::ehvolt},
    {"EWPOSMIN", 133, &Settings::ewposmin},
    {"EWPOSMAX", 134, &Settings::ewposmax},
    {"EOVS", 135, &Settings::eovs},
    {"EWOVS", 136, &Settings::ewovs},
    {"EEMP", 137, &Settings::eemp},
    {"EOVTEMP", 138, &Settings::eovtemp},
    {"ERRMASK", 139, &Settings::errmask},
    {"EOVC", 143, &Settings::eovc},
};

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kRow = 5;  // id, value
constexpr std::size_t kSum = 4;

void put(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

std::uint32_t get(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  return value;
}

// CRC-32 (ISO-HDLC), bit by bit: a block is written once in a while.
std::uint32_t crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t rest = 0xFFFFFFFF;
  for (const std::uint8_t byte : bytes) {
    rest ^= byte;
    for (int i = 0; i < 8; ++i) rest = rest >> 1 ^ ((rest & 1) != 0 ? 0xEDB88320U : 0);
  }
  return ~rest;
}

}  // namespace

Settings factory_settings(int axis) {
  return {.address = axis};
}

std::span<const SavedSetting> saved_settings() {
  return kSaved;
}

std::vector<std::uint8_t> pack(const Settings& settings) {
  std::vector<std::uint8_t> block{kVersion};
  for (const SavedSetting& saved : kSaved) {
    block.push_back(static_cast<std::uint8_t>(saved.id));
    put(block, static_cast<std::uint32_t>(settings.*saved.member));
  }
  put(block, crc(block));
  return block;
}

bool unpack(std::span<const std::uint8_t> block, Settings& settings) {
  if (block.size() < 1 + kSum || block[0] != kVersion) return false;
  const std::span rows = block.subspan(1, block.size() - 1 - kSum);
  if (rows.size() % kRow != 0) return false;
  if (crc(block.first(block.size() - kSum)) != get(block.last(kSum))) return false;
  for (std::size_t at = 0; at < rows.size(); at += kRow) {
    const auto* const saved =
        std::ranges::find(kSaved, static_cast<int>(rows[at]), &SavedSetting::id);
    if (saved == std::end(kSaved)) continue;
    settings.*saved->member = static_cast<std::int32_t>(get(rows.subspan(at + 1)));
  }
  return true;
}

}  // namespace virtdrive::rzt1
