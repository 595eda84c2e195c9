#include "plant/mains.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "core/check.h"
#include "plant/axis.h"
#include "plant/motor_library.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;
using std::numbers::sqrt2;

constexpr double kLoadOhm = 160;  // draws about 650 W
constexpr double kCapacitanceF = 560e-6;

DcLinkParameters link_on_mains(int phases, double board_ohm = kLoadOhm) {
  return {.source_v = 230 * sqrt2,
          .mains = {.phases = phases,
                    .voltage_v = 230,
                    .frequency_hz = 60,
                    .resistance_ohm = 0.4,
                    .inductance_h = 2.8e-3,
                    .charging_ohm = 40},
          .capacitance_f = kCapacitanceF,
          .board_ohm = board_ohm};
}

struct Ripple {
  double highest = 0, lowest = 1e9, mean = 0;
};

/// A motor that coasts keeps a link awake; here a spinning one without a field does.
class MainsBench {
 public:
  explicit MainsBench(const DcLinkParameters& link, Integrator integrator = Integrator::kFast)
      : bus_(link, integrator),
        axis_({.motor = find_motor("asd-0-75kw").electrical,
               .mechanics = {.inertia_kgm2 = 1},
               .effects = find_motor("asd-0-75kw").effects},
              bus_) {
    // Zero voltage vector: the bridge is on and takes nothing.
    axis_.set_bridge({.mode = Bridge::kDriven, .duty = {0.5, 0.5, 0.5}, .pwm_period = 100us});
  }
  DcBus& bus() { return bus_; }
  void run(SimDuration duration) { bus_.advance_to(bus_.now() + duration); }
  Ripple ripple(SimDuration duration) {
    Ripple r;
    const int steps = static_cast<int>(duration / 20us);
    for (int i = 0; i < steps; ++i) {
      run(20us);
      const double v = bus_.voltage_v();
      r.highest = std::max(r.highest, v);
      r.lowest = std::min(r.lowest, v);
      r.mean += v / steps;
    }
    return r;
  }

 private:
  DcBus bus_;
  Axis axis_;
};

/// The same circuit by explicit steps of 0.2 us, with diodes as they are in a schoolbook.
Ripple reference(int phases, double line_v, const DcLinkParameters& link, double settle_s) {
  constexpr double kStep = 2e-7;
  double v = link.source_v, i = 0;
  Ripple r;
  const double w = 2 * pi * link.mains.frequency_hz;
  const double turn_s = 1 / link.mains.frequency_hz;
  int samples = 0;
  for (double t = 0; t < settle_s + turn_s; t += kStep) {
    double e;
    if (phases == 1) {
      e = std::fabs(line_v * sqrt2 * std::cos(w * t));
    } else {
      double top = -1e9, bottom = 1e9;
      for (int k = 0; k < 3; ++k) {
        const double u = line_v * sqrt2 / std::sqrt(3.0) * std::cos(w * t - 2 * pi / 3 * k);
        top = std::max(top, u);
        bottom = std::min(bottom, u);
      }
      e = top - bottom;
    }
    i += kStep * (e - v - link.mains.resistance_ohm * i) / link.mains.inductance_h;
    i = std::max(0.0, i);
    v += kStep * (i - v / link.board_ohm) / link.capacitance_f;
    if (t < settle_s) continue;
    r.highest = std::max(r.highest, v);
    r.lowest = std::min(r.lowest, v);
    r.mean += v;
    ++samples;
  }
  r.mean /= samples;
  return r;
}

TEST(Mains, RippleIsThatOfTheCircuitInSmallSteps) {
  for (const int phases : {1, 3}) {
    SCOPED_TRACE(phases);
    const DcLinkParameters link = link_on_mains(phases);
    const Ripple expected = reference(phases, 230, link, 0.5);
    for (const Integrator integrator : {Integrator::kFast, Integrator::kDefault}) {
      MainsBench bench(link, integrator);
      bench.run(500ms);
      const Ripple r = bench.ripple(16'660us);
      EXPECT_NEAR(r.mean, expected.mean, 0.05);
      EXPECT_NEAR(r.highest - r.lowest, expected.highest - expected.lowest,
                  0.01 * (expected.highest - expected.lowest));
    }
    if (phases == 1) {
      EXPECT_GT(expected.highest - expected.lowest, 15);
    } else {
      EXPECT_LT(expected.highest - expected.lowest, 5);
    }
  }
}

TEST(Mains, WithoutRippleCurrentTheLinkStandsAtThePeak) {
  MainsBench bench(link_on_mains(3, 1e6));
  bench.run(100ms);
  EXPECT_NEAR(bench.bus().voltage_v(), 230 * sqrt2, 0.3);
}

TEST(Mains, ALostPhaseLeavesTheOtherTwo) {
  const DcLinkParameters link = link_on_mains(3);
  MainsBench bench(link);
  bench.bus().set_mains({.connected = {true, true, false}});
  bench.run(500ms);
  const Ripple r = bench.ripple(16'660us), expected = reference(1, 230, link, 0.5);
  EXPECT_NEAR(r.mean, expected.mean, 0.1);
  EXPECT_NEAR(r.highest - r.lowest, expected.highest - expected.lowest, 0.3);
  bench.bus().set_mains({.connected = {true, false, false}});
  bench.run(500ms);
  EXPECT_LT(bench.bus().voltage_v(), 5) << "one line alone feeds nothing";
}

TEST(Mains, ADipOfOnePhaseLeavesTheHigherLine) {
  MainsBench bench(link_on_mains(3, 1e5));
  bench.bus().set_mains({.level = {0.5, 0.5, 0.5}});
  bench.run(3s);
  // The capacitor drains through 100 kOhm, 56 s: still above the halved mains.
  EXPECT_NEAR(bench.bus().voltage_v(), 230 * sqrt2 * std::exp(-3 / 56.0), 1);
  MainsBench two(link_on_mains(3));
  two.bus().set_mains({.level = {0.4, 1, 1}});
  two.run(500ms);
  EXPECT_NEAR(two.ripple(16'660us).mean, reference(1, 230, link_on_mains(3), 0.5).mean, 8);
}

TEST(Mains, TheChargingResistorLimitsTheCurrent) {
  DcLinkParameters link = link_on_mains(3, 1e5);
  link.source_v = 0;
  MainsBench bench(link);
  bench.bus().set_mains({.contact = false});
  double most_a = 0;
  for (int i = 0; i < 3000; ++i) {
    bench.run(100us);
    most_a = std::max(most_a, bench.bus().source_current_a());
  }
  EXPECT_GT(most_a, 6);
  EXPECT_LT(most_a, 230 * sqrt2 / 40);
  EXPECT_NEAR(bench.bus().voltage_v(), 230 * sqrt2, 4);
}

TEST(Mains, ALinkAtRestCostsNothingAndKeepsThePhase) {
  DcLinkParameters link = link_on_mains(3, 0);
  link.board_w = 15;
  DcBus bus(link, Integrator::kFast);
  Axis axis({.motor = find_motor("asd-0-75kw").electrical,
             .mechanics = {.inertia_kgm2 = 1},
             .effects = find_motor("asd-0-75kw").effects},
            bus);
  bus.advance_to(kSimStart + 1s);
  EXPECT_TRUE(bus.at_rest());
  const std::uint64_t before = axis.counters().derivative_evaluations;
  bus.advance_to(kSimStart + 100s);
  EXPECT_EQ(axis.counters().derivative_evaluations, before);
  // Where it would be, were its ripple followed.
  MainsBench awake(link);
  awake.run(1s);
  const double rested_v = bus.voltage_v();
  EXPECT_NEAR(rested_v, awake.ripple(16'660us).mean, 0.15);
  bus.set_mains({.connected = {false, false, false}});
  EXPECT_FALSE(bus.at_rest());
  bus.advance_to(kSimStart + 101s);
  // C/2 (v0^2 - v^2) = P t
  EXPECT_NEAR(bus.voltage_v(), std::sqrt(rested_v * rested_v - 2 * 15 * 1.0 / kCapacitanceF), 0.1);
}

TEST(Mains, RefusesWhatCannotBe) {
  DcLinkParameters link = link_on_mains(2);
  EXPECT_THROW(DcBus(link, Integrator::kFast), SetupError);
  link = link_on_mains(3);
  link.mains.inductance_h = 0;
  EXPECT_THROW(DcBus(link, Integrator::kFast), SetupError);
}

}  // namespace
}  // namespace virtdrive
