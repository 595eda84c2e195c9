#include "firmware_models/toshiba_mcu/observer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

double estimate_hz(double base_hz, const Scaling& scaling, const LoopState& now) {
  const double emf_d = now.vd_v - scaling.resistance_ohm * now.id_a +
                       kTwoPi * now.omega_hz * scaling.inductance_h * now.iq_a;
  const double estimate = base_hz - std::copysign(scaling.position_kp_hz_per_v, base_hz) * emf_d;
  // The register ends at full scale.
  return std::clamp(estimate, -scaling.full_scale_hz, scaling.full_scale_hz);
}

}  // namespace

void Observer::advance(Stage stage, double base_hz, const Scaling& scaling, LoopState& now) {
  if (stage != Stage::kForce && stage != Stage::kFoc) {
    now.omega_hz = now.omega_calc_hz = 0;
    return;
  }
  now.omega_calc_hz = estimate_hz(base_hz, scaling, now);
  now.omega_hz = stage == Stage::kFoc ? now.omega_calc_hz : now.command_hz;
  const double step = now.omega_hz * 1e-9 * static_cast<double>(scaling.pwm_period.count());
  turns_ += step;
  now.theta_turns += step;
  now.theta_turns -= std::floor(now.theta_turns);
  now.sine = std::sin(kTwoPi * now.theta_turns);
  now.cosine = std::cos(kTwoPi * now.theta_turns);
}

void Observer::align(LoopState& now) {
  turns_ = std::round(turns_);
  now.theta_turns = 0;
  now.sine = 0;
  now.cosine = 1;
}

void Observer::turn_frame_over(LoopState& now) {
  now.theta_turns += now.theta_turns < 0.5 ? 0.5 : -0.5;
  now.sine = -now.sine;
  now.cosine = -now.cosine;
  for (double* const x : {&now.id_a, &now.iq_a, &now.iq_integral_a, &now.vd_integral_v,
                          &now.vq_integral_v, &now.vd_v, &now.vq_v}) {
    *x = -*x;
  }
}

}  // namespace virtdrive::toshiba_mcu
