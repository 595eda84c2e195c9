// The induction machine against its equivalent circuit, an energy balance and the figures that the
// sets of the bench's AC drives were made for.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "core/check.h"
#include "core/random.h"
#include "plant/axis.h"
#include "plant/induction_curves.h"
#include "plant/motor_library.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;
using std::numbers::sqrt2;
using std::numbers::sqrt3;

constexpr double kLinkV = 1000;  // enough for any set
constexpr SimDuration kPeriod = 50us;

AxisParameters bench_of(const Motor& motor) {
  return {.motor = motor.electrical,
          .link = {.source_v = kLinkV, .resistance_ohm = 0},
          .mechanics = motor.mechanics,
          .effects = motor.effects};
}

/// A three-phase supply of `line_v` (rms) for a time, made of short averaged periods.
class Supply {
 public:
  Supply(Axis& axis, double line_v, double hz)
      : axis_(axis), peak_v_(line_v * sqrt2 / sqrt3), rate_(2 * pi * hz) {}

  void run(SimDuration duration) {
    for (const SimTime end = axis_.now() + duration; axis_.now() < end;) {
      const double middle = rate_ * seconds(axis_.now() - kSimStart + kPeriod / 2);
      PhaseValues duty{};
      for (std::size_t k = 0; k < 3; ++k) {
        duty[k] = 0.5 + peak_v_ / kLinkV * std::cos(middle - 2 * pi / 3 * static_cast<double>(k));
      }
      axis_.set_bridge({.mode = Bridge::kDriven, .duty = duty, .pwm_period = kPeriod});
      axis_.advance_to(axis_.now() + kPeriod);
    }
  }
  struct Mean {
    double torque_nm = 0, current_a = 0, flux_wb = 0, speed_radps = 0;
  };
  /// Over whole turns of the field, current rms.
  Mean mean(int turns, double hz) {
    Mean sum;
    const int periods = static_cast<int>(std::lround(turns / hz / seconds(kPeriod)));
    for (int i = 0; i < periods; ++i) {
      run(kPeriod);
      const AxisState& x = axis_.state();
      sum.torque_nm += axis_.torque_nm() / periods;
      sum.current_a += (x.i_d_a * x.i_d_a + x.i_q_a * x.i_q_a) / 2 / periods;
      sum.flux_wb += axis_.main_flux_wb() / periods;
      sum.speed_radps += x.speed_radps / periods;
    }
    sum.current_a = std::sqrt(sum.current_a);
    return sum;
  }

 private:
  Axis& axis_;
  double peak_v_, rate_;
};

class Induction : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(OfTheBench, Induction,
                         testing::Values("asd-0-75kw", "asd-4kw", "asd-22kw"),
                         [](const testing::TestParamInfo<const char*>& p) {
                           std::string name;
                           for (const char c : std::string(p.param)) {
                             if (c != '-') name += c;
                           }
                           return name;
                         });

TEST_P(Induction, SetGivesWhatItWasMadeFor) {
  const Motor motor = find_motor(GetParam());
  const InductionSupply supply = rated_supply(motor);
  const InductionPoint rated = induction_at_power(motor, supply, motor.rating.power_w);
  EXPECT_NEAR(rated.speed_radps * 30 / pi, motor.rating.speed_rpm, 4);
  EXPECT_NEAR(rated.current_a / motor.rating.current_a, 1, 0.02);
  EXPECT_NEAR(rated.torque_nm / motor.rating.torque_nm, 1, 0.01);
  struct Set {
    const char* name;
    double no_load_a, breakdown, power_factor;
  };
  for (const Set& set : {Set{"asd-0-75kw", 1.95, 2.8, 0.74}, Set{"asd-4kw", 3.45, 2.9, 0.81},
                         Set{"asd-22kw", 13.4, 3.0, 0.85}}) {
    if (motor.name != set.name) continue;
    EXPECT_NEAR(induction_no_load(motor, supply).current_a / set.no_load_a, 1, 0.02);
    EXPECT_NEAR(induction_breakdown(motor, supply).torque_nm / rated.torque_nm, set.breakdown, 0.1);
    EXPECT_NEAR(rated.power_factor, set.power_factor, 0.02);
  }
}

TEST_P(Induction, TorqueOverSlipIsThatOfTheEquivalentCircuit) {
  Motor motor = find_motor(GetParam());
  motor.effects.iron_eddy_w_per_v2 = motor.effects.iron_hysteresis_w = 0;
  motor.mechanics.coulomb_nm = motor.mechanics.viscous_nm_per_radps = 0;
  const InductionSupply supply = rated_supply(motor);
  const double hz = supply.frequency_hz;
  for (const double slip : {-0.03, 0.01, 0.04, 0.2, 0.6}) {
    SCOPED_TRACE(slip);
    const InductionPoint expected = induction_point(motor, supply, slip);
    // A heavy shaft holds its speed.
    AxisParameters bench = bench_of(motor);
    bench.mechanics.inertia_kgm2 = 1e9;
    Axis axis(bench, Integrator::kFast);
    axis.set_motion(0, expected.speed_radps);
    Supply source(axis, supply.line_v, hz);
    source.run(3s);  // several rotor time constants
    const Supply::Mean mean = source.mean(3, hz);
    EXPECT_NEAR(mean.torque_nm / expected.torque_nm, 1, 1e-3);
    EXPECT_NEAR(mean.current_a / expected.current_a, 1, 1e-3);
    EXPECT_NEAR(mean.flux_wb / expected.main_flux_wb, 1, 1e-3);
  }
}

TEST_P(Induction, LockedRotorAndNoLoadCurrentsAreThoseOfTheEquivalentCircuit) {
  const Motor motor = find_motor(GetParam());
  const InductionSupply supply = rated_supply(motor);
  {
    Axis axis(bench_of(motor), Integrator::kFast, {.locked = true});
    Supply source(axis, supply.line_v, supply.frequency_hz);
    source.run(1s);
    EXPECT_NEAR(
        source.mean(3, supply.frequency_hz).current_a / induction_point(motor, supply, 1).current_a,
        1, 1e-3);
  }
  Axis axis(bench_of(motor), Integrator::kFast);
  const InductionPoint idle = induction_no_load(motor, supply);
  axis.set_motion(0, idle.speed_radps);
  Supply source(axis, supply.line_v, supply.frequency_hz);
  source.run(3s);
  const Supply::Mean mean = source.mean(6, supply.frequency_hz);
  EXPECT_NEAR(mean.current_a / idle.current_a, 1, 2e-3);
  EXPECT_NEAR(mean.speed_radps / idle.speed_radps, 1, 1e-4);
}

TEST(InductionMachine, BothIntegratorsAgree) {
  const Motor motor = find_motor("asd-0-75kw");
  Axis fast(bench_of(motor), Integrator::kFast), exact(bench_of(motor), Integrator::kDefault);
  for (Axis* axis : {&fast, &exact}) {
    Supply(*axis, 230, 60).run(300ms);
    axis->set_bridge({.mode = Bridge::kOff});
    axis->advance_to(axis->now() + 50ms);
  }
  EXPECT_NEAR(fast.state().speed_radps, exact.state().speed_radps,
              1e-5 * exact.state().speed_radps);
  EXPECT_NEAR(fast.state().angle_rad, exact.state().angle_rad, 1e-4);
  EXPECT_NEAR(fast.main_flux_wb(), exact.main_flux_wb(), 1e-5);
  EXPECT_GT(exact.main_flux_wb(), 0.2);
  EXPECT_EQ(fast.counters().stalled, 0U);
}

// Power in = heat of both windings + what the shaft gets + what the field gains, at any state.
TEST(InductionMachine, NoPowerIsLostOrMade) {
  const Motor motor = find_motor("asd-4kw");
  const SquirrelCage cage(*motor.effects.cage);
  const double rs = motor.electrical.resistance_ohm, lls = cage.parameters.stator_leakage_h;
  RandomStream random(7);
  const auto draw = [&](double most) { return most * (2 * random.uniform() - 1); };
  for (int trial = 0; trial < 200; ++trial) {
    const Dq i{draw(30), draw(30)}, psi{draw(1.5), draw(1.5)}, v{draw(400), draw(400)};
    const double w = draw(500);
    const SquirrelCage::Point p = cage.at(i, psi, w);
    const Dq rate{v.d - rs * i.d - p.emf_v.d, v.q - rs * i.q - p.emf_v.q};
    const Dq di{p.dd * rate.d + p.dq * rate.q, p.dq * rate.d + p.qq * rate.q};
    const Dq dpsi{v.d - rs * i.d - lls * di.d, v.q - rs * i.q - lls * di.q};
    const double h = 1e-7;
    const auto energy = [&](double t) {
      return cage.field_energy_j({i.d + t * di.d, i.q + t * di.q},
                                 {psi.d + t * dpsi.d, psi.q + t * dpsi.q});
    };
    const double stored_w = (energy(h) - energy(-h)) / (2 * h);
    const Dq r = p.rotor_current_a;
    const double in_w = 1.5 * (v.d * i.d + v.q * i.q);
    const double heat_w = 1.5 * (rs * (i.d * i.d + i.q * i.q) +
                                 cage.rotor_resistance_ohm() * (r.d * r.d + r.q * r.q));
    const double shaft_w = 1.5 * w * (psi.d * i.q - psi.q * i.d);
    EXPECT_NEAR(in_w, heat_w + shaft_w + stored_w, 1e-6 * (std::fabs(in_w) + heat_w) + 1e-2);
  }
}

TEST(InductionMachine, OpenStatorsFieldDecaysWithTheRotorsTimeConstantAndThenItRests) {
  Motor motor = find_motor("asd-0-75kw");
  motor.effects.cage->saturation_flux_wb = 0;
  Axis axis(bench_of(motor), Integrator::kFast, {.locked = true});
  axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.508, 0.496, 0.496}, .pwm_period = kPeriod});
  axis.advance_to(kSimStart + 2s);
  EXPECT_GT(axis.main_flux_wb(), 0.1);
  axis.set_bridge({.mode = Bridge::kOff});
  axis.advance_to(axis.now() + 50ms);
  const CageParameters& c = *motor.effects.cage;
  const double t1 = (c.rotor_leakage_h + c.main_inductance_h) / c.rotor_resistance_ohm;
  const double flux = axis.main_flux_wb();
  axis.advance_to(axis.now() + 100ms);
  EXPECT_NEAR(axis.main_flux_wb() / flux, std::exp(-0.1 / t1), 1e-6);
  EXPECT_FALSE(axis.at_rest());
  axis.advance_to(axis.now() + 3s);
  EXPECT_TRUE(axis.at_rest());
  EXPECT_EQ(axis.main_flux_wb(), 0);
}

TEST(InductionMachine, ABrokenWireKeepsTheRotorsFlux) {
  const Motor motor = find_motor("asd-0-75kw");
  Axis axis(bench_of(motor), Integrator::kFast);
  Supply source(axis, 230, 60);
  source.run(300ms);
  const double before = axis.main_flux_wb();
  axis.set_bridge_faults({.phase_open = {true, false, false}});
  EXPECT_NEAR(axis.phase_currents_a()[0], 0, 1e-9);
  EXPECT_NEAR(axis.main_flux_wb(), before, 0.1 * before);
  source.run(200ms);
  EXPECT_NEAR(axis.phase_currents_a()[0], 0, 1e-6);
  EXPECT_GT(axis.state().speed_radps, 150) << "it goes on on two phases";
}

TEST(InductionMachine, WarmWindingsHaveMoreResistance) {
  Motor motor = find_motor("asd-0-75kw");
  motor.effects.cage->saturation_flux_wb = 0;
  const InductionSupply supply = rated_supply(motor);
  Axis cold(bench_of(motor), Integrator::kFast, {.locked = true});
  Axis warm(bench_of(motor), Integrator::kFast, {.locked = true});
  warm.set_temperatures(125, 125);
  double current_a[2] = {}, torque_nm[2] = {};
  int i = 0;
  for (Axis* axis : {&cold, &warm}) {
    Supply source(*axis, supply.line_v, supply.frequency_hz);
    source.run(500ms);
    const Supply::Mean mean = source.mean(3, supply.frequency_hz);
    current_a[i] = mean.current_a;
    torque_nm[i++] = mean.torque_nm;
  }
  motor.electrical.resistance_ohm *= 1 + 100 * motor.effects.thermal.resistance_per_k;
  motor.effects.cage->rotor_resistance_ohm *= 1 + 100 * motor.effects.cage->rotor_resistance_per_k;
  const InductionPoint expected = induction_point(motor, supply, 1);
  EXPECT_NEAR(current_a[1] / expected.current_a, 1, 1e-3);
  EXPECT_NEAR(torque_nm[1] / expected.air_gap_nm, 1, 2e-3);
  EXPECT_LT(current_a[1], current_a[0]);
}

TEST(InductionMachine, RefusesWhatCannotBe) {
  const Motor motor = find_motor("asd-4kw");
  AxisParameters bench = bench_of(motor);
  bench.effects.cage->rotor_resistance_ohm = 0;
  EXPECT_THROW(Axis(bench, Integrator::kFast), SetupError);
  bench = bench_of(motor);
  bench.effects.cage->saturation_exponent = 5;
  EXPECT_THROW(Axis(bench, Integrator::kFast), SetupError);
}

}  // namespace
}  // namespace virtdrive
