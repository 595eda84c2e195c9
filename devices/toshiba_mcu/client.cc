#include "devices/toshiba_mcu/client.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"

namespace virtdrive::toshiba_mcu {
namespace {

const ParameterRow& row_named(std::string_view name) {
  const auto it = std::ranges::find(kTable.parameters, name, &ParameterRow::name);
  VIRTDRIVE_CHECK(it != kTable.parameters.end(), "no parameter {}", name);
  return *it;
}

}  // namespace

protocol::Values Client::call(std::uint8_t command, const protocol::Values& request) {
  const CommandRow* row = protocol::find(kTable.commands, command);
  VIRTDRIVE_CHECK(row != nullptr, "no command {:#x}", command);
  transport_.write(encode_request(*row, request));

  Decoder decoder(Direction::kReply);
  while (true) {
    const auto byte = transport_.read(patience_);
    if (!byte) throw DriveSilent(fmt::format("{}: the drive does not answer", row->name));
    switch (decoder.push(*byte)) {
      case Decoder::Event::kTelegram:
        if (decoder.telegram().row == &kErrorReply) {
          const std::int64_t code = decoder.telegram().values[0];
          throw DriveRefused(fmt::format("{}: refused with code {}", row->name, code), code);
        }
        if (decoder.telegram().row == row) return decoder.telegram().values;
        throw ClientError(
            fmt::format("{}: answered with {}", row->name, decoder.telegram().row->name));
      case Decoder::Event::kBadCrc:
      case Decoder::Event::kBadEnd:
        throw ClientError(fmt::format("{}: the answer is damaged", row->name));
      default:
        break;
    }
  }
}

MotorState Client::motor_state(std::uint8_t motor_nr) {
  const protocol::Values v = call(0x02, {motor_nr});
  return {static_cast<std::int32_t>(v[0]), static_cast<std::int32_t>(v[1]),
          static_cast<std::uint32_t>(v[2]), static_cast<std::uint32_t>(v[3]),
          static_cast<std::uint32_t>(v[4])};
}

UnitValue Client::get(std::uint8_t motor_nr, std::string_view parameter) {
  const protocol::Values v = call(0x09, {motor_nr, row_named(parameter).id, 0});
  return {static_cast<std::int32_t>(v[0]), static_cast<std::int8_t>(v[1])};
}

void Client::set(std::uint8_t motor_nr, std::string_view parameter, UnitValue value) {
  call(0x0A, {motor_nr, row_named(parameter).id, value.unit, value.value});
}

std::string Client::version() {
  const protocol::Values v = call(0x14, {0});
  return fmt::format("{}.{}", v[0], v[1]);
}

}  // namespace virtdrive::toshiba_mcu
