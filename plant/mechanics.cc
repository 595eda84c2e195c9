#include "plant/mechanics.h"

#include <cmath>

#include "core/check.h"

namespace virtdrive {
namespace {

void require(bool good, const char* what, double value) {
  if (!good) throw SetupError(fmt::format("{}, not {}", what, value));
}

bool not_negative(double x) {
  return std::isfinite(x) && x >= 0;
}

}  // namespace

void validate(const MechanicsParameters& mechanics) {
  require(std::isfinite(mechanics.inertia_kgm2) && mechanics.inertia_kgm2 > 0,
          "mechanics: inertia_kgm2 must be above 0", mechanics.inertia_kgm2);
  require(not_negative(mechanics.viscous_nm_per_radps),
          "mechanics: viscous_nm_per_radps must be 0 or more", mechanics.viscous_nm_per_radps);
  require(not_negative(mechanics.coulomb_nm), "mechanics: coulomb_nm must be 0 or more",
          mechanics.coulomb_nm);
}

void validate(const Load& load) {
  require(not_negative(load.inertia_kgm2), "load: inertia_kgm2 must be 0 or more",
          load.inertia_kgm2);
  require(not_negative(load.brake_torque_nm), "load: brake_torque_nm must be 0 or more",
          load.brake_torque_nm);
  require(std::isfinite(load.external_torque_nm), "load: external_torque_nm must be finite",
          load.external_torque_nm);
  require(not_negative(load.quadratic_nm_per_radps2),
          "load: quadratic_nm_per_radps2 must be 0 or more", load.quadratic_nm_per_radps2);
  require(not_negative(load.viscous_nm_per_radps), "load: viscous_nm_per_radps must be 0 or more",
          load.viscous_nm_per_radps);
}

Motion motion_of(double speed_radps, double driving_torque_nm, double friction_nm) {
  if (friction_nm == 0) return Motion::kFree;
  if (speed_radps != 0) return speed_radps > 0 ? Motion::kForward : Motion::kReverse;
  if (std::abs(driving_torque_nm) <= friction_nm) return Motion::kStuck;
  return driving_torque_nm > 0 ? Motion::kForward : Motion::kReverse;
}

}  // namespace virtdrive
