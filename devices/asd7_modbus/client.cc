#include "devices/asd7_modbus/client.h"

#include <fmt/format.h>

#include "core/check.h"

namespace virtdrive::asd7_modbus {
namespace {

const CommandRow& function_row(std::uint16_t code) {
  const CommandRow* row = protocol::find(kTable.commands, code);
  VIRTDRIVE_CHECK(row != nullptr, "no function {}", code);
  return *row;
}

}  // namespace

std::int64_t Client::read(const ParameterRow& row) {
  const protocol::Values values = call(function_row(kRead), {row.id, 1});
  const std::int64_t word = values.size() > 1 ? values[1] : 0;
  return protocol::is_signed(row.type) && word >= 0x8000 ? word - 0x10000 : word;
}

void Client::write(const ParameterRow& row, std::int64_t value) {
  call(function_row(kWrite), {row.id, value & 0xFFFF});
}

protocol::Values Client::call(const CommandRow& row, const protocol::Values& request) {
  const std::string what = fmt::format("{} {:04X}", row.name, static_cast<unsigned>(request[0]));
  // What is still on its way from before would be taken for the answer.
  while (transport_.read(SimDuration{})) {
  }
  transport_.write(encode_request(unit_, row, request));
  if (unit_ == kAllDrives) return {};
  std::vector<std::uint8_t> bytes;
  while (const auto byte = transport_.read(patience_)) {
    bytes.push_back(*byte);
    const std::size_t size = expected_size(protocol::Direction::kReply, bytes);
    if (bytes.size() != size && bytes.size() < kLongestFrame) continue;
    Frame reply;
    if (decode(protocol::Direction::kReply, bytes, reply) != FrameError::kNone) {
      throw ClientError(fmt::format("{}: wrong CRC", what));
    }
    if (reply.exception) {
      throw DriveRefused(fmt::format("{}: the drive answers exception {}", what, *reply.exception),
                         *reply.exception);
    }
    if (reply.row != &row || !reply.values) {
      throw ClientError(fmt::format("{}: the drive answers something else", what));
    }
    return *reply.values;
  }
  throw DriveSilent(fmt::format("{}: the drive does not answer", what));
}

}  // namespace virtdrive::asd7_modbus
