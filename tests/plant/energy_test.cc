// Energy: what the source gives is what is lost and what is stored, however it flows.
#include <gtest/gtest.h>

#include "tests/plant/bench.h"
#include "tests/plant/six_step.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;

/// Boole's rule over steps between two inputs: as good as the states themselves.
class EnergyMeter {
 public:
  explicit EnergyMeter(Axis& axis) : axis_(axis), stored_(stored_j()) {}

  void advance(SimDuration duration) {
    static constexpr double kWeights[] = {7.0 / 90, 32.0 / 90, 12.0 / 90, 32.0 / 90, 7.0 / 90};
    const SimTime start = axis_.now();
    for (int k = 0; k < 5; ++k) {
      axis_.advance_to(start + k * duration / 4);
      const double source = axis_.source_current_a() * axis_.parameters().link.source_v;
      const double w = kWeights[k] * seconds(duration);
      source_j_ += w * source;
      through_j_ += w * std::abs(source);
      lost_j_ += w * lost_w();
    }
  }
  /// Of the energy that has passed.
  double residue() const {
    return std::abs(source_j_ - lost_j_ - (stored_j() - stored_)) / through_j_;
  }

 private:
  double lost_w() const {
    const AxisParameters& p = axis_.parameters();
    const AxisState& x = axis_.state();
    const double i = axis_.source_current_a(), w = x.speed_radps;
    return i * i * p.link.resistance_ohm +
           1.5 * p.motor.resistance_ohm * (x.i_d_a * x.i_d_a + x.i_q_a * x.i_q_a) +
           p.mechanics.coulomb_nm * std::abs(w) + p.mechanics.viscous_nm_per_radps * w * w;
  }
  double stored_j() const {
    const AxisParameters& p = axis_.parameters();
    const AxisState& x = axis_.state();
    return 0.5 * (p.mechanics.inertia_kgm2 + axis_.load().inertia_kgm2) * x.speed_radps *
               x.speed_radps +
           0.75 * (p.motor.inductance_d_h * x.i_d_a * x.i_d_a +
                   p.motor.inductance_q_h * x.i_q_a * x.i_q_a) +
           0.5 * p.link.capacitance_f * x.bus_v * x.bus_v;
  }

  Axis& axis_;
  double stored_, source_j_ = 0, lost_j_ = 0, through_j_ = 0;
};

double driven_residue(Integrator integrator, double tolerance) {
  AxisParameters p = small_bench(0.2);
  p.motor.inductance_q_h *= 1.5;  // salient
  Axis axis(p, integrator, {.inertia_kgm2 = 5e-6}, tolerance);
  EnergyMeter meter(axis);
  for (int k = 0; k < 150; ++k) {
    axis.set_bridge(
        {.mode = Bridge::kDriven, .duty = duty_for(axis, {-0.5, 4}), .pwm_period = kPwmPeriod});
    for (int part = 0; part < 4; ++part) meter.advance(kPwmPeriod / 4);
  }
  return meter.residue();
}

TEST(Energy, ClosesToANanothAtATightTolerance) {
  EXPECT_LT(driven_residue(Integrator::kDefault, 1e-12), 1e-9);
}

TEST(Energy, ClosesWithinThePublishedFiguresAsItComes) {
  EXPECT_LT(driven_residue(Integrator::kDefault, kDefaultTolerance), 1e-7);
  EXPECT_LT(driven_residue(Integrator::kFast, kDefaultTolerance), 2e-6);
}

// Switched, trapezoid, body diodes: events in each quarter of a period, so the meter's own steps
// bound what can be shown.
TEST(Energy, ClosesOverEdgesDiodesAndCorners) {
  for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
    AxisParameters p = small_bench(0.2);
    p.motor = bldc_line_to_line(4, 1.5, 2.1e-3, 34e-3, 1.85);
    p.effects.emf = EmfShape::trapezoid(2 * pi / 3);
    p.inverter.switched = true;
    Axis axis(p, integrator, {.inertia_kgm2 = 5e-6});
    SixStep commutation{.duty = 0.6, .pwm_period = 42us};
    commutation.run(axis, kSimStart + 20ms, 7us);
    EnergyMeter meter(axis);
    for (int k = 0; k < 20; ++k) {
      axis.set_bridge(commutation.command(SixStep::sector(axis.electrical_angle_rad())));
      for (int part = 0; part < 420; ++part) meter.advance(100ns);
    }
    EXPECT_LT(meter.residue(), 1e-4);
    EXPECT_EQ(axis.counters().stalled, 0U);
  }
}

}  // namespace
}  // namespace virtdrive
