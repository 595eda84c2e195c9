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
    EXPECT_GT(motor.electrical.flux_wb, 0);
    EXPECT_GT(motor.rating.voltage_v, 0);
    EXPECT_FALSE(motor.description.empty());
    EXPECT_FALSE(motor.source.empty());
    EXPECT_TRUE(std::ranges::none_of(motor.name, [](unsigned char c) { return std::isupper(c); }));
    EXPECT_EQ(find_motor(motor.name).description, motor.description) << "file and name differ";
  }
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
