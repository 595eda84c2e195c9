// The plant against an independent referee: CVODE on equations in phase coordinates, with diodes
// as stiff resistors instead of an automaton.
#include <gtest/gtest.h>
#include <numbers>

#include "tests/plant/bench.h"
#include "tests/plant/cvode.h"
#include "tests/plant/six_step.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;

constexpr Integrator kBoth[] = {Integrator::kDefault, Integrator::kFast};

/// An isotropic machine in phase coordinates: i_a, i_b, speed, angle, link voltage.
struct PhaseModel {
  PmsmParameters motor;
  MechanicsParameters mechanics;
  DcLinkParameters link;
  double extra_inertia = 0;
  bool trapezoid = false;

  double shape(double angle) const {
    if (!trapezoid) return -std::sin(angle);
    // Rises through 0 half a turn after the magnets' axis; flat for 120 degrees.
    const double x = std::remainder(angle - pi, 2 * pi);
    return std::clamp(
        std::abs(x) > pi / 2 ? std::copysign(pi - std::abs(x), x) / (pi / 6) : x / (pi / 6), -1.0,
        1.0);
  }

  /// `terminal(phase, current, bus)` gives the terminals' voltages, `draw(i, bus)` the current out
  /// of the link.
  template <class Terminal, class Draw>
  void derivative(const double* x, double* dx, const Terminal& terminal, const Draw& draw) const {
    const double i[3] = {x[0], x[1], -x[0] - x[1]};
    const double w = x[2], v = x[4];
    double drive[3], mean = 0, torque = 0;
    for (int k = 0; k < 3; ++k) {
      const double f = shape(motor.pole_pairs * x[3] - k * 2 * pi / 3);
      drive[k] = terminal(k, i[k], v) - motor.resistance_ohm * i[k] -
                 motor.pole_pairs * w * motor.flux_wb * f;
      mean += drive[k] / 3;
      torque += motor.pole_pairs * motor.flux_wb * f * i[k];
    }
    dx[0] = (drive[0] - mean) / motor.inductance_d_h;
    dx[1] = (drive[1] - mean) / motor.inductance_d_h;
    dx[2] = (torque - mechanics.viscous_nm_per_radps * w -
             (w > 0   ? mechanics.coulomb_nm
              : w < 0 ? -mechanics.coulomb_nm
                      : 0)) /
            (mechanics.inertia_kgm2 + extra_inertia);
    dx[3] = w;
    const double source = std::max(0.0, (link.source_v - v) / link.resistance_ohm);
    dx[4] = (source - draw(i, v)) / link.capacitance_f;
  }
};

TEST(Referee, AgreesOnADrivenMachineOverManyHeldInputs) {
  AxisParameters p = small_bench(0.1);
  p.mechanics.coulomb_nm = 0;  // the referee does not stick
  for (const Integrator integrator : kBoth) {
    Axis axis(p, integrator);
    const PhaseModel model{p.motor, p.mechanics, p.link};
    PhaseValues duty{};
    Cvode referee(
        {0, 0, 0, 0, 24},
        [&](double, const double* x, double* dx) {
          model.derivative(
              x, dx, [&](int k, double, double v) { return duty[static_cast<std::size_t>(k)] * v; },
              [&](const double* i, double) {
                return duty[0] * i[0] + duty[1] * i[1] + duty[2] * i[2];
              });
        },
        1e-10, 1e-12);
    double worst = 0;
    for (int k = 0; k < 250; ++k) {
      duty = duty_for(axis, {k / 50 % 2 == 0 ? 0.0 : -0.5, 2.0 + k / 50});
      axis.set_bridge({.mode = Bridge::kDriven, .duty = duty, .pwm_period = kPwmPeriod});
      axis.advance_to(axis.now() + kPwmPeriod);
      ASSERT_TRUE(referee.advance_to(seconds(axis.now())));
      referee.restart(seconds(axis.now()));
      const PhaseValues i = axis.phase_currents_a();
      worst = std::max({worst, std::abs(i[0] - referee[0]), std::abs(i[1] - referee[1])});
    }
    EXPECT_GT(referee[2], 50);
    EXPECT_LT(worst / p.motor.rated_current_a, integrator == Integrator::kFast ? 1e-5 : 1e-7);
    EXPECT_NEAR(axis.state().speed_radps, referee[2], 1e-4);
    EXPECT_NEAR(axis.state().bus_v, referee[4], 1e-5);
  }
}

/// A half bridge with its gates off as two diodes: a megohm to the middle within the rails, a
/// tenth of a milliohm beyond them. Voltage by current.
double diode_leg(double current, double bus_v) {
  constexpr double kOff = 1e6, kOn = 1e-4;
  const double least = bus_v / 2 / kOff;
  if (current > least) return -(current - least) * kOn;
  if (current < -least) return bus_v - (current + least) * kOn;
  return bus_v / 2 - current * kOff;
}

TEST(Referee, AgreesOnWhatTheBodyDiodesRectify) {
  AxisParameters p = small_bench(0.1);
  for (const bool trapezoid : {false, true}) {
    PhaseModel model{p.motor, p.mechanics, p.link, 1.0, trapezoid};
    Cvode referee(
        {0, 0, 800, 0.3, 24},
        [&](double, const double* x, double* dx) {
          model.derivative(
              x, dx, [](int, double i, double v) { return diode_leg(i, v); },
              [](const double* i, double) {
                return std::min(0.0, i[0]) + std::min(0.0, i[1]) + std::min(0.0, i[2]);
              });
        },
        1e-8, 1e-9);
    ASSERT_TRUE(referee.advance_to(4e-3));
    for (const Integrator integrator : kBoth) {
      AxisParameters q = p;
      if (trapezoid) q.effects.emf = EmfShape::trapezoid(2 * pi / 3);
      Axis axis(q, integrator, {.inertia_kgm2 = 1});
      axis.set_motion(0.3, 800);
      double most = 0;
      while (axis.now() < kSimStart + 4ms) {
        axis.advance_to(axis.now() + 50us);
        most = std::max(most, current_a(axis));
      }
      EXPECT_GT(most, 0.5);
      const PhaseValues i = axis.phase_currents_a();
      EXPECT_NEAR(i[0], referee[0], 2e-4) << trapezoid;
      EXPECT_NEAR(i[1], referee[1], 2e-4) << trapezoid;
      EXPECT_NEAR(axis.state().bus_v, referee[4], 1e-3) << trapezoid;
      EXPECT_NEAR(axis.state().speed_radps, referee[2], 1e-5) << trapezoid;
    }
  }
}

TEST(Referee, AgreesOnSixStepWithAFloatingPhaseAndItsCommutation) {
  AxisParameters p{.motor = bldc_line_to_line(8, 4.83, 2.24e-3, 51e-3, 1),
                   .link = {.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3},
                   .mechanics = {.inertia_kgm2 = 92.5e-7, .viscous_nm_per_radps = 1e-4}};
  p.effects.emf = EmfShape::trapezoid(2 * pi / 3);
  for (const Integrator integrator : kBoth) {
    Axis axis(p, integrator);
    const PhaseModel model{p.motor, p.mechanics, p.link, 0, true};
    BridgeCommand command;
    const auto terminal = [&](int k, double i, double v) {
      const Leg leg = command.legs[static_cast<std::size_t>(k)];
      return leg == Leg::kHigh ? v : leg == Leg::kLow ? 0.0 : diode_leg(i, v);
    };
    const auto draw = [&](const double* i, double) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const Leg leg = command.legs[static_cast<std::size_t>(k)];
        sum += leg == Leg::kHigh ? i[k] : leg == Leg::kHiZ ? std::min(0.0, i[k]) : 0.0;
      }
      return sum;
    };
    Cvode referee(
        {0, 0, 0, 0, 24},
        [&](double, const double* x, double* dx) { model.derivative(x, dx, terminal, draw); }, 1e-8,
        1e-9);
    // The commutation of the plant's rotor is given to both.
    int last = -1;
    double worst = 0;
    while (axis.now() < kSimStart + 15ms) {
      const int sector = SixStep::sector(axis.electrical_angle_rad());
      if (sector != last) {
        last = sector;
        command = SixStep{}.command(sector);
        axis.set_bridge(command);
        referee.restart(seconds(axis.now()));
      }
      axis.advance_to(axis.now() + 50us);
      ASSERT_TRUE(referee.advance_to(seconds(axis.now())));
      const PhaseValues i = axis.phase_currents_a();
      worst = std::max({worst, std::abs(i[0] - referee[0]), std::abs(i[1] - referee[1])});
    }
    EXPECT_GT(referee[2], 100);
    EXPECT_LT(worst, 5e-4 * 5) << "5e-4 of the starting current";
    EXPECT_NEAR(axis.state().speed_radps, referee[2], 1e-2);
  }
}

// What the referee itself must not do: a multistep method carries its history across the edges of
// held inputs. Here against the same run with a restart at each edge.
TEST(Referee, LeftAloneAtTheStepsOfAnInputItIsWrong) {
  const AxisParameters p = small_bench(0.1);
  const PhaseModel model{p.motor, {.inertia_kgm2 = 2.4e-6}, p.link};
  const auto currents = [&](bool restart) {
    PhaseValues duty{};
    Cvode run(
        {0, 0, 0, 0, 24},
        [&](double, const double* x, double* dx) {
          model.derivative(
              x, dx, [&](int k, double, double v) { return duty[static_cast<std::size_t>(k)] * v; },
              [&](const double* i, double) {
                return duty[0] * i[0] + duty[1] * i[1] + duty[2] * i[2];
              });
        },
        1e-6, 1e-8);
    std::vector<double> all;
    for (int k = 0; k < 400; ++k) {
      const double angle = 0.2 * k;
      duty = inverse_clarke({0.1 * std::cos(angle), 0.1 * std::sin(angle)});
      for (double& d : duty) d += 0.5;
      if (restart) run.restart(k * 80e-6);
      all.push_back(run.advance_to((k + 1) * 80e-6) ? run[0] : 1e3);
    }
    return all;
  };
  const std::vector<double> right = currents(true), left_alone = currents(false);
  double worst = 0;
  for (std::size_t k = 0; k < right.size(); ++k) {
    worst = std::max(worst, std::abs(right[k] - left_alone[k]));
  }
  EXPECT_GT(worst / p.motor.rated_current_a, 1e-5) << "a hundred times the plant's own error";
}

}  // namespace
}  // namespace virtdrive
