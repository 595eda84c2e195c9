#include "scenarios/load_spec.h"

#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

TEST(LoadSpec, ReadsKindsUnitsAndTimes) {
  const auto steps =
      parse_load("brake:20mNm@1.5s,inertia:100gcm2,quadratic:2e-8,constant:-0.01", 3);
  ASSERT_EQ(steps.size(), 4U);
  EXPECT_EQ(steps[0].quantity, &Load::inertia_kgm2);
  EXPECT_NEAR(steps[0].value, 1e-5, 1e-18);
  EXPECT_EQ(steps[1].value, 2e-8);
  EXPECT_EQ(steps[2].quantity, &Load::external_torque_nm);
  EXPECT_EQ(steps[2].value, -0.01);
  EXPECT_EQ(steps[3].quantity, &Load::brake_torque_nm);
  EXPECT_EQ(steps[3].value, 0.02);
  EXPECT_EQ(steps[3].at, kSimStart + 1500ms);
}

TEST(LoadSpec, SortsStepsByTimeAndKeepsTheOrderOfEqualOnes) {
  const auto steps = parse_load("brake:2@20ms,brake:1@10ms,brake:3@20ms", 3);
  EXPECT_EQ(steps[0].value, 1);
  EXPECT_EQ(steps[1].value, 2);
  EXPECT_EQ(steps[2].value, 3);
}

TEST(LoadSpec, APartMayBeForOneChannel) {
  const auto steps = parse_load("2.brake:20mNm,inertia:100gcm2", 3);
  EXPECT_EQ(steps[0].channel, 2U);
  EXPECT_EQ(steps[0].value, 0.02);
  EXPECT_EQ(steps[1].channel, std::nullopt);
}

TEST(LoadSpec, NoneIsNoLoad) {
  EXPECT_TRUE(parse_load("none", 3).empty());
  EXPECT_TRUE(parse_load("", 3).empty());
}

TEST(LoadSpec, SaysWhatIsWrongAndWhatWasExpected) {
  const auto error_of = [](const char* text) -> std::string {
    try {
      parse_load(text, 3);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error_of("brake"), "--load brake: expected [CHANNEL.]KIND:VALUE[UNIT][@TIME]");
  EXPECT_EQ(error_of("3.brake:1"), "--load 3.brake:1: channel '3' is not 0 ... 2");
  EXPECT_EQ(error_of("brak:1"),
            "--load brak:1: unknown kind of load 'brak'; did you mean brake? (known: none, brake, "
            "constant, quadratic, viscous, inertia)");
  EXPECT_EQ(error_of("brake:x"), "--load brake:x: 'x' is not a number");
  EXPECT_EQ(error_of("brake:1kg"), "--load brake:1kg: unknown unit 'kg', expected Nm or mNm");
  EXPECT_EQ(error_of("brake:-1"), "--load brake:-1: must not be negative");
  EXPECT_EQ(error_of("brake:1@-1s"), "--load brake:1@-1s: the time must be 0 ... 1e9 s");
  EXPECT_EQ(error_of("brake:1,"), "--load: nothing before or behind a comma");
  EXPECT_EQ(error_of("brake:inf"), "--load brake:inf: 'inf' is not a number");
}

}  // namespace
}  // namespace virtdrive
