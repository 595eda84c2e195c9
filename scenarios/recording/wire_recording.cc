#include "scenarios/recording/wire_recording.h"

#include <algorithm>
#include <cerrno>
#include <concepts>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

#include "core/check.h"
#include "pty/file_descriptor.h"
#include "scenarios/recording/wire_format.h"

namespace virtdrive {
namespace {

using namespace wire_format;
using protocol::Direction;

constexpr std::size_t kLongestFile = std::size_t{1} << 30;
constexpr std::string_view kStandardInput = "-";
constexpr std::size_t kBlockFrame = 12;  // type, length, length
constexpr std::int64_t kHighestHostBaud = 100'000'000;

// Takes numbers off the front of a piece of the file; every complaint names file and offset.
class Cursor {
 public:
  Cursor(std::string_view name, std::span<const std::uint8_t> bytes, std::size_t offset)
      : name_(name), bytes_(bytes), offset_(offset) {}

  std::size_t left() const { return bytes_.size(); }

  std::span<const std::uint8_t> take(std::size_t count) {
    if (count > bytes_.size()) {
      fail(fmt::format("{} bytes are wanted where {} are left", count, bytes_.size()));
    }
    const auto taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    offset_ += count;
    return taken;
  }
  Cursor part(std::size_t count) {
    const std::size_t at = offset_;
    return {name_, take(count), at};
  }
  /// Leaves out what fills up `size` bytes to a multiple of four.
  void skip_padding(std::size_t size) { take((4 - size % 4) % 4); }

  template <std::unsigned_integral Number>
  Number number() {
    std::uint64_t value = 0;
    const auto bytes = take(sizeof(Number));
    for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint64_t{bytes[i]} << (8 * i);
    return static_cast<Number>(value);
  }
  template <std::unsigned_integral Number>
  Number number_up_to(Number maximum, std::string_view what) {
    const Number value = number<Number>();
    if (value > maximum) fail(fmt::format("{} is {}, above {}", what, value, maximum));
    return value;
  }
  SimTime time() {
    return kSimStart + SimDuration{static_cast<std::int64_t>(
                           number_up_to<std::uint64_t>(std::uint64_t{kLatestNs}, "a time in ns"))};
  }
  std::uint64_t leb128() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 63; shift += 7) {
      const std::uint8_t byte = take(1)[0];
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if (byte < 0x80) return value;
    }
    fail("a number of more than nine bytes");
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw SetupError(fmt::format("{}: damaged at offset {}: {}", name_, offset_, what));
  }

 private:
  std::string_view name_;
  std::span<const std::uint8_t> bytes_;
  std::size_t offset_;
};

std::string as_string(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

// As wire_file.cc sets them: one of these at the most, and kSymbolError beside it.
protocol::Verdict verdict_of(std::uint32_t flags) {
  using protocol::Verdict;
  if ((flags & kCrcError) != 0) return Verdict::kBadChecksum;
  if ((flags & kUnaligned) != 0) return Verdict::kMalformed;
  if ((flags & kStartError) != 0) return Verdict::kNoise;
  if ((flags & kTooShort) != 0) return Verdict::kCutShort;
  return Verdict::kFrame;
}

SetupError cannot_read(const std::string& path) {
  return SetupError(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
}

FileDescriptor open_file(const std::string& path) {
  if (path == kStandardInput) return FileDescriptor{dup(STDIN_FILENO)};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw SetupError(fmt::format("{}: is a folder; expected a recording of 'run --wire'", path));
  }
  return FileDescriptor{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
}

// Calls take(code, value) for each option.
template <class Take>
void read_options(Cursor& cursor, Take take) {
  while (cursor.left() > 0) {
    const auto code = cursor.number<std::uint16_t>();
    const auto size = cursor.number<std::uint16_t>();
    if (code == kEndOfOptions) return;
    take(code, cursor.part(size));
    cursor.skip_padding(size);
  }
}

// Takes the file in pieces; what is not a whole block yet is held.
class Parser {
 public:
  explicit Parser(std::string_view name, PacketListener listener = {})
      : name_(name), listener_(std::move(listener)) {}

  void feed(std::span<const std::uint8_t> bytes) {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    if (!begun_ && held_.size() < kBlockFrame) return;
    if (!begun_) begin();
    std::size_t taken = 0;
    while (const std::size_t length = next_block(std::span(held_).subspan(taken))) taken += length;
    held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(taken));
  }

  /// There is no more.
  WireRecording finish() {
    if (!begun_) begin();
    if (offset_ == 0) throw SetupError(cut_in_a_block());
    if (!held_.empty()) {
      recording_.cut_short = cut_in_a_block();
    } else if (!ended_) {
      recording_.cut_short = fmt::format("{}: has no end: the program was killed", name_);
    }
    if (!ended_) recording_.end = latest_;
    return std::move(recording_);
  }

 private:
  std::uint32_t number_at(std::span<const std::uint8_t> bytes, std::size_t at) const {
    Cursor cursor(name_, bytes.subspan(at), offset_ + at);
    return cursor.number<std::uint32_t>();
  }

  SetupError other(std::string_view what) const {
    return SetupError(fmt::format("{}: {}; expected a recording of 'run --wire'", name_, what));
  }

  // A section of ours comes first, or this is something else.
  void begin() {
    if (held_.size() < kBlockFrame || number_at(held_, 0) != kSection) {
      throw other("is no pcapng file");
    }
    if (number_at(held_, 8) != kByteOrderMagic) {
      throw other("is a pcapng file of another byte order");
    }
    begun_ = true;
  }

  /// The length of the block that `bytes` begin with; 0: it is not whole.
  std::size_t next_block(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < kBlockFrame) return 0;
    const std::uint32_t type = number_at(bytes, 0);
    const std::uint32_t length = number_at(bytes, 4);
    Cursor cursor(name_, bytes, offset_);
    if (length < kBlockFrame || length % 4 != 0 || length > kLongestBlock) {
      cursor.fail(fmt::format("a block of {} bytes", length));
    }
    if (length > bytes.size()) return 0;
    if (number_at(bytes, length - 4) != length) {
      cursor.fail("the block's two lengths are not the same");
    }
    cursor.take(8);
    block(type, cursor.part(length - kBlockFrame));
    if (recording_.bench.empty()) {
      throw other("is a pcapng file that does not say what bench it is of");
    }
    offset_ += length;
    return length;
  }

  std::string cut_in_a_block() const {
    return fmt::format("{}: ends in the middle of a block at offset {}", name_, offset_);
  }

  void block(std::uint32_t type, Cursor cursor) {
    if (ended_) cursor.fail("a block behind the end");
    switch (type) {
      case kSection:
        return section(cursor);
      case kInterface:
        return interface(cursor);
      case kPacket:
        return packet(cursor);
      case kFile:
        return file(cursor);
      case kHostSettings:
        return host_settings(cursor);
      case kHostWrite:
        return host_write(cursor);
      case kEnd:
        recording_.end = cursor.time();
        if (recording_.end < latest_) cursor.fail("it ends before its last event");
        ended_ = true;
        return;
      default:  // somebody else's
        return;
    }
  }

  void section(Cursor& cursor) {
    if (offset_ != 0) cursor.fail("a second section: not written by virtdrive");
    cursor.take(4);
    if (cursor.number<std::uint16_t>() != 1) cursor.fail("not version 1 of the format");
    cursor.take(2 + 8);
    read_options(cursor, [&](std::uint16_t code, Cursor value) {
      if (code == kComment) recording_.bench = as_string(value.take(value.left()));
    });
  }

  void interface(Cursor& cursor) {
    if (recording_.lines.size() == kMostLines) cursor.fail("too many lines");
    if (cursor.number<std::uint16_t>() != kLinkType) cursor.fail("not a serial line's link type");
    cursor.take(6);
    RecordedLine line;
    read_options(cursor, [&](std::uint16_t code, Cursor value) {
      if (code == kInterfaceName) line.name = as_string(value.take(value.left()));
      if (code == kInterfaceDescription) line.protocol = as_string(value.take(value.left()));
      if (code == kInterfaceSpeed) {
        line.baud = static_cast<int>(
            value.number_up_to<std::uint64_t>(std::uint64_t{kHighestHostBaud}, "a baud rate"));
      }
      if (code == kTimeResolution && value.number<std::uint8_t>() != 9) {
        value.fail("time is not in nanoseconds");
      }
    });
    recording_.lines.push_back(std::move(line));
  }

  std::size_t line_number(Cursor& cursor) {
    const auto line = cursor.number<std::uint32_t>();
    if (line >= recording_.lines.size()) cursor.fail(fmt::format("there is no line {}", line));
    return line;
  }

  void packet(Cursor& cursor) {
    RecordedPacket packet{.line = line_number(cursor)};
    const std::uint64_t high = cursor.number<std::uint32_t>();
    const std::uint64_t first = high << 32 | cursor.number<std::uint32_t>();
    const auto size = cursor.number_up_to<std::uint32_t>(kLongestPacket, "a packet's length");
    if (size == 0 || cursor.number<std::uint32_t>() != size) cursor.fail("a packet without bytes");
    const auto bytes = cursor.take(size);
    packet.bytes.assign(bytes.begin(), bytes.end());
    cursor.skip_padding(size);
    std::uint32_t flags = 0;
    read_options(cursor, [&](std::uint16_t code, Cursor value) {
      if (code == kComment) packet.comment = as_string(value.take(value.left()));
      if (code == kPacketFlags) flags = value.number<std::uint32_t>();
      if (code == kByteTimes) packet.last_bits = byte_times(value, first, size);
    });
    const std::uint32_t direction = flags & kDirections;
    if (direction != kInbound && direction != kOutbound) cursor.fail("a packet without direction");
    if (packet.last_bits.empty()) cursor.fail("a packet without the times of its bytes");
    packet.direction = direction == kInbound ? Direction::kRequest : Direction::kReply;
    packet.verdict = verdict_of(flags);
    packet.first_bit = kSimStart + SimDuration{static_cast<std::int64_t>(first)};
    latest_ = std::max(latest_, packet.last_bits.back());
    if (listener_)
      listener_(recording_, packet);
    else
      recording_.packets.push_back(std::move(packet));
  }

  static std::vector<SimTime> byte_times(Cursor value, std::uint64_t first, std::size_t count) {
    std::vector<SimTime> times;
    const SimTime last = value.time();
    std::uint64_t now = first;
    for (std::size_t i = 0; i < count; ++i) {
      now += value.leb128();
      if (now > std::uint64_t{kLatestNs}) value.fail("a byte's time is too late");
      times.push_back(kSimStart + SimDuration{static_cast<std::int64_t>(now)});
    }
    if (times.back() != last) value.fail("the bytes' times do not end at the last one's");
    return times;
  }

  void file(Cursor& cursor) {
    RecordedFile file;
    file.drive = cursor.number<std::uint32_t>();
    file.role = cursor.number<std::uint32_t>();
    const auto bytes = cursor.take(cursor.number<std::uint32_t>());
    file.content.assign(bytes.begin(), bytes.end());
    recording_.files.push_back(std::move(file));
  }

  HostAction host_action(Cursor& cursor) {
    HostAction action{.line = line_number(cursor)};
    action.when.before_events = (cursor.number<std::uint32_t>() & kBeforeEvents) != 0;
    action.when.time = cursor.time();
    if (!recording_.actions.empty() && action.when.time < recording_.actions.back().when.time) {
      cursor.fail("the host's actions are not in order");
    }
    latest_ = std::max(latest_, action.when.time);
    return action;
  }

  void host_settings(Cursor& cursor) {
    HostAction action = host_action(cursor);
    HostSettings& settings = action.settings.emplace();
    settings.baud = static_cast<int>(
        cursor.number_up_to<std::uint32_t>(kHighestHostBaud, "the host's baud rate"));
    settings.data_bits = cursor.number_up_to<std::uint8_t>(8, "the host's data bits");
    if (settings.data_bits != 0 && settings.data_bits < 5) cursor.fail("too few data bits");
    const auto parity = cursor.number_up_to<std::uint8_t>(3, "the host's parity");
    if (parity > 0) settings.parity = static_cast<Parity>(parity - 1);
    settings.stop_bits = cursor.number_up_to<std::uint8_t>(2, "the host's stop bits");
    recording_.actions.push_back(std::move(action));
  }

  void host_write(Cursor& cursor) {
    HostAction action = host_action(cursor);
    const auto bytes = cursor.take(cursor.number<std::uint32_t>());
    action.bytes.assign(bytes.begin(), bytes.end());
    recording_.actions.push_back(std::move(action));
  }

  std::string_view name_;
  PacketListener listener_;
  std::vector<std::uint8_t> held_;
  std::size_t offset_ = 0;  // of what is held
  bool begun_ = false;
  WireRecording recording_;
  SimTime latest_ = kSimStart;
  bool ended_ = false;
};

WireRecording read(const std::string& path, const PacketListener& listener) {
  const FileDescriptor file = open_file(path);
  if (!file) throw cannot_read(path);
  const std::string name = path == kStandardInput ? "standard input" : path;
  Parser parser(name, listener);
  std::vector<std::uint8_t> piece(1 << 16);
  for (std::size_t all = 0;;) {
    const ssize_t count = ::read(file.get(), piece.data(), piece.size());
    if (count == 0) return parser.finish();
    if (count < 0 && errno != EINTR) throw cannot_read(name);
    if (count < 0) continue;
    all += static_cast<std::size_t>(count);
    if (!listener && all > kLongestFile) {
      throw SetupError(fmt::format("{}: is larger than {} bytes", name, kLongestFile));
    }
    parser.feed(std::span(piece).first(static_cast<std::size_t>(count)));
  }
}

}  // namespace

WireRecording parse_wire_recording(std::span<const std::uint8_t> bytes, std::string_view name) {
  Parser parser(name);
  parser.feed(bytes);
  return parser.finish();
}

WireRecording read_wire_recording(const std::string& path) {
  return read(path, {});
}

std::string follow_wire_recording(const std::string& path, const PacketListener& listener) {
  return read(path, listener).cut_short;
}

}  // namespace virtdrive
