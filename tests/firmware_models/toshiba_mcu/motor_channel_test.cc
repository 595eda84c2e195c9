#include "firmware_models/toshiba_mcu/motor_channel.h"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>

#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

bool has(std::uint32_t errors, Fault fault) {
  return (errors & bit(fault)) != 0;
}

// --- Stages --------------------------------------------------------------------------------------

TEST(ToshibaMcuChannel, GoesThroughTheStagesInTheirTimes) {
  Rig rig;
  rig.board().set_speed_rpm(2000);
  EXPECT_EQ(rig.board().start(), Outcome::kDone);
  EXPECT_EQ(rig.channel().stage(), Stage::kBootstrap);
  EXPECT_EQ(rig.run_to(Stage::kZeroCurrentMeasure), 10ms);
  const SimDuration zero_current = rig.run_to(Stage::kInitPosition);
  EXPECT_GE(zero_current, 4 * 80us);
  EXPECT_LE(zero_current, 5 * 80us);
  EXPECT_NEAR(seconds(rig.run_to(Stage::kForce)), 0.2, 0.001);
  // 25 Hz at 300 rad/s2 electrical: 0.5236 s.
  EXPECT_NEAR(seconds(rig.run_to(Stage::kFoc)), 0.5236, 0.002);
}

TEST(ToshibaMcuChannel, BootstrapShortsTheWindingsAndZeroCurrentMeasureOpensThem) {
  Rig rig;
  rig.board().start();
  EXPECT_EQ(rig.channel().output().mode, Bridge::kShort);
  EXPECT_EQ(rig.channel().output().short_share, 1);
  rig.run_to(Stage::kZeroCurrentMeasure);
  EXPECT_EQ(rig.channel().output().mode, Bridge::kOff);
}

TEST(ToshibaMcuChannel, InitpositionRampsTheCurrentUpToIqStart) {
  Rig rig;
  rig.board().start();
  rig.run_to(Stage::kInitPosition);
  rig.run_for(100ms);
  EXPECT_NEAR(rig.channel().internals().iq_a, 0.5, 0.05);
  rig.run_for(99ms);
  EXPECT_NEAR(rig.channel().internals().iq_a, 1.0, 0.05);
  EXPECT_EQ(rig.channel().actual_rpm(), 0);
}

TEST(ToshibaMcuChannel, PositionDelayZeroGivesTheFullCurrentAtOnce) {
  Rig rig;
  rig.change(&ChannelSettings::position_delay, {0});
  rig.board().set_speed_rpm(2000);
  rig.board().start();
  rig.run_to(Stage::kInitPosition);
  EXPECT_LE(rig.run_to(Stage::kForce), 1ms);
  EXPECT_EQ(rig.channel().current_ma(), 1000U);
}

TEST(ToshibaMcuChannel, RunsUpToTheSetSpeedWithTheRotorFollowing) {
  for (const std::int32_t rpm : {2000, -2000, 4000}) {
    Rig rig;
    rig.run_up(rpm, 7s);
    EXPECT_EQ(rig.channel().stage(), Stage::kFoc) << rpm;
    EXPECT_NEAR(rig.channel().actual_rpm(), rpm, 5);
    EXPECT_NEAR(rig.speed_rpm(), rpm, 5) << "the rotor, not the drive's opinion of it";
    EXPECT_EQ(rig.channel().errors(), 0U);
  }
}

TEST(ToshibaMcuChannel, TheRampIsMaxAngAcc) {
  Rig rig;
  rig.board().set_speed_rpm(2000);
  rig.board().start();
  rig.loop.run_until(kSimStart + 10s, [&] { return rig.channel().actual_rpm() >= 1000; });
  rig.run_for(300ms);  // past the lurch at the change to FOC
  const std::int32_t from = rig.channel().actual_rpm();
  rig.run_for(1s);
  // 300 rad/s2 electrical is 716.2 rpm/s at 4 pole pairs.
  EXPECT_NEAR(rig.channel().actual_rpm() - from, 716.2, 0.02 * 716.2);
}

TEST(ToshibaMcuChannel, CurrentAndTorqueFollowTheLoad) {
  Rig rig;
  rig.run_up(2000);
  const std::uint32_t idle = rig.channel().current_ma();
  rig.set_brake(0.02);
  rig.run_for(1s);
  // 20 mNm over 34 mNm/A: 588 mA more.
  EXPECT_NEAR(double(rig.channel().current_ma()) - idle, 588, 15);
  EXPECT_NEAR(rig.channel().torque(), 3.4 * rig.channel().current_ma(), 3.4);
  EXPECT_NEAR(rig.channel().actual_rpm(), 2000, 5);
  EXPECT_EQ(rig.channel().errors(), 0U);
}

TEST(ToshibaMcuChannel, SpeedChangeAboveTheLimitKeepsTheMotorInForce) {
  Rig rig;
  rig.change(&ChannelSettings::speed_limit, {60, 0});
  rig.change(&ChannelSettings::speed_change, {61, 0});
  rig.run_up(900, 5s);
  EXPECT_EQ(rig.channel().stage(), Stage::kForce);
  EXPECT_NEAR(rig.speed_rpm(), 900, 60);
}

TEST(ToshibaMcuChannel, TargetZeroStaysInForceAtStandstillWithIqStart) {
  Rig rig;
  rig.run_up(0, 1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kForce);
  EXPECT_EQ(rig.channel().actual_rpm(), 0);
  EXPECT_NEAR(rig.channel().internals().iq_a, 1.0, 0.05);
}

TEST(ToshibaMcuChannel, GoesBackToForceFivePercentBelowSpeedChange) {
  Rig rig;
  rig.run_up(1000, 3s);
  rig.board().set_speed_rpm(200);
  rig.run_to(Stage::kForce);
  EXPECT_NEAR(std::abs(rig.channel().internals().command_hz), 0.95 * 25, 0.1);
}

TEST(ToshibaMcuChannel, ASpeedAboveTheLimitIsClipped) {
  Rig rig;
  rig.board().set_speed_rpm(100'000);
  rig.board().start();
  EXPECT_EQ(rig.channel().target_rpm(), 350 * 60 / 4);
  rig.board().set_speed_rpm(-100'000);
  EXPECT_EQ(rig.channel().target_rpm(), -350 * 60 / 4);
}

TEST(ToshibaMcuChannel, ASpeedAgainstDirectionIsZeroAndWarned) {
  Rig rig;
  rig.change(&ChannelSettings::direction, {0});
  rig.board().start();
  rig.board().set_speed_rpm(-500);
  EXPECT_EQ(rig.channel().target_rpm(), 0);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kWrongDirection));
  rig.board().set_speed_rpm(500);
  EXPECT_EQ(rig.channel().target_rpm(), 500);
  EXPECT_FALSE(has(rig.channel().errors(), Fault::kWrongDirection));
}

TEST(ToshibaMcuChannel, WithPwmFrequencyZeroAStartIsRefused) {
  Rig rig;
  rig.change(&ChannelSettings::pwm_frequency, {0});
  EXPECT_EQ(rig.board().start(), Outcome::kRefused);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
}

TEST(ToshibaMcuChannel, PwmFrequencyZeroWhileRunningStopsTheMotor) {
  Rig rig;
  rig.run_up(1000, 2s);
  rig.change(&ChannelSettings::pwm_frequency, {0});
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_EQ(rig.channel().output().mode, Bridge::kOff);
}

// --- Shutdown ------------------------------------------------------------------------------------

TEST(ToshibaMcuShutdown, StopWhileStoppedIsRefused) {
  Rig rig;
  EXPECT_EQ(rig.board().stop(), Outcome::kRefused);
}

TEST(ToshibaMcuShutdown, OutputOffLetsTheMotorCoast) {
  Rig rig;
  rig.change(&ChannelSettings::shutdown_mode, {0});
  rig.run_up(2000);
  EXPECT_EQ(rig.board().stop(), Outcome::kDone);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_EQ(rig.channel().actual_rpm(), 0) << "the drive no longer knows";
  rig.run_for(10ms);
  const double coasting = rig.speed_rpm();
  EXPECT_GT(coasting, 1600);
  EXPECT_LT(coasting, 2000);
  for (const double current : rig.axis_of().phase_currents_a()) EXPECT_EQ(current, 0);
}

TEST(ToshibaMcuShutdown, ShortBrakeStopsSoonerThanCoasting) {
  const auto speed_after = [](std::int32_t mode, std::int32_t percent) {
    Rig rig;
    rig.change(&ChannelSettings::shutdown_mode, {mode});
    rig.change(&ChannelSettings::brake_time, {30});
    rig.change(&ChannelSettings::brake_percentage, {percent});
    rig.run_up(2000);
    rig.board().stop();
    rig.run_for(15ms);
    return rig.speed_rpm();
  };
  const double coast = speed_after(0, 100);
  const double weak = speed_after(1, 30);
  const double full = speed_after(1, 100);
  EXPECT_LT(weak, coast - 30);
  EXPECT_LT(full, weak - 50);
}

TEST(ToshibaMcuShutdown, TheBrakeStageTakesBraketime) {
  Rig rig;
  rig.change(&ChannelSettings::shutdown_mode, {1});
  rig.change(&ChannelSettings::brake_time, {30});
  rig.run_up(2000);
  rig.board().stop();
  EXPECT_EQ(rig.channel().stage(), Stage::kBrake);
  EXPECT_EQ(rig.channel().actual_rpm(), 0);
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady);
  EXPECT_NEAR(seconds(rig.run_to(Stage::kStop)), 0.030, 0.001);
}

TEST(ToshibaMcuShutdown, GentleRampsDownAndForgetsTheSpeed) {
  Rig rig;
  rig.run_up(2000);
  rig.board().stop();
  EXPECT_EQ(rig.channel().stage(), Stage::kFoc);
  EXPECT_EQ(rig.channel().target_rpm(), 0);
  // 133.3 Hz at 47.75 Hz/s is 2.79 s; then the next 100 ms poll.
  const double time = seconds(rig.run_to(Stage::kStop));
  EXPECT_GT(time, 2.79);
  EXPECT_LT(time, 2.95);
  rig.board().start();
  rig.run_for(500ms);
  EXPECT_EQ(rig.channel().target_rpm(), 0);
}

TEST(ToshibaMcuShutdown, AStartDuringTheRampRestoresTheSpeed) {
  Rig rig;
  rig.run_up(2000);
  rig.board().stop();
  rig.run_for(500ms);
  EXPECT_EQ(rig.board().start(), Outcome::kDone);
  EXPECT_EQ(rig.channel().target_rpm(), 2000);
  rig.run_for(2s);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10);
}

TEST(ToshibaMcuShutdown, AfterAGentleStopTheAngleIsKnownAndInitpositionIsLeftOut) {
  Rig rig;
  rig.run_up(1000, 3s);
  rig.board().stop();
  rig.run_to(Stage::kStop);
  rig.board().set_speed_rpm(1000);
  rig.board().start();
  rig.run_to(Stage::kZeroCurrentMeasure);
  EXPECT_LE(rig.run_to(Stage::kForce), 5 * 80us);
  rig.run_for(3s);
  EXPECT_NEAR(rig.speed_rpm(), 1000, 10);
}

// --- Torque control ------------------------------------------------------------------------------

TEST(ToshibaMcuTorque, TheTorqueIsHeldWhereTheLoadTakesIt) {
  for (const std::int32_t direction : {1, -1}) {
    Rig rig;
    Load load;
    load.inertia_kgm2 = 2e-5;
    load.quadratic_nm_per_radps2 = 6e-7;
    rig.axis_of().set_load(load);
    rig.board().set_speed_rpm(direction * 4000);
    rig.board().set_torque_mnm(30);
    ASSERT_EQ(rig.board().start_torque_control(), Outcome::kDone);
    rig.run_for(6s);
    EXPECT_EQ(rig.channel().method(), Method::kTorque);
    EXPECT_NEAR(rig.axis_of().torque_nm(), direction * 0.030, 0.001);
    // 30 mNm less 3 mNm of friction at 6e-7 Nm/(rad/s)^2 and the viscous part: about 203 rad/s.
    EXPECT_NEAR(rig.speed_rpm(), direction * 1990, 60);
  }
}

TEST(ToshibaMcuTorque, TheSetSpeedIsTheHighest) {
  Rig rig;
  Load load;
  load.inertia_kgm2 = 1e-5;
  rig.axis_of().set_load(load);
  rig.board().set_speed_rpm(1500);
  rig.board().set_torque_mnm(30);
  rig.board().start_torque_control();
  double highest = 0;
  rig.loop.run_until(rig.loop.now() + 5s, [&] {
    if (rig.channel().stage() == Stage::kFoc) highest = std::max(highest, rig.speed_rpm());
    return false;
  });
  EXPECT_NEAR(rig.speed_rpm(), 1500, 30);
  EXPECT_LT(highest, 1950) << "with the overshoot of the factory gains";
}

TEST(ToshibaMcuTorque, AMethodIsChangedWhileRunningWithoutABump) {
  Rig rig;
  Load load;
  load.inertia_kgm2 = 2e-5;
  load.quadratic_nm_per_radps2 = 4e-7;
  rig.axis_of().set_load(load);
  rig.run_up(2000, 5s);
  ASSERT_NEAR(rig.speed_rpm(), 2000, 20);
  const double before = rig.channel().internals().iq_ref_a;
  rig.board().set_torque_mnm(60);
  rig.board().set_method(Method::kTorque);
  rig.run_for(1ms);
  EXPECT_NEAR(rig.channel().internals().iq_ref_a, before, 0.05);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 30) << "the set speed still limits";
  rig.board().set_method(Method::kSpeed);
  rig.run_for(1ms);
  EXPECT_NEAR(rig.channel().internals().iq_ref_a, before, 0.1);
  rig.run_for(1s);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10);
}

TEST(ToshibaMcuTorque, AGentleStopRampsTheSpeedDown) {
  Rig rig;
  Load load;
  load.inertia_kgm2 = 1e-5;
  rig.axis_of().set_load(load);
  rig.board().set_speed_rpm(1500);
  rig.board().set_torque_mnm(30);
  rig.board().start_torque_control();
  rig.run_for(4s);
  EXPECT_EQ(rig.board().stop(), Outcome::kDone);
  EXPECT_LE(rig.run_to(Stage::kStop), 3s);
  EXPECT_EQ(rig.channel().method(), Method::kIdle);
  rig.board().set_speed_rpm(1000);
  rig.board().start();
  EXPECT_EQ(rig.channel().method(), Method::kSpeed) << "torque control was for that start only";
}

// --- Anything a host may write -------------------------------------------------------------------

TEST(ToshibaMcuChannel, NoSettingsOfTheTablesRangesHarmTheBench) {
  RandomStream random = Seed{1}.stream("settings");
  const auto pick = [&](std::int32_t low, std::int32_t high) {
    const double u = random.uniform();  // small values and the ends as often as the middle
    if (u < 0.2) return low;
    if (u < 0.4) return high;
    return low + static_cast<std::int32_t>(std::pow(random.uniform(), 3) * (high - low));
  };
  for (int i = 0; i < 150; ++i) {
    Rig rig(static_cast<std::uint64_t>(i));
    ChannelSettings s = rig.channel().settings();
    s.pole_pairs.value = pick(1, 100);
    s.max_angular_acceleration = {pick(1, 10000), static_cast<std::int8_t>(pick(0, 3))};
    s.torque_factor = {pick(0, 10000), 0};
    s.resistance = {pick(0, 10000), static_cast<std::int8_t>(-3 * pick(0, 2))};
    s.inductance = {pick(0, 10000), static_cast<std::int8_t>(-3 - 3 * pick(0, 2))};
    s.speed_limit.value = pick(1, 200000);
    s.speed_change.value = pick(1, 100);
    s.position_delay.value = pick(0, 100);
    s.iq_start = {pick(1, 10000), static_cast<std::int8_t>(-3 * pick(0, 1))};
    s.iq_limit = {pick(1, 10000), static_cast<std::int8_t>(-3 * pick(0, 1))};
    s.pi_id_ki.value = pick(0, 65535);
    s.pi_id_kp.value = pick(0, 65535);
    s.pi_iq_ki.value = pick(0, 65535);
    s.pi_iq_kp.value = pick(0, 65535);
    s.position_ki.value = pick(0, 65535);
    s.position_kp.value = pick(0, 65535);
    s.speed_ki.value = pick(0, 65535);
    s.speed_kp.value = pick(0, 65535);
    s.pwm_frequency.value = pick(1, 50000);
    s.over_voltage.value = s.under_voltage.value = s.over_current.value = 0;
    s.dead_time.value = pick(0, 50) * 100;
    s.current_sensitivity = {pick(0, 10000), -3};
    s.voltage_sensitivity = {pick(0, 10000), -3};
    s.sensor_direction.value = pick(0, 1);
    rig.board().set_settings(s);
    rig.board().set_speed_rpm(pick(-3000, 3000));
    rig.board().set_torque_mnm(pick(0, 1000));
    if (i % 2 == 0)
      rig.board().start();
    else
      rig.board().start_torque_control();
    rig.run_for(1s);
    rig.axis_of().advance_to(rig.loop.now());
    EXPECT_TRUE(std::isfinite(rig.axis_of().state().angle_rad)) << i;
    EXPECT_TRUE(std::isfinite(rig.channel().internals().omega_hz)) << i;
  }
}

// --- Protections ---------------------------------------------------------------------------------

TEST(ToshibaMcuProtection, ABusBelowSwUndervoltageIsAnEmergency) {
  Rig rig;
  rig.run_up(2000);
  rig.axis_of().advance_to(rig.loop.now());
  rig.axis_of().set_source_voltage(15);
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kEmergency);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kSoftwareUnderVoltage));
  EXPECT_EQ(rig.channel().actual_rpm(), 0);
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady);
  EXPECT_EQ(rig.board().stop(), Outcome::kDone);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_EQ(rig.channel().errors(), 0U);
}

TEST(ToshibaMcuProtection, RegenerationPumpsTheBusPastSwOvervoltage) {
  Rig rig;
  Load load;
  load.inertia_kgm2 = 5e-5;
  rig.axis_of().set_load(load);
  rig.run_up(2000, 5s);
  ASSERT_NEAR(rig.speed_rpm(), 2000, 20);
  rig.board().stop();
  rig.run_to(Stage::kEmergency, 3s);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kSoftwareOverVoltage));
}

TEST(ToshibaMcuProtection, AGentleStopOfTheBareRotorLeavesTheBusAlone) {
  Rig rig;
  rig.run_up(4000, 7s);
  rig.board().stop();
  double highest = 0;
  rig.loop.run_until(rig.loop.now() + 8s, [&] {
    highest = std::max(highest, rig.axis_of().state().bus_v);
    return rig.channel().stage() == Stage::kStop;
  });
  EXPECT_LT(highest, 24.2);
  EXPECT_EQ(rig.channel().errors(), 0U);
}

TEST(ToshibaMcuProtection, ASuddenLockAtSpeedTripsOnOvercurrentOrIsFoundAsAStall) {
  Rig rig;
  rig.change(&ChannelSettings::restart_mode, {0});
  rig.run_up(2000);
  rig.set_brake(1);  // more than the motor can ever overcome
  rig.run_for(2s);
  const std::uint32_t errors = rig.channel().errors();
  EXPECT_TRUE(has(errors, Fault::kSoftwareOverCurrent) || has(errors, Fault::kStall));
  EXPECT_EQ(rig.channel().output().mode, Bridge::kOff);
}

TEST(ToshibaMcuProtection, WithSwOvercurrentOffALockedRotorIsAStallAndRestarts) {
  Rig rig;
  rig.change(&ChannelSettings::over_current, {0});
  rig.run_up(2000);
  rig.set_brake(1);
  EXPECT_LE(rig.run_to(Stage::kStop, 2s), 1s);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kStall));
  EXPECT_LE(rig.run_to(Stage::kBootstrap, 1s), 100ms);
  rig.set_brake(0);
  rig.run_for(4s);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10);
  EXPECT_FALSE(has(rig.channel().errors(), Fault::kStall)) << "cleared by the next good check";
}

TEST(ToshibaMcuProtection, HealthyStartsRaiseNoStall) {
  for (const std::int32_t rpm : {500, 1000, 2000}) {
    Rig rig;
    rig.board().set_speed_rpm(rpm);
    rig.board().start();
    const bool stalled = rig.loop.run_until(
        rig.loop.now() + 5s, [&] { return has(rig.channel().errors(), Fault::kStall); });
    EXPECT_FALSE(stalled) << rpm;
  }
}

TEST(ToshibaMcuProtection, SixHotSecondsStopTheMotorAndFiveDegreesReleaseIt) {
  Rig rig;
  rig.run_up(1000, 3s);
  rig.board().set_temperature_degc(95);
  rig.run_for(4500ms);
  EXPECT_EQ(rig.channel().stage(), Stage::kFoc);
  rig.run_for(2s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kOverTemperature));
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady);
  rig.board().set_temperature_degc(86);
  rig.run_for(2s);
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady) << "5 degC below 90, not 4";
  rig.board().set_temperature_degc(84);
  rig.run_for(2s);
  EXPECT_EQ(rig.board().start(), Outcome::kDone);
}

TEST(ToshibaMcuProtection, SpeedReductionHoldsTheLoadInsteadOfFightingIt) {
  Rig rig;
  Load load;
  load.quadratic_nm_per_radps2 =
      1.5e-6;  // 63 mNm would be due at 2000 rpm, more than the motor has
  load.inertia_kgm2 = 1e-5;
  rig.axis_of().set_load(load);
  rig.run_up(2000, 6s);
  EXPECT_EQ(rig.channel().stage(), Stage::kFoc);
  EXPECT_LT(rig.speed_rpm(), 1990);
  EXPECT_GT(rig.speed_rpm(), 1200);
  EXPECT_LT(rig.channel().current_ma(), 1860U);
}

TEST(ToshibaMcuProtection, SpeedReductionEndsWithTheLoad) {
  Rig rig;
  Load load;
  load.quadratic_nm_per_radps2 = 1.5e-6;
  load.inertia_kgm2 = 1e-5;
  rig.axis_of().set_load(load);
  rig.run_up(2000, 6s);
  EXPECT_TRUE(rig.loop.run_until(
      rig.loop.now() + 300ms, [&] { return has(rig.channel().errors(), Fault::kSpeedReduction); }));
  load.quadratic_nm_per_radps2 = 1e-6;  // all of it at once would pump the bus up
  rig.axis_of().advance_to(rig.loop.now());
  rig.axis_of().set_load(load);
  rig.run_for(4s);
  EXPECT_FALSE(has(rig.channel().errors(), Fault::kSpeedReduction));
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10) << "the target is restored";
}

TEST(ToshibaMcuProtection, TheEmergencyPinSwitchesOffAtOnce) {
  Rig rig;
  rig.run_up(2000);
  rig.set_input(&BoardInputs::emergency, true);
  EXPECT_EQ(rig.channel().stage(), Stage::kEmergency);
  EXPECT_EQ(rig.channel().output().mode, Bridge::kOff);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kEmergency));
  EXPECT_EQ(rig.channel().actual_rpm(), 0);
  rig.run_for(10ms);
  EXPECT_GT(rig.speed_rpm(), 1600) << "it coasts";
  for (const double current : rig.axis_of().phase_currents_a()) EXPECT_EQ(current, 0);
  // While the pin is pulled a start comes to nothing.
  EXPECT_EQ(rig.board().stop(), Outcome::kDone);
  EXPECT_EQ(rig.board().start(), Outcome::kDone);
  EXPECT_LE(rig.run_to(Stage::kEmergency, 1s), 80us);
  rig.set_input(&BoardInputs::emergency, false);
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kEmergency) << "left by StopMotor only";
  rig.board().stop();
  rig.run_up(1000, 3s);
  EXPECT_NEAR(rig.speed_rpm(), 1000, 10);
}

TEST(ToshibaMcuProtection, TheDriverBlocksOvervoltagePinActsWithTheSoftwareOff) {
  Rig rig;
  rig.change(&ChannelSettings::over_voltage, {0});
  rig.change(&ChannelSettings::max_angular_acceleration, {5000});
  Load load;
  load.inertia_kgm2 = 2e-5;
  rig.axis_of().set_load(load);
  rig.run_up(4000, 5s);
  ASSERT_NEAR(rig.speed_rpm(), 4000, 30);
  rig.board().stop();
  rig.run_to(Stage::kEmergency, 3s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kOverVoltage));
  EXPECT_GT(rig.axis_of().state().bus_v, 30);
}

TEST(ToshibaMcuProtection, ASagOfTheSupplyShorterThanAMillisecondIsNotSeen) {
  Rig rig;
  rig.run_up(1000, 3s);
  rig.axis_of().advance_to(rig.loop.now());
  rig.axis_of().set_source_voltage(10);
  rig.run_for(700us);
  rig.axis_of().advance_to(rig.loop.now());
  rig.axis_of().set_source_voltage(24);
  rig.run_for(1s);
  EXPECT_EQ(rig.channel().stage(), Stage::kFoc) << "1000 uF carry a light load over it";
}

TEST(ToshibaMcuProtection, AnOvervoltedSupplyIsAnEmergencyInEveryStageWithPwm) {
  Rig rig;
  rig.axis_of().set_source_voltage(28);
  rig.run_for(100ms);
  rig.board().start();
  rig.run_to(Stage::kEmergency, 1s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kSoftwareOverVoltage));
}

TEST(ToshibaMcuProtection, SwOvercurrentTripsOnWhatTheLoadDraws) {
  Rig rig;
  rig.change(&ChannelSettings::over_current, {900});
  Load load;
  load.inertia_kgm2 = 2e-5;
  rig.axis_of().set_load(load);
  rig.change(&ChannelSettings::iq_start, {700, -3});
  rig.run_up(2000, 5s);
  ASSERT_EQ(rig.channel().stage(), Stage::kFoc);
  for (double torque = 0; torque < 0.05 && rig.channel().stage() == Stage::kFoc; torque += 1e-3) {
    rig.set_brake(torque);
    rig.run_for(50ms);
  }
  EXPECT_EQ(rig.channel().stage(), Stage::kEmergency);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kSoftwareOverCurrent));
}

TEST(ToshibaMcuProtection, AConverterAtItsEndIsTheEmergencyOfTheDriverBlock) {
  Rig rig;
  rig.change(&ChannelSettings::current_gain, {5});  // 10 times: a_max 0.79 A, below IqStart
  rig.board().start();
  rig.run_to(Stage::kEmergency, 1s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kEmergency));
}

TEST(ToshibaMcuProtection, AStallWithoutRestartStaysStoppedWithItsBit) {
  Rig rig;
  rig.change(&ChannelSettings::over_current, {0});
  rig.change(&ChannelSettings::restart_mode, {0});
  rig.run_up(2000);
  rig.set_brake(1);
  rig.run_to(Stage::kStop, 2s);
  rig.run_for(2s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kStall));
  rig.set_brake(0);
  rig.run_up(1000, 3s);
  EXPECT_EQ(rig.channel().errors(), 0U) << "a start clears it";
}

TEST(ToshibaMcuProtection, ARotorLockedFromTheStartIsAStall) {
  Rig rig;
  rig.change(&ChannelSettings::restart_mode, {0});
  rig.set_brake(1);
  rig.board().set_speed_rpm(1000);
  rig.board().start();
  rig.run_to(Stage::kFoc, 2s);
  EXPECT_LE(rig.run_to(Stage::kStop, 2s), 1s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kStall));
}

TEST(ToshibaMcuProtection, ADisconnectedMotorIsFoundInForce) {
  Rig rig;
  rig.open_phases({true, true, true});
  rig.board().set_speed_rpm(1000);
  rig.board().start();
  rig.run_to(Stage::kForce, 1s);
  // From 1000/32768 of HzMax on, 1000 PWM periods of 80 us; then Emergency.
  EXPECT_NEAR(seconds(rig.run_to(Stage::kEmergency, 2s)), 12.8 / 47.7 + 0.08, 0.01);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kNoMotor));
  EXPECT_EQ(rig.speed_rpm(), 0);
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady);
  rig.board().stop();
  rig.open_phases({});
  rig.run_up(1000, 3s);
  EXPECT_NEAR(rig.speed_rpm(), 1000, 10);
}

// Runs up and loads the shaft gently.
void load_up(Rig& rig, std::int32_t rpm, int brake_mnm) {
  rig.change(&ChannelSettings::restart_mode, {0});
  Load load;
  load.inertia_kgm2 = 1e-5;
  rig.axis_of().set_load(load);
  rig.run_up(rpm, 4s);
  for (int mnm = 1; mnm <= brake_mnm; ++mnm) {
    rig.set_brake(mnm * 1e-3);
    rig.run_for(30ms);
  }
  rig.run_for(500ms);
  ASSERT_EQ(rig.channel().stage(), Stage::kFoc);
}

TEST(ToshibaMcuProtection, APhaseLostUnderLoadEndsInAStallOrAnOvercurrent) {
  for (const auto& [rpm, brake_mnm] : {std::pair{500, 10}, {500, 20}, {1000, 30}, {2000, 50}}) {
    Rig rig;
    load_up(rig, rpm, brake_mnm);
    rig.open_phases({false, true, false});
    rig.run_for(2s);
    EXPECT_EQ(rig.channel().output().mode, Bridge::kOff) << rpm << " rpm " << brake_mnm << " mNm";
    const std::uint32_t errors = rig.channel().errors();
    EXPECT_TRUE(errors == bit(Fault::kStall) || errors == bit(Fault::kSoftwareOverCurrent));
  }
}

// The disconnection check looks in Force only; inertia carries the shaft over the gaps of a torque
// that pulsates with twice the electrical frequency.
TEST(ToshibaMcuProtection, APhaseLostAtSpeedWithALightLoadIsNotNoticed) {
  Rig rig;
  load_up(rig, 2000, 10);
  rig.open_phases({false, true, false});
  rig.run_for(2s);
  EXPECT_EQ(rig.channel().stage(), Stage::kFoc);
  EXPECT_EQ(rig.channel().errors(), 0U);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 40);
  EXPECT_EQ(rig.axis_of().phase_currents_a()[1], 0);
}

TEST(ToshibaMcuProtection, AStartWithALostPhaseEndsInAnOvercurrent) {
  Rig rig;
  rig.open_phases({true, false, false});
  rig.board().set_speed_rpm(2000);
  rig.board().start();
  EXPECT_LE(rig.run_to(Stage::kEmergency), 2s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kSoftwareOverCurrent));
}

TEST(ToshibaMcuProtection, AnOverheatedWindingStopsTheMotorUntilItHasCooledBelowTheLimit) {
  // A small motor's winding: 60 s of time constant made 6 s so that the test is short.
  MachineEffects effects;
  effects.thermal = {.winding_housing_k_per_w = 20,
                     .housing_ambient_k_per_w = 5,
                     .winding_j_per_k = 0.3,
                     .housing_j_per_k = 20};
  Rig rig(1, {.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3}, effects);
  rig.change(&ChannelSettings::over_temperature, {50});
  Load load;
  load.inertia_kgm2 = 2e-5;
  load.quadratic_nm_per_radps2 = 1.1e-6;
  rig.axis_of().set_load(load);
  rig.run_up(2000, 5s);
  ASSERT_EQ(rig.channel().stage(), Stage::kFoc);
  ASSERT_TRUE(rig.loop.run_until(rig.loop.now() + 120s,
                                 [&] { return rig.channel().stage() == Stage::kStop; }));
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kOverTemperature));
  EXPECT_GT(rig.axis_of().winding_degc(), 50);
  EXPECT_EQ(rig.board().start(), Outcome::kNotReady);
  ASSERT_TRUE(
      rig.loop.run_until(rig.loop.now() + 120s, [&] { return rig.channel().errors() == 0; }));
  rig.speed_rpm();
  EXPECT_LT(rig.axis_of().winding_degc(), 45.5);
  EXPECT_GT(rig.axis_of().winding_degc(), 35);
  EXPECT_EQ(rig.board().start(), Outcome::kDone);
}

TEST(ToshibaMcuProtection, AShortedThermistorIsTakenForHeatAndABrokenOneForFrost) {
  Rig rig;
  EXPECT_NEAR(rig.board().temperature_degc(), 25, 0.3);
  rig.set_input(&BoardInputs::thermistor, NtcSensor::Fault::kOpen);
  EXPECT_EQ(rig.board().temperature_degc(), -40);
  rig.set_input(&BoardInputs::thermistor, NtcSensor::Fault::kShorted);
  EXPECT_EQ(rig.board().temperature_degc(), 150);
  rig.run_up(1000, 7s);
  EXPECT_EQ(rig.channel().stage(), Stage::kStop);
  EXPECT_TRUE(has(rig.channel().errors(), Fault::kOverTemperature));
}

TEST(ToshibaMcuProtection, TheThermistorTellsWholeDegreesOverItsRange) {
  Rig rig;
  for (int degc = -40; degc <= 150; ++degc) {
    rig.board().set_temperature_degc(degc);
    EXPECT_EQ(std::lround(rig.board().temperature_degc()), degc);
  }
}

// --- Board settings ------------------------------------------------------------------------------

TEST(ToshibaMcuBoardSettings, EachMeasurementTypeRunsTheMotor) {
  for (const std::int32_t type : {1, 2, 3}) {
    Rig rig;
    rig.change(&ChannelSettings::measurement_type, {type});
    rig.run_up(2000);
    EXPECT_NEAR(rig.speed_rpm(), 2000, 10) << type;
    EXPECT_NEAR(rig.channel().current_ma(), 120, 20);
    EXPECT_EQ(rig.channel().errors(), 0U);
  }
}

TEST(ToshibaMcuBoardSettings, AGainRefinesTheCurrentsOfTheSameMotor) {
  Rig rig;
  rig.change(&ChannelSettings::current_gain, {1});
  rig.change(&ChannelSettings::pi_id_kp, {100});  // registers count in a_max, which is halved
  rig.run_up(2000);
  EXPECT_NEAR(rig.channel().scaling().full_scale_a, 2.5 / 0.316 / 2, 1e-9);
  EXPECT_NEAR(rig.speed_rpm(), 2000, 10);
  EXPECT_NEAR(rig.channel().current_ma(), 120, 15);
}

TEST(ToshibaMcuBoardSettings, AWrongSensitivityFoolsTheDrive) {
  Rig rig;
  rig.change(&ChannelSettings::voltage_sensitivity, {182, -3});  // twice the board's
  EXPECT_NEAR(rig.board().bus_v(), 12, 0.1);
  rig.board().start();
  rig.run_to(Stage::kEmergency, 1s);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kSoftwareUnderVoltage));
}

TEST(ToshibaMcuBoardSettings, ReversedSensorsCannotControlACurrent) {
  Rig rig;
  rig.change(&ChannelSettings::sensor_direction, {1});
  rig.board().set_speed_rpm(1000);
  rig.board().start();
  EXPECT_TRUE(rig.loop.run_until(rig.loop.now() + 2s,
                                 [&] { return rig.channel().stage() == Stage::kEmergency; }));
}

// --- Side by side --------------------------------------------------------------------------------

TEST(ToshibaMcuFirmware, ThreeMotorsRunAtOnceAtTheirOwnSpeeds) {
  Rig rig;
  const std::int32_t speeds[] = {1000, -1500, 2000};
  for (std::size_t i = 0; i < 3; ++i) {
    rig.board(i).set_speed_rpm(speeds[i]);
    rig.board(i).start();
  }
  rig.run_for(4s);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(rig.channel(i).actual_rpm(), speeds[i], 5);
}

TEST(ToshibaMcuFirmware, AnIdleDriveCostsTheLoopNextToNothing) {
  Rig rig;
  rig.run_for(10s);
  EXPECT_LE(rig.loop.events(), 3 * 10 * 10U);  // the 100 ms polls of three channels
}

TEST(ToshibaMcuFirmware, TheTickCountsMillisecondsAndResetStatusReadsOnce) {
  Rig rig;
  rig.run_for(1234567us);
  EXPECT_EQ(rig.firmware.tick(), 1234U);
  EXPECT_EQ(rig.firmware.take_reset_status(), 1);
  EXPECT_EQ(rig.firmware.take_reset_status(), 0);
}

TEST(ToshibaMcuFirmware, TheSameSeedGivesTheSameBitsAndAnotherDoesNot) {
  const auto run = [](std::uint64_t seed) {
    Rig rig(seed);
    rig.run_up(2000, 1s);
    return rig.axis_of().state().angle_rad;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
