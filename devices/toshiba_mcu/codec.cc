#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {
namespace {

constexpr std::array<std::uint8_t, 256> make_crc_table() {
  std::array<std::uint8_t, 256> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80) != 0 ? (crc << 1) ^ 0x107 : crc << 1;
    table[i] = static_cast<std::uint8_t>(crc);
  }
  return table;
}

constexpr auto kCrcTable = make_crc_table();
constexpr std::size_t kHeader = 2;   // BOT, command
constexpr std::size_t kTrailer = 2;  // CRC, EOT

std::vector<std::uint8_t> encode(std::uint16_t command, std::span<const Field> fields,
                                 const protocol::Values& values) {
  const auto code = static_cast<std::uint8_t>(command);
  std::vector<std::uint8_t> bytes = {kBot, code};
  protocol::pack(fields, kTable.framing.order, values, bytes);
  bytes.push_back(crc8(code, std::span(bytes).subspan(kHeader)));
  bytes.push_back(kEot);
  return bytes;
}

}  // namespace

std::uint8_t crc8(std::uint8_t start, std::span<const std::uint8_t> payload) {
  std::uint8_t crc = start;
  for (const std::uint8_t byte : payload) crc = kCrcTable[crc ^ byte];
  return crc;
}

std::vector<std::uint8_t> encode_request(const CommandRow& row, const protocol::Values& values) {
  return encode(row.code, row.request, values);
}

std::vector<std::uint8_t> encode_reply(const CommandRow& row, const protocol::Values& values) {
  return encode(row.code, row.reply, values);
}

std::span<const Field> Decoder::fields() const {
  return direction_ == Direction::kRequest ? row_->request : row_->reply;
}

void Decoder::reset() {
  row_ = nullptr;
  started_ = false;
}

Decoder::Event Decoder::push(std::uint8_t byte) {
  if (!started_) {
    if (byte != kBot) return Event::kNoise;
    started_ = true;
    buffer_[0] = byte;
    size_ = 1;
    return Event::kNone;
  }
  buffer_[size_++] = byte;
  if (row_ == nullptr) {
    const bool error = direction_ == Direction::kReply && byte == kErrorTelegram;
    row_ = error ? &kErrorReply : protocol::find(kTable.commands, byte);
    if (row_ != nullptr) return Event::kNone;
    reset();
    return Event::kUnknownCommand;
  }
  const std::size_t payload = protocol::width(fields());
  if (size_ < kHeader + payload + kTrailer) return Event::kNone;

  const auto data = std::span(buffer_).subspan(kHeader, payload);
  telegram_ = {row_, protocol::unpack(fields(), kTable.framing.order, data)};
  const bool crc_fits = crc8(buffer_[1], data) == buffer_[kHeader + payload];
  reset();
  if (byte != kEot) return Event::kBadEnd;
  return crc_fits ? Event::kTelegram : Event::kBadCrc;
}

}  // namespace virtdrive::toshiba_mcu
