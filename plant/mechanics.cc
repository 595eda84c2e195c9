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

void require_friction(const std::string& who, double sliding_nm, double stiction_nm,
                      double stribeck_radps) {
  require(stiction_nm == 0 || (std::isfinite(stiction_nm) && stiction_nm >= sliding_nm),
          (who + ": stiction_nm must be 0 or not below the sliding friction").c_str(), stiction_nm);
  require(not_negative(stribeck_radps) && (stiction_nm == 0 || stribeck_radps > 0),
          (who + ": stribeck_radps must be above 0 where there is stiction_nm").c_str(),
          stribeck_radps);
}

}  // namespace

void validate(const MechanicsParameters& mechanics) {
  require(std::isfinite(mechanics.inertia_kgm2) && mechanics.inertia_kgm2 > 0,
          "mechanics: inertia_kgm2 must be above 0", mechanics.inertia_kgm2);
  require(not_negative(mechanics.viscous_nm_per_radps),
          "mechanics: viscous_nm_per_radps must be 0 or more", mechanics.viscous_nm_per_radps);
  require(not_negative(mechanics.coulomb_nm), "mechanics: coulomb_nm must be 0 or more",
          mechanics.coulomb_nm);
  require_friction("mechanics", mechanics.coulomb_nm, mechanics.stiction_nm,
                   mechanics.stribeck_radps);
  const Transmission& t = mechanics.transmission;
  require(std::isfinite(t.ratio) && t.ratio > 0, "transmission: ratio must be above 0", t.ratio);
  require(t.efficiency > 0 && t.efficiency <= 1, "transmission: efficiency must be above 0 .. 1",
          t.efficiency);
  require(not_negative(t.stiffness_nm_per_rad),
          "transmission: stiffness_nm_per_rad must be 0 or more", t.stiffness_nm_per_rad);
  const bool rigid = t.stiffness_nm_per_rad == 0;
  require(not_negative(t.damping_nm_per_radps) && !(rigid && t.damping_nm_per_radps > 0),
          "transmission: damping_nm_per_radps must be 0 or more, and needs stiffness_nm_per_rad",
          t.damping_nm_per_radps);
  require(not_negative(t.backlash_rad) && !(rigid && t.backlash_rad > 0),
          "transmission: backlash_rad must be 0 or more, and needs stiffness_nm_per_rad",
          t.backlash_rad);
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
  require_friction("load", load.brake_torque_nm, load.stiction_nm, load.stribeck_radps);
  require(not_negative(load.spring_nm_per_rad), "load: spring_nm_per_rad must be 0 or more",
          load.spring_nm_per_rad);
  require(std::isfinite(load.spring_rest_rad), "load: spring_rest_rad must be finite",
          load.spring_rest_rad);
  require(std::isfinite(load.gravity_nm), "load: gravity_nm must be finite", load.gravity_nm);
  require(load.lower_stop_rad < load.upper_stop_rad,
          "load: lower_stop_rad must be below upper_stop_rad", load.lower_stop_rad);
  const bool stops = std::isfinite(load.lower_stop_rad) || std::isfinite(load.upper_stop_rad);
  require(not_negative(load.stop_nm_per_rad) && (!stops || load.stop_nm_per_rad > 0),
          "load: stop_nm_per_rad must be above 0 where there is an end stop", load.stop_nm_per_rad);
  require(not_negative(load.stop_nm_per_radps), "load: stop_nm_per_radps must be 0 or more",
          load.stop_nm_per_radps);
}

void validate(const MechanicsParameters& mechanics, const Load& load) {
  validate(mechanics);
  validate(load);
  require(mechanics.transmission.stiffness_nm_per_rad == 0 || load.inertia_kgm2 > 0,
          "load: inertia_kgm2 must be above 0 behind a transmission with stiffness",
          load.inertia_kgm2);
}

}  // namespace virtdrive
