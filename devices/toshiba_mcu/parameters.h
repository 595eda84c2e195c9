// The rows of the parameter table joined to the firmware: every read and write of a parameter.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/nvm.h"
#include "devices/toshiba_mcu/table.h"
#include "firmware_models/toshiba_mcu/firmware.h"

namespace virtdrive::toshiba_mcu {

class Parameters {
 public:
  Parameters(Firmware& firmware, NonVolatileMemory& memory)
      : firmware_(firmware), memory_(memory) {}

  /// `motor_nr` is a channel, or 0xFF for the system. kRefused if the channel or the id is unknown,
  /// the parameter write-only, or not the system's.
  Outcome read(std::uint8_t motor_nr, std::uint8_t id, std::uint8_t offset, UnitValue& result);
  /// kRefused, and nothing written, also for a value out of range and an unlisted unit.
  Outcome write(std::uint8_t motor_nr, std::uint8_t id, UnitValue value);

  /// Keeps a channel's settings; false if the memory failed.
  bool store(std::size_t channel);
  bool clear() { return memory_.erase(); }
  /// What a reset does: settings that were stored by this firmware version, and are whole, take the
  /// place of the factory's.
  void restore();

 private:
  Firmware& firmware_;
  NonVolatileMemory& memory_;
};

}  // namespace virtdrive::toshiba_mcu
