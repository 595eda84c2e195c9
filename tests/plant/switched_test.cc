// The switched bridge: edges as events, dead time as real gaps.
#include <gtest/gtest.h>

#include "plant/motor_library.h"
#include "plant/pwm.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

TEST(PwmEdges, APulseLiesInTheMiddleOfItsPeriod) {
  PwmEdges edges;
  edges.start_period(kSimStart, {.duty = {0.25, 0, 1}, .pwm_period = 80us});
  EXPECT_EQ(edges.gates(), (std::array{Gate::kLow, Gate::kLow, Gate::kHigh}));
  EXPECT_EQ(edges.next(), kSimStart + 30us);
  edges.run(kSimStart + 30us);
  EXPECT_EQ(edges.gates()[0], Gate::kHigh);
  EXPECT_EQ(edges.next(), kSimStart + 50us);
  edges.run(kSimStart + 50us);
  EXPECT_EQ(edges.gates()[0], Gate::kLow);
  EXPECT_EQ(edges.next(), kNever);
  EXPECT_EQ(edges.period_end(), kSimStart + 80us);
}

TEST(PwmEdges, BothSwitchesAreOffForTheDeadTimeAfterEachEdge) {
  PwmEdges edges;
  edges.start_period(kSimStart, {.duty = {0.25}, .pwm_period = 80us, .dead_time = 1us});
  edges.run(kSimStart + 30us);
  EXPECT_EQ(edges.gates()[0], Gate::kOff);
  EXPECT_EQ(edges.next(), kSimStart + 31us);
  edges.run(kSimStart + 31us);
  EXPECT_EQ(edges.gates()[0], Gate::kHigh);
  edges.run(kSimStart + 50us);
  EXPECT_EQ(edges.gates()[0], Gate::kOff);
  edges.run(kSimStart + 51us);
  EXPECT_EQ(edges.gates()[0], Gate::kLow);
}

TEST(PwmEdges, APulseShorterThanTheDeadTimeNeverTurnsItsSwitchOn) {
  PwmEdges edges;
  edges.start_period(kSimStart, {.duty = {0.01}, .pwm_period = 80us, .dead_time = 2us});
  bool high = false;
  for (SimTime t = edges.next(); t != kNever; t = edges.next()) {
    edges.run(t);
    high = high || edges.gates()[0] == Gate::kHigh;
  }
  EXPECT_FALSE(high);
  EXPECT_EQ(edges.gates()[0], Gate::kLow);
}

AxisParameters switching(AxisParameters p) {
  p.inverter.switched = true;
  return p;
}

class Switched : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(BothIntegrators, Switched,
                         testing::Values(Integrator::kDefault, Integrator::kFast),
                         [](const auto& instance) {
                           return instance.param == Integrator::kFast ? "Fast" : "Default";
                         });

// Published for the prototype: 9e-6 of the rated current (2.2 kW), 5e-4 (24 V BLDC).
TEST_P(Switched, AtTheSamplingInstantItsCurrentIsThatOfTheAveragedBridge) {
  struct Case {
    const char* motor;
    double source_v;
    SimDuration period;
    Dq voltage;
    double bound;
  };
  for (const Case& c : {Case{"ipmsm-2kw", 540, 125us, {-20, 60}, 1e-4},
                        Case{"db42s03", 24, 80us, {-0.3, 4}, 3e-3}}) {
    const Motor& motor = find_motor(c.motor);
    const AxisParameters p{.motor = motor.electrical,
                           .link = {.source_v = c.source_v, .resistance_ohm = 0},
                           .mechanics = motor.mechanics};
    Axis averaged(p, GetParam()), switched(switching(p), GetParam());
    double worst = 0;
    for (int k = 0; k < 400; ++k) {
      const PhaseValues duty = duty_for(averaged, c.voltage, c.period);
      for (Axis* axis : {&averaged, &switched}) {
        axis->set_bridge({.mode = Bridge::kDriven, .duty = duty, .pwm_period = c.period});
        axis->advance_to(axis->now() + c.period);
      }
      worst = std::max({worst, std::abs(averaged.state().i_d_a - switched.state().i_d_a),
                        std::abs(averaged.state().i_q_a - switched.state().i_q_a)});
    }
    EXPECT_GT(averaged.state().speed_radps, 5);
    EXPECT_LT(worst / motor.electrical.rated_current_a, c.bound) << c.motor;
    EXPECT_EQ(switched.counters().stalled, 0U);
  }
}

TEST_P(Switched, ItsRippleIsVoltageTimesTimeOverInductance) {
  // Phase a against b and c at standstill: L' = 1.5 L, on for 0.2 of 80 us around the middle.
  AxisParameters p = small_bench();
  p.motor.resistance_ohm = 0;
  Axis axis(switching(p), GetParam(), {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.2, 0, 0}, .pwm_period = kPwmPeriod});
  axis.advance_to(kSimStart + 32us);
  EXPECT_NEAR(axis.phase_currents_a()[0], 0, 1e-9) << "before the pulse";
  axis.advance_to(kSimStart + 40us);
  EXPECT_NEAR(axis.phase_currents_a()[0], 24 * 8e-6 / (1.5 * 1.05e-3), 1e-8) << "half of it";
  axis.advance_to(kSimStart + 80us);
  EXPECT_NEAR(axis.phase_currents_a()[0], 24 * 16e-6 / (1.5 * 1.05e-3), 1e-8);
  EXPECT_EQ(axis.counters().time_events, 2U);
}

TEST_P(Switched, DeadTimeCostsTheVoltageThatTheAveragedBridgeSays) {
  const BridgeCommand command{.mode = Bridge::kDriven,
                              .duty = {0.55, 0.475, 0.475},
                              .pwm_period = kPwmPeriod,
                              .dead_time = 400ns};
  AxisParameters p = small_bench();
  p.inverter.diode_v = 0.7;
  Axis averaged(p, GetParam(), {.locked = true}),
      switched(switching(p), GetParam(), {.locked = true});
  double mean = 0;
  for (Axis* axis : {&averaged, &switched}) {
    axis->set_bridge(command);
    axis->advance_to(kSimStart + 40ms);
  }
  for (int k = 0; k < 800; ++k) {
    switched.advance_to(switched.now() + 100ns);
    mean += switched.phase_currents_a()[0] / 800;
  }
  EXPECT_NEAR(mean, averaged.phase_currents_a()[0], 2e-3);
  EXPECT_EQ(switched.counters().stalled, 0U);
}

TEST_P(Switched, ACurrentThatReachesZeroWithinTheDeadTimeStaysThere) {
  // Little more than the EMF is applied: a small current whose ripple comes to zero in the gaps.
  Axis axis(switching(small_bench()), GetParam(), {.inertia_kgm2 = 1});
  axis.set_motion(0, 300);
  double least = 1;
  for (int k = 0; k < 250; ++k) {
    axis.set_bridge({.mode = Bridge::kDriven,
                     .duty = duty_for(axis, {0, 300 * 4 * 5.667e-3 + 0.2}),
                     .pwm_period = kPwmPeriod,
                     .dead_time = 3us});
    for (int j = 0; j < 40; ++j) {
      axis.advance_to(axis.now() + 2us);
      for (const double i : axis.phase_currents_a()) least = std::min(least, std::abs(i));
    }
  }
  EXPECT_LT(least, 1e-9);
  EXPECT_GT(axis.counters().state_events, 100U);
  EXPECT_LT(axis.counters().state_events, 6000U) << "at most one off and one on per gap";
  EXPECT_EQ(axis.counters().stalled, 0U);
}

TEST_P(Switched, ALegHeldHighOrLowHasNoEdges) {
  Axis axis(switching(small_bench()), GetParam(), {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven,
                   .duty = {0.5},
                   .legs = {Leg::kDuty, Leg::kLow, Leg::kHiZ},
                   .pwm_period = kPwmPeriod});
  axis.advance_to(kSimStart + 10 * kPwmPeriod);
  EXPECT_EQ(axis.counters().time_events, 29U) << "two edges and the period's end";
  EXPECT_GT(axis.phase_currents_a()[0], 1);
  EXPECT_NEAR(axis.phase_currents_a()[2], 0, 1e-12);
}

}  // namespace
}  // namespace virtdrive
