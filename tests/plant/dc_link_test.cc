#include "plant/dc_link.h"

#include <gtest/gtest.h>

#include "plant/axis.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr Integrator kBoth[] = {Integrator::kDefault, Integrator::kFast};

DcLinkParameters supply(double resistance_ohm = 0.1) {
  return {.source_v = 24, .resistance_ohm = resistance_ohm, .capacitance_f = 1e-3};
}

TEST(DcBus, SwitchedOffItDrainsThroughABleeder) {
  for (const Integrator integrator : kBoth) {
    for (const double source_ohm : {0.0, 0.1}) {
      DcLinkParameters p = supply(source_ohm);
      p.board_ohm = 100;
      DcBus bus(p, integrator);
      bus.advance_to(kSimStart + 1s);
      const double start = bus.voltage_v();
      EXPECT_NEAR(start, 24 * 100 / (100 + source_ohm), 1e-5);
      EXPECT_TRUE(bus.at_rest()) << "a steady draw is no reason to integrate";
      bus.set_supply(false);
      EXPECT_FALSE(bus.at_rest());
      EXPECT_EQ(bus.source_current_a(), 0);
      bus.advance_to(bus.now() + 100ms);
      EXPECT_NEAR(bus.voltage_v(), start * std::exp(-1), 2e-4);
      bus.advance_to(bus.now() + 10s);
      EXPECT_EQ(bus.voltage_v(), 0);
      EXPECT_TRUE(bus.at_rest());
      bus.set_supply(true);
      bus.advance_to(bus.now() + 1s);
      EXPECT_NEAR(bus.voltage_v(), start, 1e-5);
    }
  }
}

TEST(DcBus, ABoardOfConstantPowerDrainsItAlongTheClosedForm) {
  // C V^2 / 2 falls by P t.
  DcLinkParameters p = supply();
  p.board_w = 2;
  DcBus bus(p, Integrator::kDefault);
  bus.set_supply(false);
  bus.advance_to(kSimStart + 100ms);
  EXPECT_NEAR(bus.voltage_v(), std::sqrt(24 * 24 - 2 * 2 * 0.1 / 1e-3), 1e-4);
}

TEST(DcBus, OneAxisMotorsOnWhatTheOtherGivesBack) {
  for (const Integrator integrator : kBoth) {
    DcBus bus(supply(), integrator);
    Axis giving(small_bench(), bus, {.inertia_kgm2 = 1e-3});
    Axis taking(small_bench(), bus, {.locked = true});
    giving.set_motion(0, 300);
    for (int k = 0; k < 500; ++k) {
      giving.set_bridge(
          {.mode = Bridge::kDriven, .duty = duty_for(giving, {0, 5.5}), .pwm_period = kPwmPeriod});
      taking.set_bridge(
          {.mode = Bridge::kDriven, .duty = duty_for(taking, {0.3, 0}), .pwm_period = kPwmPeriod});
      bus.advance_to(bus.now() + kPwmPeriod);
    }
    EXPECT_LT(giving.link_current_a(), -0.1);
    EXPECT_GT(taking.link_current_a(), 0);
    EXPECT_EQ(bus.source_current_a(), 0);
    EXPECT_GT(bus.voltage_v(), 25);
    EXPECT_EQ(giving.state().bus_v, taking.state().bus_v);
    EXPECT_EQ(giving.now(), taking.now());
  }
}

TEST(DcBus, ABatteryTakesBack) {
  DcLinkParameters p = supply();
  p.absorbs = true;
  DcBus bus(p, Integrator::kDefault);
  Axis axis(small_bench(), bus, {.inertia_kgm2 = 1e-3});
  axis.set_motion(0, 300);
  drive(axis, {0, 5.5}, 500);
  EXPECT_LT(bus.source_current_a(), -0.1);
  EXPECT_LT(bus.voltage_v(), 24.2);
}

TEST(DcBus, AChopperHoldsTheLinkBetweenItsThresholdsAndWarmsItsResistor) {
  for (const Integrator integrator : kBoth) {
    DcLinkParameters p = supply();
    p.chopper = {.on_v = 28,
                 .off_v = 26,
                 .resistance_ohm = 5,
                 .heat_capacity_j_per_k = 0.5,
                 .ambient_k_per_w = 20};
    DcBus bus(p, integrator);
    Axis axis(small_bench(), bus, {.inertia_kgm2 = 1e-3});
    axis.set_motion(0, 300);
    double highest = 0;
    bool was_on = false;
    for (int k = 0; k < 3000; ++k) {
      drive(axis, {0, 5.5}, 1);
      highest = std::max(highest, bus.voltage_v());
      was_on = was_on || bus.chopper_on();
    }
    EXPECT_TRUE(was_on);
    EXPECT_LT(highest, 28.001);
    EXPECT_GT(highest, 27.8);
    const double warm = bus.chopper_degc();
    EXPECT_GT(warm, 26);
    // It cools with 10 s while the bus rests.
    axis.set_bridge({.mode = Bridge::kOff});
    axis.set_motion(0, 0);
    bus.advance_to(bus.now() + 10s);
    EXPECT_TRUE(bus.at_rest());
    EXPECT_NEAR(bus.chopper_degc(), 25 + (warm - 25) * std::exp(-1), 0.02 * (warm - 25));
  }
}

TEST(DcBus, ARestingAxisCostsNothingBesideOneThatRuns) {
  DcBus alone(supply(), Integrator::kDefault), shared(supply(), Integrator::kDefault);
  Axis only(small_bench(), alone), one(small_bench(), shared);
  Axis resting(small_bench(), shared), resting_too(small_bench(), shared);
  drive(only, {0, 3}, 100);
  drive(one, {0, 3}, 100);
  EXPECT_EQ(one.state().i_q_a, only.state().i_q_a) << "to the bit";
  EXPECT_EQ(one.counters().derivative_evaluations, only.counters().derivative_evaluations);
  EXPECT_EQ(resting.state().bus_v, one.state().bus_v);
  drive(resting, {0, 3}, 100);
  EXPECT_GT(resting.state().speed_radps, 1) << "it wakes";
}

TEST(DcBus, AxesWakeAndSleepInAnyOrderWithoutDisturbingEachOther) {
  DcBus bus(supply(0), Integrator::kDefault);  // ideal: nothing couples them
  Axis a(small_bench(), bus), b(small_bench(), bus), c(small_bench(), bus);
  drive(c, {0, 2}, 50);
  drive(a, {0, 3}, 100);
  c.set_bridge({.mode = Bridge::kOff});
  drive(b, {0, -2}, 20);
  EXPECT_GT(a.state().speed_radps, 1);
  EXPECT_LT(b.state().speed_radps, 0);
  EXPECT_EQ(b.now(), a.now());
  bus.advance_to(bus.now() + 5s);
  EXPECT_EQ(c.state().speed_radps, 0);
}

TEST(DcLinkParametersTest, OutOfRangeAreASetupError) {
  DcLinkParameters p = supply();
  p.chopper = {.on_v = 20, .off_v = 19, .resistance_ohm = 1};
  EXPECT_THROW(validate(p), SetupError) << "below the source";
  p.chopper = {.on_v = 30, .off_v = 31, .resistance_ohm = 1};
  EXPECT_THROW(validate(p), SetupError);
  p = supply();
  p.board_w = -1;
  EXPECT_THROW(validate(p), SetupError);
}

}  // namespace
}  // namespace virtdrive
