#include "devices/rzt1/codec.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "core/check.h"
#include "devices/protocol/checksum.h"
#include "devices/protocol/text.h"

namespace virtdrive::rzt1 {
namespace {

constexpr std::size_t kHeader = 4;       // start, address, length, code
constexpr std::size_t kTraceHeader = 3;  // count, size
constexpr std::string_view kEndOfLine = "\r\n";
constexpr const Framing& kFraming = kTable.framing;

using Values = protocol::Values;
using protocol::values;

// --- Packets -------------------------------------------------------------------------------------

// What stands for the value of what the packet names.
std::vector<Field> value_of(const Packet& packet) {
  if (packet.parameter != nullptr) return protocol::value_fields(*packet.parameter);
  if (packet.function == nullptr) return {};
  return {packet.function->request.begin(), packet.function->request.end()};
}

// All that the row has, optional fields too.
std::vector<Field> request_fields(const Packet& packet) {
  return protocol::with_value(packet.row->request, value_of(packet));
}

std::vector<Field> reply_fields(const Packet& request) {
  if (request.row->reply_by_mask) return protocol::masked(request.row->reply, request.values[0]);
  return protocol::with_value(request.row->reply, value_of(request));
}

bool is_stream(const CommandRow& row) {
  return !row.request.empty() && row.request.data() == kPoints;
}
bool is_trace(const CommandRow& row) {
  return !row.reply.empty() && row.reply.data() == kTrace;
}

// A count, where there is one, and so many points.
std::vector<Field> stream_fields(bool counted, std::size_t points) {
  std::vector<Field> fields;
  if (counted) fields.push_back(kPoints[0]);
  fields.push_back(kPoints[1]);
  fields.back().count = points;
  return fields;
}

// Both layouts of B.5: which one it is the length tells.
void read_stream(Packet& packet, std::span<const std::uint8_t> data) {
  constexpr std::size_t kPointSize = protocol::width(kPoint);
  const std::size_t points = data.size() / kPointSize;
  packet.counted = data.size() % kPointSize == 1;
  const bool fits = packet.counted ? data[0] == points : data.size() % kPointSize == 0;
  if (points == 0 || !fits) {
    packet.status = Status::kBadSize;
    return;
  }
  packet.values = protocol::unpack(stream_fields(packet.counted, points), kFraming.order, data);
}

// The document's SETUP is a variable that starts something when it is written: by its request
// fields such a function is told from others.
void find_named(Packet& packet, std::span<const std::uint8_t> data) {
  const std::uint8_t id = data[0];
  const CommandRow* function = protocol::find(kTable.functions, id);
  if (packet.row->names == Names::kFunction) {
    packet.function = function;
    return;
  }
  packet.parameter = protocol::find(kTable.parameters, id);
  if (function == nullptr || function->request.empty() || !packet.row->reply.empty()) return;
  if (data.size() == 1 + protocol::width(function->request)) packet.function = function;
}

// Finds the rows that the packet names, then the values that those rows lay out.
void read(Packet& packet, std::uint8_t code, std::span<const std::uint8_t> data) {
  packet.row = protocol::find(kTable.commands, code);
  const auto refuse = [&](Status status) { packet.status = status; };
  if (packet.row == nullptr) return refuse(Status::kBadCode);
  if (packet.row->names != Names::kNothing) {
    if (data.empty()) return refuse(Status::kBadSize);
    find_named(packet, data);
    if (packet.function == nullptr && packet.parameter == nullptr) {
      return refuse(Status::kBadIndex);
    }
  }
  if (is_stream(*packet.row)) return read_stream(packet, data);
  std::vector<Field> fields = request_fields(packet);
  while (!fields.empty() && fields.back().optional && protocol::width(fields) > data.size()) {
    fields.pop_back();
  }
  if (protocol::width(fields) != data.size()) return refuse(Status::kBadSize);
  packet.values = protocol::unpack(fields, kFraming.order, data);
}

// --- Lines ---------------------------------------------------------------------------------------

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// Takes the characters off the front for which `wanted` is true.
template <class Predicate>
std::string_view take(std::string_view& text, Predicate wanted) {
  const auto end = std::find_if_not(text.begin(), text.end(), wanted);
  const std::string_view taken = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(taken.size());
  return taken;
}

bool same_name(std::string_view typed, std::string_view name) {
  return std::ranges::equal(typed, name, [](char a, char b) { return protocol::to_upper(a) == b; });
}

template <class Row>
const Row* find_name(std::span<const Row> rows, std::string_view name) {
  const auto row =
      std::ranges::find_if(rows, [&](const Row& r) { return same_name(name, r.name); });
  return row != rows.end() ? &*row : nullptr;
}

const ParameterRow* find_alias(std::string_view name) {
  const Alias* const alias = find_name(std::span<const Alias>(kAliases), name);
  return alias != nullptr ? protocol::find(kTable.parameters, alias->id) : nullptr;
}

Line read_line(std::string_view text) {
  Line line;
  take(text, is_blank);
  const std::string_view axis = take(text, protocol::is_digit);
  if (!axis.empty()) {
    line.axis = protocol::parse_digits(axis, 10).value_or(0);
    line.accepted = line.axis >= 1 && line.axis <= kAxes;
  }
  const std::string_view name = take(text, [](char c) { return !is_blank(c) && c != '='; });
  take(text, [](char c) { return is_blank(c) || c == '='; });
  const std::string_view number = take(text, [](char c) { return !is_blank(c); });
  take(text, is_blank);
  if (!name.empty()) {
    line.function = find_name(kTable.functions, name);
    line.parameter = find_name(kTable.parameters, name);
    if (line.parameter == nullptr) line.parameter = find_alias(name);
    line.accepted &= line.function != nullptr || line.parameter != nullptr;
  }
  if (!number.empty()) {
    line.argument = parse_number(number);
    line.accepted &= line.argument.has_value();
  }
  line.accepted &= text.empty();
  return line;
}

}  // namespace

std::optional<std::int64_t> parse_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.starts_with('0')) {
    base = 8;
  }
  const auto magnitude = protocol::parse_digits(text, base);
  if (!magnitude) return std::nullopt;
  return negative ? -std::int64_t{*magnitude} : std::int64_t{*magnitude};
}

Status status_of(protocol::Refusal refusal) {
  switch (refusal) {
    case protocol::Refusal::kNone:
      return Status::kOk;
    case protocol::Refusal::kUnknown:
    case protocol::Refusal::kWriteOnly:
      return Status::kBadIndex;
    case protocol::Refusal::kReadOnly:
      return Status::kReadOnly;
    case protocol::Refusal::kOutOfRange:
    case protocol::Refusal::kUnit:
      return Status::kOutOfRange;
  }
  return Status::kExecution;
}

std::vector<std::uint8_t> encode_request(const Packet& packet) {
  std::vector<Field> fields = request_fields(packet);
  if (is_stream(*packet.row)) {
    const auto points = packet.counted ? static_cast<std::size_t>(packet.values[0])
                                       : packet.values.size() / values(kPoint);
    VIRTDRIVE_CHECK(points <= kMostPoints, "{} points in a packet", points);
    fields = stream_fields(packet.counted, points);
  }
  while (values(fields) > packet.values.size()) fields.pop_back();
  std::vector<std::uint8_t> bytes = {kStart, packet.address,
                                     static_cast<std::uint8_t>(protocol::width(fields)),
                                     static_cast<std::uint8_t>(packet.row->code)};
  protocol::pack(fields, kFraming.order, packet.values, bytes);
  bytes.push_back(protocol::sum8(std::span(bytes).subspan(1)));
  return bytes;
}

std::vector<std::uint8_t> encode_request(const Line& line) {
  std::string text = line.axis == 0 ? "" : fmt::format("{}", line.axis);
  if (line.function != nullptr) text += line.function->name;
  if (line.parameter != nullptr) text += line.parameter->name;
  if (line.argument) text += fmt::format(" {}", *line.argument);
  text += kLines[0].end;
  return {text.begin(), text.end()};
}

std::vector<std::uint8_t> encode_reply(const Packet& request, const Values& values,
                                       const ReplyFormat& format) {
  std::vector<std::uint8_t> bytes(format.status_bytes, 0);
  protocol::pack(reply_fields(request), kFraming.order, values, bytes);
  bytes.push_back(protocol::sum8(bytes));
  return bytes;
}

std::vector<std::uint8_t> encode_trace(std::span<const std::int32_t> samples, TraceWidth width,
                                       const ReplyFormat& format) {
  std::vector<std::uint8_t> bytes(format.status_bytes, 0);
  const auto put = [&](WireType type, std::int64_t value) {
    bytes.resize(bytes.size() + protocol::width(type));
    protocol::store(std::span(bytes).last(protocol::width(type)), type, kFraming.order, value);
  };
  if (!format.raw_trace) {
    put(WireType::kU16, static_cast<std::int64_t>(samples.size()));
    put(WireType::kU8, static_cast<std::int64_t>(width));
  }
  for (const std::int32_t sample : samples) {
    put(width == TraceWidth::kTwoBytes ? WireType::kI16 : WireType::kI32, sample);
  }
  bytes.push_back(protocol::sum8(bytes));
  return bytes;
}

std::vector<std::uint8_t> encode_refusal(Status status, const ReplyFormat& format) {
  std::vector<std::uint8_t> bytes(format.status_bytes, 0);
  bytes[0] = static_cast<std::uint8_t>(status);
  bytes.push_back(protocol::sum8(bytes));
  return bytes;
}

std::vector<std::uint8_t> encode_reply(std::string_view text, bool accepted, std::uint32_t axis) {
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  protocol::append(bytes, kEndOfLine);
  if (axis != 0) protocol::append(bytes, fmt::format("{}", axis));
  bytes.push_back(static_cast<std::uint8_t>(accepted ? kAcceptedPrompt : kRefusedPrompt));
  return bytes;
}

std::string to_text(const ParameterRow& row, std::int64_t value) {
  if (row.hex_digits == 0) return fmt::format("{}", value);
  const std::uint64_t mask = (std::uint64_t{1} << (4 * row.hex_digits)) - 1;
  return fmt::format("{:0{}X}", static_cast<std::uint64_t>(value) & mask, row.hex_digits);
}

std::optional<std::int64_t> from_text(const ParameterRow& row, std::string_view text) {
  if (row.hex_digits == 0) return parse_number(text);
  const auto value = protocol::parse_digits(text, 16);
  return value ? std::optional<std::int64_t>(*value) : std::nullopt;
}

void Decoder::reset() {
  buffer_.clear();
  ended_ = false;
}

Decoder::Event Decoder::push(std::uint8_t byte) {
  if (ended_) reset();
  const bool in_packet = !buffer_.empty() && buffer_[0] == kStart;
  if (!in_packet && byte != kStart) return push_line(byte);
  // No line has a byte AA: what stood before the packet was noise (assumed).
  if (!in_packet) buffer_.clear();
  buffer_.push(byte);

  const std::size_t size = frame_size(kFraming, buffer_.bytes());
  if (size == 0 || buffer_.size() < size) return Event::kNone;
  ended_ = true;
  packet_ = {.address = buffer_[1]};
  if (protocol::sum8(bytes().subspan(1, size - 2)) != byte) return Event::kBadSum;
  read(packet_, buffer_[3], bytes().subspan(kHeader, buffer_[kFraming.length_at]));
  return Event::kPacket;
}

Decoder::Event Decoder::push_line(std::uint8_t byte) {
  if (byte == '\n') return Event::kNone;
  if (byte != '\r') {
    if (!buffer_.full()) buffer_.push(byte);
    return Event::kNone;
  }
  line_ = read_line(protocol::as_text(bytes()));
  ended_ = true;
  return Event::kLine;
}

PacketReplyDecoder::PacketReplyDecoder(const Packet& request, const ReplyFormat& format)
    : fields_(reply_fields(request)), trace_(is_trace(*request.row)), format_(format) {}

// Bytes of the data, as far as can be told.
std::size_t PacketReplyDecoder::data_size() const {
  if (status() != Status::kOk) return 0;
  if (!trace_) return protocol::width(fields_);
  const auto data = bytes().subspan(std::min(format_.status_bytes, buffer_.size()));
  if (data.size() < kTraceHeader) return kTraceHeader;
  const std::size_t count = data[0] | static_cast<std::size_t>(data[1]) << 8;
  return kTraceHeader + std::min(count, kTraceSize) * (data[2] == 4 ? 4 : 2);
}

PacketReplyDecoder::Event PacketReplyDecoder::push(std::uint8_t byte) {
  if (ended_) buffer_.clear();
  ended_ = false;
  buffer_.push(byte);
  const std::size_t before_sum = format_.status_bytes + data_size();
  if (buffer_.size() < before_sum + 1) return Event::kNone;
  ended_ = true;
  values_ = {};
  samples_.clear();
  if (protocol::sum8(bytes().first(before_sum)) != byte) return Event::kBadSum;
  if (status() != Status::kOk) return Event::kReply;
  const auto data = bytes().subspan(format_.status_bytes, before_sum - format_.status_bytes);
  if (!trace_) {
    values_ = protocol::unpack(fields_, kFraming.order, data);
    return Event::kReply;
  }
  const WireType type = data[2] == 4 ? WireType::kI32 : WireType::kI16;
  for (std::size_t at = kTraceHeader; at < data.size(); at += protocol::width(type)) {
    samples_.push_back(static_cast<std::int32_t>(
        protocol::load(data.subspan(at, protocol::width(type)), type, kFraming.order)));
  }
  return Event::kReply;
}

LineReplyDecoder::Event LineReplyDecoder::push(std::uint8_t byte) {
  const bool at_start = std::exchange(line_ended_, false);
  if (at_start) buffer_.clear();
  // An axis may stand before the prompt.
  const bool axis_before =
      after_end_ && buffer_.size() == 1 && protocol::is_digit(char(buffer_[0]));
  if (at_start || axis_before) {
    if (byte == kAcceptedPrompt || byte == kRefusedPrompt) {
      buffer_.clear();
      after_end_ = false;
      return byte == kAcceptedPrompt ? Event::kAccepted : Event::kRefused;
    }
  }
  after_end_ = at_start;
  const bool after_cr = std::exchange(cr_, byte == '\r');
  if (byte == '\n' && after_cr) {
    line_ended_ = true;
    return buffer_.empty() ? Event::kNone : Event::kText;
  }
  if (!cr_ && !buffer_.full()) buffer_.push(byte);
  return Event::kNone;
}

std::string_view LineReplyDecoder::text() const {
  return protocol::as_text(buffer_.bytes());
}

}  // namespace virtdrive::rzt1
