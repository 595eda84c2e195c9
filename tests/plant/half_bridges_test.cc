#include "plant/half_bridges.h"

#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr std::array<Gate, 3> kAllOff{};
constexpr std::array<Gate, 3> kAllLow{Gate::kLow, Gate::kLow, Gate::kLow};
constexpr double kBusV = 24;

/// Gates on, then off with these currents.
HalfBridges freewheeling(const PhaseValues& current_a, const InverterParameters& inverter = {}) {
  HalfBridges bridges(inverter);
  bridges.set_gates(kAllLow, {}, current_a);
  bridges.set_gates(kAllOff, {}, current_a);
  return bridges;
}

TEST(HalfBridges, DiodesTakeTheCurrentsOver) {
  const HalfBridges bridges = freewheeling({2, -0.5, -1.5});
  EXPECT_EQ(bridges.diode(0), Diode::kLower);
  EXPECT_EQ(bridges.diode(1), Diode::kUpper);
  EXPECT_EQ(bridges.diode(2), Diode::kUpper);
  EXPECT_EQ(bridges.connection().conduction, Conduction::kTerminals);
}

TEST(HalfBridges, ACurrentOfAMicroampIsNone) {
  EXPECT_EQ(freewheeling({1, -1 + 5e-7, -5e-7}).connection().floating, 2);
  EXPECT_EQ(freewheeling({9e-7, -9e-7, 0}).connection().conduction, Conduction::kOpen);
}

TEST(HalfBridges, DiodesLetGoOneAfterTheOtherAndNeverASingleOneConducts) {
  HalfBridges bridges = freewheeling({2, -0.5, -1.5});
  EXPECT_GT(bridges.margin({2, 0, -2}, {}, kBusV), 0) << "0 is not yet beyond the hysteresis";
  const PhaseValues through{2, 2e-6, -2};
  EXPECT_LT(bridges.margin(through, {}, kBusV), 0);
  EXPECT_TRUE(bridges.follow(through, {}, kBusV));
  EXPECT_EQ(bridges.connection().conduction, Conduction::kSeries);
  EXPECT_EQ(bridges.connection().floating, 1);
  const PhaseValues gone{-2e-6, 0, 2e-6};
  EXPECT_TRUE(bridges.follow(gone, {0, 12, 24}, kBusV));
  EXPECT_EQ(bridges.connection().conduction, Conduction::kOpen);
}

TEST(HalfBridges, AFloatingTerminalThatPassesARailTurnsItsDiodeOn) {
  const InverterParameters inverter{.diode_v = 0.7};
  HalfBridges bridges(inverter);
  bridges.set_gates({Gate::kHigh, Gate::kLow, Gate::kOff}, {}, {});
  const PhaseValues current{1, -1, 0};
  EXPECT_GT(bridges.margin(current, {24, 0, 24.69}, kBusV), 0);
  EXPECT_LT(bridges.margin(current, {24, 0, 24.71}, kBusV), 0);
  EXPECT_GT(bridges.margin(current, {24, 0, -0.69}, kBusV), 0);
  EXPECT_LT(bridges.margin(current, {24, 0, -0.71}, kBusV), 0);
  EXPECT_FALSE(bridges.follow(current, {24, 0, 12}, kBusV));
  EXPECT_TRUE(bridges.follow(current, {24, 0, -0.71}, kBusV));
  EXPECT_EQ(bridges.diode(2), Diode::kLower);
  EXPECT_EQ(bridges.connection().conduction, Conduction::kTerminals);
}

TEST(HalfBridges, WithNothingOnTwoDiodesTurnOnTogetherWhenTheEmfExceedsTheLink) {
  HalfBridges bridges;
  EXPECT_TRUE(bridges.watched());
  EXPECT_GT(bridges.margin({}, {11, 0, -12}, kBusV), 0);
  EXPECT_LT(bridges.margin({}, {13, 0, -12}, kBusV), 0);
  EXPECT_TRUE(bridges.follow({}, {13, 0, -12}, kBusV));
  EXPECT_EQ(bridges.diode(0), Diode::kUpper);
  EXPECT_EQ(bridges.diode(1), Diode::kBlocked);
  EXPECT_EQ(bridges.diode(2), Diode::kLower);
  // At zero current both stay on: no cycle in no time.
  EXPECT_GT(bridges.margin({}, {24, 12, 0}, kBusV), 0);
}

TEST(HalfBridges, ADiodesStatePersistsUnderARepeatedCommand) {
  HalfBridges bridges = freewheeling({2, -0.5, -1.5});
  bridges.set_gates(kAllOff, {}, {5e-7, -0.5, 0.5});  // nobody's current has crossed 0
  EXPECT_EQ(bridges.diode(0), Diode::kLower);
  EXPECT_EQ(bridges.diode(2), Diode::kUpper);
}

TEST(HalfBridges, ABrokenWireLeavesTwoPhasesInSeries) {
  HalfBridges bridges;
  bridges.set_gates({Gate::kHigh, Gate::kLow, Gate::kLow}, {}, {});
  bridges.set_faults({.phase_open = {false, true, false}}, {1, -0.5, -0.5});
  EXPECT_EQ(bridges.connection().conduction, Conduction::kSeries);
  EXPECT_EQ(bridges.connection().floating, 1);
  EXPECT_FALSE(bridges.watched()) << "the wire carries nothing whatever its voltage";
  bridges.set_faults({}, {1, 0, -1});
  EXPECT_EQ(bridges.connection().conduction, Conduction::kTerminals);
}

TEST(HalfBridges, AShortBetweenPhasesPutsThemAtOnePotentialAndLoadsTheLink) {
  HalfBridges bridges({.on_resistance_ohm = 0.01});
  bridges.set_faults({.shorted_phases = 1}, {});
  bridges.set_gates({Gate::kHigh, Gate::kLow, Gate::kLow}, {}, {});
  EXPECT_EQ(bridges.connection().conduction, Conduction::kTerminals);
  EXPECT_NEAR(bridges.connection().short_conductance, 50, 1e-9);
  const PhaseValues legs = bridges.leg_currents_a({1, 2, -3}, kBusV);
  EXPECT_NEAR(legs[0], 1.5 + 1200, 1e-9);
  EXPECT_NEAR(legs[1], 1.5 - 1200, 1e-9);
  EXPECT_EQ(legs[2], -3);
}

TEST(HalfBridges, ASwitchThatDoesNotCloseLeavesItsDiode) {
  HalfBridges bridges;
  bridges.set_gates(kAllLow, {}, {});
  bridges.set_faults({.upper = {SwitchFault::kStuckOpen}}, {});
  EXPECT_TRUE(bridges.needs_edges());
  bridges.set_gates({Gate::kHigh, Gate::kLow, Gate::kLow}, {}, {1, -0.5, -0.5});
  EXPECT_EQ(bridges.diode(0), Diode::kLower) << "the current takes the way from below";
}

TEST(HalfBridges, ASwitchThatDoesNotOpenShortsTheLinkWhenTheOtherCloses) {
  HalfBridges bridges({.on_resistance_ohm = 0.01});
  bridges.set_faults({.upper = {SwitchFault::kStuckClosed}}, {});
  bridges.set_gates(kAllOff, {}, {});
  EXPECT_EQ(bridges.connection().short_conductance, 0);
  EXPECT_FALSE(bridges.gates_off());
  bridges.set_gates(kAllLow, {}, {});
  EXPECT_NEAR(bridges.connection().short_conductance, 50, 1e-9);
}

TEST(HalfBridges, AShortThroughNoResistanceIsASetupError) {
  HalfBridges bridges;
  EXPECT_THROW(bridges.set_faults({.shorted_phases = 2}, {}), SetupError);
  EXPECT_THROW(bridges.set_faults({.lower = {SwitchFault::kStuckClosed}}, {}), SetupError);
  EXPECT_EQ(bridges.faults(), BridgeFaults{});
}

}  // namespace
}  // namespace virtdrive
