#include "devices/asd7_modbus/codec.h"

#include "devices/protocol/checksum.h"

namespace virtdrive::asd7_modbus {
namespace {

using protocol::Direction;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kHead = 2, kCrc = 2;  // unit and function; CRC
constexpr auto kOrder = kTable.framing.order;

std::span<const Field> fields_of(const CommandRow& row, Direction direction) {
  return direction == Direction::kRequest ? row.request : row.reply;
}

Bytes encode(std::uint8_t unit, std::uint8_t function, std::span<const Field> fields,
             const protocol::Values& values) {
  Bytes frame = {unit, function};
  protocol::pack(fields, kOrder, values, frame);
  const std::uint16_t crc = protocol::crc16_modbus(frame);
  frame.push_back(static_cast<std::uint8_t>(crc));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  return frame;
}

}  // namespace

FrameError decode(Direction direction, std::span<const std::uint8_t> bytes, Frame& frame) {
  if (bytes.size() < kHead + kCrc) return FrameError::kTooShort;
  const auto body = bytes.first(bytes.size() - kCrc);
  const unsigned crc = bytes[body.size()] | bytes[body.size() + 1] << 8U;
  if (protocol::crc16_modbus(body) != crc) return FrameError::kCrc;
  const auto data = body.subspan(kHead);
  frame = {.unit = body[0], .function = body[1]};
  const bool excepted = direction == Direction::kReply && (frame.function & kExceptionBit) != 0;
  const auto code =
      static_cast<std::uint8_t>(excepted ? frame.function ^ kExceptionBit : frame.function);
  frame.row = protocol::find(kTable.commands, code);
  if (excepted) {
    if (data.size() == 1) frame.exception = data[0];
  } else if (frame.row != nullptr) {
    const auto fields = fields_of(*frame.row, direction);
    if (data.size() == protocol::width(fields)) {
      frame.values = protocol::unpack(fields, kOrder, data);
    }
  }
  return FrameError::kNone;
}

std::size_t expected_size(Direction direction, std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHead) return 0;
  if (direction == Direction::kReply && (bytes[1] & kExceptionBit) != 0) return kHead + 1 + kCrc;
  const CommandRow* row = protocol::find(kTable.commands, bytes[1]);
  return row == nullptr ? 0 : kHead + protocol::width(fields_of(*row, direction)) + kCrc;
}

Bytes encode_request(std::uint8_t unit, const CommandRow& row, const protocol::Values& values) {
  return encode(unit, static_cast<std::uint8_t>(row.code), row.request, values);
}

Bytes encode_reply(std::uint8_t unit, const CommandRow& row, const protocol::Values& values) {
  return encode(unit, static_cast<std::uint8_t>(row.code), row.reply, values);
}

Bytes encode_exception(std::uint8_t unit, std::uint8_t function, Exception exception) {
  constexpr Field kCode[] = {{.name = "exception"}};
  return encode(unit, static_cast<std::uint8_t>(function | kExceptionBit), kCode,
                {static_cast<std::int64_t>(exception)});
}

}  // namespace virtdrive::asd7_modbus
