#include "plant/mains.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

using std::numbers::pi;
using std::numbers::sqrt2;
using std::numbers::sqrt3;

/// Rounding cannot make the diodes chatter.
constexpr double kHysteresisV = 1e-6;
constexpr double kZeroA = 1e-6;

std::array<double, 3> phase_values(double phase_rad) {
  const double c = std::cos(phase_rad), s = std::sin(phase_rad) * (sqrt3 / 2);
  return {c, s - c / 2, -s - c / 2};
}

}  // namespace

void validate(const MainsParameters& mains) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("mains: {}, not {}", what, value));
  };
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  const auto not_negative = [](double x) { return std::isfinite(x) && x >= 0; };
  require(mains.phases == 0 || mains.phases == 1 || mains.phases == 3, "phases must be 1 or 3",
          mains.phases);
  if (mains.phases == 0) return;
  require(positive(mains.voltage_v), "voltage_v must be above 0", mains.voltage_v);
  require(positive(mains.frequency_hz), "frequency_hz must be above 0", mains.frequency_hz);
  require(not_negative(mains.resistance_ohm), "resistance_ohm must be 0 or more",
          mains.resistance_ohm);
  require(positive(mains.inductance_h), "inductance_h must be above 0", mains.inductance_h);
  require(not_negative(mains.charging_ohm), "charging_ohm must be 0 or more", mains.charging_ohm);
}

RectifiedMains::RectifiedMains(const MainsParameters& parameters) : p(parameters) {
  validate(p);
  if (!any()) return;
  omega_ = 2 * pi * p.frequency_hz;
  corner_rad_ = p.phases == 3 ? pi / 6 : pi / 2;
  inverse_inductance_ = 1 / p.inductance_h;
  prepare();
}

void RectifiedMains::set_input(const MainsInput& input) {
  for (const double level : input.level) {
    VIRTDRIVE_CHECK(level >= 0 && level <= 1.5, "mains level {}", level);
  }
  input_ = input;
  if (any()) prepare();
}

void RectifiedMains::prepare() {
  resistance_ohm_ = p.resistance_ohm + (input_.contact ? 0 : p.charging_ohm);
  const double line_peak_v = sqrt2 * p.voltage_v;
  const auto& on = input_.connected;
  if (p.phases == 1) {
    peak_v_ = on[0] && on[1] ? input_.level[0] * line_peak_v : 0;
    pulse_s_ = 0.5 / p.frequency_hz;
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) peak_of_phase_[k] = input_.level[k] * line_peak_v / sqrt3;
  const bool all = on[0] && on[1] && on[2];
  balanced_ = all && input_.level[0] == input_.level[1] && input_.level[1] == input_.level[2];
  pulse_s_ = (balanced_ ? 1.0 / 6 : 0.5) / p.frequency_hz;
  peak_v_ = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (!on[k] || !on[next]) continue;
    const double a = peak_of_phase_[k], b = peak_of_phase_[next];
    peak_v_ = std::max(peak_v_, std::sqrt(a * a + b * b + a * b));  // 120 degrees apart
  }
}

double RectifiedMains::rectified_v(double phase_rad) const {
  if (p.phases == 1) return std::fabs(peak_v_ * std::cos(phase_rad));
  if (balanced_) {
    // Between two corners the envelope is the top of one line's sine.
    constexpr double kSixth = pi / 3;
    const double within = phase_rad - kSixth * std::floor(phase_rad / kSixth);
    return peak_v_ * std::cos(within - kSixth / 2);
  }
  const std::array<double, 3> unit = phase_values(phase_rad);
  double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!input_.connected[k]) continue;
    const double v = peak_of_phase_[k] * unit[k];
    highest = std::max(highest, v);
    lowest = std::min(lowest, v);
  }
  return std::max(0.0, highest - lowest);
}

double RectifiedMains::margin(double phase_rad, double current_a, double link_v) const {
  if (conducts) return current_a + kZeroA;
  return link_v + kHysteresisV - rectified_v(phase_rad);
}

bool RectifiedMains::follow(double phase_rad, double& current_a, double link_v) {
  if (margin(phase_rad, current_a, link_v) > 0) return false;
  conducts = !conducts;
  current_a = 0;
  return true;
}

double RectifiedMains::next_corner_s(double phase_rad) const {
  // A step that ends at a corner leaves it a hair behind, up to the nanosecond that time is cut to.
  const double hair = 2e-9 * omega_ / corner_rad_;
  const double place = phase_rad / corner_rad_;
  return (std::floor(place + hair) + 1 - place) * corner_rad_ / omega_;
}

// A small current flows in short pulses around the peaks of e: from the angle -a, where e = v, to
// 2 a, with the charge 9/8 peak a^4 / (w^2 L).
double RectifiedMains::resting_v(double current_a) const {
  if (peak_v_ == 0) return 0;
  const double charge_c = current_a * pulse_s_;
  const double a =
      std::sqrt(std::sqrt(charge_c * omega_ * omega_ * p.inductance_h / (1.125 * peak_v_)));
  return std::max(0.0, peak_v_ * std::cos(std::min(a, 0.5)) - resistance_ohm_ * current_a);
}

double RectifiedMains::step_limit_s(double capacitance_f) const {
  const double swing_s = 0.2 * std::sqrt(p.inductance_h * capacitance_f);
  // Charging is slow beside L / R, whose accuracy does not matter then.
  return resistance_ohm_ > 0 ? std::min(swing_s, p.inductance_h / resistance_ohm_) : swing_s;
}

}  // namespace virtdrive
