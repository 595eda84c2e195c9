#include "plant/induction_curves.h"

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Where a function that falls through 0 between two slips does so.
double bisect(double low, double high, const std::function<double(double)>& f) {
  const bool rising = f(high) > f(low);
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    ((f(middle) < 0) == rising ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

InductionSupply rated_supply(const Motor& motor) {
  return {motor.rating.voltage_v / std::numbers::sqrt2, motor.rating.frequency_hz};
}

InductionPoint induction_point(const Motor& motor, const InductionSupply& supply, double slip) {
  VIRTDRIVE_CHECK(motor.effects.cage.has_value(), "{} is no induction machine", motor.name);
  const CageParameters& c = *motor.effects.cage;
  const double w = 2 * pi * supply.frequency_hz;
  const double phase_v = supply.line_v / std::numbers::sqrt3;
  const Complex stator(motor.electrical.resistance_ohm, w * c.stator_leakage_h);
  // Admittance, so that slip 0 is an open branch.
  const Complex rotor = slip / Complex(c.rotor_resistance_ohm, slip * w * c.rotor_leakage_h);
  Complex current, main_v;
  double flux = phase_v * std::numbers::sqrt2 / w;
  for (int trial = 0; trial < 200; ++trial) {
    const double ratio = c.saturation_flux_wb > 0 ? flux / c.saturation_flux_wb : 0;
    const double inverse_h = (1 + std::pow(ratio, c.saturation_exponent)) / c.main_inductance_h;
    const Complex parallel = 1.0 / (rotor + inverse_h / Complex(0, w));
    current = phase_v / (stator + parallel);
    main_v = current * parallel;
    const double found = std::abs(main_v) * std::numbers::sqrt2 / w;
    if (std::fabs(found - flux) < 1e-13 * flux) break;
    flux += (found - flux) / 2;
  }
  const double w_rotor = w * (1 - slip);
  const double pairs = motor.electrical.pole_pairs;
  const double rotor_a = std::abs(main_v * rotor);
  const MachineEffects& e = motor.effects;
  const double stator_flux =
      std::abs(main_v + current * Complex(0, w * c.stator_leakage_h)) * std::numbers::sqrt2 / w;
  const double flux2 = stator_flux * stator_flux;
  const double way = w_rotor > 0 ? 1 : w_rotor < 0 ? -1 : 0;
  InductionPoint point;
  point.slip = slip;
  point.speed_radps = w_rotor / pairs;
  if (slip != 0) {
    point.air_gap_nm = 3 * rotor_a * rotor_a * c.rotor_resistance_ohm / slip * pairs / w;
  }
  point.torque_nm = point.air_gap_nm - e.iron_eddy_w_per_v2 * pairs * w_rotor * flux2 -
                    way * (e.iron_hysteresis_w * pairs * flux2 + motor.mechanics.coulomb_nm) -
                    motor.mechanics.viscous_nm_per_radps * point.speed_radps;
  point.current_a = std::abs(current);
  point.main_flux_wb = flux;
  point.input_w = 3 * phase_v * current.real();
  point.output_w = point.torque_nm * point.speed_radps;
  point.power_factor = current.real() / point.current_a;
  return point;
}

InductionPoint induction_breakdown(const Motor& motor, const InductionSupply& supply) {
  // Golden section: one maximum between synchronism and standstill.
  constexpr double kGolden = 0.6180339887498949;
  double low = 0, high = 1;
  const auto torque = [&](double slip) { return induction_point(motor, supply, slip).torque_nm; };
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double at_a = torque(a), at_b = torque(b);
  for (int i = 0; i < 50; ++i) {
    if (at_a > at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - kGolden * (high - low);
      at_a = torque(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + kGolden * (high - low);
      at_b = torque(b);
    }
  }
  return induction_point(motor, supply, (low + high) / 2);
}

InductionPoint induction_at_power(const Motor& motor, const InductionSupply& supply,
                                  double power_w) {
  const double slip = bisect(0, induction_breakdown(motor, supply).slip, [&](double s) {
    return induction_point(motor, supply, s).output_w - power_w;
  });
  return induction_point(motor, supply, slip);
}

InductionPoint induction_no_load(const Motor& motor, const InductionSupply& supply) {
  return induction_at_power(motor, supply, 0);
}

}  // namespace virtdrive
