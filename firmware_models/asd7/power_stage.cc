#include "firmware_models/asd7/power_stage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive::asd7 {
namespace {

// Assumed: 12 bits, detectors for 3.5 times the rated peak.
constexpr Adc kAdc{.bits = 12, .reference_v = 5.0};
constexpr double kFullScale = 3.5;
constexpr double kNoise = 5e-4;

}  // namespace

PowerStage::PowerStage(Axis& axis, double rated_current_a, double full_scale_v, const Seed& seed)
    : axis_(axis), noise_(seed.stream("detectors")) {
  const double peak_a = kFullScale * std::numbers::sqrt2 * rated_current_a;
  detector_ = {.adc = kAdc,
               .volts_per_amp = kAdc.reference_v / 2 / peak_a,
               .noise_a = kNoise * rated_current_a};
  divider_ = {.adc = kAdc, .volts_per_volt = kAdc.reference_v / full_scale_v};
}

Measured PowerStage::sample() {
  Measured m;
  // The middle of a count is what it stands for.
  const double bus_counts = divider_.counts(axis_.state().bus_v, noise_) + 0.5;
  m.bus_v = bus_counts * kAdc.reference_v / (kAdc.full_scale() + 1) / divider_.volts_per_volt;
  if (!on_ && axis_.at_rest()) return m;
  const PhaseValues i = axis_.phase_currents_a();
  const double amps = kAdc.reference_v / (kAdc.full_scale() + 1) / detector_.volts_per_amp;
  for (std::size_t k = 0; k < 2; ++k) {
    const int counts = detector_.counts(i[k], noise_) - detector_.zero_counts();
    m.current_a[k] = (counts + 0.5) * amps;
  }
  m.current_a[2] = -m.current_a[0] - m.current_a[1];
  m.current = clarke(m.current_a);
  m.current2 = (m.current.alpha * m.current.alpha + m.current.beta * m.current.beta) / 2;
  return m;
}

AlphaBeta PowerStage::put(AlphaBeta v, double bus_v) {
  const double length = std::hypot(v.alpha, v.beta);
  const double most = bus_v / std::numbers::sqrt3;
  if (length > most) v = {v.alpha * most / length, v.beta * most / length};
  const PhaseValues phase = inverse_clarke(v);
  const auto [lowest, highest] = std::minmax({phase[0], phase[1], phase[2]});
  const double middle = (lowest + highest) / 2;  // space-vector modulation
  PhaseValues duty{};
  for (std::size_t k = 0; k < 3; ++k) {
    duty[k] = std::clamp(0.5 + (phase[k] - middle) / bus_v, 0.0, 1.0);
  }
  axis_.set_bridge({.mode = Bridge::kDriven, .duty = duty});
  on_ = true;
  return v;
}

void PowerStage::off() {
  if (!on_) return;
  axis_.set_bridge({.mode = Bridge::kOff});
  on_ = false;
}

}  // namespace virtdrive::asd7
