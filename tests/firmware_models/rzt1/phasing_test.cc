// Finding the rotor, with a rotor that really swings.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/searches.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

TEST(Phasing, EachModeFindsTheRotor) {
  for (const Case& c : kCases) phase_from(c, 3);
}

TEST(Phasing, OnPhasesAndThenHoldsThePosition) {
  for (const int mode : {0, 1, 2}) {
    Rig rig;
    rig.turn_to(1.1);
    rig.set(&Settings::pimode, mode);
    ASSERT_EQ(rig.axis().on(), Result::kOk);
    ASSERT_GE(rig.run_to([&] { return !rig.axis().busy(); }), 0);
    EXPECT_TRUE(rig.axis().servo_on());
    rig.run_for(100ms);
    EXPECT_NEAR(rig.axis().position_error(), 0, 5);
    // From the Halls it is rough until the first of them changes.
    EXPECT_EQ(rig.axis().phased(), mode != 1);
    rig.move_to(rig.axis().position() + kTurn / 2);
    EXPECT_TRUE(rig.axis().phased());
    rig.run_for(100ms);
    EXPECT_LE(std::fabs(error_deg(rig)), 3);
    EXPECT_NEAR(rig.axis().position_error(), 0, 5);
  }
}

TEST(Phasing, WithoutHallsTheHallModeIsForced) {
  Hardware hardware;
  hardware.axis[0].hall_plug = AxisHardware::HallPlug::kNone;
  Rig rig(bench_axis(), {}, hardware);
  rig.turn_to(0.5);
  rig.set(&Settings::pimode, 1);
  ASSERT_EQ(rig.axis().align(), Result::kOk);
  EXPECT_NEAR(rig.run_to([&] { return !rig.axis().busy(); }), 0.5, 0.002);
  EXPECT_LE(std::fabs(error_deg(rig)), 1.5);
}

TEST(Phasing, FailsWhenAStuckHallNeverChanges) {
  Rig rig;
  using Output = HallSensors::Output;
  // The rotor's present code, for ever.
  rig.hardware.axis[0].halls.output = {Output::kStuckLow, Output::kStuckHigh, Output::kStuckLow};
  rig.drive->hardware_changed();
  rig.run_for(2ms);
  rig.set(&Settings::pimode, 1);
  ASSERT_EQ(rig.axis().align(), Result::kOk);
  ASSERT_GT(rig.run_to([&] { return !rig.axis().busy(); }), 0);
  EXPECT_FALSE(rig.axis().phased());
  EXPECT_TRUE(rig.axis().search_failed());
}

TEST(Phasing, TheOffsetIsAddedAtTheEnd) {
  Rig rig;
  rig.set(&Settings::pioffs, 1000);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_NEAR(error_deg(rig), -1000.0 / 26214 * 360, 1.5);
}

TEST(Setup, FindsSwappedPhasesAndInvertedHalls) {
  for (const bool swapped : {false, true}) {
    for (const bool inverted : {false, true}) {
      for (const double start : {0.0, 0.63, 2.9}) {
        Hardware hardware;
        if (swapped) hardware.axis[0].wiring = {0, 2, 1};
        if (inverted) hardware.axis[0].halls.offset_rad += std::numbers::pi;
        Rig rig(bench_axis(), {}, hardware);
        rig.turn_to(start);
        ASSERT_EQ(rig.axis().setup(), Result::kOk);
        ASSERT_GT(rig.run_to([&] { return !rig.axis().busy(); }), 0);
        EXPECT_FALSE(rig.axis().search_failed());
        EXPECT_EQ(rig.axis().settings().pmap, swapped ? 1 : 0);
        EXPECT_EQ(rig.axis().settings().hinvert, inverted ? 1 : 0);
        EXPECT_FALSE(rig.axis().amplifier_on());
        ASSERT_EQ(rig.ready(), Result::kOk);
        EXPECT_GT(rig.move_to(rig.axis().position() + kTurn), 0);
        EXPECT_NEAR(rig.axis().position_error(), 0, 100);
      }
    }
  }
}

TEST(Setup, FailsWhenNothingMoves) {
  Rig rig;
  Load locked;
  locked.locked = true;
  rig.change_load(locked);
  ASSERT_EQ(rig.axis().setup(), Result::kOk);
  ASSERT_GT(rig.run_to([&] { return !rig.axis().busy(); }), 0);
  EXPECT_TRUE(rig.axis().search_failed());
}

}  // namespace
}  // namespace virtdrive::rzt1
