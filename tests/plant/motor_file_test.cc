#include "plant/motor_file.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHead =
    "virtdrive_motor: 1\nname: m\ndescription: d\nkind: pmsm\nsource: s\nrated_voltage_v: 24\n"
    "rated_current_a: 2\nrotor_inertia_kgm2: 1e-5\n";

Motor read(std::string_view more) {
  return parse_motor(YamlFile("m.yaml", std::string(kHead) + std::string(more)));
}

// Each file of tests/data/motors_bad begins with "# expect LINE:COLUMN the beginning of a message".
TEST(MotorFile, EachMistakeIsToldWithItsPlaceAndReason) {
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(VIRTDRIVE_TEST_DATA "/motors_bad")) {
    SCOPED_TRACE(entry.path().filename());
    std::ifstream stream(entry.path());
    std::string first;
    std::getline(stream, first);
    ASSERT_TRUE(first.starts_with("# expect "));
    const std::string expected = first.substr(9);
    const std::size_t space = expected.find(' ');
    const std::string beginning =
        entry.path().string() + ":" + expected.substr(0, space) + ": " + expected.substr(space + 1);
    try {
      find_motor(entry.path().string());
      ADD_FAILURE() << "no error; expected " << beginning;
    } catch (const SetupError& error) {
      EXPECT_EQ(std::string(error.what()).substr(0, beginning.size()), beginning);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
    ++files;
  }
  EXPECT_GE(files, 30U);
}

TEST(MotorFile, LineToLineValuesAreTwiceThePhases) {
  const Motor motor = read(
      "pole_pairs: 4\nline_resistance_ohm: 1.5\nline_inductance_h: 2.1e-3\nmagnet_flux_wb: 0.01\n");
  EXPECT_EQ(motor.electrical.resistance_ohm, 0.75);
  EXPECT_EQ(motor.electrical.inductance_d_h, 1.05e-3);
  EXPECT_EQ(motor.electrical.inductance_q_h, 1.05e-3);
}

// psi = 10 mWb with 4 pole pairs: 60 mNm/A of Iq, EMF of a phase 4.18879 V peak at 1000 rpm.
TEST(MotorFile, TheMagnetsAreToldInFiveWays) {
  const std::string rest = "pole_pairs: 4\nphase_resistance_ohm: 1\nphase_inductance_h: 1e-3\n";
  const double emf_v = 0.01 * 4 * 1000 * std::numbers::pi / 30;
  for (const auto& [key, value] : std::vector<std::pair<std::string, double>>{
           {"magnet_flux_wb", 0.01},
           {"torque_constant_nm_per_a", 0.06},
           {"torque_constant_nm_per_arms", 0.06 * std::numbers::sqrt2},
           {"line_emf_vpk_per_krpm", emf_v * std::numbers::sqrt3},
           {"line_emf_vrms_per_krpm", emf_v * std::numbers::sqrt3 / std::numbers::sqrt2}}) {
    const Motor motor = read(fmt::format("{}{}: {:.17g}\n", rest, key, value));
    EXPECT_NEAR(motor.electrical.flux_wb, 0.01, 1e-12) << key;
  }
}

TEST(MotorFile, WhatIsLeftOutIsNothing) {
  const Motor motor =
      read("pole_pairs: 1\nphase_resistance_ohm: 1\nphase_inductance_h: 1e-3\nmagnet_flux_wb: 1\n");
  EXPECT_EQ(motor.mechanics.coulomb_nm, 0);
  EXPECT_EQ(motor.mechanics.viscous_nm_per_radps, 0);
  EXPECT_EQ(motor.rating.peak_current_a, 0);
  EXPECT_EQ(motor.rating.counted_as, CurrentRating::kPeak);
  EXPECT_EQ(motor.assumed, "");
}

TEST(MotorFile, AReluctanceMachineNeedsNoMagnets) {
  const Motor motor = read(
      "pole_pairs: 2\nphase_resistance_ohm: 0.54\nd_axis_inductance_h: 41.5e-3\n"
      "q_axis_inductance_h: 6.2e-3\nmagnet_flux_wb: 0\n");
  EXPECT_EQ(motor.electrical.flux_wb, 0);
}

Motor read_kind(std::string_view kind, std::string_view more) {
  std::string head(kHead);
  head.replace(head.find("pmsm"), 4, kind);
  return parse_motor(YamlFile("m.yaml", head + std::string(more)));
}

// Data sheet of the EC 45 flat 24 V, 339281: Kt 51 mNm/A between two terminals.
TEST(MotorFile, ABldcHasATrapezoid) {
  const Motor motor = find_motor("ec45-flat-24v");
  EXPECT_EQ(motor.kind, MachineKind::kBldc);
  EXPECT_DOUBLE_EQ(motor.electrical.flux_wb, 51e-3 / 16);
  EXPECT_EQ(motor.electrical.resistance_ohm, 4.83 / 2);
  ASSERT_FALSE(motor.effects.emf.table.empty());
  EXPECT_NEAR(motor.effects.emf.table.at(0.25), 1, 1e-12);
  EXPECT_NEAR(motor.effects.emf.table.at(1.0 / 24), 0.5, 1e-12);
  EXPECT_EQ(motor.effects.thermal.winding_housing_k_per_w, 3.96);
  const Motor by_emf = read_kind("bldc",
                                 "pole_pairs: 8\nline_resistance_ohm: 5\nline_inductance_h: 2e-3\n"
                                 "line_emf_vpk_per_krpm: 5.34\n");
  EXPECT_NEAR(by_emf.electrical.flux_wb, 51e-3 / 16, 2e-5) << "5.34 V at 1000 rpm is 51 mV s";
}

TEST(MotorFile, ABrushedMotorAndAVoiceCoilHaveTwoTerminals) {
  const Motor motor = find_motor("re40-24v");
  EXPECT_TRUE(motor.effects.commutator);
  const PmsmParameters expected = brushed_dc(0.299, 0.0823e-3, 30.2e-3, 6);
  EXPECT_EQ(motor.electrical.flux_wb, expected.flux_wb);
  EXPECT_EQ(motor.electrical.resistance_ohm, expected.resistance_ohm);
  const Motor coil = find_motor("voice-coil-20n");
  EXPECT_EQ(coil.kind, MachineKind::kVoiceCoil);
  EXPECT_EQ(coil.electrical.flux_wb, brushed_dc(5, 1.5e-3, 10, 2).flux_wb);
  EXPECT_EQ(coil.mechanics.inertia_kgm2, 0.1);
}

// V5: two points of the 6.7-kW machine.
TEST(MotorFile, SaturationInClosedFormReachesThePlant) {
  const Motor motor = find_motor("syrm-7kw");
  const Winding winding(motor.electrical, motor.effects);
  const Winding::Point p = winding.at({0.5, 0.1});
  EXPECT_NEAR(p.current_a.d, 15.92812, 1e-5);
  EXPECT_NEAR(p.current_a.q, 16.45667, 1e-5);
  EXPECT_NEAR(motor.electrical.inductance_d_h, 1 / 17.4, 1e-12);
  EXPECT_NEAR(motor.electrical.inductance_q_h, 1 / 52.1, 1e-12);
}

TEST(MotorFile, AFluxMapReachesThePlant) {
  const Motor motor = read(
      "pole_pairs: 3\nphase_resistance_ohm: 0.5\nmagnet_flux_wb: 0.1\nflux_map:\n"
      "  current_d_a: [-2, -1, 0, 1]\n  current_q_a: [-1, 0, 1, 2]\n"
      "  flux_d_wb: [[.08, .08, .08, .08], [.09, .09, .09, .09], [.1, .1, .1, .1], [.11, .11, .11, "
      ".11]]\n"
      "  flux_q_wb: [[-.02, 0, .02, .04], [-.02, 0, .02, .04], [-.02, 0, .02, .04], [-.02, 0, .02, "
      ".04]]\n");
  ASSERT_TRUE(motor.effects.flux_map);
  EXPECT_NEAR(motor.effects.flux_map->at({-0.5, 0.5}).flux_wb.d, 0.095, 1e-12);
  EXPECT_NEAR(motor.electrical.inductance_d_h, 0.01, 1e-12);
  EXPECT_NEAR(motor.electrical.inductance_q_h, 0.02, 1e-12);
}

TEST(MotorFile, CoggingHarmonicsFrictionAndIronReachThePlant) {
  const Motor motor = read(
      "pole_pairs: 4\nphase_resistance_ohm: 1\nphase_inductance_h: 1e-3\nmagnet_flux_wb: 0.01\n"
      "cogging_peak_nm: 2e-3\ncogging_periods_per_turn: 24\nemf_harmonics: [[1, 1], [5, 0.03]]\n"
      "coulomb_friction_nm: 1e-3\nbreakaway_friction_nm: 2e-3\nstribeck_speed_radps: 3\n"
      "iron_eddy_w_per_v2: 0.01\niron_hysteresis_ws_per_wb2: 5\nmagnet_flux_per_k: -0.002\n");
  EXPECT_NEAR(motor.effects.cogging_nm.at(1.0 / 96), 2e-3, 1e-12);
  EXPECT_NEAR(motor.effects.emf.table.at(0.25), 1.03, 1e-6);
  EXPECT_EQ(motor.mechanics.stiction_nm, 2e-3);
  EXPECT_EQ(motor.mechanics.stribeck_radps, 3);
  EXPECT_EQ(motor.effects.iron_eddy_w_per_v2, 0.01);
  EXPECT_EQ(motor.effects.iron_hysteresis_w, 5);
  EXPECT_EQ(motor.effects.thermal.flux_per_k, -0.002);
  EXPECT_NO_THROW(validate(motor.effects));
}

TEST(MotorFile, EveryKeyHasAMeaningAndEveryNumberARange) {
  for (const MotorKey& key : motor_keys()) {
    EXPECT_FALSE(key.doc.empty()) << key.name;
    if (key.type != MotorKey::Type::kNumber) continue;
    EXPECT_FALSE(key.range.unit.empty()) << key.name;
    EXPECT_NE(key.kinds, 0) << key.name;
    EXPECT_TRUE(std::isfinite(key.range.minimum) && std::isfinite(key.range.maximum)) << key.name;
  }
}

}  // namespace
}  // namespace virtdrive
