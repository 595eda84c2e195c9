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

double length(Dq x) {
  return std::hypot(x.d, x.q);
}

// The fundamental of an EMF's shape, 1 of a sine.
double fundamental(const EmfShape& emf) {
  if (emf.table.empty()) return 1;
  constexpr int kSteps = 3600;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double turns = (i + 0.5) / kSteps;
    sum += emf.table.at(turns) * std::sin(2 * std::numbers::pi * turns);
  }
  return 2 * sum / kSteps;
}

// Saturation in closed form gives currents for fluxes; a fine map gives fluxes for currents.
FluxMap map_of(const Motor& motor) {
  constexpr int kPoints = 61;
  const DriveLimits limits = limits_of(motor, true);
  const Winding winding(motor.electrical, motor.effects);
  std::vector<double> axis, flux_d, flux_q;
  for (int i = 0; i < kPoints; ++i) {
    axis.push_back(1.1 * limits.current_a * (2.0 * i / (kPoints - 1) - 1));
  }
  Dq near{motor.electrical.flux_wb, 0};
  for (const double d : axis) {
    for (const double q : axis) {
      near = winding.state_with_current(near, {d, q});
      flux_d.push_back(near.d);
      flux_q.push_back(near.q);
    }
  }
  return {axis, axis, std::move(flux_d), std::move(flux_q)};
}

OperatingPoint point_at(const SteadyMotor& steady, Dq current_a, double speed_radps) {
  OperatingPoint point;
  point.speed_radps = speed_radps;
  point.torque_nm = steady.air_gap_nm(current_a) - steady.friction_nm(speed_radps);
  point.current_a = current_a;
  point.voltage_v = steady.voltage_v(current_a, speed_radps);
  point.output_w = point.torque_nm * speed_radps;
  point.input_w =
      steady.phases() * (point.voltage_v.d * current_a.d + point.voltage_v.q * current_a.q);
  return point;
}

// The zero of a function that falls from positive to negative between low and high.
double zero_of(const std::function<double(double)>& f, double low, double high, int halvings = 80) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (f(middle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

// From where a falling condition fails, beyond 0; infinite if it holds as far as doubling goes.
double last_speed(const std::function<double(double)>& f) {
  constexpr double kFastest = 1e6;
  if (!(f(0) > 0)) return 0;
  double high = 1;
  while (f(high) > 0) {
    high *= 2;
    if (high > kFastest) return kNever;
  }
  return zero_of(f, 0, high);
}

// Of a function with one hump, -infinity where it is not defined: a scan, then a golden section.
double argument_of_maximum(const std::function<double(double)>& f, double low, double high,
                           int scan, int sections) {
  const double step = (high - low) / scan;
  int best = 0;
  double best_value = -kNever;
  for (int i = 0; i <= scan; ++i) {
    const double value = f(low + i * step);
    if (value > best_value) {
      best = i;
      best_value = value;
    }
  }
  double left = low + std::max(0, best - 1) * step, right = low + std::min(scan, best + 1) * step;
  for (int i = 0; i < sections; ++i) {
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

// A map's values cost more than a formula's.
double best_d_current(const SteadyMotor& steady, const DriveLimits& limits,
                      const std::function<double(double)>& f) {
  const int scan = steady.saturated() ? 90 : 200, sections = steady.saturated() ? 25 : 60;
  // A reluctance machine is the same on both sides of its axes.
  const double low_a = steady.machine().flux_wb == 0 && steady.saturated() ? 0 : -limits.current_a;
  return argument_of_maximum(f, low_a, limits.current_a, scan, sections);
}

constexpr int kMapHalvings = 30;

// The greatest q current that both limits allow beside a d current; none if there is none. With
// constant inductances |v|^2 = a iq^2 + 2 b iq + c; else it grows with iq from 0 on.
std::optional<double> greatest_q_current(const SteadyMotor& steady, const DriveLimits& limits,
                                         double d_current_a, double speed_radps) {
  const double on_circle = limits.current_a * limits.current_a - d_current_a * d_current_a;
  if (on_circle < 0) return {};
  double upper = std::sqrt(on_circle), lower = -upper;
  if (steady.saturated()) {
    const auto margin_v = [&](double q_a) {
      return limits.voltage_v - length(steady.voltage_v({d_current_a, q_a}, speed_radps));
    };
    if (margin_v(upper) >= 0) return upper;
    if (margin_v(0) < 0) return {};
    return zero_of(margin_v, 0, upper, kMapHalvings);
  }
  const PmsmParameters& m = steady.machine();
  const double w = m.pole_pairs * speed_radps;
  const double r = m.resistance_ohm;
  const double xq = w * m.inductance_q_h;
  const double emf = w * (m.inductance_d_h * d_current_a + m.flux_wb);
  const double a = r * r + xq * xq;
  const double b = r * emf - r * d_current_a * xq;
  const double c =
      r * r * d_current_a * d_current_a + emf * emf - limits.voltage_v * limits.voltage_v;
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

// The q current that gives an air-gap torque beside a d current; infinite if none does.
double q_current_for(const SteadyMotor& steady, const DriveLimits& limits, double d_current_a,
                     double air_gap_nm) {
  const auto missing_nm = [&](double q_a) {
    return air_gap_nm - steady.air_gap_nm({d_current_a, q_a});
  };
  if (!steady.saturated()) {
    const double per_ampere = -missing_nm(1) + air_gap_nm;
    return per_ampere > 0 ? air_gap_nm / per_ampere : kNever;
  }
  if (missing_nm(limits.current_a) > 0) return kNever;
  return missing_nm(0) <= 0 ? 0 : zero_of(missing_nm, 0, limits.current_a, kMapHalvings);
}

Dq most_torque_current_a(const SteadyMotor& steady, double amplitude_a) {
  if (steady.two_terminals()) return {0, amplitude_a};
  if (!steady.saturated()) return mtpa_current_a(steady.machine(), amplitude_a);
  const auto point = most_torque(steady, {.voltage_v = kNever, .current_a = amplitude_a}, 0);
  return point ? point->current_a : Dq{0, amplitude_a};
}

}  // namespace

SteadyMotor::SteadyMotor(const Motor& motor) : motor_(&motor), machine_(motor.electrical) {
  if (two_terminals()) {
    // Back from brushed_dc(): the one winding between the terminals, K as its flux.
    machine_.resistance_ohm *= 2;
    machine_.inductance_d_h *= 2;
    machine_.inductance_q_h *= 2;
    machine_.flux_wb *= std::numbers::sqrt3;
    return;
  }
  machine_.flux_wb *= fundamental(motor.effects.emf);
  if (motor.effects.flux_map) map_ = *motor.effects.flux_map;
  if (motor.effects.saturation) map_ = map_of(motor);
}

Dq SteadyMotor::flux_wb(Dq i) const {
  if (map_) return map_->at(i).flux_wb;
  return {machine_.inductance_d_h * i.d + machine_.flux_wb, machine_.inductance_q_h * i.q};
}

double SteadyMotor::air_gap_nm(Dq i) const {
  if (two_terminals()) return machine_.flux_wb * i.q;
  const Dq flux = flux_wb(i);
  return 1.5 * machine_.pole_pairs * (flux.d * i.q - flux.q * i.d);
}

Dq SteadyMotor::voltage_v(Dq i, double speed_radps) const {
  const double r = machine_.resistance_ohm;
  if (two_terminals()) return {0, r * i.q + machine_.flux_wb * speed_radps};
  const Dq flux = flux_wb(i);
  const double w = machine_.pole_pairs * speed_radps;
  return {r * i.d - w * flux.q, r * i.q + w * flux.d};
}

// Coulomb friction at standstill too: what starts must break away.
double SteadyMotor::friction_nm(double speed_radps) const {
  const MechanicsParameters& m = motor_->mechanics;
  return m.viscous_nm_per_radps * speed_radps + m.coulomb_nm;
}

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
  if (motor.effects.commutator) return {.voltage_v = rating.voltage_v, .current_a = current_a};
  return {.voltage_v = rating.voltage_v / std::numbers::sqrt3,
          .current_a = phase_peak_a(current_a, rating.counted_as)};
}

MotorConstants motor_constants(const SteadyMotor& steady) {
  const Motor& motor = steady.motor();
  const PmsmParameters& e = steady.machine();
  const DriveLimits limits = limits_of(motor);
  MotorConstants k;
  k.emf_v_per_radps = (steady.two_terminals() ? 1 : e.pole_pairs) * e.flux_wb;
  k.torque_constant_nm_per_a = steady.phases() * k.emf_v_per_radps;
  k.torque_constant_nm_per_arms = k.torque_constant_nm_per_a * std::numbers::sqrt2;
  const double line_vpk_per_rpm =
      (steady.two_terminals() ? 1 : std::numbers::sqrt3) * k.emf_v_per_radps / kRpmPerRadps;
  k.line_emf_vrms_per_krpm = line_vpk_per_rpm * 1000 / std::numbers::sqrt2;
  k.speed_constant_rpm_per_v = 1 / line_vpk_per_rpm;
  k.motor_constant_nm_per_rtw =
      k.torque_constant_nm_per_a / std::sqrt(steady.phases() * e.resistance_ohm);
  k.electrical_time_constant_s = e.inductance_q_h / e.resistance_ohm;
  k.mechanical_time_constant_s = motor.mechanics.inertia_kgm2 * e.resistance_ohm /
                                 (k.torque_constant_nm_per_a * k.emf_v_per_radps);
  k.rated_peak_a = limits.current_a;
  k.characteristic_current_a = e.flux_wb / e.inductance_d_h;
  k.stall_current_a = limits.voltage_v / e.resistance_ohm;
  const auto voltage_left = [&](Dq current_a, double speed) {
    return limits.voltage_v - length(steady.voltage_v(current_a, speed));
  };
  // Without magnets there is no EMF to end it.
  k.no_load_radps = e.flux_wb == 0 ? kNever : last_speed([&](double speed) {
    return voltage_left({0, steady.friction_nm(speed) / k.torque_constant_nm_per_a}, speed);
  });
  const Dq rated_a = most_torque_current_a(steady, limits.current_a);
  k.base_radps = last_speed([&](double speed) { return voltage_left(rated_a, speed); });
  k.rated_torque_nm = steady.air_gap_nm(rated_a) - motor.mechanics.coulomb_nm;
  return k;
}

std::optional<OperatingPoint> most_torque(const SteadyMotor& steady, const DriveLimits& limits,
                                          double speed_radps) {
  if (steady.two_terminals()) {
    const PmsmParameters& m = steady.machine();
    const double left_v = limits.voltage_v - m.flux_wb * speed_radps;
    const double i_a = m.resistance_ohm > 0 ? std::min(limits.current_a, left_v / m.resistance_ohm)
                                            : limits.current_a;
    if (left_v < 0) return {};
    return point_at(steady, {0, i_a}, speed_radps);
  }
  const auto torque_beside = [&](double d_a) {
    const auto q_a = greatest_q_current(steady, limits, d_a, speed_radps);
    return q_a ? steady.air_gap_nm({d_a, *q_a}) : -kNever;
  };
  const double d_a = best_d_current(steady, limits, torque_beside);
  const auto q_a = greatest_q_current(steady, limits, d_a, speed_radps);
  if (!q_a) return {};
  return point_at(steady, {d_a, *q_a}, speed_radps);
}

std::optional<OperatingPoint> least_current(const SteadyMotor& steady, const DriveLimits& limits,
                                            double torque_nm, double speed_radps) {
  const double air_gap_nm = torque_nm + steady.friction_nm(speed_radps);
  // Minus the current where it is within the limits, else far below by how much it is not: so the
  // search finds its way to the smallest corner that is.
  constexpr double kFar = 1e12, kRounding = 1e-9;
  const auto goodness_of = [&](Dq current_a) {
    const double too_much =
        std::max({kRounding, length(current_a) / limits.current_a - 1,
                  length(steady.voltage_v(current_a, speed_radps)) / limits.voltage_v - 1});
    return too_much > kRounding ? -kFar * (1 + too_much) : -length(current_a);
  };
  Dq current_a{0, 0};
  if (steady.two_terminals()) {
    current_a.q = air_gap_nm / steady.machine().flux_wb;
  } else {
    const auto beside = [&](double d_a) {
      const double q_a = q_current_for(steady, limits, d_a, air_gap_nm);
      return std::isfinite(q_a) ? goodness_of({d_a, q_a}) : -kNever;
    };
    current_a.d = best_d_current(steady, limits, beside);
    current_a.q = q_current_for(steady, limits, current_a.d, air_gap_nm);
  }
  if (!std::isfinite(current_a.q) || goodness_of(current_a) <= -kFar) return {};
  return point_at(steady, current_a, speed_radps);
}

}  // namespace virtdrive
