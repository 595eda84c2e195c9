// What several tests of the plant share: a bench with a db42s03, and a dq voltage put on it.
#pragma once

#include <algorithm>
#include <cmath>

#include "plant/axis.h"
#include "plant/motor_library.h"

namespace virtdrive {

inline constexpr SimDuration kPwmPeriod = std::chrono::microseconds(80);

/// db42s03 behind an ideal 24 V unless changed.
inline AxisParameters small_bench(double source_resistance_ohm = 0) {
  const Motor& motor = find_motor("db42s03");
  return {.motor = motor.electrical,
          .link = {.source_v = 24, .resistance_ohm = source_resistance_ohm, .capacitance_f = 1e-3},
          .mechanics = motor.mechanics};
}

/// Duties that give this dq voltage at the rotor's angle in the middle of the coming period.
inline PhaseValues duty_for(const Axis& axis, Dq voltage_v, SimDuration period = kPwmPeriod) {
  const AxisState& x = axis.state();
  const double angle =
      axis.parameters().motor.pole_pairs * (x.angle_rad + x.speed_radps * seconds(period) / 2);
  PhaseValues duty = inverse_clarke(inverse_park(voltage_v, Rotation(angle)));
  for (double& d : duty) d = std::clamp(d / x.bus_v + 0.5, 0.0, 1.0);
  return duty;
}

/// Drives with a dq voltage for some periods, a new duty in each.
inline void drive(Axis& axis, Dq voltage_v, int periods) {
  for (int k = 0; k < periods; ++k) {
    axis.set_bridge(
        {.mode = Bridge::kDriven, .duty = duty_for(axis, voltage_v), .pwm_period = kPwmPeriod});
    axis.advance_to(axis.now() + kPwmPeriod);
  }
}

/// Turns the shaft to a speed within 100 ms, gates off, and leaves it with `load`.
inline void spin_up(Axis& axis, double speed_radps, const Load& load = {}) {
  using namespace std::chrono_literals;
  const MechanicsParameters& m = axis.parameters().mechanics;
  axis.set_bridge({.mode = Bridge::kOff});
  const double torque = m.inertia_kgm2 * speed_radps / 0.1;
  axis.set_load({.external_torque_nm = -(torque + std::copysign(m.coulomb_nm, speed_radps))});
  axis.advance_to(axis.now() + 100ms);
  axis.set_load(load);
}

inline double current_a(const Axis& axis) {
  return std::hypot(axis.state().i_d_a, axis.state().i_q_a);
}

}  // namespace virtdrive
