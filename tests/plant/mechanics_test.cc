// One mass with true stiction, through the whole axis (gates off: the shaft alone).
#include "plant/mechanics.h"

#include <gtest/gtest.h>

#include "core/check.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

class Shaft : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(BothIntegrators, Shaft,
                         testing::Values(Integrator::kDefault, Integrator::kFast),
                         [](const auto& instance) {
                           return instance.param == Integrator::kFast ? "Fast" : "Default";
                         });

/// A shaft of 1e-5 kg m2 with 3 mNm of Coulomb friction.
Axis shaft(Integrator integrator, double viscous_nm_per_radps = 0) {
  AxisParameters p = small_bench();
  p.mechanics = {
      .inertia_kgm2 = 1e-5, .viscous_nm_per_radps = viscous_nm_per_radps, .coulomb_nm = 3e-3};
  return Axis(p, integrator);
}

/// When the speed becomes exactly 0, to 1 us, searched from now() on.
double stop_time_s(Axis& axis) {
  const SimTime start = axis.now();
  while (axis.state().speed_radps != 0 && axis.now() < start + 10s) {
    axis.advance_to(axis.now() + 1us);
  }
  return seconds(axis.now() - start);
}

TEST_P(Shaft, StandsExactlyStillBelowBreakaway) {
  Axis axis = shaft(GetParam());
  axis.set_load({.external_torque_nm = 2.999e-3});
  axis.advance_to(kSimStart + 10s);
  EXPECT_EQ(axis.state().speed_radps, 0);
  EXPECT_EQ(axis.state().angle_rad, 0);
}

TEST_P(Shaft, BreaksAwayAboveAndSlidesAgainstItsFriction) {
  Axis axis = shaft(GetParam());
  axis.set_load({.external_torque_nm = 4e-3});
  axis.advance_to(kSimStart + 100ms);
  // (4 - 3) mNm on 1e-5 kg m2, backwards.
  EXPECT_NEAR(axis.state().speed_radps, -10, 1e-8);
  EXPECT_NEAR(axis.state().angle_rad, -0.5, 1e-8);
}

TEST_P(Shaft, TheMotorBreaksItAwayWhenItsTorqueHasGrownToTheFriction) {
  Axis axis(small_bench(), GetParam());
  // Standstill, so the current is the step response of R and L; 3 mNm takes 88 mA of 0.4 A.
  axis.set_bridge({.mode = Bridge::kDriven, .duty = duty_for(axis, {0, 0.3}), .pwm_period = 1ms});
  const double torque_per_amp = 1.5 * 4 * 5.667e-3;
  const double breakaway_s = -1.05e-3 / 0.75 * std::log(1 - 3e-3 / torque_per_amp / 0.4);
  axis.advance_to(kSimStart + from_seconds(breakaway_s - 1e-6));
  EXPECT_EQ(axis.state().speed_radps, 0);
  axis.advance_to(kSimStart + from_seconds(breakaway_s + 20e-6));
  EXPECT_GT(axis.state().speed_radps, 0);
  EXPECT_EQ(axis.counters().stalled, 0U);
}

TEST_P(Shaft, StopsAtTheTimeAndPlaceOfTheClosedForm) {
  Axis axis = shaft(GetParam());
  spin_up(axis, 100);
  const double speed = axis.state().speed_radps, angle = axis.state().angle_rad;
  ASSERT_NEAR(speed, 100, 1e-6);
  EXPECT_NEAR(stop_time_s(axis), 1e-5 * speed / 3e-3, 2e-6);
  EXPECT_NEAR(axis.state().angle_rad - angle, 1e-5 * speed * speed / 2 / 3e-3, 1e-6);
  EXPECT_TRUE(axis.at_rest());
}

TEST_P(Shaft, StopsAtTheTimeOfTheClosedFormWithViscousFriction) {
  constexpr double kViscous = 2e-5;
  Axis axis = shaft(GetParam(), kViscous);
  spin_up(axis, 100);
  const double speed = axis.state().speed_radps;
  ASSERT_GT(speed, 50);
  EXPECT_NEAR(stop_time_s(axis), 1e-5 / kViscous * std::log1p(kViscous * speed / 3e-3), 2e-6);
}

TEST_P(Shaft, OneLongAdvanceStopsWhereManyShortOnesDo) {
  Axis stepped = shaft(GetParam(), 2e-5), at_once = shaft(GetParam(), 2e-5);
  spin_up(stepped, 100);
  spin_up(at_once, 100);
  at_once.advance_to(kSimStart + 10s);
  while (stepped.now() < kSimStart + 1s) stepped.advance_to(stepped.now() + 80us);
  EXPECT_EQ(at_once.state().speed_radps, 0);
  EXPECT_NEAR(at_once.state().angle_rad, stepped.state().angle_rad, 1e-5);
}

TEST_P(Shaft, ABrakeStopsAndHolds) {
  Axis axis = shaft(GetParam());
  spin_up(axis, 100, {.brake_torque_nm = 17e-3});
  EXPECT_NEAR(stop_time_s(axis), 1e-5 * 100 / 20e-3, 2e-6);
  axis.set_load({.brake_torque_nm = 17e-3, .external_torque_nm = -19.9e-3});
  axis.advance_to(axis.now() + 1s);
  EXPECT_EQ(axis.state().speed_radps, 0);
  axis.set_load({.brake_torque_nm = 17e-3, .external_torque_nm = -20.1e-3});
  axis.advance_to(axis.now() + 100ms);
  EXPECT_NEAR(axis.state().speed_radps, 0.1e-3 * 0.1 / 1e-5, 1e-6);
}

TEST_P(Shaft, AHoistThatWinsStopsTheShaftAndTurnsItRoundAtOnce) {
  Axis axis = shaft(GetParam());
  spin_up(axis, 10, {.external_torque_nm = 5e-3});
  // Up against 8 mNm for 12.5 ms, then down with 2 mNm.
  axis.advance_to(axis.now() + 112500us);
  EXPECT_NEAR(axis.state().speed_radps, -0.1 * 2e-3 / 1e-5, 1e-5);
}

TEST_P(Shaft, AFanRunsTheSpeedUpAlongTheHyperbolicTangent) {
  // V1, the fan drive of the Modelica Standard Library, with its constant torque as an active load.
  const Motor& motor = find_motor("smpm-msl");
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 300, .resistance_ohm = 0},
             .mechanics = motor.mechanics},
            GetParam(),
            {.inertia_kgm2 = 0.29,
             .external_torque_nm = -181.4477,
             .quadratic_nm_per_radps2 = 181.4 / (157.0796 * 157.0796)});
  axis.advance_to(kSimStart + 500ms);
  EXPECT_NEAR(axis.state().speed_radps, 119.3602, 1e-4);
  axis.advance_to(kSimStart + 2s);
  EXPECT_NEAR(axis.state().speed_radps, 156.9912, 1e-4);
}

TEST_P(Shaft, LoadTorqueIsWhatTheLoadAsks) {
  Axis axis = shaft(GetParam());
  axis.set_load({.brake_torque_nm = 6e-3, .external_torque_nm = 4.5e-3});
  // Stuck: 4.5 mNm are held, a third by the bearings, two thirds by the brake, which so pushes up.
  EXPECT_NEAR(axis.load_torque_nm(), 1.5e-3, 1e-12);
  axis.set_load({.external_torque_nm = -13e-3,
                 .quadratic_nm_per_radps2 = 1e-6,
                 .viscous_nm_per_radps = 1e-5});
  axis.advance_to(kSimStart + 20ms);
  const double w = axis.state().speed_radps;
  ASSERT_GT(w, 10);
  EXPECT_NEAR(axis.load_torque_nm(), -13e-3 + 1e-6 * w * w + 1e-5 * w, 1e-12);
}

TEST(Load, OutOfRangeIsASetupError) {
  Axis axis(small_bench(), Integrator::kFast);
  EXPECT_THROW(axis.set_load({.brake_torque_nm = -1}), SetupError);
  EXPECT_THROW(axis.set_load({.external_torque_nm = std::nan("")}), SetupError);
  EXPECT_EQ(axis.load(), Load{});
}

}  // namespace
}  // namespace virtdrive
