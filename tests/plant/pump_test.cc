#include "plant/pump.h"

#include <cmath>
#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

TEST(Pump, SettlesWhereItsHeadMeetsTheConsumers) {
  for (const double speed : {1.0, 0.8}) {
    for (const double demand : {0.5, 1.0, 1.5}) {
      Pump pump({.static_bar = 0.3});
      pump.set_demand(demand);
      pump.advance_to(kSimStart + 60s, speed * 180);
      // shut-off s^2 - static - k q^2 = p with q = demand K sqrt(p)
      const double k = 0.7 / 100, opening = 10 / 2.0 * demand;
      const double expected = (5 * speed * speed - 0.3) / (1 + k * opening * opening);
      EXPECT_NEAR(pump.pressure_bar(), expected, 1e-6);
      EXPECT_NEAR(pump.flow_m3h(), pump.demand_m3h(), 1e-5);
    }
  }
}

TEST(Pump, GivesItsRatedFlowAndPressureAtItsRatedSpeed) {
  Pump pump({});
  pump.advance_to(kSimStart + 60s, 180);
  EXPECT_NEAR(pump.pressure_bar(), 4, 1e-6);
  EXPECT_NEAR(pump.flow_m3h(), 10, 1e-5);
}

TEST(Pump, ACheckValveHoldsThePressureOfAPumpThatStands) {
  Pump pump({});
  pump.advance_to(kSimStart + 60s, 180);
  pump.set_demand(0);
  pump.advance_to(kSimStart + 61s, 0);
  EXPECT_NEAR(pump.pressure_bar(), 4, 0.01);
  EXPECT_EQ(pump.flow_m3h(), 0);
  pump.set_demand(1);
  pump.advance_to(kSimStart + 80s, 0);
  EXPECT_LT(pump.pressure_bar(), 0.01);
}

TEST(Pump, TurnedBackwardsPumpsNothing) {
  Pump pump({});
  pump.advance_to(kSimStart + 10s, -180);
  EXPECT_EQ(pump.pressure_bar(), 0);
}

TEST(Pump, RefusesWhatCannotBe) {
  EXPECT_THROW(Pump({.shutoff_bar = 3.9}), SetupError);
  EXPECT_THROW(Pump({.vessel_m3_per_bar = 0}), SetupError);
}

}  // namespace
}  // namespace virtdrive
