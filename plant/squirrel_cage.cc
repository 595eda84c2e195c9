#include "plant/squirrel_cage.h"

#include <cmath>

#include "core/check.h"

namespace virtdrive {
namespace {

/// Of the flux that saturates, or of that of an ampere.
constexpr double kNoFlux = 1e-6;

}  // namespace

void validate(const CageParameters& cage) {
  const auto positive = [](const char* what, double value) {
    if (!std::isfinite(value) || value <= 0) {
      throw SetupError(fmt::format("motor: {} must be above 0, not {}", what, value));
    }
  };
  positive("rotor_resistance_ohm", cage.rotor_resistance_ohm);
  positive("stator_leakage_h", cage.stator_leakage_h);
  positive("rotor_leakage_h", cage.rotor_leakage_h);
  positive("main_inductance_h", cage.main_inductance_h);
  if (!std::isfinite(cage.saturation_flux_wb) || cage.saturation_flux_wb < 0) {
    throw SetupError(fmt::format("motor: saturation_flux_wb must be 0 or more, not {}",
                                 cage.saturation_flux_wb));
  }
  const int s = cage.saturation_exponent;
  if (s < 2 || s > 20 || s % 2 != 0) {
    throw SetupError(fmt::format("motor: saturation_exponent must be even, 2..20, not {}", s));
  }
}

SquirrelCage::SquirrelCage(const CageParameters& p)
    : parameters(p),
      rotor_resistance_ohm_(p.rotor_resistance_ohm),
      inverse_main_(1 / p.main_inductance_h),
      inverse_leakage_(1 / p.stator_leakage_h),
      leakage_ratio_(p.rotor_leakage_h / p.stator_leakage_h) {
  const double flux = p.saturation_flux_wb;
  if (flux > 0) inverse_saturation2_ = 1 / (flux * flux);
  no_flux_wb_ = kNoFlux * (flux > 0 ? flux : p.main_inductance_h);
}

Dq SquirrelCage::rotor_flux_wb(Dq i, Dq psi) const {
  const Dq m = magnetizing_current_a(psi);
  return {psi.d + parameters.rotor_leakage_h * (m.d - i.d),
          psi.q + parameters.rotor_leakage_h * (m.q - i.q)};
}

Dq SquirrelCage::main_flux_wb(Dq rotor, Dq i) const {
  // psi_m (1 + Llr g(|psi_m|)) = psi_r + Llr i_s: the direction is given, the length by Newton on a
  // convex function from above.
  const double l = parameters.rotor_leakage_h;
  const Dq sum{rotor.d + l * i.d, rotor.q + l * i.q};
  const double length = std::hypot(sum.d, sum.q);
  if (length == 0) return {};
  double x = length / (1 + l * inverse_main_);
  for (int trial = 0; trial < 50 && inverse_saturation2_ > 0; ++trial) {
    const double u = saturation(x * x);
    const double rest = x * (1 + l * (1 + u) * inverse_main_) - length;
    const double slope = 1 + l * (1 + (parameters.saturation_exponent + 1) * u) * inverse_main_;
    x -= rest / slope;
    if (std::fabs(rest) < 1e-15 * length) break;
  }
  return {sum.d * x / length, sum.q * x / length};
}

double SquirrelCage::field_energy_j(Dq i, Dq psi) const {
  const Dq m = magnetizing_current_a(psi);
  const double rotor2 = square({m.d - i.d, m.q - i.q}), flux2 = square(psi);
  const double u = saturation(flux2);
  const double iron = inverse_main_ * flux2 * (0.5 + u / (parameters.saturation_exponent + 2));
  return 1.5 * (iron + parameters.stator_leakage_h * square(i) / 2 +
                parameters.rotor_leakage_h * rotor2 / 2);
}

double SquirrelCage::transient_inductance_h() const {
  const CageParameters& p = parameters;
  return p.stator_leakage_h +
         p.rotor_leakage_h * p.main_inductance_h / (p.rotor_leakage_h + p.main_inductance_h);
}

}  // namespace virtdrive
