#include "firmware_models/md/speed_input.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "firmware_models/md/hall.h"
#include "firmware_models/md/six_step.h"

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

Settings with_type(InputType type) {
  Settings settings;
  settings.input_type = static_cast<std::int32_t>(type);
  return settings;
}

TEST(MdSpeedInput, AnalogIsLinearBetweenItsLimits) {
  Settings s = with_type(InputType::kAnalog);
  EXPECT_NEAR(speed_input({.speed_v = 0}, s), 0, 1);
  EXPECT_NEAR(speed_input({.speed_v = 2.5}, s), 511.5, 1);
  EXPECT_NEAR(speed_input({.speed_v = 5}, s), 1023, 1);
  EXPECT_NEAR(speed_input({.pwm_duty = 0.25}, s), 256, 1);
  s.low_speed_limit = 100;
  s.high_speed_limit = 900;
  EXPECT_EQ(speed_input({.speed_v = 0.4}, s), 0);
  EXPECT_NEAR(speed_input({.speed_v = 500 * 5 / 1023.0}, s), 511.5, 1);
  EXPECT_EQ(speed_input({.speed_v = 4.5}, s), 1023);
}

TEST(MdSpeedInput, TheJoystickHasItsCentreAtTwoAndAHalfVolts) {
  const Settings s = with_type(InputType::kJoystick);
  EXPECT_EQ(speed_input({.speed_v = 2.5}, s), 0);
  EXPECT_EQ(speed_input({.speed_v = 2.05}, s), 0);
  EXPECT_EQ(speed_input({.speed_v = 2.95}, s), 0);
  EXPECT_LT(speed_input({.speed_v = 1.9}, s), 0);
  EXPECT_GT(speed_input({.speed_v = 3.1}, s), 0);
  EXPECT_NEAR(speed_input({.speed_v = 0}, s), -1023, 1);
  EXPECT_NEAR(speed_input({.speed_v = 5}, s), 1023, 1);
}

TEST(MdSpeedInput, PulsesCountUpToFiveHundredThousand) {
  const Settings s = with_type(InputType::kPulse);
  EXPECT_EQ(speed_input({.pulse_hz = 1000}, s), 0);
  EXPECT_NEAR(speed_input({.pulse_hz = 250e3}, s), 511.5, 1);
  EXPECT_EQ(speed_input({.pulse_hz = 700e3}, s), 1023);
}

TEST(MdSpeedInput, AServoPulseHasItsCentreAtOneAndAHalfMilliseconds) {
  const Settings s = with_type(InputType::kRcServo);
  EXPECT_EQ(speed_input({.rc_ms = 0}, s), 0);
  EXPECT_EQ(speed_input({.rc_ms = 1.5}, s), 0);
  EXPECT_EQ(speed_input({.rc_ms = 1.58}, s), 0);
  EXPECT_NEAR(speed_input({.rc_ms = 1.05}, s), -1023, 1);
  EXPECT_NEAR(speed_input({.rc_ms = 1.95}, s), 1023, 1);
}

TEST(MdSpeedInput, TheCurveGoesThroughThePointsThatAreSet) {
  Settings s = with_type(InputType::kAnalog);
  s.curve[0] = {300, 100};
  s.curve[1] = {600, 800};
  EXPECT_NEAR(curve(150, s), 50, 1e-9);
  EXPECT_NEAR(curve(450, s), 450, 1e-9);
  EXPECT_NEAR(curve(1023, s), 1023, 1e-9);
  EXPECT_NEAR(curve(-450, s), -450, 1e-9);
  s.curve[1].x = 200;  // before the first: no curve
  EXPECT_NEAR(curve(150, s), 150, 1e-9);
  s.curve[2] = {500, 250};
  EXPECT_NEAR(curve(-500, s), -250, 1e-9);
}

TEST(MdSpeedInput, APositionHasThreePoints) {
  Settings s;
  s.posi_min = 100;
  s.posi_cen = 800;
  s.posi_max = 1200;
  EXPECT_EQ(position_input(-1023, s), 100);
  EXPECT_EQ(position_input(0, s), 800);
  EXPECT_EQ(position_input(511.5, s), 1000);
  EXPECT_EQ(position_input(1023, s), 1200);
}

TEST(MdHall, TellsSpeedDirectionAndStandstill) {
  constexpr std::uint8_t kForward[] = {5, 1, 3, 2, 6, 4};
  HallCounter hall;
  SimTime t = kSimStart;
  for (int i = 0; i < 60; ++i) hall.see(kForward[i % 6], t += 2ms);
  EXPECT_EQ(hall.count(), 59);
  EXPECT_NEAR(hall.rpm(t, 30), 1000, 1e-6);
  EXPECT_NEAR(hall.rpm(t + 20ms, 30), 100, 1e-6);  // the next edge is late
  EXPECT_EQ(hall.rpm(t + 1100ms, 30), 0);
  hall.see(kForward[58 % 6], t += 2ms);
  EXPECT_EQ(hall.count(), 58);
  EXPECT_EQ(hall.rpm(t, 30), 0);  // to and fro is no speed
  hall.see(7, t + 1ms);
  EXPECT_EQ(hall.count(), 58);
}

TEST(MdSixStep, OneLegFloatsInEverySector) {
  for (int sector = 0; sector < 6; ++sector) {
    for (const double output : {0.4, -0.4}) {
      const BridgeCommand command = six_step(sector, output, 62'500ns);
      EXPECT_EQ(std::ranges::count(command.legs, Leg::kHiZ), 1);
      EXPECT_EQ(std::ranges::count(command.legs, Leg::kLow), 1);
      const PhasePair pair = pair_of(sector);
      const std::size_t source = output > 0 ? pair.source : pair.sink;
      EXPECT_EQ(command.legs[source], Leg::kDuty);
      EXPECT_EQ(command.duty[source], 0.4);
    }
  }
}

}  // namespace
}  // namespace virtdrive::md
