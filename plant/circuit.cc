#include "plant/circuit.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr int kEventsAtOneInstant = 16;
constexpr double kOneInstantS = 1e-12;
constexpr double kMovedOnS = 100e-9;
// Resistance and magnets follow the temperatures at least this often.
constexpr SimDuration kThermalStep = 10ms;

/// Errors are judged against the motor's own size: 1e-6 of the rated current, of a volt, ...
void add_tolerances(const AxisUnit& unit, double scale, std::vector<double>& relative,
                    std::vector<double>& absolute) {
  const AxisModel& model = unit.model;
  const auto add = [&](double r, double a) {
    relative.push_back(r * scale);
    absolute.push_back(a * scale);
  };
  const PmsmParameters& motor = unit.parameters.motor;
  const bool fluxes = unit.parameters.effects.saturation != nullptr;
  const double current =
      0.1 * motor.rated_current_a * (fluxes ? model.winding.least_inductance_h() : 1);
  add(1, current);
  add(1, current);
  for (int i = 0; i < model.shaft.states(); i += 2) {
    add(1, 10);
    add(0, 1);
  }
  if (model.thermal()) {
    add(1, 1);
    add(1, 1);
  }
  if (model.winding.cage()) {
    const double flux = 0.1 * motor.rated_current_a * model.winding.least_inductance_h();
    add(1, flux);
    add(1, flux);
  }
}

AxisParameters checked(const AxisParameters& p) {
  validate(p.motor);
  validate(p.effects);
  validate(p.inverter);
  return p;
}

Load checked(const AxisParameters& p, const Load& load) {
  validate(p.mechanics, load);
  return load;
}

}  // namespace

AxisUnit::AxisUnit(const AxisParameters& p, const Load& l)
    : parameters(checked(p)),
      load(checked(p, l)),
      bridges(p.inverter, {false, false, p.effects.commutator}),
      model(Winding(p.motor, p.effects, p.inverter.on_resistance_ohm), Shaft(p.mechanics, l)),
      winding_degc_(p.effects.thermal.reference_degc),
      magnet_degc_(p.effects.thermal.reference_degc) {
  own_states.resize(static_cast<std::size_t>(model.states()));
  x = own_states.data();
  const Dq unmagnetised = model.winding.state_with_current({p.motor.flux_wb, 0}, {});
  x[0] = unmagnetised.d;
  x[1] = unmagnetised.q;
  if (model.thermal()) {
    x[model.temperatures_at()] = x[model.temperatures_at() + 1] = p.effects.thermal.ambient_degc;
    update_temperatures();
  }
  model.connection = bridges.connection();
  set_shaft();
}

void AxisUnit::set_shaft() {
  Load with_profile = load;
  with_profile.external_torque_nm += profile_nm_;
  model.shaft = Shaft(parameters.mechanics, with_profile);
  model.shaft.decide(x + AxisModel::kShaft, torque(), drag());
}

void AxisUnit::set_load(const Load& new_load) {
  validate(parameters.mechanics, new_load);
  load = new_load;
  set_shaft();
}

void AxisUnit::set_torque_profile(std::vector<TorqueStep> profile, SimTime now) {
  for (std::size_t i = 1; i < profile.size(); ++i) {
    VIRTDRIVE_CHECK(profile[i].at >= profile[i - 1].at, "torque profile: {} ns after {} ns",
                    profile[i].at.count(), profile[i - 1].at.count());
  }
  profile_ = std::move(profile);
  profile_start_ = now;
  next_step_ = 0;
  profile_nm_ = 0;
  next_step_at_ = profile_.empty() ? kNever : now + profile_[0].at;
  set_shaft();
}

void AxisUnit::set_motion(double angle_rad, double speed_radps) {
  double* const shaft = x + AxisModel::kShaft;
  shaft[Shaft::kSpeed] = speed_radps;
  shaft[Shaft::kAngle] = angle_rad;
  if (model.shaft.two_masses) {
    shaft[Shaft::kLoadSpeed] = speed_radps * model.shaft.inverse_ratio;
    shaft[Shaft::kLoadAngle] = angle_rad * model.shaft.inverse_ratio;
  }
  set_shaft();
}

void AxisUnit::set_temperatures(double winding_degc, double magnet_degc) {
  if (model.thermal()) {
    x[model.temperatures_at()] = winding_degc;
    x[model.temperatures_at() + 1] = magnet_degc;
  }
  winding_degc_ = winding_degc;
  magnet_degc_ = magnet_degc;
  model.winding.set_temperatures(winding_degc, magnet_degc);
}

void AxisUnit::update_temperatures() {
  const double* degc = x + model.temperatures_at();
  model.winding.set_temperatures(degc[0], degc[1]);
}

double AxisUnit::winding_degc() const {
  return model.thermal() ? x[model.temperatures_at()] : winding_degc_;
}

double AxisUnit::magnet_degc() const {
  return model.thermal() ? x[model.temperatures_at() + 1] : parameters.effects.thermal.ambient_degc;
}

void AxisUnit::rest(double duration_s) {
  if (!model.thermal() || duration_s <= 0) return;
  // Two linear nodes without a source: dx/dt = A x, A = [-a a; b -c], by its two eigenvalues.
  const ThermalParameters& t = parameters.effects.thermal;
  double* degc = x + model.temperatures_at();
  const double a = 1 / (t.winding_housing_k_per_w * t.winding_j_per_k);
  const double b = 1 / (t.winding_housing_k_per_w * t.housing_j_per_k);
  const double c = b + 1 / (t.housing_ambient_k_per_w * t.housing_j_per_k);
  const double mean = -(a + c) / 2;
  const double half = std::sqrt((a - c) * (a - c) / 4 + a * b);
  const double slow = std::exp((mean + half) * duration_s);
  const double fast = std::exp((mean - half) * duration_s);
  const double u = degc[0] - t.ambient_degc, v = degc[1] - t.ambient_degc;
  // exp(A t) = (slow (A - fast root) - fast (A - slow root)) / (2 half)
  const double even = (slow + fast) / 2, odd = (slow - fast) / (2 * half);
  degc[0] = t.ambient_degc + even * u + odd * ((-a - mean) * u + a * v);
  degc[1] = t.ambient_degc + even * v + odd * (b * u + (-c - mean) * v);
  update_temperatures();
}

void AxisUnit::set_bridge(const BridgeCommand& command, SimTime now, double bus_v) {
  const bool stays_off = command.mode == Bridge::kOff && command_.mode == Bridge::kOff;
  command_ = command;
  if (!stays_off) apply(now, bus_v);
}

void AxisUnit::set_bridge_faults(const BridgeFaults& faults, SimTime now, double bus_v) {
  bridges.set_faults(faults, phase_currents());
  follow_bridges();
  edges_.stop();
  apply(now, bus_v);
}

void AxisUnit::apply(SimTime now, double bus_v) {
  command_at_ = now;
  next_time_event_ = kNever;
  switch (command_.mode) {
    case Bridge::kOff:
      edges_.stop();
      set_gates({});
      break;
    case Bridge::kShort:
      edges_.stop();
      short_circuit(now);
      break;
    case Bridge::kDriven:
      drive(now, bus_v);
      break;
  }
}

void AxisUnit::take_time_event(SimTime now, double bus_v) {
  ++time_events;
  if (next_step_at_ <= now) {
    profile_nm_ = profile_[next_step_].torque_nm;
    ++next_step_;
    next_step_at_ =
        next_step_ < profile_.size() ? profile_start_ + profile_[next_step_].at : kNever;
    set_shaft();
    return;
  }
  if (command_.mode == Bridge::kDriven) {
    if (switched() && now < edges_.period_end()) {
      edges_.run(now);
      set_gates(edges_.gates());
      next_time_event_ = std::min(edges_.next(), edges_.period_end());
      return;
    }
    command_at_ = now;
    drive(now, bus_v);
  } else if (shorted_part_) {
    set_gates({});
    shorted_part_ = false;
    next_time_event_ = command_at_ + command_.pwm_period;
  } else {
    command_at_ = now;
    short_circuit(now);
  }
}

void AxisUnit::drive(SimTime now, double bus_v) {
  for (const double duty : command_.duty) {
    VIRTDRIVE_CHECK(duty >= 0 && duty <= 1, "duty {}", duty);
  }
  const bool dead_time = command_.dead_time > SimDuration{0};
  const bool timed = command_.pwm_period > SimDuration{0};
  if (switched() && !timed) {
    for (std::size_t leg = 0; leg < 3; ++leg) {
      const double duty = command_.duty[leg];
      VIRTDRIVE_CHECK(command_.legs[leg] != Leg::kDuty || duty == 0 || duty == 1,
                      "duty {} of a switched bridge needs a PWM period", duty);
    }
  }
  if (dead_time || (switched() && timed)) {
    VIRTDRIVE_CHECK(command_.pwm_period > command_.dead_time, "PWM period {} ns, dead time {} ns",
                    command_.pwm_period.count(), command_.dead_time.count());
    next_time_event_ = now + command_.pwm_period;
  }
  if (switched() && timed) {
    edges_.start_period(now, command_);
    edges_.run(now);
    next_time_event_ = std::min(edges_.next(), next_time_event_);
    set_gates(edges_.gates());
    return;
  }
  constexpr std::array<Gate, 3> kAllAveraged{Gate::kAveraged, Gate::kAveraged, Gate::kAveraged};
  if (!dead_time && !switched() && command_.legs == std::array<Leg, 3>{}) {
    set_gates(kAllAveraged, command_.duty);
    return;
  }
  std::array<Gate, 3> gates{};
  for (std::size_t leg = 0; leg < 3; ++leg) {
    switch (command_.legs[leg]) {
      case Leg::kDuty:
        gates[leg] = !switched()               ? Gate::kAveraged
                     : command_.duty[leg] == 1 ? Gate::kHigh
                                               : Gate::kLow;
        break;
      case Leg::kHigh:
        gates[leg] = Gate::kHigh;
        break;
      case Leg::kLow:
        gates[leg] = Gate::kLow;
        break;
      case Leg::kHiZ:
        gates[leg] = Gate::kOff;
        break;
    }
  }
  set_gates(gates, dead_time ? effective_duty(command_, phase_currents(), bus_v,
                                              model.winding.least_inductance_h(),
                                              parameters.inverter.diode_v)
                             : command_.duty);
}

void AxisUnit::short_circuit(SimTime now) {
  VIRTDRIVE_CHECK(command_.short_share >= 0 && command_.short_share <= 1, "short_share {}",
                  command_.short_share);
  shorted_part_ = true;
  if (command_.short_share < 1) {
    VIRTDRIVE_CHECK(command_.pwm_period > SimDuration{0}, "PWM period {} ns",
                    command_.pwm_period.count());
    const SimDuration shorted = from_seconds(seconds(command_.pwm_period) * command_.short_share);
    next_time_event_ = command_at_ + shorted;
    if (shorted == SimDuration{0}) {
      set_gates({});
      shorted_part_ = false;
      next_time_event_ = now + command_.pwm_period;
      return;
    }
  }
  set_gates({Gate::kLow, Gate::kLow, Gate::kLow});
}

void AxisUnit::set_gates(const std::array<Gate, 3>& gates, const PhaseValues& share) {
  // Only a half bridge that loses its gates asks for its current.
  const bool all_on = std::ranges::find(gates, Gate::kOff) == gates.end() && bridges.healthy();
  bridges.set_gates(gates, share, all_on ? PhaseValues{} : phase_currents());
  follow_bridges();
}

void AxisUnit::follow_bridges() {
  model.connection = bridges.connection();
  model.drop_blocked_current(x);
}

bool AxisUnit::follow(double bus_v) {
  bool changed = false;
  if (bridges.watched()) {
    const AxisModel::Phases p = model.phases(bridges, x, bus_v);
    if (bridges.margin(p.current_a, p.terminal_v, bus_v) <= 0 &&
        bridges.follow(p.current_a, p.terminal_v, bus_v)) {
      follow_bridges();
      changed = true;
    }
  }
  if (model.shaft_margin(x) <= 0) {
    model.shaft.follow(x + AxisModel::kShaft, torque(), drag());
    changed = true;
  }
  return changed;
}

bool AxisUnit::at_rest() const {
  return command_.mode == Bridge::kOff && next_step_at_ == kNever &&
         model.connection.conduction == Conduction::kOpen &&
         model.connection.short_conductance == 0 && model.shaft.at_rest(x + AxisModel::kShaft) &&
         (model.shaft.motion == Motion::kStuck || torque() == 0) && model.without_flux(x);
}

Circuit::Circuit(const DcLinkParameters& parameters, Integrator integrator, double tol)
    : link(parameters),
      link_states(static_cast<std::size_t>(link.states())),
      tolerance(tol),
      x(link_states),
      solver(integrator) {
  x[DcLink::kVoltage] = parameters.source_v;
  if (link.has_chopper()) x[DcLink::kChopperDegc] = parameters.chopper.ambient_degc;
  choose_active();
}

AxisUnit& Circuit::add(const AxisParameters& parameters, const Load& load) {
  AxisUnit& unit = *units.emplace_back(std::make_unique<AxisUnit>(parameters, load));
  std::size_t most = link_states;
  for (const auto& each : units) most += each->own_states.size();
  if (most > kMostStates) {
    throw SetupError(
        fmt::format("DC bus: {} axes are too many for one link ({} states, at most "
                    "{}); give some a link of their own",
                    units.size(), most, kMostStates));
  }
  add_tolerances(unit, tolerance, unit.relative, unit.absolute);
  choose_active();
  return unit;
}

/// Axes that rest leave the vector, those that have woken enter it.
void Circuit::choose_active() {
  bool same = !relative.empty();
  for (const auto& unit : units) same = same && unit->active != unit->at_rest();
  if (!same) {
    for (AxisUnit* unit : active) {
      std::copy_n(unit->x, unit->own_states.size(), unit->own_states.data());
      unit->x = unit->own_states.data();
    }
    active.clear();
    x.resize(link_states);
    relative = {tolerance};
    absolute = {tolerance * std::max(1.0, link.p.source_v)};
    while (relative.size() < link_states) {
      relative.push_back(tolerance);
      absolute.push_back(tolerance);
    }
    thermal = false;
    for (const auto& unit : units) {
      unit->active = !unit->at_rest();
      if (!unit->active) continue;
      active.push_back(unit.get());
      x.insert(x.end(), unit->own_states.begin(), unit->own_states.end());
      relative.insert(relative.end(), unit->relative.begin(), unit->relative.end());
      absolute.insert(absolute.end(), unit->absolute.begin(), unit->absolute.end());
      thermal = thermal || unit->model.thermal();
    }
    std::size_t at = link_states;
    for (AxisUnit* unit : active) {
      unit->x = x.data() + at;
      at += unit->own_states.size();
    }
  }
  settled = active.empty() && link.settle(x.data());
}

void Circuit::inputs_changed(AxisUnit* unit) {
  for (int i = 0; i < kEventsAtOneInstant; ++i) {
    if (!follow() && (unit == nullptr || unit->active || !unit->follow(bus_v()))) break;
  }
  choose_active();
}

bool Circuit::follow() {
  bool changed = link.follow(x.data());
  for (AxisUnit* unit : active) changed = unit->follow(bus_v()) || changed;
  return changed;
}

void Circuit::advance_to(SimTime t) {
  VIRTDRIVE_CHECK(t >= now, "axis at {} ns asked to go back to {} ns",
                  now.time_since_epoch().count(), t.time_since_epoch().count());
  while (now < t) {
    SimTime until = t;
    bool event_due = false;
    for (AxisUnit* unit : active) {
      if (unit->next_time_event() <= now) {
        unit->take_time_event(now, bus_v());
        event_due = true;
      }
      until = std::min(until, unit->next_time_event());
    }
    if (event_due) {
      inputs_changed();
      continue;
    }
    if (thermal) {
      until = std::min(until, now + kThermalStep);
      for (AxisUnit* unit : active) {
        if (unit->model.thermal()) unit->update_temperatures();
      }
    }
    if (link.mains.any() && !at_rest()) until = std::min(until, now + next_corner());
    const double duration_s = seconds(until - now);
    for (const auto& unit : units) {
      if (!unit->active) unit->rest(duration_s);
    }
    if (at_rest()) {
      link.rest(x.data(), duration_s);
    } else {
      integrate(duration_s);
    }
    now = until;
  }
}

void Circuit::integrate(double duration_s) {
  int at_one_instant = 0;
  double left = duration_s;
  while (left > 0) {
    held = at_one_instant > kEventsAtOneInstant;
    if (held) ++counters.stalled;
    const double part = held ? std::min(left, kMovedOnS) : left;
    const OdeOutcome outcome = solver.advance(*this, x.data(), part);
    left = outcome.elapsed_s < left ? left - outcome.elapsed_s : 0;
    if (outcome.elapsed_s > kOneInstantS) at_one_instant = 0;
    // One event can call for the next at once: a diode that turns off leaves its phase beyond the
    // other rail.
    while (outcome.event && at_one_instant <= kEventsAtOneInstant && follow()) {
      ++counters.state_events;
      ++at_one_instant;
    }
  }
  held = false;
  for (AxisUnit* unit : active) unit->tidy();
  if (axes_without_current()) {
    if (!active.empty()) link.settle(x.data());
    choose_active();
  }
}

bool Circuit::axes_without_current() const {
  for (const AxisUnit* unit : active) {
    if (unit->model.connection.conduction != Conduction::kOpen) return false;
  }
  return true;
}

void Circuit::set_source(double source_v, bool on) {
  link.set_source(x.data(), source_v, on);
  inputs_changed();
}

void Circuit::set_mains(const MainsInput& input) {
  link.mains.set_input(input);
  inputs_changed();
}

void Circuit::set_chopper(bool enabled) {
  link.set_chopper(enabled);
  inputs_changed();
}

/// Of the mains, at least a nanosecond away.
SimDuration Circuit::next_corner() const {
  return std::max(from_seconds(link.next_corner_s(x.data())), SimDuration{1});
}

double Circuit::source_current() const {
  double bridge_a = 0;
  for (const AxisUnit* unit : active) {
    bridge_a += unit->model.electrical(unit->x, bus_v()).bridge_a;
  }
  return link.source_current(x.data(), bridge_a);
}

}  // namespace virtdrive
