#include "firmware_models/toshiba_mcu/external_speed.h"

#include <gtest/gtest.h>

#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

TEST(ToshibaMcuExternalSpeed, TheSharesOfTheSignals) {
  using E = ExternalSpeed;
  EXPECT_EQ(wanted_share(E::kNone, {.adc_counts = 4095}), 0);
  EXPECT_EQ(wanted_share(E::kAdc, {.adc_counts = 0}), 0);
  EXPECT_EQ(wanted_share(E::kAdc, {.adc_counts = 4095}), 1);
  EXPECT_NEAR(wanted_share(E::kAdc, {.adc_counts = 2048}), 0.5, 1e-3);
  EXPECT_EQ(wanted_share(E::kAdc, {.adc_counts = 4095, .reverse = true}), -1);
  EXPECT_EQ(wanted_share(E::kPwm, {.pwm_high = 0.04}), 0);
  EXPECT_EQ(wanted_share(E::kPwm, {.pwm_high = 0.06}), 0.06);
  EXPECT_EQ(wanted_share(E::kPwm, {.pwm_high = 0.96}), 1);
  EXPECT_EQ(wanted_share(E::kPwm, {.pwm_high = 0.5, .reverse = true}), -0.5);
  EXPECT_EQ(wanted_share(E::kServoBothWays, {.servo_us = 0}), 0) << "no pulse";
  EXPECT_EQ(wanted_share(E::kServoBothWays, {.servo_us = 1000}), -1);
  EXPECT_EQ(wanted_share(E::kServoBothWays, {.servo_us = 1520}), 0);
  EXPECT_EQ(wanted_share(E::kServoBothWays, {.servo_us = 1750}), 0.5);
  EXPECT_EQ(wanted_share(E::kServoBothWays, {.servo_us = 2500}), 1);
  EXPECT_EQ(wanted_share(E::kServoOneWay, {.servo_us = 1000}), 0);
  EXPECT_EQ(wanted_share(E::kServoOneWay, {.servo_us = 1500}), 0.5);
  EXPECT_EQ(wanted_share(E::kServoOneWay, {.servo_us = 2000, .reverse = true}), -1);
}

TEST(ToshibaMcuExternalSpeed, AVoltageStartsSetsAndStopsTheMotor) {
  Rig rig;
  rig.change(&ChannelSettings::external_speed_control, {1});
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  rig.set_input(&BoardInputs::speed_v, 5.0 * 2000 / 5250);
  rig.run_for(5s);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10);
  rig.set_input(&BoardInputs::speed_v, 5.0 * 1000 / 5250);
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 1000, 10);
  rig.board().set_speed_rpm(3000);
  rig.run_for(100ms);
  EXPECT_NEAR(rig.channel().target_rpm(), 1000, 3) << "the signal overrides the host";
  rig.set_input(&BoardInputs::speed_v, 0.0);
  EXPECT_LE(rig.run_to(Stage::kStop), 3s);
}

TEST(ToshibaMcuExternalSpeed, APwmSignalAndTheDirectionPin) {
  Rig rig;
  rig.change(&ChannelSettings::external_speed_control, {2});
  rig.set_input(&BoardInputs::speed_reverse, true);
  rig.set_input(&BoardInputs::speed_pwm, 0.3);
  rig.run_for(5s);
  EXPECT_NEAR(rig.speed_rpm(), -0.3 * 5250, 10);
}

TEST(ToshibaMcuExternalSpeed, AServosPulseTurnsBothWaysAndItsLossStops) {
  Rig rig;
  rig.change(&ChannelSettings::external_speed_control, {3});
  rig.set_input(&BoardInputs::speed_servo_us, 1300.0);
  rig.run_for(5s);
  EXPECT_NEAR(rig.speed_rpm(), -0.4 * 5250, 10);
  rig.set_input(&BoardInputs::speed_servo_us, 0.0);
  EXPECT_LE(rig.run_to(Stage::kStop), 5s);
  rig.change(&ChannelSettings::external_speed_control, {4});
  rig.set_input(&BoardInputs::speed_servo_us, 1400.0);
  rig.run_for(6s);
  EXPECT_NEAR(rig.speed_rpm(), 0.4 * 5250, 10);
}

TEST(ToshibaMcuExternalSpeed, KeepsToDirection) {
  Rig rig;
  rig.change(&ChannelSettings::external_speed_control, {3});
  rig.change(&ChannelSettings::direction, {0});
  rig.set_input(&BoardInputs::speed_servo_us, 1300.0);
  rig.run_for(2s);
  EXPECT_EQ(rig.channel().target_rpm(), 0);
  EXPECT_NE(rig.channel().errors() & bit(Fault::kWrongDirection), 0U);
}

TEST(ToshibaMcuExternalSpeed, WithoutItTheSignalsAreIdle) {
  Rig rig;
  rig.set_input(&BoardInputs::speed_v, 5.0);
  rig.set_input(&BoardInputs::speed_pwm, 1.0);
  rig.set_input(&BoardInputs::speed_servo_us, 2000.0);
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
