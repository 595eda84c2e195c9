#include "plant/motor_library.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive {
namespace {

/// The peak flux linkage of one phase from the torque per ampere of Iq (peak).
constexpr double flux_from_torque_constant(double nm_per_a, int pole_pairs) {
  return nm_per_a / (1.5 * pole_pairs);
}

/// A row of Toshiba's MCU motor-study presets: per-phase values, mNm/A of Iq, the limit of Iq as
/// the rated current.
constexpr PmsmParameters preset(int pole_pairs, double torque_nm_per_a, double resistance_ohm,
                                double inductance_h, double iq_limit_a) {
  return {.pole_pairs = pole_pairs,
          .resistance_ohm = resistance_ohm,
          .inductance_d_h = inductance_h,
          .inductance_q_h = inductance_h,
          .flux_wb = flux_from_torque_constant(torque_nm_per_a, pole_pairs),
          .rated_current_a = iq_limit_a};
}

constexpr std::string_view kPresetSource =
    "Toshiba MCU Motor Studio preset: pole pairs, R and L per phase, torque per ampere of Iq; "
    "rated current = its limit of Iq";
constexpr std::string_view kAssumedRotor = "rated voltage, rotor inertia, friction";

// pi to the digits that matter to a constant; SMPM's reactances are given at 50 Hz.
constexpr double kSmpmOmega = 2 * 3.14159265358979323846 * 50;

constexpr std::array kMotors = std::to_array<Motor>({
    {.name = "db42s03",
     .description = "Nanotec DB42S03, 24 V BLDC servo, 8 poles",
     .rated_voltage_v = 24,
     .electrical = {.pole_pairs = 4,
                    .resistance_ohm = 0.75,     // 1.5 Ohm line to line
                    .inductance_d_h = 1.05e-3,  // 2.1 mH line to line
                    .inductance_q_h = 1.05e-3,
                    .flux_wb = 5.667e-3,  // 34 mNm per ampere of Iq
                    .rated_current_a = 1.85},
     .mechanics = {.inertia_kgm2 = 2.4e-6, .viscous_nm_per_radps = 5e-6, .coulomb_nm = 3e-3},
     .source = "Nanotec data sheet DB42S03; Toshiba MCU Motor Studio's default motor",
     .assumed = "friction; inertia is the lower of the published 2.4e-6 .. 4.8e-6 kg m2"},
    {.name = "db42s01",
     .description = "Nanotec DB42S01 at 24 V",
     .rated_voltage_v = 24,
     .electrical = preset(4, 57e-3, 3.5, 5.8e-3, 0.8),
     .mechanics = {.inertia_kgm2 = 2.4e-6, .viscous_nm_per_radps = 5e-6, .coulomb_nm = 3e-3},
     .source = kPresetSource,
     .assumed = "rotor inertia and friction (as db42s03)"},
    {.name = "dr38312",
     .description = "Shinano DR-38312, small BLDC",
     .rated_voltage_v = 24,
     .electrical = preset(6, 51e-3, 1.35, 1.2e-3, 1.8),
     .mechanics = {.inertia_kgm2 = 1e-5, .viscous_nm_per_radps = 5e-6, .coulomb_nm = 3e-3},
     .source = kPresetSource,
     .assumed = kAssumedRotor},
    {.name = "pmba-200fk-hv",
     .description = "Shinano PMBA-200FK, high voltage",
     .rated_voltage_v = 325,
     .electrical = preset(5, 330e-3, 3.46, 5e-3, 1.0),
     .mechanics = {.inertia_kgm2 = 2e-5, .viscous_nm_per_radps = 2e-5, .coulomb_nm = 1e-2},
     .source = kPresetSource,
     .assumed = kAssumedRotor},
    {.name = "maxon-ec",
     .description = "maxon EC, small BLDC",
     .rated_voltage_v = 24,
     .electrical = preset(4, 51e-3, 6.85, 3.865e-3, 1.8),
     .mechanics = {.inertia_kgm2 = 9e-6, .viscous_nm_per_radps = 5e-6, .coulomb_nm = 3e-3},
     .source = kPresetSource,
     .assumed = kAssumedRotor},
    {.name = "ecs-7140-hv",
     .description = "Gefeg ECs 7140, high voltage",
     .rated_voltage_v = 325,
     .electrical = preset(2, 330e-3, 40, 34e-3, 0.5),
     .mechanics = {.inertia_kgm2 = 2e-5, .viscous_nm_per_radps = 2e-5, .coulomb_nm = 1e-2},
     .source = kPresetSource,
     .assumed = kAssumedRotor},
    {.name = "ipmsm-2kw",
     .description = "2.2-kW interior-magnet servo, 370 V (line to line) 4.3 A (rms) 75 Hz 14 Nm",
     .rated_voltage_v = 540,
     .electrical = {.pole_pairs = 3,
                    .resistance_ohm = 3.6,
                    .inductance_d_h = 36e-3,
                    .inductance_q_h = 51e-3,
                    .flux_wb = 0.545,
                    .rated_current_a = 4.3},
     .mechanics = {.inertia_kgm2 = 0.015},
     .source = "motulator's 2.2-kW IPMSM example (aalto-electric-drives/motulator)",
     .assumed = ""},
    {.name = "smpm-msl",
     .description = "Surface-magnet machine of the Modelica Standard Library, 100 V 100 A rms",
     .rated_voltage_v = 300,
     .electrical = {.pole_pairs = 2,
                    .resistance_ohm = 0.03,
                    .inductance_d_h = (0.1 + 0.3) / kSmpmOmega,  // stray and main
                    .inductance_q_h = (0.1 + 0.3) / kSmpmOmega,
                    // 112.3 V rms open-circuit at 50 Hz.
                    .flux_wb = 112.3 * 1.41421356237309504880 / kSmpmOmega,
                    .rated_current_a = 100},
     .mechanics = {.inertia_kgm2 = 0.29},
     .source = "Modelica.Electrical.Machines SM_PermanentMagnetData, without damper cage",
     .assumed = "the DC voltage"},
    {.name = "gem-pmsm",
     .description = "Traction machine with strong saliency, 300 V 240 A",
     .rated_voltage_v = 300,
     .electrical = {.pole_pairs = 3,
                    .resistance_ohm = 18e-3,
                    .inductance_d_h = 0.37e-3,
                    .inductance_q_h = 1.2e-3,
                    .flux_wb = 66e-3,
                    .rated_current_a = 240},
     .mechanics = {.inertia_kgm2 = 0.03883},
     .source = "gym-electric-motor's default PMSM (10.1109/TPEL.2020.3006779)",
     .assumed = ""},
});

}  // namespace

std::span<const Motor> motor_library() {
  return kMotors;
}

const Motor& find_motor(std::string_view name) {
  const auto found = std::ranges::find(kMotors, name, &Motor::name);
  if (found != kMotors.end()) return *found;
  std::vector<std::string_view> known;
  for (const Motor& motor : kMotors) known.push_back(motor.name);
  throw SetupError(unknown_name("motor", name, known));
}

}  // namespace virtdrive
