#include "plant/machine.h"

#include <gtest/gtest.h>
#include <numbers>

#include "core/check.h"
#include "plant/axis.h"
#include "tests/plant/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;

/// V5: the 6.7-kW synchronous reluctance machine of M. Hinkkanen et al.,
/// doi 10.1109/TIA.2016.2644624: i_d = (17.4 + 373 |pd|^5 + 560 |pd| pq^2) pd,
/// i_q = (52.1 + 658 |pq| + 373.33 |pd|^3) pq.
MachineEffects syrm_effects() {
  MachineEffects effects;
  effects.saturation = std::make_shared<AnalyticSaturation>(AnalyticSaturation{
      .d0 = 17.4, .dd = 373, .q0 = 52.1, .qq = 658, .dq = 1120, .s = 5, .t = 1, .u = 1, .v = 0});
  return effects;
}

PmsmParameters syrm() {
  return {.pole_pairs = 2,
          .resistance_ohm = 0.54,
          .inductance_d_h = 1 / 17.4,
          .inductance_q_h = 1 / 52.1,
          .flux_wb = 0,
          .rated_current_a = 15.5};
}

TEST(Saturation, HasThePublishedSamples) {
  struct Sample {
    Dq flux, current;
    double torque;
  };
  constexpr Sample kSamples[] = {{{0.4, 0.05}, {8.71181, 5.44467}, 5.22683},
                                 {{0.5, 0.1}, {15.92812, 16.45667}, 19.90656},
                                 {{0.3, -0.1}, {5.99592, -12.79800}, -9.71942}};
  const Winding winding(syrm(), syrm_effects());
  for (const Sample& s : kSamples) {
    const Winding::Point p = winding.at(s.flux);
    EXPECT_NEAR(p.current_a.d, s.current.d, 1e-5);
    EXPECT_NEAR(p.current_a.q, s.current.q, 1e-5);
    EXPECT_NEAR(1.5 * 2 * (p.flux_wb.d * p.current_a.q - p.flux_wb.q * p.current_a.d), s.torque,
                1e-5);
  }
}

TEST(Saturation, ItsIncrementalInductancesAreTheDerivativesOfItsCurrents) {
  const Winding winding(syrm(), syrm_effects());
  constexpr double kStep = 1e-6;
  for (const Dq flux : {Dq{0.4, 0.05}, Dq{-0.3, 0.1}, Dq{0.5, -0.2}}) {
    const Winding::Point p = winding.at(flux);
    const auto slope = [&](Dq by) {
      const Dq a = winding.at({flux.d + by.d, flux.q + by.q}).current_a;
      const Dq b = winding.at({flux.d - by.d, flux.q - by.q}).current_a;
      return Dq{(a.d - b.d) / (2 * kStep), (a.q - b.q) / (2 * kStep)};
    };
    EXPECT_NEAR(slope({kStep, 0}).d, p.dd, 1e-5 * p.dd);
    EXPECT_NEAR(slope({kStep, 0}).q, p.qd, 1e-5 * p.dd);
    EXPECT_NEAR(slope({0, kStep}).d, p.dq, 1e-5 * p.dd);
    EXPECT_NEAR(slope({0, kStep}).q, p.qq, 1e-5 * p.qq);
    EXPECT_EQ(p.dq, p.qd) << "the field's energy is a function of the state";
  }
}

TEST(Saturation, AStateIsFoundForACurrent) {
  MachineEffects effects = syrm_effects();
  PmsmParameters motor = syrm();
  motor.flux_wb = 0.2;  // with magnets on the d axis
  const Winding winding(motor, effects);
  EXPECT_NEAR(winding.at({0.2, 0}).current_a.d, 0, 1e-12);
  const Dq state = winding.state_with_current({0.2, 0}, {-3, 8});
  EXPECT_NEAR(winding.at(state).current_a.d, -3, 1e-9);
  EXPECT_NEAR(winding.at(state).current_a.q, 8, 1e-9);
}

/// The same machine as a table: fluxes over a grid of currents.
std::shared_ptr<FluxMap> syrm_map(int points) {
  const Winding winding(syrm(), syrm_effects());
  std::vector<double> d, q, flux_d, flux_q;
  for (int i = 0; i < points; ++i) {
    const double x = 2.0 * i / (points - 1) - 1;
    d.push_back(25 * x);
    q.push_back(25 * x);
  }
  Dq near{};
  for (const double id : d) {
    for (const double iq : q) {
      near = winding.state_with_current({id / 40, iq / 80}, {id, iq});
      flux_d.push_back(near.d);
      flux_q.push_back(near.q);
    }
  }
  return std::make_shared<FluxMap>(d, q, flux_d, flux_q);
}

TEST(FluxMap, RunsAMachineLikeTheClosedFormItWasTabulatedFrom) {
  const auto run = [](const MachineEffects& effects) {
    Axis axis({.motor = syrm(),
               .link = {.source_v = 540, .resistance_ohm = 0},
               .mechanics = {.inertia_kgm2 = 0.015},
               .effects = effects},
              Integrator::kDefault);
    std::vector<AxisState> states;
    for (int k = 0; k < 200; ++k) {
      const Dq voltage{k < 40 ? 60.0 : 6.0, k < 100 ? 20.0 : -10.0};
      axis.set_bridge(
          {.mode = Bridge::kDriven, .duty = duty_for(axis, voltage, 100us), .pwm_period = 100us});
      axis.advance_to(axis.now() + 100us);
      states.push_back(axis.state());
    }
    return states;
  };
  MachineEffects mapped;
  mapped.flux_map = syrm_map(101);
  const auto exact = run(syrm_effects()), table = run(mapped);
  double most = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    most = std::max(most, std::abs(exact[k].i_d_a));
    EXPECT_NEAR(table[k].i_d_a, exact[k].i_d_a, 0.02) << k;
    EXPECT_NEAR(table[k].i_q_a, exact[k].i_q_a, 0.02) << k;
    EXPECT_NEAR(table[k].speed_radps, exact[k].speed_radps, 0.01) << k;
  }
  EXPECT_GT(most, 5) << "well into saturation";
}

TEST(FluxMap, ALinearMapIsTheLinearMachineInsideAndOutsideOfItsGrid) {
  std::vector<double> axis{-2, -1, 1, 2}, flux_d, flux_q;
  for (const double d : axis) {
    for (const double q : axis) {
      flux_d.push_back(2e-3 * d + 1e-2 + 1e-4 * q);
      flux_q.push_back(3e-3 * q + 1e-4 * d);
    }
  }
  const FluxMap map(axis, axis, flux_d, flux_q);
  for (const Dq i : {Dq{0.3, -0.7}, Dq{-2, 2}, Dq{5, -7}}) {
    const FluxMap::Point p = map.at(i);
    EXPECT_NEAR(p.flux_wb.d, 2e-3 * i.d + 1e-2 + 1e-4 * i.q, 1e-15);
    EXPECT_NEAR(p.flux_wb.q, 3e-3 * i.q + 1e-4 * i.d, 1e-15);
    EXPECT_NEAR(p.dd, 2e-3, 1e-15);
    EXPECT_NEAR(p.dq, 1e-4, 1e-15);
    EXPECT_NEAR(p.qq, 3e-3, 1e-15);
  }
}

TEST(FluxMap, OneThatIsNotMonotonicIsRefusedByItsGridPoint) {
  const std::vector<double> axis{-2, -1, 1, 2};
  std::vector<double> flux_d(16), flux_q(16);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      flux_d[4 * i + k] = axis[i];
      flux_q[4 * i + k] = axis[k];
    }
  }
  EXPECT_NO_THROW(FluxMap(axis, axis, flux_d, flux_q));
  std::vector<double> falling = flux_q;
  falling[4 * 2 + 2] = -3;
  try {
    FluxMap(axis, axis, flux_d, falling);
    ADD_FAILURE() << "no error";
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("not monotonic at i_d = 1 A, i_q = -1 A"),
              std::string::npos)
        << error.what();
  }
  EXPECT_THROW(FluxMap({0, 1, 1, 2}, axis, flux_d, flux_q), SetupError);
  EXPECT_THROW(FluxMap(axis, axis, {1, 2}, flux_q), SetupError);
}

/// A locked db42s03 that warms up within seconds.
AxisParameters warming() {
  AxisParameters p = small_bench();
  p.effects.thermal = {.winding_housing_k_per_w = 5,
                       .housing_ambient_k_per_w = 4,
                       .winding_j_per_k = 0.2,
                       .housing_j_per_k = 1};
  return p;
}

TEST(Thermal, WindingAndHousingSettleWhereHeatInIsHeatOut) {
  Axis axis(warming(), Integrator::kFast, {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.55, 0.475, 0.475}, .pwm_period = 1ms});
  axis.advance_to(kSimStart + 40s);
  const double i = axis.phase_currents_a()[0];
  const double resistance = 0.75 * (1 + 3.93e-3 * (axis.winding_degc() - 25));
  EXPECT_NEAR(i, 1.2 / resistance, 1e-4);
  const double heat_w = 1.5 * resistance * i * i;
  EXPECT_GT(axis.winding_degc(), 35);
  EXPECT_NEAR(axis.winding_degc() - axis.magnet_degc(), 5 * heat_w, 0.02);
  EXPECT_NEAR(axis.magnet_degc() - 25, 4 * heat_w, 0.02);
}

TEST(Thermal, AtRestItCoolsAsItDoesWhileItIsIntegrated) {
  Axis resting(warming(), Integrator::kDefault), awake(warming(), Integrator::kDefault);
  for (Axis* axis : {&resting, &awake}) axis->set_temperatures(120, 60);
  // Shorted, nothing moves and nothing flows, but it is not at rest.
  awake.set_bridge({.mode = Bridge::kShort});
  for (Axis* axis : {&resting, &awake}) axis->advance_to(kSimStart + 1500ms);
  EXPECT_TRUE(resting.at_rest());
  EXPECT_EQ(resting.counters().derivative_evaluations, 0U);
  EXPECT_GT(awake.counters().derivative_evaluations, 0U);
  EXPECT_LT(resting.winding_degc(), 90);
  EXPECT_NEAR(resting.winding_degc(), awake.winding_degc(), 1e-3);
  EXPECT_NEAR(resting.magnet_degc(), awake.magnet_degc(), 1e-3);
}

TEST(Thermal, HotMagnetsGiveLessTorquePerAmpere) {
  AxisParameters p = warming();
  p.effects.thermal.flux_per_k = -2e-3;
  Axis axis(p, Integrator::kDefault, {.locked = true});
  drive(axis, {0, 0.5}, 50);
  const double cold = axis.torque_nm() / axis.state().i_q_a;
  axis.set_temperatures(25, 75);
  EXPECT_NEAR(axis.torque_nm() / axis.state().i_q_a, 0.9 * cold, 1e-9);
}

TEST(Cogging, HoldsTheRotorInADetentWhereItSwings) {
  AxisParameters p = small_bench();
  constexpr int kCogs = 12;
  constexpr double kAmplitude = 5e-3;
  std::vector<double> table(kCogs * 32);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = -kAmplitude * std::sin(2 * pi * static_cast<double>(i) / 32);
  }
  p.effects.cogging_nm = PeriodicTable(table, Interpolation::kCubic);
  p.mechanics.coulomb_nm = p.mechanics.viscous_nm_per_radps = 0;
  for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
    Axis axis(p, integrator);
    axis.set_motion(2 * pi / kCogs + 0.01, 0);
    // A quarter of the small-angle period: J w^2 = amplitude * cogs. 0.12 rad of phase: 0.1 % off.
    const double quarter_s = pi / 2 / std::sqrt(kAmplitude * kCogs / 2.4e-6);
    axis.advance_to(kSimStart + from_seconds(quarter_s));
    EXPECT_NEAR(axis.state().angle_rad, 2 * pi / kCogs, 1e-4);
    EXPECT_NEAR(axis.state().speed_radps, -0.01 * std::sqrt(kAmplitude * kCogs / 2.4e-6), 0.02);
  }
}

TEST(IronLoss, EddyCurrentsSlowACoastingRotorExponentially) {
  AxisParameters p = small_bench();
  p.effects.iron_eddy_w_per_v2 = 0.05;
  p.mechanics.coulomb_nm = p.mechanics.viscous_nm_per_radps = 0;
  Axis axis(p, Integrator::kDefault);
  axis.set_motion(0, 200);
  axis.advance_to(kSimStart + 100ms);
  const double per_speed = 0.05 * 16 * 5.667e-3 * 5.667e-3;  // torque / speed
  EXPECT_NEAR(axis.state().speed_radps, 200 * std::exp(-per_speed * 0.1 / 2.4e-6), 1e-3);
}

TEST(IronLoss, HysteresisIsADragThatHoldsLikeFriction) {
  AxisParameters p = small_bench();
  p.effects.iron_hysteresis_w = 20;
  p.mechanics.coulomb_nm = p.mechanics.viscous_nm_per_radps = 0;
  const double drag_nm = 20 * 4 * 5.667e-3 * 5.667e-3;
  Axis axis(p, Integrator::kDefault, {.external_torque_nm = 0.99 * drag_nm});
  axis.advance_to(kSimStart + 100ms);
  EXPECT_EQ(axis.state().speed_radps, 0);
  axis.set_load({});
  axis.set_motion(0, 100);
  axis.advance_to(axis.now() + 10ms);
  EXPECT_NEAR(axis.state().speed_radps, 100 - drag_nm / 2.4e-6 * 0.01, 1e-6);
}

/// A 24 V brushed motor: 2 Ohm, 1 mH, 40 mNm/A.
AxisParameters brushed() {
  AxisParameters p{.motor = brushed_dc(2, 1e-3, 40e-3, 3),
                   .link = {.source_v = 24, .resistance_ohm = 0},
                   .mechanics = {.inertia_kgm2 = 1e-5, .viscous_nm_per_radps = 1e-5}};
  p.effects.commutator = true;
  return p;
}

BridgeCommand h_bridge(Leg a, Leg b) {
  return {.mode = Bridge::kDriven, .legs = {a, b, Leg::kHiZ}};
}

TEST(BrushedDc, RunsUpToTheSpeedOfItsClosedForm) {
  for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
    for (const double direction : {1.0, -1.0}) {
      Axis axis(brushed(), integrator);
      axis.set_bridge(direction > 0 ? h_bridge(Leg::kHigh, Leg::kLow)
                                    : h_bridge(Leg::kLow, Leg::kHigh));
      axis.advance_to(kSimStart + 1s);
      // V = R i + K w, K i = b w.
      const double speed = 24 / (2 * 1e-5 / 40e-3 + 40e-3);
      EXPECT_NEAR(axis.state().speed_radps, direction * speed, 1e-3);
      EXPECT_NEAR(axis.phase_currents_a()[0], direction * speed * 1e-5 / 40e-3, 1e-6);
      EXPECT_NEAR(axis.torque_nm(), direction * speed * 1e-5, 1e-7);
      EXPECT_NEAR(axis.source_current_a(), speed * 1e-5 / 40e-3, 1e-6);
    }
  }
}

TEST(BrushedDc, StallsAndFreewheelsAsItsClosedForm) {
  Axis axis(brushed(), Integrator::kDefault, {.locked = true});
  axis.set_bridge(h_bridge(Leg::kHigh, Leg::kLow));
  axis.advance_to(kSimStart + 500us);
  EXPECT_NEAR(axis.phase_currents_a()[0], 12 * (1 - std::exp(-1)), 1e-5);
  axis.advance_to(kSimStart + 20ms);
  EXPECT_NEAR(axis.phase_currents_a()[0], 12, 1e-5);
  EXPECT_NEAR(axis.torque_nm(), 0.48, 1e-6);
  EXPECT_NEAR(axis.phase_currents_a()[2], 0, 1e-12);
  // Through the diodes against the supply: to zero after tau ln 2, and no further.
  axis.set_bridge({.mode = Bridge::kOff});
  axis.advance_to(kSimStart + 20ms + 250us);
  EXPECT_NEAR(axis.phase_currents_a()[0], -12 + 24 * std::exp(-0.5), 1e-4);
  axis.advance_to(kSimStart + 21ms);
  EXPECT_EQ(axis.phase_currents_a()[0], 0);
}

TEST(BrushedDc, SpunAboveTheSupplyItRectifies) {
  AxisParameters p = brushed();
  p.link.resistance_ohm = 0.1;
  Axis axis(p, Integrator::kDefault, {.inertia_kgm2 = 1});
  axis.set_motion(0, 1000);  // 40 V
  axis.advance_to(kSimStart + 200ms);
  EXPECT_NEAR(axis.state().bus_v, 40, 0.2);
}

TEST(VoiceCoil, HoldsASpringWhereForceMeetsForce) {
  // 10 N/A, 0.1 kg, 2000 N/m; 1 rad stands for 1 m.
  AxisParameters p{.motor = brushed_dc(4, 1e-3, 10, 2),
                   .link = {.source_v = 24, .resistance_ohm = 0},
                   .mechanics = {.inertia_kgm2 = 0.1, .viscous_nm_per_radps = 10}};
  p.effects.commutator = true;
  Axis axis(p, Integrator::kDefault,
            {.spring_nm_per_rad = 2000,
             .lower_stop_rad = -0.02,
             .upper_stop_rad = 0.02,
             .stop_nm_per_rad = 1e6,
             .stop_nm_per_radps = 300});
  axis.set_bridge(
      {.mode = Bridge::kDriven, .duty = {0.25}, .legs = {Leg::kDuty, Leg::kLow, Leg::kHiZ}});
  axis.advance_to(kSimStart + 2s);
  EXPECT_NEAR(axis.state().angle_rad, 10 * 1.5 / 2000, 1e-6);
  EXPECT_NEAR(axis.phase_currents_a()[0], 1.5, 1e-5);
  axis.set_bridge(h_bridge(Leg::kHigh, Leg::kLow));  // 60 N: 40 N at the stop, 20 N into it
  axis.advance_to(axis.now() + 2s);
  EXPECT_NEAR(axis.state().angle_rad, 0.02 + (60 - 2000 * 0.02) / 1.002e6, 1e-7);
}

TEST(MachineEffectsTest, OutOfRangeAreASetupError) {
  MachineEffects e;
  e.emf.table = PeriodicTable({0, 1, 0, -1}, Interpolation::kLinear);
  EXPECT_THROW(validate(e), SetupError) << "not a multiple of 3";
  e = {};
  e.thermal.winding_housing_k_per_w = 1;
  EXPECT_THROW(validate(e), SetupError);
  e = syrm_effects();
  e.flux_map = syrm_map(11);
  EXPECT_THROW(validate(e), SetupError);
  EXPECT_THROW(EmfShape::trapezoid(4), SetupError);
}

}  // namespace
}  // namespace virtdrive
