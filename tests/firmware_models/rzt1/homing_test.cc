// Finding the zero: the index really passes, the stop is a real stop.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/searches.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

TEST(Homing, FindsTheSameZeroByEachSensor) {
  by_index(3);
  by_switch(3);
  by_hard_stop(3);
}

TEST(Homing, TheOffsetMovesTheZero) {
  Rig rig(bench_axis(), {}, with_index_and_switch());
  prepare(rig, 3.0);
  rig.set(&Settings::hoffs, 5000);
  home(rig, HomingState::kDone);
  // The index is at -HOFFS.
  EXPECT_NEAR(rig.angle_rad(), 1.0 + 5000 * kCountRad, 4 * kCountRad);
  EXPECT_NEAR(rig.axis().position(), 0, 4);
}

TEST(Homing, FailsWhenTheIndexIsDead) {
  Hardware hardware = with_index_and_switch();
  hardware.axis[0].incremental.index_dead = true;
  Rig rig(bench_axis(), {}, hardware);
  prepare(rig, 2.0);
  const std::int32_t from = rig.axis().position();
  home(rig, HomingState::kFailed);
  EXPECT_EQ(rig.axis().status() & (kBusy | kMotionComplete), kMotionComplete);
  EXPECT_TRUE(rig.axis().servo_on());
  EXPECT_NEAR(rig.axis().position(), from - 1.2 * kTurn, 5);
}

TEST(Homing, FailsWhenTheSwitchIsDead) {
  Hardware hardware = with_index_and_switch();
  hardware.axis[0].home_switch.input = 0;
  Rig rig(bench_axis(), {}, hardware);
  prepare(rig, 2.0);
  rig.set(&Settings::hmask, 4);
  home(rig, HomingState::kFailed);
}

TEST(Homing, FailsWhenThereIsNoStop) {
  Rig rig;
  prepare(rig, 2.0);
  rig.set(&Settings::hmask, 3);
  home(rig, HomingState::kFailed);
  EXPECT_TRUE(rig.axis().servo_on());
}

TEST(Homing, AnInvertedSwitchIsApproachedFromTheOtherSide) {
  Hardware hardware = with_index_and_switch();
  hardware.axis[0].home_switch.from_rad = -100 * kTurnRad;
  hardware.axis[0].home_switch.to_rad = 3.7 * kTurnRad;
  Rig rig(bench_axis(), {}, hardware);
  prepare(rig, 2 * kTurnRad);
  rig.set(&Settings::hmask, 4);
  rig.set(&Settings::invert, 4);
  home(rig, HomingState::kDone);
  EXPECT_NEAR(rig.angle_rad(), 4 * kTurnRad + 1.0, 1e-3);
}

TEST(Homing, PassesThroughTheStatesOfTheFigure) {
  Rig rig(bench_axis(), {}, with_index_and_switch());
  prepare(rig, 2 * kTurnRad);
  rig.set(&Settings::hmask, 4);
  ASSERT_EQ(rig.axis().home(), Result::kOk);
  using enum HomingState;
  for (const HomingState state :
       {kFindingSwitch, kWaitingAtSwitch, kFindingIndex, kWaitingAtIndex, kMovingHome, kDone}) {
    EXPECT_GE(rig.run_to([&] { return rig.axis().homing_state() == state; }), 0)
        << static_cast<int>(state);
  }
}

TEST(Homing, StopEndsIt) {
  Rig rig(bench_axis(), {}, with_index_and_switch());
  prepare(rig, 2.0);
  ASSERT_EQ(rig.axis().home(), Result::kOk);
  rig.run_for(50ms);
  ASSERT_EQ(rig.axis().stop(), Result::kOk);
  EXPECT_EQ(rig.axis().homing_state(), HomingState::kIdle);
  EXPECT_GT(rig.run_to_end_of_motion(), 0);
}

TEST(Homing, LiteralDistancesAreTheExamplesCounts) {
  FirmwareOptions options;
  options.homing.literal = true;
  Rig rig(bench_axis(), options, with_index_and_switch());
  prepare(rig, 2.6);
  ASSERT_EQ(rig.axis().set_position(-20'000), Result::kOk);
  ASSERT_EQ(rig.axis().home(), Result::kOk);
  rig.run_to([&] { return rig.axis().homing_state() != HomingState::kFindingIndex; });
  // The index lies more than 30'000 counts behind this start.
  EXPECT_EQ(rig.axis().homing_state(), HomingState::kFailed);
  EXPECT_EQ(rig.axis().command_position(), -50'000);
}

TEST(IndexCapture, LatchesWhereTheMarkPassedAndReadingClearsIt) {
  Rig rig(bench_axis(), {}, with_index_and_switch());
  prepare(rig, 0.2);
  EXPECT_EQ(rig.axis().status() & kIndexCaptured, 0);
  const double origin = rig.angle_rad() - rig.axis().position() * kCountRad;
  rig.move_to(rig.axis().position() + kTurn / 2);
  EXPECT_TRUE((rig.axis().status() & kIndexCaptured) != 0);
  EXPECT_NEAR(rig.axis().take_index() * kCountRad + origin, 1.0, 1.5 * kCountRad);
  EXPECT_EQ(rig.axis().status() & kIndexCaptured, 0);
}

}  // namespace
}  // namespace virtdrive::rzt1
