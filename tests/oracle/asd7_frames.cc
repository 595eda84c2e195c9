// Frames of the 7-Series in all their formats, and of Modbus RTU, from a seed; each with what our
// decoders make of it, a line each:
//
//   request 28524644303029... ascii ok - R fd00 - bare open
//   reply 2f4c72fd0000001770.. binary ok - r fd00 00001770
//   request 0103fd000001b5a6 modbus ok 1 3 fd00 1
//
// usage: virtdrive_asd7_frames COUNT SEED
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "devices/asd7/codec.h"
#include "devices/asd7_modbus/codec.h"
#include "devices/protocol/text.h"
#include "tests/oracle/frames.h"

namespace virtdrive {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Direction;

// Each tenth frame is spoilt: a bit flipped, a byte lost, or the end.
void spoil(Bytes& frame, RandomStream& random) {
  const std::uint64_t bits = random.bits();
  const std::size_t at = (bits >> 16) % frame.size();
  switch (bits % 30) {
    case 0:
      frame[at] ^= static_cast<std::uint8_t>(1U << (bits >> 8) % 8);
      break;
    case 1:
      frame.erase(frame.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 2:
      frame.resize(1 + at);
      break;
    default:
      break;
  }
}

namespace own {

using namespace asd7;

AsdNumber random_number(Format format, RandomStream& random) {
  const std::uint64_t bits = random.bits();
  if (!is_ascii(format)) {
    if (bits % 8 == 0) return {.tens = AsdNumber::kAny, .units = AsdNumber::kAny};
    const auto number = static_cast<std::uint8_t>((bits >> 8) % (kHighestBinaryNumber + 1));
    return {.tens = static_cast<std::uint8_t>(number / 10),
            .units = static_cast<std::uint8_t>(number % 10)};
  }
  const auto digit = [](std::uint64_t n) {
    return static_cast<std::uint8_t>(n % 11 == 10 ? std::uint64_t{AsdNumber::kAny} : n % 11);
  };
  return {.tens = digit(bits >> 8), .units = digit(bits >> 24)};
}

// Of a number as the oracle knows it: "-", "05", "**".
std::string text(const std::optional<AsdNumber>& number) {
  if (!number) return "-";
  const auto digit = [](std::uint8_t d) { return d == AsdNumber::kAny ? '*' : char('0' + d); };
  return {digit(number->tens), digit(number->units)};
}

std::string decoded(Direction direction, const Bytes& frame) {
  Decoder decoder(direction);
  for (const std::uint8_t byte : frame) {
    const Decoder::Event event = decoder.push(byte);
    if (event == Decoder::Event::kNone) continue;
    if (event == Decoder::Event::kNoise) return "noise";
    if (event == Decoder::Event::kFormatError) return "silence";
    if (event == Decoder::Event::kUnknownCommand) return "unknown_command";
    const Message& m = decoder.message();
    if (m.error == Error::kSum) return "bad_sum";
    if (m.error == Error::kCommand) return "no_command";
    if (m.error == Error::kRange) return "too_many_digits";
    const bool known = m.row == &kErrorReply || m.parameter != nullptr;
    if (!known && direction == Direction::kRequest) return "no_number";
    const char upper = static_cast<char>(m.row->code);
    const std::uint64_t mask = is_wide(m.format) ? 0xFFFFFFFF : 0xFFFF;
    const std::string data =
        m.values.size() > 1 ? fmt::format("{:0{}x}", static_cast<std::uint64_t>(m.values[1]) & mask,
                                          is_wide(m.format) ? 8 : 4)
                            : "-";
    return fmt::format(
        "ok {} {} {:04x} {}{}", text(m.number), m.tripped ? protocol::to_lower(upper) : upper,
        static_cast<unsigned>(m.values[0]), data,
        is_ascii(m.format)
            ? fmt::format(" {} {}", m.with_sum ? "sum" : "bare", m.closed ? "closed" : "open")
            : "");
  }
  return "incomplete";
}

std::string line(RandomStream& random) {
  constexpr std::uint8_t kMarks[] = {'(', '/', 'L', '\r'};
  const std::uint64_t bits = random.bits();
  const bool request = (bits & 1) != 0;
  const Format format =
      std::array{Format::kAscii, Format::kBinary16, Format::kBinary32}[(bits >> 1) % 3];
  Message message{.format = format,
                  .with_sum = (bits & 0x100) != 0,
                  .closed = (bits & 0x200) != 0,
                  .row = &kCommands[(bits >> 16) % std::size(kCommands)],
                  .parameter = &kParameters[(bits >> 32) % std::size(kParameters)]};
  if (is_ascii(format) && is_binary_only(*message.row)) message.row = &kCommands[2];
  if ((bits & 0x400) != 0) message.number = random_number(format, random);
  constexpr Field kData[] = {{.name = "data", .type = WireType::kU32}};
  const bool wide = is_wide(format);
  const std::int64_t value =
      random_values(kData, kTable.framing.order, kMarks, random)[0] & (wide ? 0xFFFFFFFF : 0xFFFF);
  message.values = {message.parameter->id};
  if (message.row->request.size() > 1) message.values.push(value);
  Bytes frame;
  if (request) {
    frame = encode_request(message);
  } else {
    if (!message.row->replies) message.row = &kCommands[1];
    const ReplyStyle style{.tripped = (bits & 0x800) != 0};
    const bool sign = protocol::is_signed(message.parameter->type);
    const std::int64_t held = !sign  ? value
                              : wide ? std::int64_t{static_cast<std::int32_t>(value)}
                                     : std::int64_t{static_cast<std::int16_t>(value)};
    frame = (bits & 0x7000) == 0
                ? encode_error(message, static_cast<Error>((bits >> 40) % 5), style)
                : encode_reply(message, held, style);
  }
  spoil(frame, random);
  const auto direction = request ? Direction::kRequest : Direction::kReply;
  return fmt::format("{} {:02x} {} {}\n", request ? "request" : "reply", fmt::join(frame, ""),
                     is_ascii(format) ? "ascii" : "binary", decoded(direction, frame));
}

}  // namespace own

namespace rtu {

using namespace asd7_modbus;

std::string decoded(Direction direction, const Bytes& bytes) {
  Frame frame;
  switch (decode(direction, bytes, frame)) {
    case FrameError::kTooShort:
      return "too_short";
    case FrameError::kCrc:
      return "bad_crc";
    case FrameError::kNone:
      break;
  }
  if (frame.exception) return fmt::format("exception {} {}", frame.unit, *frame.exception);
  if (frame.row == nullptr) return fmt::format("no_function {}", frame.unit);
  if (!frame.values) return "other_length";
  return fmt::format("ok {} {}{}", frame.unit, frame.function, text(*frame.values));
}

std::string line(RandomStream& random) {
  constexpr std::uint8_t kMarks[] = {0x83, 0x03, 0x10};
  const std::uint64_t bits = random.bits();
  const bool request = (bits & 1) != 0;
  const auto unit = static_cast<std::uint8_t>(bits >> 8);
  const CommandRow& row = kFunctions[(bits >> 16) % std::size(kFunctions)];
  const auto fields = request ? row.request : row.reply;
  const protocol::Values values = random_values(fields, kTable.framing.order, kMarks, random);
  Bytes frame = request ? encode_request(unit, row, values) : encode_reply(unit, row, values);
  if (!request && (bits & 0x70000000) == 0) {
    frame = encode_exception(unit, static_cast<std::uint8_t>(row.code),
                             static_cast<Exception>(1 + (bits >> 40) % 4));
  }
  spoil(frame, random);
  const auto direction = request ? Direction::kRequest : Direction::kReply;
  return fmt::format("{} {:02x} modbus {}\n", request ? "request" : "reply", fmt::join(frame, ""),
                     decoded(direction, frame));
}

}  // namespace rtu

std::string line(RandomStream& random) {
  return random.bits() % 4 == 0 ? rtu::line(random) : own::line(random);
}

}  // namespace
}  // namespace virtdrive

int main(int argc, char** argv) {
  return virtdrive::print_frames(argc, argv, virtdrive::line);
}
