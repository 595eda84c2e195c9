#include "plant/pmsm.h"

#include <cmath>

#include "core/check.h"

namespace virtdrive {

void validate(const PmsmParameters& motor) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("motor: {}, not {}", what, value));
  };
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  require(motor.pole_pairs >= 1, "pole_pairs must be 1 or more", motor.pole_pairs);
  require(std::isfinite(motor.resistance_ohm) && motor.resistance_ohm >= 0,
          "resistance_ohm must be 0 or more", motor.resistance_ohm);
  require(positive(motor.inductance_d_h), "inductance_d_h must be above 0", motor.inductance_d_h);
  require(positive(motor.inductance_q_h), "inductance_q_h must be above 0", motor.inductance_q_h);
  require(std::isfinite(motor.flux_wb) && motor.flux_wb >= 0, "flux_wb must be 0 or more",
          motor.flux_wb);
  require(positive(motor.rated_current_a), "rated_current_a must be above 0",
          motor.rated_current_a);
}

Dq steady_state_voltage_v(const PmsmParameters& motor, Dq current_a, double speed_radps) {
  return {motor.resistance_ohm * current_a.d - speed_radps * motor.inductance_q_h * current_a.q,
          motor.resistance_ohm * current_a.q +
              speed_radps * (motor.inductance_d_h * current_a.d + motor.flux_wb)};
}

Dq mtpa_current_a(const PmsmParameters& motor, double amplitude_a) {
  // d(torque)/d(angle) = 0 is 2 dL id^2 - psi id - dL I^2 = 0 with dL = Lq - Ld; the root that is
  // finite for dL = 0, in the form that does not cancel.
  const double saliency = motor.inductance_q_h - motor.inductance_d_h;
  const double x = saliency * amplitude_a;
  const double denominator = motor.flux_wb + std::sqrt(motor.flux_wb * motor.flux_wb + 8 * x * x);
  const double d = denominator > 0 ? -2 * x * amplitude_a / denominator : 0;
  return {d,
          std::copysign(std::sqrt(std::max(0.0, amplitude_a * amplitude_a - d * d)), amplitude_a)};
}

}  // namespace virtdrive
