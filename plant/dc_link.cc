#include "plant/dc_link.h"

#include <cmath>
#include <numbers>

namespace virtdrive {
namespace {

/// Below this a link that nothing feeds is empty.
constexpr double kEmptyV = 1e-3;

}  // namespace

void validate(const DcLinkParameters& link) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("DC link: {}, not {}", what, value));
  };
  const auto not_negative = [](double x) { return std::isfinite(x) && x >= 0; };
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  require(not_negative(link.source_v), "source_v must be 0 or more", link.source_v);
  require(not_negative(link.resistance_ohm), "resistance_ohm must be 0 or more",
          link.resistance_ohm);
  require(positive(link.capacitance_f), "capacitance_f must be above 0", link.capacitance_f);
  require(not_negative(link.board_ohm), "board_ohm must be 0 or more", link.board_ohm);
  require(not_negative(link.board_w), "board_w must be 0 or more", link.board_w);
  require(positive(link.board_cutoff_v), "board_cutoff_v must be above 0", link.board_cutoff_v);
  validate(link.mains);
  const BrakeChopper& c = link.chopper;
  require(not_negative(c.on_v), "chopper on_v must be 0 or more", c.on_v);
  if (c.on_v == 0) return;
  require(c.on_v > link.source_v, "chopper on_v must be above source_v", c.on_v);
  require(c.off_v > 0 && c.off_v < c.on_v, "chopper off_v must be above 0 and below on_v", c.off_v);
  require(positive(c.resistance_ohm), "chopper resistance_ohm must be above 0", c.resistance_ohm);
  require(positive(c.heat_capacity_j_per_k), "chopper heat_capacity_j_per_k must be above 0",
          c.heat_capacity_j_per_k);
  require(positive(c.ambient_k_per_w), "chopper ambient_k_per_w must be above 0",
          c.ambient_k_per_w);
}

DcLink::DcLink(const DcLinkParameters& parameters) : p(parameters), mains(parameters.mains) {
  validate(p);
  ideal = p.resistance_ohm == 0 && !mains.any();
  draws = p.board_ohm > 0 || p.board_w > 0;
  source_conductance = p.resistance_ohm == 0 || mains.any() ? 0 : 1 / p.resistance_ohm;
  inverse_capacitance = 1 / p.capacitance_f;
  board_conductance = p.board_ohm > 0 ? 1 / p.board_ohm : 0;
  // Half of the source's time constant keeps RK4 stable and errs by 5e-4 of a step of its voltage;
  // the slow ones can have more.
  double slow = board_conductance + p.board_w / (p.board_cutoff_v * p.board_cutoff_v);
  if (has_chopper()) slow += 1 / p.chopper.resistance_ohm;
  const double rate = std::max(2 * source_conductance, 10 * slow);
  step_limit = rate > 0 ? p.capacitance_f / rate : std::numeric_limits<double>::infinity();
}

bool DcLink::follow(double* x) {
  bool changed = mains.any() && mains.follow(x[phase_at()], x[rectifier_at()], x[kVoltage]);
  if (has_diode()) {
    const double above = x[kVoltage] - p.source_v;
    if (kSourceHysteresisV + (feeds ? -above : above) <= 0) {
      feeds = !feeds;
      changed = true;
    }
  }
  if (chopper_enabled()) {
    const double left = chopper_on ? x[kVoltage] - p.chopper.off_v : p.chopper.on_v - x[kVoltage];
    if (left <= 0) {
      chopper_on = !chopper_on;
      changed = true;
    }
  }
  return changed;
}

void DcLink::set_source(double* x, double source_v, bool switched_on) {
  DcLinkParameters changed = p;
  changed.source_v = source_v;
  validate(changed);
  p.source_v = source_v;
  on = switched_on;
  if (pinned()) x[kVoltage] = source_v;
  feeds = x[kVoltage] <= source_v;
}

void DcLink::set_chopper(bool enabled) {
  chopper_off = !enabled;
  if (chopper_off) chopper_on = false;
}

/// Of a source that feeds: (E - V) / R = board current.
double DcLink::equilibrium_v() const {
  double v = p.source_v;
  if (!draws) return v;
  for (int trial = 0; trial < 50; ++trial) {
    const double next = p.source_v - board_current(v) / source_conductance;
    if (std::fabs(next - v) < 1e-12 * p.source_v) return next;
    v = std::max(0.0, next);
  }
  return v;
}

bool DcLink::settle(double* x) {
  double& v = x[kVoltage];
  if (chopper_on) return false;
  if (pinned()) return true;
  if (mains.any() && mains.peak_v() > 0 && v <= mains.peak_v()) return settle_on_mains(x);
  const bool fed = !mains.any() && on && (p.absorbs || v <= p.source_v + kSourceHysteresisV);
  if (!fed) {
    if (!draws) return true;
    if (v > kEmptyV) return false;
    v = 0;
    return true;
  }
  const double target = equilibrium_v();
  if (std::fabs(v - target) > kSourceHysteresisV) return false;
  v = target;
  return true;
}

/// At rest the link stands at the mean that the standing load leaves; its ripple is not followed.
bool DcLink::settle_on_mains(double* x) {
  double& v = x[kVoltage];
  const double load_a = board_current(v);
  const double target = mains.resting_v(load_a);
  constexpr double kOfPeak = 1e-3;  // what the closed form may err by
  const double band = mains.resting_ripple_v(load_a, p.capacitance_f) + kOfPeak * mains.peak_v();
  if (!mains.input().contact || std::fabs(v - target) > band) return false;
  v = target;
  x[rectifier_at()] = 0;
  mains.conducts = false;
  return true;
}

void DcLink::rest(double* x, double duration_s) const {
  if (mains.any()) {
    constexpr double kTurn = 2 * std::numbers::pi;
    x[phase_at()] = std::fmod(x[phase_at()] + mains.phase_rate() * duration_s, kTurn);
  }
  if (!has_chopper()) return;
  const BrakeChopper& c = p.chopper;
  const double left = std::exp(-duration_s / (c.ambient_k_per_w * c.heat_capacity_j_per_k));
  x[kChopperDegc] = c.ambient_degc + (x[kChopperDegc] - c.ambient_degc) * left;
}

}  // namespace virtdrive
