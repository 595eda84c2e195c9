#include "plant/motor_library.h"

#include <algorithm>
#include <cctype>
#include <gtest/gtest.h>
#include <string>

#include "core/check.h"

namespace virtdrive {
namespace {

TEST(MotorLibrary, EveryMotorIsCompleteAndNamesItsSource) {
  for (const Motor& motor : motor_library()) {
    SCOPED_TRACE(motor.name);
    EXPECT_NO_THROW(validate(motor.electrical));
    EXPECT_NO_THROW(validate(motor.mechanics));
    EXPECT_NO_THROW(validate(motor.effects));
    EXPECT_TRUE(motor.electrical.flux_wb > 0 || motor.effects.saturation || motor.effects.cage);
    EXPECT_GT(motor.rating.voltage_v, 0);
    EXPECT_FALSE(motor.description.empty());
    EXPECT_FALSE(motor.source.empty());
    EXPECT_TRUE(std::ranges::none_of(motor.name, [](unsigned char c) { return std::isupper(c); }));
    EXPECT_EQ(find_motor(motor.name).description, motor.description) << "file and name differ";
  }
}

TEST(MotorLibrary, HoldsWhatBenchesAskFor) {
  EXPECT_GE(motor_library().size(), 15U);
  EXPECT_EQ(motor_names().size(), motor_library().size());
  for (const char* name :
       {"db42s03", "md100", "md200t", "servo-400w", "ecma-c20807", "gt2215", "ec45-flat-24v",
        "ipmsm-2kw", "smpm-msl", "gem-pmsm", "syrm-7kw", "re40-24v", "voice-coil-20n"}) {
    EXPECT_EQ(find_motor(name).name, name);
  }
  EXPECT_EQ(find_motor("md200t").electrical.pole_pairs, 10);
  EXPECT_EQ(find_motor("gt2215").electrical.inductance_d_h, 9e-6);
}

// What drives, tests and recordings were made with stays what it is.
TEST(MotorLibrary, TheFirstMotorsKeepTheirValues) {
  const Motor db42s03 = find_motor("db42s03");
  EXPECT_EQ(db42s03.electrical.pole_pairs, 4);
  EXPECT_EQ(db42s03.electrical.resistance_ohm, 0.75);
  EXPECT_EQ(db42s03.electrical.inductance_d_h, 1.05e-3);
  EXPECT_EQ(db42s03.electrical.inductance_q_h, 1.05e-3);
  EXPECT_EQ(db42s03.electrical.flux_wb, 5.667e-3);
  EXPECT_EQ(db42s03.electrical.rated_current_a, 1.85);
  EXPECT_EQ(db42s03.mechanics.inertia_kgm2, 2.4e-6);
  EXPECT_EQ(db42s03.mechanics.viscous_nm_per_radps, 5e-6);
  EXPECT_EQ(db42s03.mechanics.coulomb_nm, 3e-3);
  EXPECT_EQ(find_motor("dr38312").electrical.flux_wb, 51e-3 / 9);
  EXPECT_EQ(find_motor("ipmsm-2kw").electrical.flux_wb, 0.545);
  EXPECT_EQ(find_motor("gem-pmsm").electrical.inductance_q_h, 1.2e-3);
}

TEST(MotorLibrary, AFileIsNamedByItsPath) {
  const Motor motor = find_motor(VIRTDRIVE_SOURCE_DIR "/data/motors/md100.yaml");
  EXPECT_EQ(motor.electrical.flux_wb, find_motor("md100").electrical.flux_wb);
  EXPECT_THROW(find_motor("./no_such_motor.yaml"), SetupError);
}

TEST(MotorLibrary, ABlockCurrentStandsForItsFundamental) {
  EXPECT_EQ(phase_peak_a(2, CurrentRating::kPeak), 2);
  EXPECT_NEAR(phase_peak_a(2, CurrentRating::kRms), 2.828427, 1e-6);
  // b1 of a 120-degree block: 4/pi cos(30 deg).
  EXPECT_NEAR(phase_peak_a(1, CurrentRating::kDc), 1.102658, 1e-6);
}

TEST(MotorLibrary, FluxFollowsFromTheTorquePerAmpere) {
  EXPECT_NEAR(torque_nm(find_motor("db42s03").electrical, {0, 1}), 34e-3, 3e-6);
  EXPECT_NEAR(torque_nm(find_motor("dr38312").electrical, {0, 1}), 51e-3, 1e-9);
  EXPECT_NEAR(torque_nm(find_motor("ecs-7140-hv").electrical, {0, 1}), 330e-3, 1e-9);
}

TEST(MotorLibrary, AnUnknownNameOffersTheNearest) {
  try {
    find_motor("db42s30");
    ADD_FAILURE() << "no error";
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("unknown motor 'db42s30'; did you mean db42s03"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace virtdrive
