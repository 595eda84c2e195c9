// The bridge with a machine behind it: rectification, drops, faults.
#include <gtest/gtest.h>

#include "core/check.h"
#include "plant/axis.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::sqrt3;

constexpr Load kFlywheel{.inertia_kgm2 = 1e3};

class BridgeOf : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(BothIntegrators, BridgeOf,
                         testing::Values(Integrator::kDefault, Integrator::kFast),
                         [](const auto& instance) {
                           return instance.param == Integrator::kFast ? "Fast" : "Default";
                         });

double line_peak_v(const Axis& axis) {
  const PmsmParameters& m = axis.parameters().motor;
  return sqrt3 * m.pole_pairs * m.flux_wb * std::abs(axis.state().speed_radps);
}

TEST_P(BridgeOf, AMotorSpunAboveTheBusRectifiesIntoIt) {
  for (const double direction : {1.0, -1.0}) {
    Axis axis(small_bench(0.1), GetParam(), kFlywheel);
    axis.set_motion(0.3, direction * 1000);  // 39.3 V between lines, 24 V on the link
    axis.advance_to(kSimStart + 5ms);
    EXPECT_GT(axis.state().bus_v, 25);
    EXPECT_LT(axis.torque_nm() * direction, 0);
    axis.advance_to(kSimStart + 1s);
    EXPECT_NEAR(axis.state().bus_v, line_peak_v(axis), 0.1);
    EXPECT_LT(axis.state().bus_v, line_peak_v(axis) + 1e-3) << "charged to the peak, not beyond";
    EXPECT_LT(current_a(axis), 0.05);
    EXPECT_EQ(axis.counters().stalled, 0U);
  }
}

TEST_P(BridgeOf, ADiodesForwardVoltageIsMissingFromWhatIsRectified) {
  AxisParameters p = small_bench(0.1);
  p.inverter.diode_v = 0.8;
  Axis axis(p, GetParam(), kFlywheel);
  axis.set_motion(0, 1000);
  axis.advance_to(kSimStart + 1s);
  EXPECT_NEAR(axis.state().bus_v, line_peak_v(axis) - 1.6, 0.1);
}

TEST_P(BridgeOf, BelowTheBusAMotorWithGatesOffCarriesNoCurrent) {
  Axis axis(small_bench(0.1), GetParam(), kFlywheel);
  axis.set_motion(0, 600);  // 23.6 V between lines
  axis.advance_to(kSimStart + 100ms);
  EXPECT_EQ(current_a(axis), 0);
  EXPECT_EQ(axis.counters().state_events, 0U);
  axis.set_motion(0, 612);  // 24.03 V
  axis.advance_to(axis.now() + 20ms);
  EXPECT_GT(axis.counters().state_events, 0U);
}

TEST_P(BridgeOf, SwitchAndDiodeDropsAreThoseOfTheClosedForm) {
  AxisParameters p = small_bench();
  p.inverter = {.on_resistance_ohm = 0.1, .diode_v = 0.7};
  Axis axis(p, GetParam(), {.locked = true});
  axis.set_bridge(
      {.mode = Bridge::kDriven, .duty = {0.55, 0.475, 0.475}, .pwm_period = kPwmPeriod});
  axis.advance_to(kSimStart + 50ms);
  const double start = 24 * 0.05 / 0.85;
  EXPECT_NEAR(axis.phase_currents_a()[0], start, 1e-6);
  // a through the lower diode, b and c through the upper ones: -2/3 (Vbus + 2 * 0.7) along a.
  axis.set_bridge({.mode = Bridge::kOff});
  const double target = -(24 + 1.4) * 2 / 3 / 0.85, tau = 1.05e-3 / 0.85;
  axis.advance_to(axis.now() + 40us);
  EXPECT_NEAR(axis.phase_currents_a()[0], target + (start - target) * std::exp(-40e-6 / tau), 2e-6);
}

TEST_P(BridgeOf, DeadTimeAlsoCostsTheDiodesForwardVoltage) {
  AxisParameters p = small_bench();
  p.inverter.diode_v = 0.7;
  Axis axis(p, GetParam(), {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven,
                   .duty = {0.55, 0.475, 0.475},
                   .pwm_period = kPwmPeriod,
                   .dead_time = 400ns});
  axis.advance_to(kSimStart + 50ms);
  const double lost_v = 4.0 / 3 * (24 + 1.4) * 400e-9 / 80e-6;
  EXPECT_NEAR(axis.phase_currents_a()[0], (24 * 0.05 - lost_v) / 0.75, 1e-6);
}

TEST_P(BridgeOf, ALegAloneIsHighLowOrFloating) {
  Axis axis(small_bench(), GetParam(), {.locked = true});
  axis.set_bridge(
      {.mode = Bridge::kDriven, .duty = {0.1}, .legs = {Leg::kDuty, Leg::kLow, Leg::kHiZ}});
  axis.advance_to(kSimStart + 50ms);
  EXPECT_NEAR(axis.phase_currents_a()[0], 2.4 / 1.5, 1e-6);
  EXPECT_NEAR(axis.phase_currents_a()[2], 0, 1e-12);
  const PhaseValues v = axis.terminal_voltages_v();
  EXPECT_NEAR(v[0], 2.4, 1e-9);
  EXPECT_EQ(v[1], 0);
  EXPECT_NEAR(v[2], 1.2, 1e-6) << "in the middle of the two";
  axis.set_bridge({.mode = Bridge::kDriven, .legs = {Leg::kLow, Leg::kLow, Leg::kHigh}});
  axis.advance_to(axis.now() + 10us);
  EXPECT_GT(axis.phase_currents_a()[2], 0);
}

TEST_P(BridgeOf, ABrokenWireCarriesNothingAndComesBack) {
  for (int phase = 0; phase < 3; ++phase) {
    Axis axis(small_bench(0.1), GetParam(), {.inertia_kgm2 = 1e-4});
    drive(axis, {0, 3}, 100);
    BridgeFaults faults;
    faults.phase_open[static_cast<std::size_t>(phase)] = true;
    axis.set_bridge_faults(faults);
    double other = 0;
    for (int k = 0; k < 100; ++k) {
      drive(axis, {0, 3}, 1);
      const PhaseValues i = axis.phase_currents_a();
      ASSERT_LT(std::abs(i[static_cast<std::size_t>(phase)]), 1e-9);
      other = std::max(other, std::abs(i[static_cast<std::size_t>((phase + 1) % 3)]));
    }
    EXPECT_GT(other, 0.2);
    axis.set_bridge_faults({});
    drive(axis, {0, 3}, 5);
    EXPECT_GT(std::abs(axis.phase_currents_a()[static_cast<std::size_t>(phase)]), 1e-3);
  }
}

TEST_P(BridgeOf, ShortedPhasesLoadTheLinkAndBrakeTheMotor) {
  AxisParameters p = small_bench(0.1);
  p.inverter.on_resistance_ohm = 0.02;
  Axis axis(p, GetParam(), {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.6, 0.4, 0.5}, .pwm_period = kPwmPeriod});
  axis.advance_to(kSimStart + 20ms);
  const double healthy = axis.source_current_a();
  axis.set_bridge_faults({.shorted_phases = 1});
  axis.advance_to(axis.now() + 20ms);
  // 0.2 of the time the link is shorted through two switches.
  EXPECT_NEAR(axis.link_current_a(), 0.2 * axis.state().bus_v / 0.04, 1);
  EXPECT_GT(axis.source_current_a(), 20 * healthy);
  // Gates off: the shorted pair is a brake at any speed.
  Axis coasting(p, GetParam(), {.inertia_kgm2 = 1e-5});
  coasting.set_motion(0, 200);
  coasting.set_bridge_faults({.shorted_phases = 3});
  coasting.advance_to(kSimStart + 20ms);
  EXPECT_LT(coasting.state().speed_radps, 150);
  const PhaseValues i = coasting.phase_currents_a();
  EXPECT_LT(std::abs(i[1]), 1e-9);
  EXPECT_GT(std::abs(i[0]), 0.1);
  EXPECT_EQ(coasting.counters().stalled, 0U);
}

TEST_P(BridgeOf, ASwitchThatStaysOpenGivesOnlyHalfWaves) {
  AxisParameters p = small_bench(0.1);
  p.inverter.on_resistance_ohm = 0.02;
  Axis axis(p, GetParam(), {.inertia_kgm2 = 1e-4});
  drive(axis, {0, 3}, 50);
  axis.set_bridge_faults({.upper = {SwitchFault::kStuckOpen}});
  double most = -1, least = 1;
  for (int k = 0; k < 1000; ++k) {
    drive(axis, {0, 4}, 1);
    most = std::max(most, axis.phase_currents_a()[0]);
    least = std::min(least, axis.phase_currents_a()[0]);
  }
  EXPECT_LT(most, 0.1) << "no upper switch: the phase cannot be driven up";
  EXPECT_LT(least, -0.5);
  EXPECT_EQ(axis.counters().stalled, 0U);
}

TEST_P(BridgeOf, ASwitchThatStaysClosedShortsTheLinkEachPeriod) {
  AxisParameters p = small_bench(0.5);
  p.inverter.on_resistance_ohm = 0.02;
  Axis axis(p, GetParam(), {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.5, 0.5, 0.5}, .pwm_period = kPwmPeriod});
  axis.set_bridge_faults({.upper = {SwitchFault::kStuckClosed}});
  axis.advance_to(kSimStart + 5ms);
  EXPECT_LT(axis.state().bus_v, 6) << "0.04 Ohm for half of the time";
  EXPECT_GT(axis.source_current_a(), 30);
}

TEST(BridgeFaultsTest, OfASwitchActOnLegsThatAreHeldHighOrLowWithoutAnyPeriod) {
  Axis axis(small_bench(), Integrator::kDefault, {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .legs = {Leg::kHigh, Leg::kLow, Leg::kLow}});
  axis.advance_to(kSimStart + 10ms);
  EXPECT_GT(axis.phase_currents_a()[0], 10);
  axis.set_bridge_faults({.upper = {SwitchFault::kStuckOpen}});
  axis.advance_to(axis.now() + 10ms);
  EXPECT_LT(axis.phase_currents_a()[0], 0.1) << "it has run out through the lower diode";
}

TEST(BridgeFaultsTest, NeedSwitchesWithAResistanceWhereTheyShortTheLink) {
  Axis axis(small_bench(), Integrator::kFast);
  EXPECT_THROW(axis.set_bridge_faults({.shorted_phases = 1}), SetupError);
  axis.set_bridge_faults({.phase_open = {true}});
  EXPECT_TRUE(axis.bridge_faults().phase_open[0]);
}

}  // namespace
}  // namespace virtdrive
