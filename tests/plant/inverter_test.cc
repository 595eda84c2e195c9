#include "plant/inverter.h"

#include <gtest/gtest.h>

#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr Load kLocked{.brake_torque_nm = 100};

BridgeCommand driven(PhaseValues duty, SimDuration dead_time) {
  return {.mode = Bridge::kDriven, .duty = duty, .pwm_period = kPwmPeriod, .dead_time = dead_time};
}

TEST(DeadTime, TakesItsShareOfTheBusFromTheCurrentsDirection) {
  const PhaseValues e = effective_duty(driven({0.6, 0.5, 0.4}, 800ns), {1, -0.5, -0.5}, 24, 1e-3);
  EXPECT_NEAR(e[0], 0.59, 1e-12);
  EXPECT_NEAR(e[1], 0.51, 1e-12);
  EXPECT_NEAR(e[2], 0.41, 1e-12);
}

TEST(DeadTime, IsSoftenedWithinTheCurrentItMovesInOnePeriod) {
  // Band: 24 V * 0.8 us / 1 mH = 19.2 mA.
  const PhaseValues e =
      effective_duty(driven({0.5, 0.5, 0.5}, 800ns), {9.6e-3, 0, -19.2e-3}, 24, 1e-3);
  EXPECT_NEAR(e[0], 0.495, 1e-12);
  EXPECT_EQ(e[1], 0.5);
  EXPECT_NEAR(e[2], 0.51, 1e-12);
}

TEST(DeadTime, LeavesAPhaseThatDoesNotSwitchAlone) {
  const PhaseValues e = effective_duty(driven({1, 0, 0.005}, 800ns), {1, -1, 1}, 24, 1e-3);
  EXPECT_EQ(e, (PhaseValues{1, 0, 0})) << "and swallows a pulse shorter than itself";
}

TEST(DeadTime, ReducesTheOpenLoopCurrentAtStandstillAsTheClosedFormSays) {
  // A vector along phase a: 4/3 * Vbus * td / Ts is missing (a loses, b and c gain).
  for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
    Axis axis(small_bench(), integrator, kLocked);
    axis.set_bridge(driven({0.55, 0.475, 0.475}, 400ns));
    axis.advance_to(kSimStart + 50ms);
    const double lost_v = 4.0 / 3 * 24 * 400e-9 / 80e-6;
    EXPECT_NEAR(axis.phase_currents_a()[0], (24 * 0.05 - lost_v) / 0.75, 1e-6);
    Axis ideal(small_bench(), integrator, kLocked);
    ideal.set_bridge(driven({0.55, 0.475, 0.475}, 0ns));
    ideal.advance_to(kSimStart + 50ms);
    EXPECT_NEAR(ideal.phase_currents_a()[0], 24 * 0.05 / 0.75, 1e-6);
  }
}

TEST(DeadTime, DoesNotChatterAroundZeroCurrent) {
  Axis axis(small_bench(), Integrator::kDefault, kLocked);
  axis.set_bridge(driven({0.55, 0.475, 0.475}, 1400ns));
  axis.advance_to(kSimStart + 10ms);
  ASSERT_GT(current_a(axis), 0.5);
  double before = current_a(axis);
  for (int k = 0; k < 100; ++k) {
    axis.set_bridge(driven({0.5, 0.5, 0.5}, 1400ns));
    axis.advance_to(axis.now() + kPwmPeriod);
    // At a constant rate first, then by more than a factor ten a period.
    ASSERT_LT(current_a(axis), std::max(1e-12, before < 0.02 ? before / 10 : before)) << k;
    before = current_a(axis);
  }
  EXPECT_LT(current_a(axis), 1e-12);
}

TEST(DeadTime, FollowsTheCurrentPeriodByPeriodUnderAHeldCommand) {
  Axis held(small_bench(), Integrator::kDefault);
  Axis repeated(small_bench(), Integrator::kDefault);
  const BridgeCommand command = driven({0.53, 0.5, 0.47}, 400ns);
  held.set_bridge(command);
  held.advance_to(kSimStart + 250 * kPwmPeriod);
  for (int k = 1; k <= 250; ++k) {
    repeated.set_bridge(command);
    repeated.advance_to(kSimStart + k * kPwmPeriod);
  }
  EXPECT_EQ(held.state().i_q_a, repeated.state().i_q_a);
  EXPECT_EQ(held.counters().time_events, 249U);
}

class Coast : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(BothIntegrators, Coast,
                         testing::Values(Integrator::kDefault, Integrator::kFast),
                         [](const auto& instance) {
                           return instance.param == Integrator::kFast ? "Fast" : "Default";
                         });

TEST_P(Coast, CurrentsReachZeroThreeThenTwoThenNoneAndStayThere) {
  Axis axis(small_bench(0.1), GetParam());
  drive(axis, {-0.4, 2}, 250);
  ASSERT_GT(current_a(axis), 0.1);
  axis.set_bridge({.mode = Bridge::kOff});
  bool two = false;
  for (int k = 0; k < 2000; ++k) {
    axis.advance_to(axis.now() + 1us);
    const PhaseValues i = axis.phase_currents_a();
    two = two || (std::ranges::count_if(i, [](double x) { return std::abs(x) < 1e-9; }) == 1);
  }
  EXPECT_TRUE(two);
  EXPECT_EQ(current_a(axis), 0);
  EXPECT_GT(axis.state().speed_radps, 10);
  axis.advance_to(axis.now() + 10ms);
  EXPECT_EQ(current_a(axis), 0);
  EXPECT_EQ(axis.counters().stalled, 0U);
}

TEST_P(Coast, AtStandstillTheCurrentDecaysAsTheClosedFormSays) {
  // i_a > 0 through the lower diode, b and c through the upper ones: -2/3 Vbus along a.
  Axis axis(small_bench(), GetParam(), kLocked);
  axis.set_bridge(driven({0.55, 0.475, 0.475}, 0ns));
  axis.advance_to(kSimStart + 50ms);
  axis.set_bridge({.mode = Bridge::kOff});
  const double start = 24 * 0.05 / 0.75, target = -24 * 2.0 / 3 / 0.75, tau = 1.05e-3 / 0.75;
  axis.advance_to(axis.now() + 50us);
  EXPECT_NEAR(axis.phase_currents_a()[0], target + (start - target) * std::exp(-50e-6 / tau), 2e-6);
  // b and c reach zero together with a.
  const double end_s = tau * std::log1p(-start / target);
  axis.advance_to(kSimStart + 50ms + from_seconds(end_s - 1e-6));
  EXPECT_GT(axis.phase_currents_a()[0], 0);
  axis.advance_to(kSimStart + 50ms + from_seconds(end_s + 1e-6));
  EXPECT_EQ(axis.phase_currents_a()[0], 0);
}

TEST_P(Coast, TheFloatingPhaseStaysAtZeroInASalientMachineThatTurns) {
  const Motor& motor = find_motor("gem-pmsm");
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 300, .resistance_ohm = 0},
             .mechanics = motor.mechanics},
            GetParam(), {.inertia_kgm2 = 0.1});
  for (int k = 0; k < 400; ++k) {
    axis.set_bridge(
        {.mode = Bridge::kDriven, .duty = duty_for(axis, {-5, 12}, 100us), .pwm_period = 100us});
    axis.advance_to(axis.now() + 100us);
  }
  ASSERT_GT(axis.state().speed_radps, 10);
  axis.set_bridge({.mode = Bridge::kOff});
  int floating = -1;
  double worst = 0, torque = 0;
  for (int k = 0; k < 20000 && current_a(axis) > 0; ++k) {
    axis.advance_to(axis.now() + 1us);
    const PhaseValues i = axis.phase_currents_a();
    for (int x = 0; x < 3 && floating < 0; ++x) {
      if (std::abs(i[static_cast<std::size_t>(x)]) < 1e-9) floating = x;
    }
    if (floating < 0) continue;
    worst = std::max(worst, std::abs(i[static_cast<std::size_t>(floating)]));
    torque = std::max(torque, std::abs(axis.torque_nm()));
  }
  ASSERT_GE(floating, 0);
  EXPECT_GT(torque, 1) << "the two others do carry current";
  EXPECT_LT(worst, 1e-9);
  EXPECT_EQ(current_a(axis), 0);
}

TEST_P(Coast, RepeatingTheOffCommandDoesNotDisturbTheDiodes) {
  Axis once(small_bench(), GetParam()), repeated(small_bench(), GetParam());
  for (Axis* axis : {&once, &repeated}) {
    drive(*axis, {-0.4, 2}, 100);
    axis->set_bridge({.mode = Bridge::kOff});
  }
  for (int k = 0; k < 20; ++k) {
    repeated.set_bridge({.mode = Bridge::kOff});
    once.advance_to(once.now() + 10us);
    repeated.advance_to(repeated.now() + 10us);
    ASSERT_EQ(once.state().i_q_a, repeated.state().i_q_a);
  }
}

// V6: the traction machine at 100 rad/s, terminals shorted, 10.1109/TPEL.2020.3006779.
TEST_P(Coast, ShortedAtSpeedItSettlesAtItsShortCircuitCurrent) {
  const Motor& motor = find_motor("gem-pmsm");
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 300, .resistance_ohm = 0},
             .mechanics = motor.mechanics},
            GetParam());
  spin_up(axis, 100, {.inertia_kgm2 = 1e9});
  axis.set_bridge({.mode = Bridge::kShort});
  axis.advance_to(axis.now() + 1s);
  EXPECT_NEAR(axis.state().speed_radps, 100, 1e-6);
  EXPECT_NEAR(axis.state().i_d_a, -176.9437, 1e-4);
  EXPECT_NEAR(axis.state().i_q_a, -8.8472, 1e-4);
  EXPECT_NEAR(axis.torque_nm(), -8.4746, 1e-4);
}

TEST_P(Coast, APulsedShortBrakesLessThanAFullOneAndChargesTheLink) {
  Axis full(small_bench(0.1), GetParam()), pulsed(small_bench(0.1), GetParam());
  for (Axis* axis : {&full, &pulsed}) spin_up(*axis, 200, {.inertia_kgm2 = 2e-5});
  full.set_bridge({.mode = Bridge::kShort});
  pulsed.set_bridge({.mode = Bridge::kShort, .short_share = 0.8, .pwm_period = kPwmPeriod});
  for (Axis* axis : {&full, &pulsed}) axis->advance_to(axis->now() + 10ms);
  EXPECT_LT(full.state().speed_radps, pulsed.state().speed_radps - 1);
  EXPECT_LT(pulsed.state().speed_radps, 195);
  EXPECT_NEAR(full.state().bus_v, 24, 1e-6);
  EXPECT_GT(pulsed.state().bus_v, 24.01);
  EXPECT_EQ(pulsed.source_current_a(), 0);
  EXPECT_EQ(pulsed.counters().stalled, 0U);
}

TEST_P(Coast, APulsedShortKeepsItsEdgesHoweverItIsAdvanced) {
  const auto run = [&](SimDuration step) {
    Axis axis(small_bench(0.1), GetParam());
    spin_up(axis, 200, {.inertia_kgm2 = 2e-5});
    axis.set_bridge({.mode = Bridge::kShort, .short_share = 0.8, .pwm_period = kPwmPeriod});
    const SimTime end = axis.now() + 4ms;
    while (axis.now() < end) axis.advance_to(std::min(end, axis.now() + step));
    return axis.state();
  };
  const AxisState fine = run(3us), coarse = run(4ms);
  EXPECT_NEAR(fine.i_q_a, coarse.i_q_a, 1e-5);
  EXPECT_NEAR(fine.speed_radps, coarse.speed_radps, 1e-5);
  EXPECT_NEAR(fine.bus_v, coarse.bus_v, 1e-6);
}

}  // namespace
}  // namespace virtdrive
