#include "scenarios/recording/wire_file.h"

#include <algorithm>
#include <concepts>
#include <fmt/format.h>

#include "core/check.h"
#include "scenarios/recording/wire_format.h"

namespace virtdrive {
namespace {

using namespace wire_format;
using protocol::Direction;
using protocol::Verdict;

std::int64_t nanoseconds(SimTime time) {
  return time.time_since_epoch().count();
}

// Little-endian, whatever the machine.
template <std::unsigned_integral Number>
std::string encoded(Number value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes += static_cast<char>(static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i)));
  }
  return bytes;
}

// A block under way.
class Block {
 public:
  explicit Block(std::uint32_t type) { number(type).number(std::uint32_t{0}); }

  template <std::unsigned_integral Number>
  Block& number(Number value) {
    bytes_ += encoded(value);
    return *this;
  }
  Block& time(SimTime time) { return number(static_cast<std::uint64_t>(nanoseconds(time))); }
  Block& raw(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  Block& raw(std::span<const std::uint8_t> bytes) {
    bytes_.append(bytes.begin(), bytes.end());
    return *this;
  }
  Block& pad() {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return *this;
  }
  Block& option(std::uint16_t code, std::string_view value) {
    VIRTDRIVE_CHECK(value.size() <= 0xFFFF, "an option of {} bytes", value.size());
    return number(code).number(static_cast<std::uint16_t>(value.size())).raw(value).pad();
  }
  Block& end_of_options() { return number(kEndOfOptions).number(std::uint16_t{0}); }

  /// The whole block; its length stands at both ends.
  std::string end() {
    pad();
    const auto length = static_cast<std::uint32_t>(bytes_.size() + 4);
    for (std::size_t i = 0; i < 4; ++i) bytes_[4 + i] = static_cast<char>(length >> (8 * i));
    number(length);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

std::string section(std::string_view bench) {
  if (bench.size() > 0xFFFF) {
    throw SetupError("--wire: the bench has too many settings for a recording; use fewer --set");
  }
  constexpr auto kUnknownLength = ~std::uint64_t{0};
  return Block(kSection)
      .number(kByteOrderMagic)
      .number(std::uint16_t{1})
      .number(std::uint16_t{0})
      .number(kUnknownLength)
      .option(kComment, bench)
      .option(kApplication, "virtdrive")
      .end_of_options()
      .end();
}

std::string interface(const RecordedLine& line) {
  return Block(kInterface)
      .number(kLinkType)
      .number(std::uint16_t{0})
      .number(std::uint32_t{0})  // no limit to a packet's length
      .option(kInterfaceName, line.name)
      .option(kInterfaceDescription, line.protocol)
      .option(kInterfaceSpeed, encoded(static_cast<std::uint64_t>(line.baud)))
      .option(kTimeResolution, "\x09")  // 10^-9 s
      .end_of_options()
      .end();
}

std::uint32_t error_flags(Verdict verdict) {
  switch (verdict) {
    case Verdict::kFrame:
      return 0;
    case Verdict::kBadChecksum:
      return kCrcError;
    case Verdict::kMalformed:
      return kUnaligned;
    case Verdict::kNoise:
      return kStartError;
    case Verdict::kCutShort:
      return kTooShort;
  }
  return 0;
}

// LEB128: seven bits a byte, the lowest first, bit 7 set in all but the last.
void append_number(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7)
    out += static_cast<char>(static_cast<std::uint8_t>(value | 0x80));
  out += static_cast<char>(value);
}

// The last byte's last bit, then the steps from bit to bit.
std::string byte_times(std::span<const WireByte> bytes) {
  std::string value = encoded(static_cast<std::uint64_t>(nanoseconds(bytes.back().end)));
  SimTime before = bytes.front().begin;
  for (const WireByte& byte : bytes) {
    append_number(value, static_cast<std::uint64_t>((byte.end - before).count()));
    before = byte.end;
  }
  return value;
}

std::string comment(const WirePacket& packet) {
  std::string text(packet.text);
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '.';
  }
  return fmt::format("{} ({:.6f} ... {:.6f} s)", text, seconds(packet.bytes.front().begin),
                     seconds(packet.bytes.back().end));
}

Block host_block(std::uint32_t type, std::size_t line, HostInstant when) {
  Block block(type);
  block.number(static_cast<std::uint32_t>(line))
      .number(when.before_events ? kBeforeEvents : std::uint32_t{0})
      .time(when.time);
  return block;
}

std::uint8_t parity_code(std::optional<Parity> parity) {
  return parity ? static_cast<std::uint8_t>(1 + static_cast<int>(*parity)) : std::uint8_t{0};
}

}  // namespace

WireFile::WireFile(const std::string& path, std::string_view bench,
                   const std::vector<RecordedLine>& lines, const std::vector<RecordedFile>& files)
    : file_("--wire", path) {
  write(section(bench));
  for (const RecordedLine& line : lines) write(interface(line));
  for (const RecordedFile& file : files) {
    write(Block(kFile)
              .number(static_cast<std::uint32_t>(file.drive))
              .number(static_cast<std::uint32_t>(file.role))
              .number(static_cast<std::uint32_t>(file.content.size()))
              .raw(file.content)
              .end());
  }
}

void WireFile::host_settings(std::size_t line, HostInstant when, const HostSettings& settings) {
  write(host_block(kHostSettings, line, when)
            .number(static_cast<std::uint32_t>(settings.baud))
            .number(static_cast<std::uint8_t>(settings.data_bits))
            .number(parity_code(settings.parity))
            .number(static_cast<std::uint8_t>(settings.stop_bits))
            .end());
}

void WireFile::host_write(std::size_t line, HostInstant when, std::span<const std::uint8_t> bytes) {
  write(host_block(kHostWrite, line, when)
            .number(static_cast<std::uint32_t>(bytes.size()))
            .raw(bytes)
            .end());
}

void WireFile::packet(std::size_t line, const WirePacket& packet) {
  const auto first = static_cast<std::uint64_t>(nanoseconds(packet.bytes.front().begin));
  const auto size = static_cast<std::uint32_t>(packet.bytes.size());
  Block block(kPacket);
  block.number(static_cast<std::uint32_t>(line))
      .number(static_cast<std::uint32_t>(first >> 32))
      .number(static_cast<std::uint32_t>(first))
      .number(size)
      .number(size);
  for (const WireByte& byte : packet.bytes) block.number(byte.byte);
  const std::uint32_t direction = packet.direction == Direction::kRequest ? kInbound : kOutbound;
  const bool garbled = std::ranges::any_of(
      packet.bytes, [](const WireByte& byte) { return byte.error || byte.collided; });
  const std::uint32_t errors = error_flags(packet.verdict) | (garbled ? kSymbolError : 0U);
  write(block.pad()
            .option(kComment, comment(packet))
            .option(kPacketFlags, encoded(direction | errors))
            .option(kByteTimes, byte_times(packet.bytes))
            .end_of_options()
            .end());
}

void WireFile::close(SimTime end) {
  write(Block(kEnd).time(end).end());
  file_.close();
}

void WireFile::write(std::string_view block) {
  file_.write(block);
  file_.flush();
}

}  // namespace virtdrive
