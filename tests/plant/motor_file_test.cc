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

TEST(MotorFile, EveryKeyHasAMeaningAndEveryNumberARange) {
  for (const MotorKey& key : motor_keys()) {
    EXPECT_FALSE(key.doc.empty()) << key.name;
    if (key.type != MotorKey::Type::kNumber) continue;
    EXPECT_FALSE(key.range.unit.empty()) << key.name;
    EXPECT_TRUE(std::isfinite(key.range.minimum) && std::isfinite(key.range.maximum)) << key.name;
  }
}

}  // namespace
}  // namespace virtdrive
