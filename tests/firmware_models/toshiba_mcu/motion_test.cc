#include "firmware_models/toshiba_mcu/motion.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

class MotionTest : public testing::Test {
 protected:
  double plant_turns() {
    rig_.speed_rpm();
    return rig_.axis_of().state().angle_rad / (2 * std::numbers::pi);
  }
  /// Runs until the channel's target is 0 and it stands; the highest |rpm| on the way.
  double run_to_standstill(SimDuration patience = 120s) {
    double highest = 0;
    rig_.run_for(300ms);
    rig_.loop.run_until(rig_.loop.now() + patience, [&] {
      highest = std::max(highest, std::abs(rig_.channel().internals().command_hz) * 15);
      return rig_.channel().target_rpm() == 0 && rig_.channel().internals().command_hz == 0;
    });
    rig_.run_for(200ms);
    return highest;
  }
  Rig rig_;
};

// --- DoTurn --------------------------------------------------------------------------------------

TEST_F(MotionTest, TurnsSoManyAndStops) {
  for (const std::int32_t turns : {15, -15}) {
    rig_.board().set_speed_rpm(0);
    const double from = plant_turns();
    const std::int32_t number = rig_.board().turn_number();
    ASSERT_EQ(rig_.board().do_turn(turns, 600), Outcome::kDone);
    const double highest = run_to_standstill();
    EXPECT_EQ(rig_.channel().stage(), Stage::kStop);
    EXPECT_EQ(rig_.board().turn_number() - number, turns);
    // The rotor was somewhere when it was pulled to the frame's angle: half a pole pair at most.
    EXPECT_NEAR(plant_turns() - from, turns, 0.2);
    EXPECT_NEAR(highest, 600, 30);
  }
}

TEST_F(MotionTest, WithAnEncoderTheCountIsTheEncoders) {
  rig_.change(&ChannelSettings::encoder, {3});
  rig_.board().do_turn(5, 500);
  run_to_standstill();
  EXPECT_EQ(rig_.channel().stage(), Stage::kStop);
  EXPECT_EQ(rig_.board().turn_number(), 5);
  EXPECT_NEAR(rig_.board().encoder_count(), 10'000, 60);
  EXPECT_NEAR(plant_turns(), 5, 0.05);
}

TEST_F(MotionTest, TheLastTurnIsMadeAtTenRpm) {
  rig_.board().do_turn(4, 500);
  rig_.loop.run_until(rig_.loop.now() + 30s, [&] { return rig_.board().turn_number() == 3; });
  rig_.run_for(500ms);
  EXPECT_NEAR(rig_.channel().actual_rpm(), 10, 2);
  EXPECT_EQ(rig_.channel().target_rpm(), 10);
}

TEST_F(MotionTest, MoreTurnsAreAddedToThoseUnderWay) {
  rig_.board().do_turn(3, 500);
  rig_.run_for(1500ms);
  EXPECT_EQ(rig_.board().do_turn(4, 500), Outcome::kDone);
  run_to_standstill();
  EXPECT_EQ(rig_.board().turn_number(), 7);
}

TEST_F(MotionTest, TurnsAreRefusedWithoutSpeedAndAgainstDirection) {
  EXPECT_EQ(rig_.board().do_turn(1, 0), Outcome::kRefused);
  rig_.change(&ChannelSettings::direction, {0});
  EXPECT_EQ(rig_.board().do_turn(-1, 100), Outcome::kRefused);
  EXPECT_EQ(rig_.channel().errors(), bit(Fault::kWrongDirection));
  EXPECT_EQ(rig_.channel().stage(), Stage::kStop);
}

TEST_F(MotionTest, StopAndASpeedEndIt) {
  rig_.board().do_turn(100, 500);
  rig_.run_for(2s);
  EXPECT_EQ(rig_.board().stop(), Outcome::kDone);
  EXPECT_LE(rig_.run_to(Stage::kStop), 2s);
  rig_.board().do_turn(100, 500);
  rig_.run_for(2s);
  rig_.board().set_speed_rpm(1000);
  rig_.run_for(3s);
  EXPECT_NEAR(rig_.channel().actual_rpm(), 1000, 10);
}

TEST_F(MotionTest, ATurnNeedsAHealthyDrive) {
  rig_.board().start();
  rig_.run_for(20ms);
  rig_.set_input(&BoardInputs::emergency, true);
  ASSERT_EQ(rig_.channel().stage(), Stage::kEmergency);
  EXPECT_EQ(rig_.board().do_turn(1, 100), Outcome::kNotReady);
  EXPECT_FALSE(rig_.board().do_linear_motion(1, 100));
}

// --- Linear motion -------------------------------------------------------------------------------

class LinearMotionTest : public MotionTest {
 protected:
  LinearMotionTest() { rig_.change(&ChannelSettings::encoder, {3}); }
  /// What is left to the position, in pulses, after the motion.
  double go_to(std::uint32_t position, std::int32_t rpm = 500) {
    EXPECT_TRUE(rig_.board().do_linear_motion(position, rpm)) << position;
    run_to_standstill();
    return static_cast<double>(position) - rig_.board().absolute_position();
  }
};

TEST_F(LinearMotionTest, GoesToPositionsAndHoldsThem) {
  // 1 A holds 34 mNm against 3 mNm of friction: what swings on at the end is a few pulses.
  for (const std::uint32_t position : {20'000U, 24'000U, 3'000U, 3'050U, 3'000U, 0U, 10'000U}) {
    EXPECT_NEAR(go_to(position), 0, 12) << position;
    EXPECT_EQ(rig_.channel().stage(), Stage::kForce) << "powered";
    EXPECT_NEAR(plant_turns() * 2000, position, 14);
  }
}

TEST_F(LinearMotionTest, HoldsAgainstALoad) {
  go_to(4000);
  Load load;
  load.external_torque_nm = 0.015;
  rig_.axis_of().set_load(load);
  rig_.run_for(1s);
  // asin(15/34) of an electrical turn's 500 counts at the most, and the friction's share.
  EXPECT_NEAR(rig_.board().absolute_position(), 4000, 50);
}

TEST_F(LinearMotionTest, TheLastTwentiethIsApproached) {
  rig_.change(&ChannelSettings::encoder_approach, {40});
  ASSERT_TRUE(rig_.board().do_linear_motion(100'000, 1500));
  rig_.loop.run_until(rig_.loop.now() + 60s,
                      [&] { return rig_.board().absolute_position() > 96'500; });
  EXPECT_NEAR(rig_.channel().actual_rpm(), 40, 6);
  EXPECT_EQ(rig_.channel().target_rpm(), 40);
}

TEST_F(LinearMotionTest, WithoutAnEncoderTheEmulatedCountIsThePosition) {
  rig_.change(&ChannelSettings::encoder, {0});
  EXPECT_NEAR(go_to(240), 0, 1);  // 24 a turn
  EXPECT_NEAR(plant_turns(), 10, 0.2);
}

TEST_F(LinearMotionTest, StartPositionIsWhatTheEncoderStandsForWhenItIsWritten) {
  go_to(2000);
  rig_.change(&ChannelSettings::encoder_start_position, {500'000});
  EXPECT_EQ(rig_.board().absolute_position(), 500'000U);
  EXPECT_NEAR(go_to(504'000), 0, 12);
  EXPECT_NEAR(plant_turns(), 3, 0.02);
}

TEST_F(LinearMotionTest, PositionsReachOverTheSignedHalfOfThirtyTwoBits) {
  rig_.change(&ChannelSettings::encoder_start_position, {-2'000});  // 4294965296
  EXPECT_EQ(rig_.board().absolute_position(), 4294965296U);
  EXPECT_NEAR(go_to(4294967000U), 0, 12);
}

TEST_F(LinearMotionTest, TheGearMakesPulsesOfTheOutputShaft) {
  rig_.change(&ChannelSettings::encoder_gear_factor, {10});
  EXPECT_NEAR(go_to(2000, 1000), 0, 2);
  EXPECT_NEAR(plant_turns(), 10, 0.1);
  EXPECT_NEAR(rig_.board().encoder_count(), 20'000, 30);
}

TEST_F(LinearMotionTest, RefusesWhatItCannotDo) {
  rig_.change(&ChannelSettings::encoder_min_position, {100});
  rig_.change(&ChannelSettings::encoder_max_position, {5000});
  EXPECT_FALSE(rig_.board().do_linear_motion(99, 500));
  EXPECT_FALSE(rig_.board().do_linear_motion(5001, 500));
  EXPECT_FALSE(rig_.board().do_linear_motion(5000, 0));
  EXPECT_EQ(rig_.channel().stage(), Stage::kStop);
  EXPECT_TRUE(rig_.board().do_linear_motion(5000, 500));
  rig_.run_for(500ms);
  EXPECT_FALSE(rig_.board().do_linear_motion(200, 500)) << "busy";
  rig_.board().abort_linear_motion();
  rig_.run_for(1s);
  EXPECT_EQ(rig_.channel().stage(), Stage::kForce) << "still powered";
  EXPECT_EQ(rig_.channel().target_rpm(), 0);
  EXPECT_TRUE(rig_.board().do_linear_motion(200, 500));
  rig_.board().abort_linear_motion();
  rig_.change(&ChannelSettings::encoder_approach, {0});
  EXPECT_FALSE(rig_.board().do_linear_motion(300, 500));
}

TEST_F(LinearMotionTest, AnAbortWithoutAMotionChangesNothing) {
  rig_.run_up(1000, 3s);
  rig_.board().abort_linear_motion();
  EXPECT_EQ(rig_.channel().target_rpm(), 1000);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
