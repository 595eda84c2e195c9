#include "firmware_models/md/controller.h"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware_models/md/rig.h"

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

constexpr int kNoAlarm = 0;

double seconds_to(SimDuration d) {
  return seconds(d);
}

// --- Control -------------------------------------------------------------------------------------

TEST(MdControl, SpeedIsReachedInBothDirectionsAndKeptUnderLoad) {
  for (const double rpm : {1500.0, -1500.0}) {
    Rig rig;
    rig.order().speed(rpm);
    rig.run_for(2s);
    EXPECT_NEAR(rig.speed_rpm(), rpm, 15);
    EXPECT_EQ(rig.motor().type(), ControlType::kSpeed);
    rig.load(&Load::brake_torque_nm, 1.0);
    rig.run_for(3s);
    EXPECT_NEAR(rig.speed_rpm(), rpm, 15);
    EXPECT_NEAR(rig.motor().current_a(), 1.0 / 0.12, 1.0);
    EXPECT_EQ(rig.motor().status(), kNoAlarm);
  }
}

TEST(MdControl, EveryModelReachesItsSpeed) {
  for (const Model& model : models()) {
    Rig rig(model.name);
    for (std::size_t i = 0; i < model.motors; ++i) rig.order(i).speed(0.7 * model.max_rpm);
    rig.run_for(2500ms);
    for (std::size_t i = 0; i < model.motors; ++i) {
      EXPECT_NEAR(rig.speed_rpm(i), 0.7 * model.max_rpm, 0.02 * model.max_rpm) << model.name;
      EXPECT_EQ(rig.motor(i).status(), kNoAlarm) << model.name;
    }
  }
}

TEST(MdControl, PositionCountsThreeAPole) {
  Rig rig;
  rig.order().speed(600);
  rig.run_for(5s);
  const double turns = rig.axis().state().angle_rad / (2 * std::numbers::pi);
  EXPECT_NEAR(rig.motor().position(), 30 * turns, 1);  // 10 poles
}

TEST(MdControl, SlowStartAndSlowDownAreStraightRamps) {
  Rig rig;
  rig.change(&Settings::p_gain, 6000);
  rig.change(&Settings::i_gain, 6000);
  rig.change(&Settings::slow_start, 205);  // 3 s from 0 to MAX_RPM
  rig.change(&Settings::slow_down, 137);   // 2 s
  rig.order().speed(1500);
  rig.run_for(750ms);
  EXPECT_NEAR(rig.motor().reference_rpm(), 750, 10);
  EXPECT_NEAR(rig.speed_rpm(), 750, 60);
  rig.run_for(2s);
  EXPECT_EQ(rig.motor().reference_rpm(), 1500);
  rig.order().speed(0);
  rig.run_for(500ms);
  EXPECT_NEAR(rig.motor().reference_rpm(), 750, 10);
}

TEST(MdControl, AReversalGoesThroughZeroOnBothRamps) {
  Rig rig;
  rig.change(&Settings::regeneration, 1);
  rig.change(&Settings::slow_start, 205);
  rig.change(&Settings::slow_down, 68);
  rig.order().speed(1000);
  rig.run_for(2s);
  rig.order().speed(-1000);
  rig.run_for(400ms);  // 1000 rpm down in 0.33 s
  EXPECT_LE(rig.motor().reference_rpm(), 0);
  EXPECT_GT(rig.motor().reference_rpm(), -120);
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), -1000, 15);
}

TEST(MdControl, WithoutRegenerationItCoastsAndWithItItBrakes) {
  SimDuration stop[2];
  for (const int regeneration : {0, 1}) {
    Rig rig;
    rig.change(&Settings::regeneration, regeneration);
    rig.change(&Settings::p_gain, 2000);
    rig.load(&Load::inertia_kgm2, 5e-4);
    rig.order().speed(1500);
    rig.run_for(4s);
    rig.order().speed(0);
    stop[regeneration] = rig.run_to([&] { return std::fabs(rig.speed_rpm()) < 100; });
  }
  EXPECT_LT(seconds_to(stop[1]), 0.5 * seconds_to(stop[0]));
}

TEST(MdControl, AtSpeedZeroItIsFreeHeldOrShorted) {
  const auto turned_by_load = [](int stop_status) {
    Rig rig;
    rig.change(&Settings::zero_vel_ctrl, stop_status);
    rig.order().speed(500);
    rig.run_for(1s);
    rig.order().speed(0);
    rig.run_for(2s);
    EXPECT_NEAR(rig.speed_rpm(), 0, 1);
    EXPECT_EQ(rig.motor().type(), stop_status == 1 ? ControlType::kSpeed : ControlType::kOff);
    rig.load(&Load::external_torque_nm, 0.2);
    rig.run_for(1s);
    return std::fabs(rig.speed_rpm());
  };
  const double free = turned_by_load(0), held = turned_by_load(1), shorted = turned_by_load(2);
  EXPECT_GT(free, 1000);
  EXPECT_LT(held, 30);
  EXPECT_LT(shorted, 100);
  EXPECT_GT(shorted, 3);
}

TEST(MdControl, OpenLoopGivesDutyAndTorqueGivesCurrent) {
  Rig rig;
  rig.order().open_loop(512);
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), 1850, 120);  // half of the speed without load
  EXPECT_EQ(rig.motor().type(), ControlType::kOpenLoop);
  EXPECT_EQ(rig.motor().output_counts(), 512);

  Rig locked;
  locked.load(&Load::brake_torque_nm, 5);
  locked.order().torque(512);
  locked.run_for(1s);
  EXPECT_NEAR(locked.motor().current_a(), 10, 0.4);  // half of MAX_LOAD
  EXPECT_NEAR(locked.axis().torque_nm(), 1.2, 0.25);
  EXPECT_EQ(locked.motor().type(), ControlType::kTorque);
}

TEST(MdControl, TheLimiterHoldsTheCurrentAt120PercentOfMaxLoad) {
  Rig rig;
  rig.change(&Settings::max_load, 50);
  rig.load(&Load::brake_torque_nm, 5);
  rig.order().open_loop(400);
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    rig.run_for(1ms);
    for (const double a : rig.axis().phase_currents_a()) most = std::max(most, std::fabs(a));
  }
  EXPECT_GT(most, 5.5);
  EXPECT_LT(most, 7.5);
}

TEST(MdControl, AMoveEndsOnItsTarget) {
  Rig rig;
  rig.order().move_to(1000, 1000);
  EXPECT_EQ(rig.motor().type(), ControlType::kPosition);
  rig.run_for(1s);
  EXPECT_LT(rig.motor().rpm(), 1100);
  rig.run_for(6s);
  EXPECT_NEAR(rig.motor().position(), 1000, 2);
  EXPECT_EQ(rig.motor().target_position(), 1000);
  rig.order().move_by(-400, 500);
  rig.run_for(6s);
  EXPECT_NEAR(rig.motor().position(), 600, 2);
}

TEST(MdControl, InPositionEndsTheControlWhereAWindowIsSet) {
  Rig rig;
  rig.change(&Settings::in_position, 5);
  rig.order().move_to(300, 1000);
  rig.run_for(6s);
  EXPECT_NEAR(rig.motor().position(), 300, 6);
  EXPECT_TRUE(rig.motor().in_position());
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
}

TEST(MdControl, APositionSetDuringAMoveJerksNothing) {
  Rig rig;
  rig.order().move_to(3000, 600);
  rig.run_for(1s);
  const double before = rig.speed_rpm();
  rig.controller->set_position(0, 0);
  rig.run_for(20ms);
  EXPECT_NEAR(rig.speed_rpm(), before, 40);
  EXPECT_NEAR(rig.motor().position(), 0, 10);
}

TEST(MdControl, APhaseLeadMakesItFasterAtFullOutput) {
  double rpm[2];
  for (const int lead : {0, 20}) {
    Rig rig;
    rig.change(&Settings::ccw_phase_offset, lead);
    rig.change(&Settings::max_rpm, 6000);
    rig.order().open_loop(1023);
    rig.run_for(2s);
    rpm[lead > 0] = rig.speed_rpm();
  }
  EXPECT_GT(rpm[1], rpm[0] + 20);
}

TEST(MdControl, OverModulationGivesMoreSpeedWithMoreRipple) {
  const auto run = [](int over_modulation) {
    Rig rig;
    rig.change(&Settings::over_modulation, over_modulation);
    rig.change(&Settings::max_rpm, 6000);
    rig.load(&Load::brake_torque_nm, 0.8);
    rig.order().open_loop(1023);
    rig.run_for(1500ms);
    double most = 0, least = 1e9;
    for (int i = 0; i < 200; ++i) {
      rig.run_for(100us);
      most = std::max(most, rig.axis().torque_nm());
      least = std::min(least, rig.axis().torque_nm());
    }
    return std::pair(rig.speed_rpm(), most - least);
  };
  const auto [plain_rpm, plain_ripple] = run(0);
  const auto [rpm, ripple] = run(1);
  EXPECT_GT(rpm, 1.005 * plain_rpm);
  EXPECT_GT(ripple, plain_ripple);
}

TEST(MdControl, TheSecondsOfASlowStartAreASetting) {
  Rig rig;
  rig.change(&Settings::max_ss_time, 4);
  rig.change(&Settings::slow_start, 1023);
  rig.order().speed(3000);
  rig.run_for(1s);
  EXPECT_NEAR(rig.motor().reference_rpm(), 750, 5);
}

TEST(MdControl, WhileItBrakesTheResistorsDutyIsTold) {
  Rig rig("mda1k", 1,
          {.on_v = 390,
           .off_v = 380,
           .resistance_ohm = 100,
           .heat_capacity_j_per_k = 200,
           .ambient_k_per_w = 0.5});
  rig.change(&Settings::regeneration, 1);
  rig.change(&Settings::p_gain, 2000);
  rig.load(&Load::inertia_kgm2, 5e-3);
  rig.order().speed(2500);
  rig.run_for(3s);
  EXPECT_EQ(rig.controller->brake_duty(), 0);
  rig.order().speed(0);
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    rig.run_for(1ms);
    most = std::max(most, rig.controller->brake_duty());
  }
  EXPECT_GT(most, 0.2);
  EXPECT_LE(most, 1);
  EXPECT_LT(rig.axis().bus().voltage_v(), 400);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.run_for(2s);
  EXPECT_LT(rig.controller->brake_duty(), 0.01);
}

// 4 x 1000 counts a turn; Hall edges give 30. The sign of positions is the other one.
TEST(MdControl, AnEncoderMayGiveThePositionToo) {
  Rig rig;
  rig.controller->stage(0).set_sensors({.encoder = {.lines = 1000}});
  rig.change(&Settings::enc_ppr, 1000);
  rig.change(&Settings::use_eposi, 1);
  rig.order().speed(300);
  rig.run_for(2s);
  const double turns = rig.axis().state().angle_rad / (2 * std::numbers::pi);
  EXPECT_NEAR(rig.motor().position(), -4000 * turns, 25);
  rig.controller->set_position(0, 0);
  rig.order().move_to(6000, 300);
  rig.run_for(5s);
  EXPECT_NEAR(rig.motor().position(), 6000, 3);
  const double moved = rig.axis().state().angle_rad / (2 * std::numbers::pi) - turns;
  EXPECT_NEAR(moved, -1.5, 0.01);
  rig.order().move_by(-2000, 300);
  rig.run_for(5s);
  EXPECT_NEAR(rig.motor().position(), 4000, 20);
}

TEST(MdControl, AnEncoderKeepsASpeedThatHallEdgesAreTooRareFor) {
  Rig rig;
  rig.controller->stage(0).set_sensors({.encoder = {.lines = 2500}});
  rig.change(&Settings::enc_ppr, 2500);
  rig.order().speed(-20);
  rig.run_for(2s);
  for (int i = 0; i < 50; ++i) {
    rig.run_for(10ms);
    ASSERT_NEAR(rig.speed_rpm(), -20, 4);
  }
}

TEST(MdControl, AnEncoderGivesTheSpeedAndItsLossIsSeen) {
  Rig rig;
  rig.change(&Settings::enc_ppr, 1000);
  rig.controller->stage(0).set_sensors({.encoder = {.lines = 1000}});
  rig.order().speed(500);
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), 500, 5);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.controller->stage(0).set_sensors({});
  rig.run_for(2s);
  EXPECT_EQ(rig.motor().status2(), kEncFail);
  EXPECT_NE(rig.motor().status() & kAlarm, 0);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
}

// --- Limits --------------------------------------------------------------------------------------

TEST(MdLimits, AnOpenLimitStopsItsDirectionOnly) {
  Rig rig;
  rig.order().speed(500);
  rig.run_for(1s);
  rig.pins().start = false;
  rig.run_for(500ms);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
  EXPECT_NEAR(rig.speed_rpm(), 0, 1);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.order().speed(-500);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), -500, 15);
  rig.order().speed(500);
  rig.run_for(2s);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
  rig.pins().start = true;
  rig.run_for(50ms);
  rig.order().speed(500);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), 500, 15);
}

TEST(MdLimits, AnInverseSignTurnsWhichLimitCounts) {
  Rig rig;
  rig.change(&Settings::inv_sign, 1);
  rig.pins().start = false;  // CCW of the motor
  rig.order().speed(500);    // turns CW
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), -500, 15);
  EXPECT_NEAR(rig.motor().rpm(), 500, 15);
}

TEST(MdLimits, TheCurrentStopsLikeASwitch) {
  Rig rig;
  rig.change(&Settings::tq_limit_sw, 1);
  rig.order().speed(500);
  rig.run_for(1s);
  rig.load(&Load::brake_torque_nm, 5);
  EXPECT_LT(rig.run_to([&] { return rig.motor().type() == ControlType::kOff; }), 1500ms);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
}

TEST(MdLimits, RunBrakeActsOnceWhileFramesDrive) {
  Rig rig;
  rig.order().speed(500);
  rig.run_for(1s);
  rig.pins().run = false;
  rig.run_for(100ms);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
  rig.order().speed(500);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), 500, 15);
}

// --- Protections, each by what causes it ---------------------------------------------------------

TEST(MdProtections, CtrlFailAfterFifteenSecondsFarFromTheReference) {
  Rig rig;
  rig.change(&Settings::max_rpm, 6000);  // more than the voltage allows
  rig.change(&Settings::regeneration, 1);
  rig.order().speed(6000);
  const SimDuration time = rig.run_to_status(kAlarm | kCtrlFail);
  EXPECT_NEAR(seconds_to(time), 15, 0.5);
  EXPECT_EQ(rig.motor().status(), kAlarm | kCtrlFail);
}

TEST(MdProtections, OverVoltTenMillisecondsAfterTheSupplyRose) {
  Rig rig;
  rig.order().speed(500);
  rig.run_for(1s);
  rig.axis().set_source_voltage(61);
  EXPECT_NEAR(seconds_to(rig.run_to_status(kAlarm | kOverVolt)), 0.010, 0.002);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
  rig.controller->reset_alarms();
  rig.run_for(50ms);
  EXPECT_NE(rig.motor().status() & kOverVolt, 0);  // the cause is still there
  rig.axis().set_source_voltage(48);
  rig.controller->reset_alarms();
  rig.run_for(50ms);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
}

TEST(MdProtections, OverTempAboveSixtyFiveDegreesAndLessCurrentBefore) {
  EXPECT_DOUBLE_EQ(derating(55), 1);
  EXPECT_DOUBLE_EQ(derating(60), 0.75);
  EXPECT_DOUBLE_EQ(derating(65), 0.5);
  Rig rig;
  rig.order().speed(1000);
  rig.controller->set_ambient_degc(60);
  rig.run_for(1s);
  EXPECT_NEAR(rig.motor().output().limit_a, 20 * 1.2 * 0.75, 0.3);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.controller->set_ambient_degc(66);
  rig.run_for(10ms);
  EXPECT_EQ(rig.motor().status(), kAlarm | kOverTemp);
}

TEST(MdProtections, TheHeatSinkWarmsWithTheLoadAndTheFanCools) {
  Rig rig;
  rig.controller->set_ambient_degc(40);
  rig.order().speed(1000);
  rig.load(&Load::brake_torque_nm, 2.0);
  rig.run_for(4s);
  EXPECT_GT(rig.controller->heat_sink_degc(), 40.2);
  EXPECT_FALSE(rig.controller->fan());
  rig.controller->set_ambient_degc(46);
  rig.run_for(10ms);
  EXPECT_TRUE(rig.controller->fan());
  rig.controller->set_ambient_degc(35);
  rig.run_for(10ms);
  EXPECT_FALSE(rig.controller->fan());
}

TEST(MdProtections, OverLoadAfterFourSecondsAboveMaxLoad) {
  Rig rig;
  rig.change(&Settings::max_load, 50);
  rig.order().speed(1000);
  rig.run_for(2s);
  rig.load(&Load::brake_torque_nm, 0.6);  // 5.2 A: above MAX_LOAD, below the limiter
  const SimDuration time = rig.run_to_status(kAlarm | kOverLoad);
  EXPECT_GT(time, 4s);
  EXPECT_LT(time, 6s);
  EXPECT_EQ(rig.motor().status(), kAlarm | kOverLoad);
}

// 1.6 Nm take 13.5 A; 150 % of a MAX_LOAD of 6 A are 9 A.
TEST(MdProtections, OverLoadAtOnceWhenTheLoadTakesMoreThanOneAndAHalfTimesMaxLoad) {
  Rig rig;
  rig.order().speed(1000);
  rig.load(&Load::brake_torque_nm, 1.6);
  rig.run_for(2s);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.change(&Settings::max_load, 60);
  EXPECT_LE(rig.run_to_status(kAlarm | kOverLoad), 3ms);
  EXPECT_EQ(rig.motor().type(), ControlType::kOff);
}

TEST(MdProtections, OverLoadAtOnceAboveHalfAsMuchAgain) {
  Protections protections;
  EXPECT_TRUE(protections.watch({.current_a = 15.1, .max_load_a = 10, .over_v = 60, .hall = 5}));
  EXPECT_EQ(protections.status(), kAlarm | kOverLoad);
}

HallSensors broken_hall_cable(std::uint8_t code) {
  HallSensors hall = StageSensors{}.hall;
  hall.output.fill(code == 7 ? HallSensors::Output::kStuckHigh : HallSensors::Output::kStuckLow);
  return hall;
}

TEST(MdProtections, HallFailTenMillisecondsAfterTheCableBroke) {
  for (const std::uint8_t code : {std::uint8_t{0}, std::uint8_t{7}}) {
    Rig rig;
    rig.order().speed(500);
    rig.run_for(1s);
    rig.controller->stage(0).set_sensors({.hall = broken_hall_cable(code)});
    EXPECT_NEAR(seconds_to(rig.run_to_status(kAlarm | kHallFail)), 0.010, 0.002);
    EXPECT_EQ(rig.motor().type(), ControlType::kOff);
    rig.order().speed(500);
    EXPECT_EQ(rig.motor().type(), ControlType::kOff);  // ignored until the reset
    rig.controller->stage(0).set_sensors({});
    rig.controller->reset_alarms();
    rig.order().speed(500);
    rig.run_for(2s);
    EXPECT_NEAR(rig.speed_rpm(), 500, 15);
    EXPECT_EQ(rig.motor().last_alarm(), kAlarm | kHallFail);
  }
}

TEST(MdProtections, InvVelWhenALoadTurnsTheMotorAgainstItsOutput) {
  Rig rig;
  rig.order().open_loop(100);
  rig.run_for(500ms);
  rig.load(&Load::viscous_nm_per_radps, 0.01);
  rig.load(&Load::external_torque_nm, 4);
  const SimDuration time = rig.run_to_status(kAlarm | kInvVel, 5s);
  EXPECT_GT(time, 1s);
  EXPECT_LT(time, 2s);
}

TEST(MdProtections, StallTwoSecondsAfterTheShaftWasHeld) {
  Rig rig;
  rig.change(&Settings::max_load, 300);
  rig.load(&Load::brake_torque_nm, 50);
  rig.order().speed(1000);
  const SimDuration time = rig.run_to_status(kAlarm | kStall);
  EXPECT_GT(time, 2s);
  EXPECT_LT(time, 4s);
  EXPECT_NE(rig.motor().status() & kCtrlFail, 0);
}

TEST(MdProtections, UndervoltageHasNoBitAndPassesByItself) {
  Rig rig;
  rig.order().speed(500);
  rig.run_for(1s);
  rig.axis().set_source_voltage(8);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), 0, 1);
  EXPECT_EQ(rig.motor().status(), kNoAlarm);
  rig.axis().set_source_voltage(48);
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), 500, 15);
}

// --- Terminals -----------------------------------------------------------------------------------

TEST(MdTerminals, AtPowerUpNothingMoves) {
  for (const char* name : {"md400", "md200t"}) {
    Rig rig(name);
    rig.run_for(1s);
    EXPECT_EQ(rig.speed_rpm(), 0);
    EXPECT_EQ(rig.motor().type(), ControlType::kOff);
    EXPECT_EQ(input_byte(rig.pins()), 0x7C);
  }
}

TEST(MdTerminals, TheVoltageDrivesUntilAFrameDoes) {
  Rig rig;
  rig.pins().cw = false;
  rig.pins().speed_v = 2.5;
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 1500, 30);
  rig.pins().cw = true;
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), -1500, 30);
  rig.pins().start = false;
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), 0, 1);
  rig.pins().start = true;
  rig.run_for(2s);
  rig.pins().run = false;
  rig.run_for(100ms);
  EXPECT_NEAR(rig.speed_rpm(), 0, 20);  // shorted
  rig.pins().run = true;
  rig.order().speed(300);
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 300, 15);
  rig.controller->let_frames_drive(false);
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), -1500, 30);
}

TEST(MdTerminals, TheInternalVolumeAndWhatReplacesIt) {
  Rig rig;
  rig.pins().cw = false;
  rig.pins().int_speed = true;
  rig.pins().volume = 0.5;
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 1500, 30);
  rig.change(&Settings::tar_vel, 700);
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 700, 15);
}

TEST(MdTerminals, StepsAreTheThreePinsAsANumber) {
  Rig rig;
  rig.pins().cw = false;
  rig.change(&Settings::input_type, 5);
  for (const int step : {7, 2, 1}) {
    rig.pins().int_speed = (step & 1) != 0;
    rig.pins().run = (step & 2) != 0;
    rig.pins().start = (step & 4) != 0;
    rig.run_for(4s);
    EXPECT_NEAR(rig.speed_rpm(), 3000 * step / 7, 30) << step;
  }
}

TEST(MdTerminals, TheirReferenceMayBeTorqueOrPosition) {
  Rig rig;
  rig.change(&Settings::tq_ctrl, 1);
  rig.load(&Load::brake_torque_nm, 5);
  rig.pins().cw = false;
  rig.pins().speed_v = 2.5;
  rig.run_for(1s);
  EXPECT_EQ(rig.motor().type(), ControlType::kTorque);
  EXPECT_NEAR(rig.motor().current_a(), 10, 0.5);

  Rig place;
  place.controller->set_terminal_control(TerminalControl::kPosition);
  place.change(&Settings::posi_max, 600);
  place.pins().speed_v = 5;
  place.run_for(6s);
  EXPECT_NEAR(place.motor().position(), 600, 2);
}

// --- Special functions (p. 29) -------------------------------------------------------------------

class Functions : public testing::Test {
 protected:
  void begin(int type) {
    rig_.pins().start = false;
    rig_.change(&Settings::func_type, type);
    rig_.change(&Settings::func_speed, 600);
    rig_.change(&Settings::func_delay, 20);  // 2 s
    rig_.run_for(20ms);
  }
  void start(bool on, SimDuration for_time) {
    rig_.pins().start = on;
    rig_.run_for(for_time);
  }
  bool runs() { return rig_.speed_rpm() > 500; }
  bool stands() { return std::fabs(rig_.speed_rpm()) < 1; }
  Rig rig_;
};

TEST_F(Functions, SpeedRunsForItsDelayHoweverLongTheSignalIs) {
  begin(1);
  start(true, 1s);
  EXPECT_TRUE(runs());
  start(false, 900ms);
  EXPECT_TRUE(runs());
  rig_.run_for(1s);
  EXPECT_TRUE(stands());
  start(true, 4s);
  EXPECT_TRUE(stands());
}

TEST_F(Functions, MomentaryRunsWhileTheSignalIsOn) {
  begin(3);
  start(true, 4s);
  EXPECT_TRUE(runs());
  start(false, 1s);
  EXPECT_TRUE(stands());
}

TEST_F(Functions, AddRunsForItsDelayBehindTheSignal) {
  begin(4);
  start(true, 4s);
  EXPECT_TRUE(runs());
  start(false, 1900ms);
  EXPECT_TRUE(runs());
  rig_.run_for(1s);
  EXPECT_TRUE(stands());
}

TEST_F(Functions, PositionMovesByItsIncrementAtEachEdge) {
  begin(2);
  start(true, 4s);
  EXPECT_NEAR(rig_.motor().position(), 240, 2);
  start(false, 1s);
  start(true, 4s);
  EXPECT_NEAR(rig_.motor().position(), 480, 3);
}

TEST_F(Functions, AFrameMayGiveTheSignalAndMoveNothingElse) {
  begin(3);
  EXPECT_EQ(rig_.controller->by_frame(0), nullptr);
  rig_.controller->function_signal(true);
  rig_.run_for(1s);
  EXPECT_TRUE(runs());
  rig_.controller->function_signal(false);
  rig_.run_for(1s);
  EXPECT_TRUE(stands());
}

// --- Outputs -------------------------------------------------------------------------------------

TEST(MdOutputs, TheMechanicalBrakeHoldsTheShaft) {
  Rig rig;
  rig.controller->set_clutch(true);
  rig.load(&Load::external_torque_nm, 1);
  rig.run_for(500ms);
  EXPECT_EQ(rig.speed_rpm(), 0);
  rig.controller->set_clutch(false);
  rig.run_for(500ms);
  EXPECT_LT(rig.speed_rpm(), -500);
  Rig without("md50");
  without.controller->set_clutch(true);
  EXPECT_FALSE(without.controller->clutch());
}

TEST(MdOutputs, TheAlarmOutputMayBeInverted) {
  Rig rig;
  rig.run_for(10ms);
  EXPECT_FALSE(rig.controller->alarm_output());
  rig.change(&Settings::inv_alarm, 1);
  EXPECT_TRUE(rig.controller->alarm_output());
  rig.controller->stage(0).set_sensors({.hall = broken_hall_cable(7)});
  rig.run_for(50ms);
  EXPECT_FALSE(rig.controller->alarm_output());
}

TEST(MdOutputs, TheSameSeedGivesTheSameBits) {
  const auto run = [](std::uint64_t seed) {
    Rig rig("md200t", seed);
    rig.order(0).speed(150);
    rig.order(1).speed(-90);
    rig.run_for(1s);
    return std::pair(rig.axis(0).state().angle_rad, rig.axis(1).state().angle_rad);
  };
  EXPECT_EQ(run(3), run(3));
}

}  // namespace
}  // namespace virtdrive::md
