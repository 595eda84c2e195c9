#include "plant/motor_curves.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kNever = std::numeric_limits<double>::infinity();

// At standstill too: what starts must break away.
double friction_nm(const Motor& motor, double speed_radps) {
  return motor.mechanics.viscous_nm_per_radps * speed_radps + motor.mechanics.coulomb_nm;
}

double length(Dq x) {
  return std::hypot(x.d, x.q);
}

Dq voltage_at(const Motor& motor, Dq current_a, double speed_radps) {
  return steady_state_voltage_v(motor.electrical, current_a,
                                motor.electrical.pole_pairs * speed_radps);
}

OperatingPoint point_at(const Motor& motor, Dq current_a, double speed_radps) {
  OperatingPoint point;
  point.speed_radps = speed_radps;
  const double air_gap_nm = torque_nm(motor.electrical, current_a);
  point.torque_nm = air_gap_nm - friction_nm(motor, speed_radps);
  point.current_a = current_a;
  point.voltage_v = voltage_at(motor, current_a, speed_radps);
  point.output_w = point.torque_nm * speed_radps;
  point.input_w = 1.5 * (point.voltage_v.d * current_a.d + point.voltage_v.q * current_a.q);
  return point;
}

// The greatest q current that both limits allow beside a d current; none if there is none.
// |v|^2 = a iq^2 + 2 b iq + c.
std::optional<double> greatest_q_current(const PmsmParameters& motor, const DriveLimits& limits,
                                         double d_current_a, double electrical_radps) {
  const double on_circle = limits.current_a * limits.current_a - d_current_a * d_current_a;
  if (on_circle < 0) return {};
  const double r = motor.resistance_ohm;
  const double xq = electrical_radps * motor.inductance_q_h;
  const double emf = electrical_radps * (motor.inductance_d_h * d_current_a + motor.flux_wb);
  const double a = r * r + xq * xq;
  const double b = r * emf - r * d_current_a * xq;
  const double c =
      r * r * d_current_a * d_current_a + emf * emf - limits.voltage_v * limits.voltage_v;
  double upper = std::sqrt(on_circle), lower = -upper;
  if (a > 0) {
    const double discriminant = b * b - a * c;
    if (discriminant < 0) return {};
    upper = std::min(upper, (-b + std::sqrt(discriminant)) / a);
    lower = std::max(lower, (-b - std::sqrt(discriminant)) / a);
  } else if (c > 0) {
    return {};
  }
  if (upper < lower) return {};
  return upper;
}

// Of a function with one hump, -infinity where it is not defined: a scan, then a golden section.
double argument_of_maximum(const std::function<double(double)>& f, double low, double high) {
  constexpr int kScan = 200, kSections = 60;
  const double step = (high - low) / kScan;
  int best = 0;
  double best_value = -kNever;
  for (int i = 0; i <= kScan; ++i) {
    const double value = f(low + i * step);
    if (value > best_value) {
      best = i;
      best_value = value;
    }
  }
  double left = low + std::max(0, best - 1) * step, right = low + std::min(kScan, best + 1) * step;
  for (int i = 0; i < kSections; ++i) {
    const double part = (right - left) / std::numbers::phi;
    if (f(right - part) > f(left + part)) {
      right = left + part;
    } else {
      left = right - part;
    }
  }
  const double refined = (left + right) / 2;
  return f(refined) >= best_value ? refined : low + best * step;
}

// The zero of a function that falls from positive to negative between low and high.
double zero_of(const std::function<double(double)>& f, double low, double high) {
  constexpr int kHalvings = 80;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (f(middle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

// From where a falling condition fails, beyond 0; infinite if it holds as far as doubling goes.
double last_speed(const std::function<double(double)>& f) {
  constexpr double kFastest = 1e6;
  if (f(0) <= 0) return 0;
  double high = 1;
  while (f(high) > 0) {
    high *= 2;
    if (high > kFastest) return kNever;
  }
  return zero_of(f, 0, high);
}

}  // namespace

double OperatingPoint::current_peak_a() const {
  return length(current_a);
}

double OperatingPoint::efficiency() const {
  return output_w > 0 && input_w > 0 ? output_w / input_w : 0;
}

DriveLimits limits_of(const Motor& motor, bool peak) {
  const MotorRating& rating = motor.rating;
  const double current_a =
      peak && rating.peak_current_a > 0 ? rating.peak_current_a : rating.current_a;
  return {.voltage_v = rating.voltage_v / std::numbers::sqrt3,
          .current_a = phase_peak_a(current_a, rating.counted_as)};
}

MotorConstants motor_constants(const Motor& motor) {
  const PmsmParameters& e = motor.electrical;
  const DriveLimits limits = limits_of(motor);
  MotorConstants k;
  k.torque_constant_nm_per_a = 1.5 * e.pole_pairs * e.flux_wb;
  k.torque_constant_nm_per_arms = k.torque_constant_nm_per_a * std::numbers::sqrt2;
  k.emf_v_per_radps = e.pole_pairs * e.flux_wb;
  const double line_vpk_per_rpm = std::numbers::sqrt3 * k.emf_v_per_radps / kRpmPerRadps;
  k.line_emf_vrms_per_krpm = line_vpk_per_rpm * 1000 / std::numbers::sqrt2;
  k.speed_constant_rpm_per_v = 1 / line_vpk_per_rpm;
  k.motor_constant_nm_per_rtw = k.torque_constant_nm_per_a / std::sqrt(1.5 * e.resistance_ohm);
  k.electrical_time_constant_s = e.inductance_q_h / e.resistance_ohm;
  k.mechanical_time_constant_s = motor.mechanics.inertia_kgm2 * e.resistance_ohm /
                                 (k.torque_constant_nm_per_a * k.emf_v_per_radps);
  k.rated_peak_a = limits.current_a;
  k.characteristic_current_a = e.flux_wb / e.inductance_d_h;
  k.stall_current_a = limits.voltage_v / e.resistance_ohm;
  // Without magnets there is no EMF to end it.
  k.no_load_radps = e.flux_wb == 0 ? kNever : last_speed([&](double speed) {
    const double q_a = friction_nm(motor, speed) / k.torque_constant_nm_per_a;
    return limits.voltage_v - length(voltage_at(motor, {0, q_a}, speed));
  });
  const Dq rated_a = mtpa_current_a(e, limits.current_a);
  k.base_radps = last_speed(
      [&](double speed) { return limits.voltage_v - length(voltage_at(motor, rated_a, speed)); });
  k.rated_torque_nm = torque_nm(e, rated_a) - motor.mechanics.coulomb_nm;
  return k;
}

std::optional<OperatingPoint> most_torque(const Motor& motor, const DriveLimits& limits,
                                          double speed_radps) {
  const PmsmParameters& e = motor.electrical;
  const auto torque_beside = [&](double d_a) {
    const auto q_a = greatest_q_current(e, limits, d_a, e.pole_pairs * speed_radps);
    return q_a ? torque_nm(e, {d_a, *q_a}) : -kNever;
  };
  const double d_a = argument_of_maximum(torque_beside, -limits.current_a, limits.current_a);
  const auto q_a = greatest_q_current(e, limits, d_a, e.pole_pairs * speed_radps);
  if (!q_a) return {};
  return point_at(motor, {d_a, *q_a}, speed_radps);
}

std::optional<OperatingPoint> least_current(const Motor& motor, const DriveLimits& limits,
                                            double torque_nm, double speed_radps) {
  const PmsmParameters& e = motor.electrical;
  const double air_gap_nm = torque_nm + friction_nm(motor, speed_radps);
  const auto q_beside = [&](double d_a) {
    const double flux = e.flux_wb + (e.inductance_d_h - e.inductance_q_h) * d_a;
    return flux > 0 ? air_gap_nm / (1.5 * e.pole_pairs * flux) : kNever;
  };
  // Minus the current where it is within the limits, else far below by how much it is not: so the
  // search finds its way to the smallest corner that is.
  constexpr double kFar = 1e12, kRounding = 1e-9;
  const auto goodness = [&](double d_a) {
    const Dq current_a{d_a, q_beside(d_a)};
    const double too_much =
        std::max({kRounding, length(current_a) / limits.current_a - 1,
                  length(voltage_at(motor, current_a, speed_radps)) / limits.voltage_v - 1});
    return too_much > kRounding ? -kFar * (1 + too_much) : -length(current_a);
  };
  const double d_a = argument_of_maximum(goodness, -limits.current_a, limits.current_a);
  if (goodness(d_a) <= -kFar) return {};
  return point_at(motor, {d_a, q_beside(d_a)}, speed_radps);
}

}  // namespace virtdrive
