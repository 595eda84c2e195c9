// Each interlock of 7.1, on what causes it.
#include <cstdlib>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

bool has(const Rig& rig, std::uint32_t error) {
  return (rig.drive->axis(0).errors() & error) != 0;
}

bool shows(const Rig& rig, std::uint16_t bit) {
  return (rig.drive->axis(0).status() & bit) != 0;
}

// Holds a position against a torque: a current.
void press(Rig& rig, double torque_nm) {
  rig.change_load({.external_torque_nm = torque_nm});
}

TEST(Interlock, MotorHeatIsAFlagThatClearsItself) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.set(&Settings::climit, 100);
  rig.set(&Settings::ctime, 0);
  rig.set(&Settings::plimit, 300);
  rig.set(&Settings::ptime, 100);
  press(rig, 1.0);
  EXPECT_GT(rig.run_to([&] { return shows(rig, kMotorOverheat); }, 2), 0.01);
  EXPECT_TRUE(has(rig, kErrorMotorHeat));
  EXPECT_TRUE(rig.axis().servo_on());
  EXPECT_GT(rig.axis().i2t(), (300 * 300 - 100 * 100) * 100);
  rig.change_load({});
  EXPECT_GT(rig.run_to([&] { return !shows(rig, kMotorOverheat); }, 20), 0);
  EXPECT_TRUE(has(rig, kErrorMotorHeat));  // latched until ERESET
  rig.axis().reset_errors();
  rig.run_for(5ms);
  EXPECT_EQ(rig.axis().errors(), 0U);
}

TEST(Interlock, OverCurrentForItsTimeSwitchesTheServoOff) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.set(&Settings::climit, 150);
  rig.set(&Settings::ctime, 1000);
  rig.set(&Settings::errmask, 0);
  press(rig, 1.0);
  EXPECT_NEAR(rig.run_to([&] { return shows(rig, kOverCurrent); }, 2), 0.1, 0.02);
  EXPECT_TRUE(has(rig, kErrorOverCurrent));
  EXPECT_FALSE(rig.axis().servo_on());
  EXPECT_TRUE(rig.axis().amplifier_on());
  rig.change_load({});
  ASSERT_EQ(rig.axis().on(), Result::kOk);
  EXPECT_FALSE(shows(rig, kOverCurrent));
}

TEST(Interlock, ByMaskItTakesThePowerAndForbidsOn) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.set(&Settings::climit, 150);
  rig.set(&Settings::ctime, 1000);
  press(rig, 1.0);
  EXPECT_GT(rig.run_to([&] { return !rig.axis().amplifier_on(); }, 2), 0);
  EXPECT_TRUE(shows(rig, kMotionComplete));
  EXPECT_EQ(rig.axis().on(), Result::kInterlock);
  EXPECT_EQ(rig.axis().enable(), Result::kInterlock);
  EXPECT_EQ(rig.axis().go(), Result::kInterlock);
  rig.axis().reset_errors();
  rig.change_load({});
  EXPECT_EQ(rig.axis().on(), Result::kOk);
}

TEST(Interlock, TheInvertersFaultSwitchesTheServoOff) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.hardware.axis[0].amplifier_fault = true;
  rig.drive->hardware_changed();
  rig.run_for(2ms);
  EXPECT_TRUE(shows(rig, kAmplifierFault));
  EXPECT_TRUE(has(rig, kErrorAmplifier));
  EXPECT_FALSE(rig.axis().servo_on());
  EXPECT_EQ(rig.axis().on(), Result::kFault);
  rig.hardware.axis[0].amplifier_fault = false;
  rig.run_for(2ms);
  EXPECT_EQ(rig.axis().on(), Result::kOk);
  EXPECT_FALSE(shows(rig, kAmplifierFault));
}

TEST(Interlock, AnExcessErrorStopsTheMotionAndWithAstopTheServo) {
  for (const int astop : {0, 1}) {
    Rig rig;
    rig.set(&Settings::astop, astop);
    ASSERT_EQ(rig.ready(), Result::kOk);
    ASSERT_EQ(rig.axis().jog(7158282), Result::kOk);
    rig.run_for(200ms);
    Load locked;
    locked.locked = true;
    rig.change_load(locked);
    // 5000 counts after 5 ms, then ETIME.
    EXPECT_NEAR(rig.run_to([&] { return shows(rig, kPositionErrorBit); }), 0.055, 0.01);
    EXPECT_TRUE(has(rig, kErrorPosition));
    const ErrorLatch latch = rig.axis().latched();
    EXPECT_GT(latch.command_position - latch.position, 5000);
    EXPECT_EQ(latch.command_velocity, 7158282);
    EXPECT_GT(rig.run_to_end_of_motion(), 0);
    rig.run_for(1ms);
    EXPECT_EQ(rig.axis().servo_on(), astop == 0);
  }
}

TEST(Interlock, AnInputInhibitsAtOnce) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.hardware.axis[0].input_pins = 2;
  rig.drive->hardware_changed();
  rig.run_for(5ms);
  EXPECT_TRUE(rig.axis().servo_on());
  rig.set(&Settings::emask, 2);
  rig.run_for(1ms);
  EXPECT_TRUE(shows(rig, kInputInhibit));
  EXPECT_TRUE(has(rig, kErrorInput));
  EXPECT_FALSE(rig.axis().servo_on());
  EXPECT_FALSE(rig.axis().amplifier_on());
}

TEST(Interlock, BusVoltageHasTwoLimits) {
  for (const bool low : {true, false}) {
    Rig rig;
    rig.set(&Settings::elvolt, 200 * 8);
    rig.set(&Settings::ehvolt, 350 * 8);
    ASSERT_EQ(rig.ready(), Result::kOk);
    EXPECT_NEAR(rig.axis().bus_counts(), 280 * 8, 1);
    EXPECT_EQ(rig.axis().errors(), 0U);
    rig.plant().set_source_voltage(low ? 150 : 400);
    rig.run_for(2ms);
    EXPECT_TRUE(has(rig, low ? kErrorUnderVoltage : kErrorOverVoltage));
    EXPECT_FALSE(has(rig, low ? kErrorOverVoltage : kErrorUnderVoltage));
    EXPECT_FALSE(rig.axis().amplifier_on());
  }
}

TEST(Interlock, ACurrentBeyondTheConverterTakesTheOutputs) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().off(), Result::kOk);
  rig.set(&Settings::pcmode, 0);
  Load locked;
  locked.locked = true;
  rig.change_load(locked);
  ASSERT_EQ(rig.axis().set_output(12'000), Result::kOk);  // 59 V on 1.5 ohms
  EXPECT_LT(rig.run_to([&] { return !rig.axis().amplifier_on(); }), 0.01);
  EXPECT_TRUE(has(rig, kErrorOutputDisable));
  rig.run_for(10ms);
  EXPECT_NEAR(rig.plant().state().i_q_a, 0, 1e-3);
}

TEST(Interlock, ThePreAlarmComesBeforeTheTrip) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.set(&Settings::eovc, 120);
  rig.set(&Settings::errmask, 0x1E380000 & ~static_cast<std::int32_t>(kErrorPreAlarm));
  rig.set(&Settings::climit, 900);
  press(rig, 0.8);
  rig.run_for(100ms);
  EXPECT_TRUE(has(rig, kErrorPreAlarm));
  EXPECT_TRUE(rig.axis().servo_on());
}

TEST(Interlock, OverSpeedTrips) {
  Rig rig;
  rig.set(&Settings::eovs, 6'000'000);
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().jog(5'000'000), Result::kOk);
  rig.run_for(200ms);
  EXPECT_EQ(rig.axis().errors(), 0U);
  ASSERT_EQ(rig.axis().jog(7'000'000), Result::kOk);
  rig.run_for(200ms);
  EXPECT_TRUE(has(rig, kErrorOverSpeed));
  EXPECT_FALSE(rig.axis().servo_on());
}

TEST(Interlock, ASpeedDifferenceTripsAfterFiveSeconds) {
  Rig rig;
  rig.set(&Settings::ewovs, 1'000'000);
  rig.set(&Settings::max_error, 0);
  rig.set(&Settings::ctime, 0);
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().jog(3'000'000), Result::kOk);
  rig.run_for(100ms);
  Load locked;
  locked.locked = true;
  rig.change_load(locked);
  EXPECT_NEAR(rig.run_to([&] { return has(rig, kErrorSpeedDifference); }), 5, 0.1);
  EXPECT_FALSE(rig.axis().amplifier_on());
}

TEST(Interlock, PositionsBeyondTheLimitsAreNoticed) {
  for (const int direction : {-1, 1}) {
    Rig rig;
    ASSERT_EQ(rig.ready(), Result::kOk);
    ASSERT_EQ(rig.axis().set_position(0), Result::kOk);
    rig.set(&Settings::ewposmin, -10'000);
    rig.set(&Settings::ewposmax, 10'000);
    rig.move_to(direction * 20'000);
    EXPECT_TRUE(has(rig, direction > 0 ? kErrorPositionHigh : kErrorPositionLow));
    EXPECT_TRUE(rig.axis().servo_on());  // not in the factory's mask
  }
}

TEST(Interlock, AHotInverterIsNoticed) {
  Rig rig;
  rig.run_for(2ms);
  EXPECT_EQ(rig.axis().temperature_counts(), 700);
  rig.hardware.axis[0].inverter_degc = 110;
  rig.run_for(2ms);
  EXPECT_TRUE(has(rig, kErrorTemperature));
  rig.set(&Settings::errmask, kErrorTemperature);
  EXPECT_EQ(rig.axis().on(), Result::kInterlock);
}

TEST(Interlock, AHotInverterCoolsWhenItRests) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  const std::int32_t cool = rig.axis().temperature_counts();
  press(rig, 1.27);
  rig.run_for(10s);
  const std::int32_t warm = rig.axis().temperature_counts();
  EXPECT_GT(warm, cool + 5);
  ASSERT_EQ(rig.axis().disable(), Result::kOk);
  rig.change_load({});
  rig.run_for(200s);
  EXPECT_LT(rig.axis().temperature_counts(), warm - 4);
}

TEST(Interlock, AFaultyInverterLetsGoByItself) {
  Rig rig;
  ASSERT_EQ(rig.axis().align(), Result::kOk);
  rig.run_for(100ms);
  EXPECT_GT(rig.axis().total_current(), 100);
  rig.hardware.axis[0].amplifier_fault = true;
  rig.run_for(50us);
  rig.run_for(10ms);
  EXPECT_LT(rig.axis().total_current(), 3);
  EXPECT_FALSE(rig.axis().busy());
  EXPECT_TRUE(rig.axis().search_failed());
}

TEST(Interlock, OneAxisTripsAndTheOtherGoesOn) {
  Rig rig;
  ASSERT_EQ(rig.ready(0), Result::kOk);
  ASSERT_EQ(rig.ready(1), Result::kOk);
  rig.hardware.axis[0].amplifier_fault = true;
  rig.run_for(2ms);
  EXPECT_FALSE(rig.axis(0).servo_on());
  EXPECT_TRUE(rig.axis(1).servo_on());
}

// --- Inputs --------------------------------------------------------------------------------------

TEST(Inputs, TwoOfThreeSamplesDecide) {
  Rig rig;
  rig.run_for(3ms);
  Inputs inputs;
  for (int i = 0; i < 3; ++i) inputs.sample(0, 2);
  EXPECT_EQ(inputs.word(), 0x20);
  inputs.sample(1, 2);  // one sample is noise
  EXPECT_EQ(inputs.word(), 0x20);
  inputs.sample(0, 2);
  EXPECT_EQ(inputs.word(), 0x20);
  inputs.sample(1, 2);
  EXPECT_EQ(inputs.word(), 0x21);
}

TEST(Inputs, TheWordHasHallsAndInputsOfBothAxes) {
  Rig rig;
  rig.hardware.axis[0].input_pins = 0b1001;
  rig.hardware.axis[1].input_pins = 0b0010;
  rig.drive->hardware_changed();
  rig.run_for(3ms);
  EXPECT_EQ(rig.axis(0).halls(), 2);  // the d axis is on phase U
  EXPECT_EQ(rig.drive->inputs(), 0x2922);
}

TEST(Inputs, HallsFollowTheRotorInTheLegalCycle) {
  Rig rig;
  const std::uint8_t cycle[] = {2, 6, 4, 5, 1, 3};
  for (int sector = 0; sector < 6; ++sector) {
    rig.turn_to(sector * kTurnRad / 6 / 5);
    rig.run_for(3ms);
    EXPECT_EQ(rig.axis().halls(), cycle[sector]);
    EXPECT_EQ(hall_sector(rig.axis().halls()), sector);
  }
  rig.set(&Settings::hinvert, 1);
  rig.run_for(3ms);
  EXPECT_EQ(rig.axis().halls(), 7 - 3);
  EXPECT_EQ(rig.axis().hall_position(), rig.axis().position());
}

TEST(Inputs, ADipSwitchChoosesTheHallsConnector) {
  Rig rig;
  rig.run_for(3ms);
  EXPECT_EQ(rig.axis().halls(), 2);
  rig.hardware.dip_halls_at_encoder[0] = false;
  rig.run_for(5ms);
  EXPECT_EQ(rig.axis().halls(), 0);
  rig.hardware.axis[0].hall_plug = AxisHardware::HallPlug::kP5;
  rig.run_for(5ms);
  EXPECT_EQ(rig.axis().halls(), 2);
}

}  // namespace
}  // namespace virtdrive::rzt1
