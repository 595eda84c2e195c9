#include "devices/md485/codec.h"

#include <utility>

#include "devices/md485/model_table.h"
#include "devices/protocol/checksum.h"

namespace virtdrive::md485 {
namespace {

constexpr std::size_t kHeader = kTable.framing.length_at + 1;

std::vector<std::uint8_t> encode(std::uint8_t to, std::uint8_t from, std::uint8_t id,
                                 std::uint16_t pid, std::span<const Field> fields,
                                 const protocol::Values& values) {
  std::vector<std::uint8_t> bytes = {to, from, id, static_cast<std::uint8_t>(pid),
                                     static_cast<std::uint8_t>(protocol::width(fields))};
  protocol::pack(fields, kTable.framing.order, values, bytes);
  bytes.push_back(protocol::negated_sum8(bytes));
  return bytes;
}

// A text is as long as its frame says.
std::vector<Field> fields_of(const Frame& frame, bool request, std::size_t bytes) {
  if (frame.command != nullptr) {
    return {frame.command->request.begin(), frame.command->request.end()};
  }
  if (frame.parameter->type == WireType::kText && bytes > 0 && bytes <= frame.parameter->count) {
    return {{.name = frame.parameter->name, .type = WireType::kText, .count = bytes}};
  }
  return request ? write_fields(*frame.parameter) : protocol::value_fields(*frame.parameter);
}

}  // namespace

std::vector<std::uint8_t> encode_request(Route route, const CommandRow& row,
                                         const protocol::Values& values) {
  return encode(kController, route.host, route.id, row.code, row.request, values);
}

std::vector<std::uint8_t> encode_request(Route route, const ParameterRow& row,
                                         const protocol::Values& values) {
  return encode(kController, route.host, route.id, row.id, write_fields(row), values);
}

std::vector<std::uint8_t> encode_reply(Route route, const ParameterRow& row,
                                       const protocol::Values& values) {
  return encode(route.host, kController, route.id, row.id, protocol::value_fields(row), values);
}

DataVerdict read_data(protocol::Direction direction, std::span<const std::uint8_t> data,
                      Frame& frame) {
  const bool request = direction == protocol::Direction::kRequest;
  frame.command = request ? protocol::find(kTable.commands, frame.pid) : nullptr;
  frame.parameter =
      frame.command != nullptr ? nullptr : protocol::find(kTable.parameters, frame.pid);
  if (frame.command == nullptr && frame.parameter == nullptr) return DataVerdict::kUnknownPid;
  const std::vector<Field> fields = fields_of(frame, request, data.size());
  const auto values = protocol::unpack_some(fields, kTable.framing.order, data);
  if (!values) return DataVerdict::kTooShort;
  frame.values = *values;
  return DataVerdict::kGood;
}

void Decoder::reset() {
  buffer_.clear();
  ended_ = 0;
  shown_ = 0;
}

std::span<const std::uint8_t> Decoder::bytes() const {
  return shown_ > 0 ? buffer_.bytes().first(shown_) : buffer_.bytes().subspan(ended_);
}

bool Decoder::can_start() const {
  if (direction_ == protocol::Direction::kReply) {
    return buffer_[0] == host_ && (buffer_.size() < 2 || buffer_[1] == kController);
  }
  if (buffer_[0] == kController) return true;
  return hosts_[buffer_[0]] && (buffer_.size() < 2 || buffer_[1] == kController);
}

Decoder::Event Decoder::push(std::uint8_t byte) {
  buffer_.drop(std::exchange(ended_, 0));
  buffer_.push(byte);
  return next();
}

Decoder::Event Decoder::next() {
  buffer_.drop(std::exchange(ended_, 0));
  shown_ = 0;
  bool noise = false;
  while (!buffer_.empty() && !can_start()) {
    buffer_.drop(1);
    noise = true;
  }
  const std::size_t size = frame_size(kTable.framing, buffer_.bytes());
  if (size == 0 || buffer_.size() < size) return noise ? Event::kNoise : Event::kNone;

  shown_ = size;
  const auto bytes = buffer_.bytes().first(size);
  ended_ = protocol::sum8(bytes) == 0 ? size : 1;
  return ended_ == size ? read(bytes) : Event::kBadSum;
}

Decoder::Event Decoder::expire() {
  Event event = next();
  while (!idle() && (event == Event::kNone || event == Event::kNoise)) {
    ended_ = 1;
    event = next();
  }
  return event;
}

Decoder::Event Decoder::read(std::span<const std::uint8_t> bytes) {
  const bool request = direction_ == protocol::Direction::kRequest;
  if (request && bytes[0] != kController) return Event::kNoise;
  if (request) hosts_.set(bytes[1]);
  frame_ = {.route = {.host = bytes[request ? 1 : 0], .id = bytes[2]}, .pid = bytes[3]};
  switch (read_data(direction_, bytes.subspan(kHeader, bytes[kTable.framing.length_at]), frame_)) {
    case DataVerdict::kUnknownPid:
      return Event::kUnknownPid;
    case DataVerdict::kTooShort:
      return Event::kTooShort;
    case DataVerdict::kGood:
      break;
  }
  return Event::kFrame;
}

}  // namespace virtdrive::md485
