// What users and scenarios write of this drive, in the words of its table: "2.IqStart=1200mA".
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>

#include "devices/host_transport.h"
#include "devices/toshiba_mcu/table.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct ToshibaMcuAssignment {
  std::optional<std::size_t> channel;
  const toshiba_mcu::ParameterRow* row;
  toshiba_mcu::UnitValue value;
};

/// [CHANNEL.]NAME=NUMBER[UNIT]; SetupError that names the part that is wrong.
ToshibaMcuAssignment parse_toshiba_mcu_assignment(std::string_view text);

std::unique_ptr<HostClient> make_toshiba_mcu_host(std::unique_ptr<HostTransport> transport);

}  // namespace virtdrive
