// Six-step commutation by ideal Hall sensors, for tests and benchmarks.
#pragma once

#include <cmath>
#include <numbers>

#include "plant/axis.h"

namespace virtdrive {

struct SixStep {
  double duty = 1;  // of the upper switch
  SimDuration pwm_period{0};
  SimDuration dead_time{0};
  int direction = 1;
  int last_sector = -1;

  /// The pair of phases under the flat tops at the rotor's angle.
  static int sector(double electrical_rad) {
    const int sixth = static_cast<int>(
        std::floor((electrical_rad + std::numbers::pi / 6) / (std::numbers::pi / 3)));
    return ((sixth + 2) % 6 + 6) % 6;
  }

  BridgeCommand command(int sector) const {
    constexpr std::size_t kPlus[] = {0, 0, 1, 1, 2, 2}, kMinus[] = {1, 2, 2, 0, 0, 1};
    const auto s = static_cast<std::size_t>(direction > 0 ? sector : (sector + 3) % 6);
    BridgeCommand c{.mode = Bridge::kDriven,
                    .legs = {Leg::kHiZ, Leg::kHiZ, Leg::kHiZ},
                    .pwm_period = pwm_period,
                    .dead_time = dead_time};
    c.legs[kPlus[s]] = duty < 1 ? Leg::kDuty : Leg::kHigh;
    c.duty[kPlus[s]] = duty;
    c.legs[kMinus[s]] = Leg::kLow;
    return c;
  }

  /// Advances to `end`, looking at the sensors every `step`. `each` is called after each step.
  template <class Each>
  void run(Axis& axis, SimTime end, SimDuration step, const Each& each) {
    while (axis.now() < end) {
      const int now = sector(axis.electrical_angle_rad());
      if (now != last_sector) {
        last_sector = now;
        axis.set_bridge(command(now));
      }
      axis.advance_to(std::min(end, axis.now() + step));
      each();
    }
  }
  void run(Axis& axis, SimTime end, SimDuration step) {
    run(axis, end, step, [] {});
  }
};

}  // namespace virtdrive
