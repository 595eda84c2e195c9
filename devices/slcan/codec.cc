#include "devices/slcan/codec.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace virtdrive::slcan {
namespace {

constexpr std::uint32_t kHighestStandard = 0x7FF;
constexpr std::uint32_t kHighestExtended = 0x1FFF'FFFF;

std::optional<std::uint32_t> hex(std::string_view digits) {
  std::uint32_t value = 0;
  for (const char c : digits) {
    const char lower = c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
    if (lower >= '0' && lower <= '9')
      value = value << 4 | static_cast<std::uint32_t>(lower - '0');
    else if (lower >= 'a' && lower <= 'f')
      value = value << 4 | static_cast<std::uint32_t>(lower - 'a' + 10);
    else
      return std::nullopt;
  }
  return value;
}

bool is_frame(char letter) {
  return std::string_view("tTrR").find(letter) != std::string_view::npos;
}

std::optional<CanFrame> parse_frame(char letter, std::uint32_t id, std::string_view rest) {
  CanFrame frame{.id = id, .extended = letter == 'T' || letter == 'R'};
  frame.remote = letter == 'r' || letter == 'R';
  if (id > (frame.extended ? kHighestExtended : kHighestStandard)) return std::nullopt;
  if (rest.empty() || rest[0] < '0' || rest[0] > '8') return std::nullopt;
  frame.length = static_cast<std::uint8_t>(rest[0] - '0');
  rest.remove_prefix(1);
  if (rest.size() != 2 * frame.bytes().size()) return std::nullopt;
  for (std::size_t i = 0; i < frame.bytes().size(); ++i) {
    const auto byte = hex(rest.substr(2 * i, 2));
    if (!byte) return std::nullopt;
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  return frame;
}

}  // namespace

Decoder::Event Decoder::push(std::uint8_t byte) {
  if (ended_) {
    line_.clear();
    ended_ = too_long_ = false;
  }
  if (byte == kOk) {
    ended_ = true;
    return too_long_ ? Event::kTooLong : Event::kLine;
  }
  if (line_.size() < kLongest)
    line_ += static_cast<char>(byte);
  else
    too_long_ = true;
  return Event::kNone;
}

std::optional<Line> parse(std::string_view line) {
  if (line.empty()) return std::nullopt;
  const auto* const command = std::ranges::find(kCommands, line[0], &Command::letter);
  if (command == std::end(kCommands)) return std::nullopt;
  const std::string_view digits = line.substr(1);
  const bool frame = is_frame(command->letter);
  if (digits.size() < command->digits || (!frame && digits.size() > command->digits)) {
    return std::nullopt;
  }
  const auto number = hex(digits.substr(0, command->digits));
  if (!number) return std::nullopt;
  Line parsed{.command = command, .number = *number};
  if (frame) {
    const auto data = parse_frame(command->letter, *number, digits.substr(command->digits));
    if (!data) return std::nullopt;
    parsed.frame = *data;
  }
  return parsed;
}

std::string text_of(const CanFrame& frame) {
  const char letter = frame.extended ? (frame.remote ? 'R' : 'T') : (frame.remote ? 'r' : 't');
  std::string text = frame.extended ? fmt::format("{}{:08X}{}", letter, frame.id, frame.length)
                                    : fmt::format("{}{:03X}{}", letter, frame.id, frame.length);
  for (const std::uint8_t byte : frame.bytes()) text += fmt::format("{:02X}", byte);
  return text;
}

int bit_rate_of(std::uint32_t btr) {
  constexpr int kClockHz = 16'000'000;
  const auto prescaler = static_cast<int>(btr >> 8 & 0x3F) + 1;
  const auto segments = static_cast<int>(3 + (btr & 0x0F) + (btr >> 4 & 0x07));
  return kClockHz / (2 * prescaler * segments);
}

bool AcceptanceFilter::passes(const CanFrame& frame) const {
  const auto equal = [](std::uint32_t a, std::uint32_t b, std::uint32_t care) {
    return ((a ^ b) & care) == 0;
  };
  const std::uint32_t care = ~mask;
  const std::uint32_t first = code >> 16, second = code & 0xFFFF;
  const std::uint32_t first_care = care >> 16, second_care = care & 0xFFFF;
  if (frame.extended) {
    const std::uint32_t top = frame.id >> 13;
    return equal(top, first, first_care) || equal(top, second, second_care);
  }
  // Identifier and RTR in the upper 12 bits; the first filter's lower nibbles are data byte 1.
  const std::uint32_t head = frame.id << 5 | std::uint32_t{frame.remote} << 4;
  const std::uint32_t byte_code = (first & 0xF) << 4 | (second & 0xF);
  const std::uint32_t byte_care = (first_care & 0xF) << 4 | (second_care & 0xF);
  const bool data = frame.bytes().empty() || equal(frame.data[0], byte_code, byte_care);
  return (equal(head, first, first_care & 0xFFF0) && data) ||
         equal(head, second, second_care & 0xFFF0);
}

}  // namespace virtdrive::slcan
