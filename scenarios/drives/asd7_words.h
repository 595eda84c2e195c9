// What users and scenarios write of a 7-Series drive, in the words of its table: "ACC=5s",
// "F803=10", "frequency=60Hz", "command=0x8400".
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "devices/asd7/table.h"
#include "devices/host_transport.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct Asd7Assignment {
  std::optional<std::uint8_t> number;  // of the drive that is meant
  const asd7::ParameterRow* row;
  std::int64_t value;  // as the register holds it
};

/// [NUMBER.]NAME=VALUE[UNIT]: NAME a row's, Fnnn, or four hexadecimal digits; VALUE in the row's
/// unit, or in one that measures the same, or 0x and the register's word. SetupError that names the
/// part that is wrong.
Asd7Assignment parse_asd7_assignment(std::string_view text);

std::unique_ptr<HostClient> make_asd7_host(std::unique_ptr<HostTransport> transport);
std::unique_ptr<HostClient> make_asd7_modbus_host(std::unique_ptr<HostTransport> transport);

}  // namespace virtdrive
