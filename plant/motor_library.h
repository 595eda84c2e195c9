// Motors by name, each with where its numbers come from.
#pragma once

#include <span>
#include <string_view>

#include "plant/mechanics.h"
#include "plant/pmsm.h"

namespace virtdrive {

struct Motor {
  std::string_view name;         // lower case
  std::string_view description;  // one line
  double rated_voltage_v;        // DC link, unless the description says otherwise
  PmsmParameters electrical;     // holds the rated current
  MechanicsParameters mechanics;
  std::string_view source;
  std::string_view assumed;  // what no source gives; "" if nothing is
};

std::span<const Motor> motor_library();

/// Throws SetupError with the nearest names for an unknown one.
const Motor& find_motor(std::string_view name);

}  // namespace virtdrive
