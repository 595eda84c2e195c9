// What the MCU's converters, counters and pins read at one instant.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_models/toshiba_mcu/scaling.h"

namespace virtdrive::toshiba_mcu {

struct Reading {
  std::array<int, 3> current_counts{kAdcMiddle, kAdcMiddle, kAdcMiddle};
  int bus_counts = 0;
  std::int64_t encoder_count = 0;  // edges that the input chosen by Encoder has counted
  bool emergency_pin = false;
  bool over_voltage_pin = false;
};

}  // namespace virtdrive::toshiba_mcu
