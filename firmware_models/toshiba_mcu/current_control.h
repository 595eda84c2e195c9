// Currents: counts to d and q, the two controllers, the space vector.
//
// Once each PWM period, as the vector engine's schedule runs: zero_current() four times before a
// start, then measure() and, when angle and references are known, control(). The gates' duties come
// out of it.
#pragma once

#include <array>

#include "firmware_models/toshiba_mcu/loop_state.h"
#include "firmware_models/toshiba_mcu/reading.h"
#include "firmware_models/toshiba_mcu/settings.h"

namespace virtdrive::toshiba_mcu {

class CurrentControl {
 public:
  void begin_zero_current();
  /// True when enough periods were averaged: the amplifiers' zero is known.
  bool zero_current(const Reading& reading);

  void measure(const Reading& reading, const ChannelSettings& settings, const Scaling& scaling,
               LoopState& now) const;
  /// From references and measurements to voltages and duties. The voltage ends at the circle of
  /// Vdc / sqrt(3); both integrators are calculated back from what is put out.
  void control(const Scaling& scaling, LoopState& now) const;

 private:
  int zero_periods_ = 0;
  std::array<int, 3> zero_sum_{};
  std::array<double, 3> zero_counts_{};
};

}  // namespace virtdrive::toshiba_mcu
