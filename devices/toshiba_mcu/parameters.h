// The rows of the parameter table joined to the firmware: every read and write of a parameter.
#pragma once

#include <cstdint>
#include <string_view>

#include "devices/toshiba_mcu/table.h"
#include "firmware_models/toshiba_mcu/firmware.h"

namespace virtdrive::toshiba_mcu {

class Parameters {
 public:
  explicit Parameters(Firmware& firmware) : firmware_(firmware) {}

  /// `motor_nr` is a channel, or 0xFF for the system. kRefused if the channel or the id is unknown,
  /// the parameter write-only, or not the system's.
  Outcome read(std::uint8_t motor_nr, std::uint8_t id, std::uint8_t offset, UnitValue& result);
  /// kRefused, and nothing written, also for a value out of range and an unlisted unit.
  Outcome write(std::uint8_t motor_nr, std::uint8_t id, UnitValue value);

 private:
  Firmware& firmware_;
};

}  // namespace virtdrive::toshiba_mcu
