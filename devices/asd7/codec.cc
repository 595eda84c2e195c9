#include "devices/asd7/codec.h"

#include <algorithm>
#include <array>
#include <string>

#include "devices/protocol/checksum.h"
#include "devices/protocol/text.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Direction;
using Bytes = std::span<const std::uint8_t>;

constexpr protocol::ByteOrder kOrder = kTable.framing.order;
constexpr std::size_t kNumberDigits = 4;
constexpr std::size_t most_digits(Format format) {
  return is_wide(format) ? 8 : 4;
}

// --- Values --------------------------------------------------------------------------------------

// 32-bit signed values keep their sign in 16 bits: the upper word is the extension of bit 15. So do
// those of a row without a sign that are negative all the same (`signed_frequency`).
Field data_field(const ParameterRow* row, Format format, std::int64_t value = 0) {
  const bool sign = (row != nullptr && protocol::is_signed(row->type)) || value < 0;
  const WireType narrow = sign ? WireType::kI16 : WireType::kU16;
  const WireType wide = sign ? WireType::kI32 : WireType::kU32;
  return {.name = "data", .type = is_wide(format) ? wide : narrow};
}

std::vector<Field> with_data(std::span<const Field> fields, const Field& data) {
  return protocol::with_value(fields, std::span(&data, 1));
}

bool fits(std::int64_t value, const Field& field) {
  std::array<std::uint8_t, 4> bytes{};
  protocol::store(bytes, field.type, kOrder, value);
  return protocol::load(bytes, field.type, kOrder) == value;
}

std::span<const Field> fields_of(const CommandRow& row, Direction direction) {
  return direction == Direction::kRequest ? row.request : row.reply;
}

// Reads the payload, whose first number tells the parameter and so the sign of the data.
void read(Message& message, std::span<const Field> fields, Bytes payload) {
  if (message.row != &kErrorReply) {  // else the first number is the error's code
    const auto number = protocol::load(payload, WireType::kU16, kOrder);
    message.parameter = protocol::find(kTable.parameters, static_cast<std::uint16_t>(number));
  }
  const auto concrete = with_data(fields, data_field(message.parameter, message.format));
  message.values = protocol::unpack(concrete, kOrder, payload);
}

// A command's row; in replies it may be lower case, and N.
const CommandRow* find_command(char c, Direction direction) {
  const bool reply = direction == Direction::kReply;
  const char upper = reply ? protocol::to_upper(c) : c;
  if (reply && upper == static_cast<char>(kErrorReply.code)) return &kErrorReply;
  const CommandRow* row = protocol::find(kTable.commands, static_cast<std::uint8_t>(upper));
  return row != nullptr && reply && !row->replies ? nullptr : row;
}
const CommandRow* find_ascii_command(char c, Direction direction) {
  const CommandRow* row = find_command(c, direction);
  return row != nullptr && is_binary_only(*row) ? nullptr : row;
}

// --- Framing -------------------------------------------------------------------------------------

std::uint8_t number_byte(AsdNumber number) {
  if (number.tens == AsdNumber::kAny && number.units == AsdNumber::kAny) return kAllBinary;
  const int byte = 10 * number.tens + number.units;
  VIRTDRIVE_CHECK(byte <= kHighestBinaryNumber, "ASD number {} in binary", byte);
  return static_cast<std::uint8_t>(byte);
}

std::uint8_t number_digit(std::uint8_t digit) {
  return static_cast<std::uint8_t>(digit == AsdNumber::kAny ? kAnyDigit : '0' + digit);
}

AsdNumber read_number(std::uint8_t byte) {
  if (byte == kAllBinary) return {.tens = AsdNumber::kAny, .units = AsdNumber::kAny};
  return {.tens = static_cast<std::uint8_t>(byte / 10),
          .units = static_cast<std::uint8_t>(byte % 10)};
}

// A reply has the request's format, and the number of the drive that answers.
Message reply_form(const Message& request) {
  Message form = request;
  if (form.number) form.number = form.number->representative();
  return form;
}

std::vector<std::uint8_t> frame_ascii(const Message& style, char command, Bytes payload) {
  std::vector<std::uint8_t> out = {kAsciiStart};
  if (style.number) {
    out.push_back(number_digit(style.number->tens));
    out.push_back(number_digit(style.number->units));
  }
  if (style.format == Format::kAscii32) out.push_back(kWide);
  out.push_back(static_cast<std::uint8_t>(command));
  protocol::append_hex(out, payload);
  if (style.with_sum) {
    out.push_back(kAsciiSum);
    const std::uint8_t sum[] = {protocol::sum8(out)};
    protocol::append_hex(out, sum);
  }
  if (style.closed) out.push_back(kAsciiClose);
  out.push_back(kAsciiEnd);
  return out;
}

std::vector<std::uint8_t> frame_binary(const Message& style, char command, Bytes payload) {
  std::vector<std::uint8_t> out = {kBinaryStart};
  if (style.number) out.push_back(number_byte(*style.number));
  if (style.format == Format::kBinary32) out.push_back(kWide);
  out.push_back(static_cast<std::uint8_t>(command));
  out.insert(out.end(), payload.begin(), payload.end());
  out.push_back(protocol::sum8(out));
  return out;
}

std::vector<std::uint8_t> frame(const Message& style, const CommandRow& row, bool tripped,
                                std::span<const Field> fields, const protocol::Values& values) {
  std::vector<std::uint8_t> payload;
  protocol::pack(fields, kOrder, values, payload);
  const char upper = static_cast<char>(row.code);
  const char command = tripped ? protocol::to_lower(upper) : upper;
  return is_ascii(style.format) ? frame_ascii(style, command, payload)
                                : frame_binary(style, command, payload);
}

// --- Reading ASCII -------------------------------------------------------------------------------

std::optional<std::uint8_t> read_digit(char c) {
  if (c == kAnyDigit) return AsdNumber::kAny;
  if (!protocol::is_digit(c)) return std::nullopt;
  return static_cast<std::uint8_t>(c - '0');
}

// Takes n characters off the front; fewer if there are not so many.
std::string_view take(std::string_view& text, std::size_t n) {
  const std::string_view taken = text.substr(0, n);
  text.remove_prefix(taken.size());
  return taken;
}

std::string_view take_hex(std::string_view& text) {
  std::size_t n = 0;
  while (n < text.size() && protocol::is_hex_digit(text[n])) ++n;
  return take(text, n);
}

// The parts of an ASCII message, each where it must be.
struct AsciiParts {
  std::optional<AsdNumber> number;
  bool wide = false;
  const CommandRow* row = nullptr;
  bool lower_case = false;
  std::string_view digits;  // communication number (or an error's code) and data
  std::optional<std::uint32_t> sum;
  bool closed = false;
};

// Nothing if a part is not. What follows an unknown command may be anything up to the sum.
std::optional<AsciiParts> split(std::string_view text, Direction direction, bool ascii_wide) {
  AsciiParts parts;
  if (!text.empty() && read_digit(text[0])) {
    const std::string_view number = take(text, 2);
    if (number.size() < 2 || !read_digit(number[1])) return std::nullopt;
    parts.number = {.tens = *read_digit(number[0]), .units = *read_digit(number[1])};
  }
  if (ascii_wide && text.starts_with(kWide)) {
    parts.wide = true;
    take(text, 1);
  }
  if (text.empty() || !protocol::is_letter(text[0])) return std::nullopt;
  const char command = take(text, 1)[0];
  parts.row = find_ascii_command(command, direction);
  parts.lower_case = command != protocol::to_upper(command);
  if (parts.row == nullptr) {
    take(text, std::min(text.find(kAsciiSum), text.find(kAsciiClose)));
  } else {
    parts.digits = take_hex(text);
    if (parts.digits.size() < kNumberDigits) return std::nullopt;
  }
  if (text.starts_with(kAsciiSum)) {
    take(text, 1);
    const std::string_view sum = take(text, 2);
    parts.sum = protocol::parse_digits(sum, 16);
    if (sum.size() < 2 || !parts.sum) return std::nullopt;
  }
  parts.closed = text.starts_with(kAsciiClose);
  if (parts.closed) take(text, 1);
  return text.empty() ? std::optional(parts) : std::nullopt;
}

std::vector<std::uint8_t> bytes_of(std::string_view digits) {
  std::vector<std::uint8_t> bytes;
  while (!digits.empty()) {
    const auto value = protocol::parse_digits(take(digits, 2), 16);
    bytes.push_back(static_cast<std::uint8_t>(*value));
  }
  return bytes;
}

// --- Reading -------------------------------------------------------------------------------------

using Event = Decoder::Event;

// In the order in which a drive looks (assumed).
std::optional<Error> first_error(const Message& message, Direction direction, bool sum_fits,
                                 bool digits_fit) {
  if (!sum_fits) return Error::kSum;
  if (direction == Direction::kReply) return std::nullopt;
  if (message.row == nullptr) return Error::kCommand;
  if (message.parameter == nullptr) return Error::kNumber;
  return digits_fit ? std::nullopt : std::optional(Error::kRange);
}

bool sum_fits(Bytes frame, const AsciiParts& parts) {
  if (!parts.sum) return true;
  const std::size_t end = protocol::as_text(frame).find(kAsciiSum) + 1;
  return protocol::sum8(frame.first(end)) == *parts.sum;
}

// Reads the number and, if there are as many digits as the row wants, the data: one to four (wide:
// eight) in a request, where they stand to the right, and all of them in a reply. Nothing if that
// is no message; false if the data are out of range.
std::optional<bool> read_digits(Message& message, std::string_view data, Direction direction) {
  const auto fields = fields_of(*message.row, direction);
  std::string digits(take(data, kNumberDigits));
  if (fields.size() == 1) {
    if (!data.empty()) return std::nullopt;
    read(message, fields, bytes_of(digits));
    return true;
  }
  const std::size_t most = most_digits(message.format);
  if (direction == Direction::kReply && data.size() != most) return std::nullopt;
  if (data.empty() || data.size() > most) {
    read(message, fields.first(1), bytes_of(digits));
    return false;
  }
  digits.append(most - data.size(), '0').append(data);
  read(message, fields, bytes_of(digits));
  return true;
}

Event read_ascii(Message& message, Bytes frame, Direction direction, bool ascii_wide) {
  const std::string_view text = protocol::as_text(frame).substr(1, frame.size() - 2);
  const auto parts = split(text, direction, ascii_wide);
  if (!parts) return Event::kFormatError;
  const bool reply = direction == Direction::kReply;
  message = {.format = parts->wide ? Format::kAscii32 : Format::kAscii,
             .number = parts->number,
             .with_sum = parts->sum.has_value(),
             .closed = parts->closed,
             .row = parts->row,
             .tripped = reply && parts->lower_case};
  std::optional<bool> digits_fit = reply ? std::nullopt : std::optional(true);
  if (message.row != nullptr) digits_fit = read_digits(message, parts->digits, direction);
  if (!digits_fit) return Event::kFormatError;
  message.error = first_error(message, direction, sum_fits(frame, *parts), *digits_fit);
  return Event::kMessage;
}

// kNone while bytes are missing. Numbers and commands share no byte: either may follow the start.
Event read_binary(Message& message, Bytes frame, Direction direction) {
  message = {.format = Format::kBinary16};
  std::size_t at = 1;
  if (at < frame.size() && (frame[at] <= kHighestBinaryNumber || frame[at] == kAllBinary)) {
    message.number = read_number(frame[at++]);
  }
  if (at < frame.size() && frame[at] == kWide) {
    message.format = Format::kBinary32;
    ++at;
  }
  if (at == frame.size()) return Event::kNone;
  const char command = static_cast<char>(frame[at++]);
  message.row = find_command(command, direction);
  message.tripped = direction == Direction::kReply && command != protocol::to_upper(command);
  if (message.row == nullptr) return Event::kUnknownCommand;

  const auto fields = fields_of(*message.row, direction);
  const std::size_t payload =
      protocol::width(with_data(fields, data_field(nullptr, message.format)));
  if (frame.size() < at + payload + 1) return Event::kNone;
  read(message, fields, frame.subspan(at, payload));
  const bool fits = protocol::sum8(frame.first(at + payload)) == frame[at + payload];
  message.error = first_error(message, direction, fits, true);
  return Event::kMessage;
}

}  // namespace

std::vector<std::uint8_t> encode_request(const Message& message) {
  const auto fields =
      with_data(message.row->request, data_field(message.parameter, message.format));
  return frame(message, *message.row, false, fields, message.values);
}

std::vector<std::uint8_t> encode_reply(const Message& request, std::int64_t value,
                                       const ReplyStyle& style) {
  const Field data = data_field(request.parameter, request.format, value);
  if (!fits(value, data)) return encode_error(request, style.mode_error, style);
  return frame(reply_form(request), *request.row, style.tripped,
               with_data(request.row->reply, data), {request.values[0], value});
}

std::vector<std::uint8_t> encode_error(const Message& request, Error error,
                                       const ReplyStyle& style) {
  Message form = reply_form(request);
  form.format = is_ascii(form.format) ? Format::kAscii : Format::kBinary16;
  form.with_sum = form.with_sum || style.error_sum_always;
  return frame(form, kErrorReply, style.tripped, kErrorReply.reply,
               {static_cast<std::int64_t>(error)});
}

void Decoder::reset() {
  buffer_.clear();
  ended_ = false;
}

Decoder::Event Decoder::push(std::uint8_t byte) {
  if (ended_) reset();
  if (buffer_.empty()) {
    if (byte == '\r' || byte == '\n') return Event::kNone;
    if (byte != kAsciiStart && byte != kBinaryStart) return Event::kNoise;
    buffer_.push(byte);
    return Event::kNone;
  }
  return buffer_[0] == kAsciiStart ? push_ascii(byte) : push_binary(byte);
}

Decoder::Event Decoder::push_ascii(std::uint8_t byte) {
  if (byte == kAsciiStart) buffer_.clear();
  buffer_.push(byte);
  if (byte == kAsciiStart) return Event::kFormatError;
  if (byte == kAsciiEnd) return end(read_ascii(message_, bytes(), direction_, ascii_wide_));
  return buffer_.full() ? end(Event::kFormatError) : Event::kNone;
}

Decoder::Event Decoder::push_binary(std::uint8_t byte) {
  buffer_.push(byte);
  return end(read_binary(message_, bytes(), direction_));
}

Decoder::Event Decoder::end(Event event) {
  ended_ = event != Event::kNone;
  return event;
}

}  // namespace virtdrive::asd7
