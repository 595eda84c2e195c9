// What users and scenarios write of an RZ/T1 board, in the words of its table.
//
//   KP          2.KP           a variable, in packets, by the module's address (1 if none is told)
//   ascii.KP    ascii.2.KP     the same in a line, by the axis
//   2.ON        ascii.ON       a function
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "devices/host_transport.h"
#include "devices/rzt1/table.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct Rzt1Name {
  bool in_lines = false;
  std::optional<std::uint8_t> number;  // address of a packet, axis of a line
  std::string_view name;
};
/// SetupError for a number out of 1 ... 255.
Rzt1Name parse_rzt1_name(std::string_view text);

struct Rzt1Assignment {
  Rzt1Name name;
  const rzt1::ParameterRow* row;
  std::int64_t value;
};
/// NAME=NUMBER, decimal, 0x or octal as the board takes it; SetupError that names the wrong part.
Rzt1Assignment parse_rzt1_assignment(std::string_view text);

std::unique_ptr<HostClient> make_rzt1_host(std::unique_ptr<HostTransport> transport);

}  // namespace virtdrive
