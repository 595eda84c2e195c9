// Transmissions, position-dependent loads, friction that rises towards standstill.
#include <gtest/gtest.h>
#include <numbers>

#include "core/check.h"
#include "plant/axis.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;

constexpr Integrator kBoth[] = {Integrator::kDefault, Integrator::kFast};

AxisParameters mechanism(const MechanicsParameters& mechanics) {
  AxisParameters p = small_bench();
  p.mechanics = mechanics;
  return p;
}

/// V4: motulator's two-mass system, J_M = J_L = 0.005 kg m2, K = 700 Nm/rad, C = 0.01 Nm s/rad.
AxisParameters two_masses() {
  return mechanism({.inertia_kgm2 = 0.005,
                    .transmission = {.stiffness_nm_per_rad = 700, .damping_nm_per_radps = 0.01}});
}

/// From the times at which the twist crosses 0, over many half periods.
double oscillation_hz(Axis& axis) {
  double before = 0, first = 0, last = 0;
  int crossings = 0;
  while (crossings < 41) {
    axis.advance_to(axis.now() + 20us);
    const double twist = axis.state().angle_rad - axis.load_angle_rad();
    if (before * twist < 0) {
      const double t = seconds(axis.now()) - 20e-6 * twist / (twist - before);
      if (crossings++ == 0) first = t;
      last = t;
    }
    before = twist;
  }
  return 20 / (last - first);
}

TEST(TwoMasses, OscillateAtTheirResonanceAndAntiresonance) {
  for (const Integrator integrator : kBoth) {
    Axis free(two_masses(), integrator, {.inertia_kgm2 = 0.005});
    free.set_load({.inertia_kgm2 = 0.005, .external_torque_nm = 1});
    free.advance_to(kSimStart + 3ms);
    free.set_load({.inertia_kgm2 = 0.005});
    EXPECT_NEAR(oscillation_hz(free), 84.2169, 2e-3);
    // The load held: what the torque-to-speed response cannot pass.
    Axis held(two_masses(), integrator, {.inertia_kgm2 = 0.005, .locked = true});
    held.set_motion(0, 1);
    EXPECT_NEAR(oscillation_hz(held), 59.5503, 2e-3);
    EXPECT_EQ(held.load_angle_rad(), 0);
  }
}

/// V9: J = 1e-4 kg m2 on a spring of 10 Nm/rad whose end is drawn at 0.5 rad/s; Fs = 0.15,
/// Fc = 0.1 Nm, ws = 0.2 rad/s (Gaussian Stribeck), b = 1e-3.
TEST(TwoMasses, StickAndSlipAsBothPrototypesDid) {
  for (const Integrator integrator : kBoth) {
    Axis axis(mechanism({.inertia_kgm2 = 1e12, .transmission = {.stiffness_nm_per_rad = 10}}),
              integrator,
              {.inertia_kgm2 = 1e-4,
               .brake_torque_nm = 0.1,
               .viscous_nm_per_radps = 1e-3,
               .stiction_nm = 0.15,
               .stribeck_radps = 0.2},
              1e-9);
    axis.set_motion(0, 0.5);
    // set_motion gives both the speed: the load starts at rest.
    axis.set_load({.inertia_kgm2 = 1e-4, .locked = true});
    axis.set_load({.inertia_kgm2 = 1e-4,
                   .brake_torque_nm = 0.1,
                   .viscous_nm_per_radps = 1e-3,
                   .stiction_nm = 0.15,
                   .stribeck_radps = 0.2});
    axis.advance_to(kSimStart + 1991ms);
    EXPECT_EQ(axis.counters().state_events, 115U);
    axis.advance_to(kSimStart + 1991243us);
    EXPECT_EQ(axis.counters().state_events, 115U);
    axis.advance_to(kSimStart + 1991245us);
    EXPECT_EQ(axis.counters().state_events, 116U);
    axis.advance_to(kSimStart + 2s);
    EXPECT_EQ(axis.counters().state_events, 116U);
    EXPECT_NEAR(axis.load_angle_rad(), 0.991086929, integrator == Integrator::kFast ? 2e-7 : 1e-8);
  }
}

TEST(Gear, ReflectsInertiaAndTorqueByItsRatio) {
  for (const Integrator integrator : kBoth) {
    Axis axis(mechanism({.inertia_kgm2 = 1e-5, .transmission = {.ratio = 10}}), integrator,
              {.inertia_kgm2 = 2e-3, .external_torque_nm = -0.3});
    axis.advance_to(kSimStart + 100ms);
    EXPECT_NEAR(axis.state().speed_radps, 0.03 * 0.1 / 3e-5, 1e-6);
    EXPECT_NEAR(axis.load_speed_radps(), axis.state().speed_radps / 10, 1e-12);
    EXPECT_NEAR(axis.load_angle_rad(), axis.state().angle_rad / 10, 1e-12);
  }
}

TEST(Gear, WhoeverDrivesPaysItsLoss) {
  for (const Integrator integrator : kBoth) {
    // The load drives: 0.3 Nm at the output, of which the gear passes 80 % to the rotor.
    const MechanicsParameters geared{.inertia_kgm2 = 1e-5,
                                     .transmission = {.ratio = 10, .efficiency = 0.8}};
    Axis driven(mechanism(geared), integrator, {.inertia_kgm2 = 2e-3, .external_torque_nm = -0.3});
    driven.advance_to(kSimStart + 100ms);
    EXPECT_NEAR(driven.state().speed_radps, 0.8 * 0.03 * 0.1 / (1e-5 + 0.8 * 2e-5), 1e-6);
    // The rotor drives (as it runs out against a load): it needs 1 / 0.8 of it.
    Axis driving(mechanism(geared), integrator, {.inertia_kgm2 = 1e-9, .external_torque_nm = 0.3});
    driving.set_motion(0, 300);
    driving.advance_to(kSimStart + 50ms);
    EXPECT_NEAR(driving.state().speed_radps, 300 - 0.03 / 0.8 / 1e-5 * 0.05, 1e-2);
  }
}

TEST(Gear, OfLowEfficiencyHoldsItsLoadLikeFriction) {
  // Power that comes back has to pass the loss: with friction of the rotor beside it, it cannot.
  Axis axis(mechanism({.inertia_kgm2 = 1e-5,
                       .coulomb_nm = 1e-3,
                       .transmission = {.ratio = 50, .efficiency = 0.3}}),
            Integrator::kDefault, {.inertia_kgm2 = 1e-3, .external_torque_nm = 0.15});
  axis.advance_to(kSimStart + 1s);  // 3 mNm at the rotor, of which 0.9 arrive
  EXPECT_EQ(axis.state().speed_radps, 0);
  axis.set_load({.inertia_kgm2 = 1e-3, .external_torque_nm = 0.18});
  axis.advance_to(axis.now() + 100ms);
  EXPECT_LT(axis.state().speed_radps, 0);
}

TEST(Backlash, TheLoadFollowsOnceThePlayIsUsedUp) {
  for (const Integrator integrator : kBoth) {
    Axis axis(mechanism({.inertia_kgm2 = 1,
                         .transmission = {.stiffness_nm_per_rad = 1000,
                                          .damping_nm_per_radps = 0.5,
                                          .backlash_rad = 0.02}}),
              integrator, {.inertia_kgm2 = 1e-4, .brake_torque_nm = 0.01});
    axis.set_motion(0, 0);
    axis.set_load({.inertia_kgm2 = 1e-4, .brake_torque_nm = 0.01, .locked = true});
    axis.set_motion(0, 1);  // the rotor goes at 1 rad/s, the load is held
    axis.set_load({.inertia_kgm2 = 1e-4, .brake_torque_nm = 0.01});
    axis.advance_to(kSimStart + 9900us);
    EXPECT_EQ(axis.load_angle_rad(), 0) << "within the play";
    axis.advance_to(kSimStart + 200ms);
    EXPECT_NEAR(axis.state().angle_rad - axis.load_angle_rad(), 0.01, 2e-3);
    EXPECT_NEAR(axis.load_speed_radps(), 1, 0.05);
    EXPECT_EQ(axis.counters().stalled, 0U);
  }
}

TEST(Gravity, ALeverSwingsWithThePendulumsPeriod) {
  for (const Integrator integrator : kBoth) {
    Axis axis(mechanism({.inertia_kgm2 = 1e-3}), integrator, {.gravity_nm = 0.1});
    axis.set_motion(0.1, 0);
    // Complete elliptic integral: T = T0 (1 + a^2 / 16 + 11 a^4 / 3072).
    const double period_s = 2 * pi / 10 * (1 + 0.01 / 16 + 11e-4 / 3072);
    axis.advance_to(kSimStart + from_seconds(period_s));
    EXPECT_NEAR(axis.state().angle_rad, 0.1, 1e-7);
    EXPECT_NEAR(axis.state().speed_radps, 0, 1e-5);
  }
}

TEST(EndStop, ReturnsAShaftWithWhatItsDamperLeaves) {
  for (const Integrator integrator : kBoth) {
    Load load{.upper_stop_rad = 1, .stop_nm_per_rad = 100};
    Axis elastic(mechanism({.inertia_kgm2 = 1e-3}), integrator, load);
    elastic.set_motion(0, 10);
    // Half an oscillation in the stop, pi sqrt(J / K) long, sqrt(J / K) w deep.
    elastic.advance_to(kSimStart + 100ms + from_seconds(pi / 2 * std::sqrt(1e-5)));
    EXPECT_NEAR(elastic.state().angle_rad, 1 + 10 * std::sqrt(1e-5), 1e-6);
    elastic.advance_to(kSimStart + 300ms);
    EXPECT_NEAR(elastic.state().speed_radps, -10, 1e-3);
    load.stop_nm_per_radps = 0.2;
    Axis damped(mechanism({.inertia_kgm2 = 1e-3}), integrator, load);
    damped.set_motion(0, 10);
    damped.advance_to(kSimStart + 300ms);
    EXPECT_GT(damped.state().speed_radps, -8);
    EXPECT_LT(damped.state().speed_radps, -2);
    EXPECT_EQ(damped.counters().stalled, 0U);
  }
}

TEST(LockedRotor, StandsWhateverTheTorque) {
  for (const Integrator integrator : kBoth) {
    Axis axis(small_bench(), integrator, {.external_torque_nm = 10, .locked = true});
    axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.5, 0.6, 0.4}, .pwm_period = kPwmPeriod});
    axis.advance_to(kSimStart + 100ms);
    EXPECT_EQ(axis.state().speed_radps, 0);
    EXPECT_EQ(axis.state().angle_rad, 0);
    axis.set_load({});
    axis.advance_to(axis.now() + 1ms);
    EXPECT_NE(axis.state().speed_radps, 0);
  }
}

TEST(TorqueProfile, ItsStepsActAtTheirMoments) {
  for (const Integrator integrator : kBoth) {
    Axis axis(mechanism({.inertia_kgm2 = 1e-3}), integrator);
    axis.advance_to(kSimStart + 5ms);
    axis.set_torque_profile(
        {{.at = 0ms, .torque_nm = -1}, {.at = 10ms, .torque_nm = 2}, {.at = 15ms}});
    axis.advance_to(kSimStart + 15ms);
    EXPECT_NEAR(axis.state().speed_radps, 10, 1e-9);
    axis.advance_to(kSimStart + 1s);
    EXPECT_NEAR(axis.state().speed_radps, 0, 1e-9);
    EXPECT_NEAR(axis.state().angle_rad, 10 * 0.01 / 2 + 10 * 0.005 / 2, 1e-9);
  }
}

TEST(MechanicsParametersTest, WhatDoesNotFitTogetherIsASetupError) {
  EXPECT_THROW(Axis(two_masses(), Integrator::kFast), SetupError) << "no load behind the spring";
  EXPECT_THROW(validate(MechanicsParameters{.inertia_kgm2 = 1, .transmission = {.efficiency = 0}}),
               SetupError);
  EXPECT_THROW(
      validate(MechanicsParameters{.inertia_kgm2 = 1, .transmission = {.backlash_rad = 0.1}}),
      SetupError);
  EXPECT_THROW(validate(MechanicsParameters{.inertia_kgm2 = 1, .coulomb_nm = 2, .stiction_nm = 1}),
               SetupError);
  EXPECT_THROW(validate(Load{.upper_stop_rad = 1}), SetupError);
}

}  // namespace
}  // namespace virtdrive
