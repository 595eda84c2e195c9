#include "plant/axis.h"

#include <cmath>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr int kEventsAtOneInstant = 16;
constexpr double kOneInstantS = 1e-12;
constexpr double kMovedOnS = 100e-9;

/// How the currents are led.
enum class Conduction : std::uint8_t {
  kTerminals,  // three terminal voltages are given
  kSeries,     // one phase floats, the two others conduct in series
  kOpen,       // no current
};

/// The continuous part between two events: constants, held inputs and modes, and the derivative.
struct Machine {
  static constexpr int kStates = 5;
  static constexpr int kRoots = 5;
  enum State { kId, kIq, kSpeed, kAngle, kBus };
  enum Root { kPhaseA, kPhaseB, kPhaseC, kMotion, kSource };
  using Vector = std::array<double, kStates>;

  PmsmParameters motor;
  double inverse_inertia = 0, viscous = 0, quadratic = 0;
  double friction_nm = 0, external_nm = 0;
  bool ideal_source = false;
  double source_v = 0, source_conductance = 0, inverse_capacitance = 0;
  double electrical_step_s = 0, link_step_s = 0;  // what limits the fast path's step

  Conduction conduction = Conduction::kOpen;
  bool moved_by_bus = false;  // any terminal away from the lower rail
  AlphaBeta terminals;        // terminal voltages as shares of the bus voltage
  AlphaBeta floating_axis;    // direction of the floating phase
  bool freewheeling = false;
  BodyDiodes diodes;
  Motion motion = Motion::kFree;
  bool source_feeds = true;
  bool held = false;  // the modes are held whatever the roots say

  struct Electrical {
    Dq derivative;
    double bridge_a = 0;  // out of the link
  };

  double electrical_speed(const double* x) const { return motor.pole_pairs * x[kSpeed]; }
  Rotation rotation(const double* x) const { return Rotation(motor.pole_pairs * x[kAngle]); }

  Electrical electrical(const double* x) const {
    const Dq current{x[kId], x[kIq]};
    if (conduction == Conduction::kOpen) return {};
    if (!moved_by_bus && conduction == Conduction::kTerminals) {
      return {current_derivative(motor, current, {}, electrical_speed(x)), 0};
    }
    const Rotation r = rotation(x);
    const Dq share = park(terminals, r);
    const Dq voltage{x[kBus] * share.d, x[kBus] * share.q};
    // Terminal power balance: the link gives what the terminals take.
    const double bridge_a = 1.5 * (share.d * current.d + share.q * current.q);
    Dq slope = current_derivative(motor, current, voltage, electrical_speed(x));
    if (conduction == Conduction::kSeries) hold_floating_phase(x, r, slope);
    return {slope, bridge_a};
  }

  /// Adds the floating terminal's voltage: the one that keeps its phase current, i.u with u the
  /// phase's axis in dq, where it is. d(i.u)/dt = u.di/dt + i.du/dt, du/dt = we (u.q, -u.d), and
  /// the voltage acts along u with 2/3 of itself.
  void hold_floating_phase(const double* x, const Rotation& r, Dq& slope) const {
    const Dq u = park(floating_axis, r);
    const double drift =
        u.d * slope.d + u.q * slope.q + electrical_speed(x) * (u.q * x[kId] - u.d * x[kIq]);
    const double gain = u.d * u.d / motor.inductance_d_h + u.q * u.q / motor.inductance_q_h;
    slope.d -= drift / gain * u.d / motor.inductance_d_h;
    slope.q -= drift / gain * u.q / motor.inductance_q_h;
  }

  double motor_torque(const double* x) const {
    return conduction == Conduction::kOpen ? 0 : torque_nm(motor, {x[kId], x[kIq]});
  }
  double driving_torque(const double* x) const { return motor_torque(x) - external_nm; }

  double source_current(const double* x) const {
    return source_feeds ? std::max(0.0, (source_v - x[kBus]) * source_conductance) : 0;
  }

  void derivative(const double* x, double* dx) const {
    const Electrical e = electrical(x);
    dx[kId] = e.derivative.d;
    dx[kIq] = e.derivative.q;
    const double speed = x[kSpeed];
    dx[kSpeed] = motion == Motion::kStuck
                     ? 0
                     : (driving_torque(x) - (viscous + quadratic * std::fabs(speed)) * speed -
                        direction(motion) * friction_nm) *
                           inverse_inertia;
    dx[kAngle] = speed;
    dx[kBus] = ideal_source ? 0 : (source_current(x) - e.bridge_a) * inverse_capacitance;
  }

  bool watched() const {
    return !held && (motion != Motion::kFree || freewheeling || !ideal_source);
  }

  /// Friction beyond which a stuck shaft breaks away: a hair above the friction that stops it.
  double breakaway_nm() const { return friction_nm * (1 + 1e-9); }

  void roots(const double* x, double* g) const {
    std::fill_n(g, kRoots, 1.0);
    if (held) return;
    if (freewheeling && conduction != Conduction::kOpen) diode_roots(x, g);
    if (motion == Motion::kStuck) {
      g[kMotion] = breakaway_nm() - std::fabs(driving_torque(x));
    } else if (motion != Motion::kFree) {
      g[kMotion] = direction(motion) * x[kSpeed];
    }
    if (!ideal_source) {
      const double above = x[kBus] - source_v;
      g[kSource] = kSourceHysteresisV + (source_feeds ? -above : above);
    }
  }

  void diode_roots(const double* x, double* g) const {
    const PhaseValues current = inverse_clarke(inverse_park({x[kId], x[kIq]}, rotation(x)));
    for (int phase = 0; phase < 3; ++phase) {
      const double i = current[static_cast<std::size_t>(phase)];
      if (diodes[phase] != Diode::kBlocked) {
        g[kPhaseA + phase] = diodes[phase] == Diode::kLower ? i : -i;
      }
    }
  }

  /// Half of a link's time constant etc. keep RK4 stable; the rest is accuracy (0.1 rad of the
  /// rotor's turn, a fifth of the electrical time constant).
  double step_limit_s(const double* x) const {
    return std::min(
        {50e-6, electrical_step_s, link_step_s, 0.1 / (std::fabs(electrical_speed(x)) + 1)});
  }
};

double inverse_or_zero(double x) {
  return x == 0 ? 0 : 1 / x;
}

double positive_or_endless(double x) {
  return x > 0 ? x : std::numeric_limits<double>::infinity();
}

/// Errors are judged against the motor's own size: 1e-6 of the rated current, of a volt, ...
OdeTolerances<Machine::kStates> tolerances(const AxisParameters& p) {
  const double current = 1e-7 * p.motor.rated_current_a;
  return {.relative = {1e-6, 1e-6, 1e-6, 0, 1e-6},
          .absolute = {current, current, 1e-5, 1e-6, 1e-6 * std::max(1.0, p.link.source_v)}};
}

void validate(const AxisParameters& p, const Load& load) {
  validate(p.motor);
  validate(p.link);
  validate(p.mechanics);
  validate(load);
}

}  // namespace

struct Axis::Impl {
  Impl(const AxisParameters& p, Integrator integrator, const Load& initial_load);

  void advance_to(SimTime t);
  void set_bridge(const BridgeCommand& command);
  void set_load(const Load& new_load);
  void set_source_voltage(double source_v);
  bool at_rest() const;
  PhaseValues phase_currents() const;

  AxisParameters parameters;
  Load load;
  Machine machine;
  OdeSolver<Machine> solver;
  Machine::Vector x{};
  AxisState state;
  SimTime now = kSimStart;
  AxisCounters counters;

 private:
  void integrate(double duration_s);
  void handle(std::uint32_t fired);
  void take_time_event();
  void drive();
  void short_circuit();
  void gates_off();
  void block(int phase);
  void follow_diodes();
  void hold_blocked_phase_at_zero();
  void decide_motion();
  void decide_source();
  void publish();

  BridgeCommand command_;
  SimTime command_at_ = kSimStart;  // start of the PWM period in progress
  SimTime next_time_event_ = kNever;
  bool shorted_part_ = false;  // of a pulsed short's period
};

Axis::Impl::Impl(const AxisParameters& p, Integrator integrator, const Load& initial_load)
    : parameters((validate(p, initial_load), p)), solver(integrator, tolerances(p)) {
  machine.motor = p.motor;
  machine.ideal_source = is_ideal(p.link);
  machine.source_conductance = inverse_or_zero(p.link.resistance_ohm);
  machine.inverse_capacitance = 1 / p.link.capacitance_f;
  const double least_inductance = std::min(p.motor.inductance_d_h, p.motor.inductance_q_h);
  machine.electrical_step_s =
      positive_or_endless(least_inductance * inverse_or_zero(p.motor.resistance_ohm) / 5);
  machine.link_step_s = positive_or_endless(p.link.resistance_ohm * p.link.capacitance_f / 2);
  x[Machine::kBus] = p.link.source_v;
  machine.source_v = p.link.source_v;
  set_load(initial_load);
  publish();
}

void Axis::Impl::advance_to(SimTime t) {
  VIRTDRIVE_CHECK(t >= now, "axis at {} ns asked to go back to {} ns",
                  now.time_since_epoch().count(), t.time_since_epoch().count());
  while (now < t) {
    if (at_rest()) {
      now = t;
      break;
    }
    if (now == next_time_event_) take_time_event();
    const SimTime until = std::min(t, next_time_event_);
    integrate(seconds(until - now));
    now = until;
  }
  publish();
}

void Axis::Impl::integrate(double duration_s) {
  int at_one_instant = 0;
  double left = duration_s;
  while (left > 0) {
    machine.held = at_one_instant > kEventsAtOneInstant;
    if (machine.held) {
      ++counters.stalled;
      at_one_instant = 0;
    }
    const double part = machine.held ? std::min(left, kMovedOnS) : left;
    const OdeOutcome outcome = solver.advance(machine, x, part);
    left = outcome.elapsed_s < left ? left - outcome.elapsed_s : 0;
    if (outcome.fired != 0) {
      handle(outcome.fired);
      ++counters.state_events;
      at_one_instant = outcome.elapsed_s < kOneInstantS ? at_one_instant + 1 : 0;
    }
  }
  machine.held = false;
  if (machine.conduction == Conduction::kSeries) hold_blocked_phase_at_zero();
  if (std::fabs(machine.source_v - x[Machine::kBus]) < kSourceHysteresisV &&
      machine.conduction == Conduction::kOpen) {
    x[Machine::kBus] = machine.source_v;
  }
}

void Axis::Impl::handle(std::uint32_t fired) {
  for (int phase = 0; phase < 3; ++phase) {
    if ((fired >> (Machine::kPhaseA + phase) & 1U) != 0) block(phase);
  }
  if ((fired >> Machine::kMotion & 1U) != 0) {
    // Either the shaft has just stopped, or it stood and now breaks away: it is at 0 both times.
    x[Machine::kSpeed] = 0;
    decide_motion();
  }
  if ((fired >> Machine::kSource & 1U) != 0) machine.source_feeds = !machine.source_feeds;
}

void Axis::Impl::take_time_event() {
  ++counters.time_events;
  if (command_.mode == Bridge::kDriven) {
    command_at_ = now;
    drive();
  } else if (shorted_part_) {
    gates_off();
    shorted_part_ = false;
    next_time_event_ = command_at_ + command_.pwm_period;
  } else {
    command_at_ = now;
    short_circuit();
  }
}

void Axis::Impl::set_bridge(const BridgeCommand& command) {
  const bool stays_off = command.mode == Bridge::kOff && command_.mode == Bridge::kOff;
  command_ = command;
  if (stays_off) return;
  command_at_ = now;
  next_time_event_ = kNever;
  switch (command.mode) {
    case Bridge::kOff:
      gates_off();
      break;
    case Bridge::kShort:
      short_circuit();
      break;
    case Bridge::kDriven:
      drive();
      break;
  }
  publish();
}

void Axis::Impl::drive() {
  for (const double duty : command_.duty) {
    VIRTDRIVE_CHECK(duty >= 0 && duty <= 1, "duty {}", duty);
  }
  const bool dead_time = command_.dead_time > SimDuration{0};
  if (dead_time) {
    VIRTDRIVE_CHECK(command_.pwm_period > command_.dead_time, "PWM period {} ns, dead time {} ns",
                    command_.pwm_period.count(), command_.dead_time.count());
    next_time_event_ = command_at_ + command_.pwm_period;
  }
  const PmsmParameters& motor = machine.motor;
  machine.terminals =
      clarke(dead_time ? effective_duty(command_, phase_currents(), x[Machine::kBus],
                                        std::min(motor.inductance_d_h, motor.inductance_q_h))
                       : command_.duty);
  machine.moved_by_bus = true;
  machine.freewheeling = false;
  machine.conduction = Conduction::kTerminals;
}

void Axis::Impl::short_circuit() {
  VIRTDRIVE_CHECK(command_.short_share >= 0 && command_.short_share <= 1, "short_share {}",
                  command_.short_share);
  shorted_part_ = true;
  if (command_.short_share < 1) {
    VIRTDRIVE_CHECK(command_.pwm_period > SimDuration{0}, "PWM period {} ns",
                    command_.pwm_period.count());
    const SimDuration shorted = from_seconds(seconds(command_.pwm_period) * command_.short_share);
    next_time_event_ = command_at_ + shorted;
    if (shorted == SimDuration{0}) {
      take_time_event();
      return;
    }
  }
  machine.terminals = {};
  machine.moved_by_bus = false;
  machine.freewheeling = false;
  machine.conduction = Conduction::kTerminals;
}

void Axis::Impl::gates_off() {
  machine.diodes.take_over(phase_currents());
  machine.freewheeling = true;
  follow_diodes();
}

void Axis::Impl::block(int phase) {
  if (machine.diodes[phase] == Diode::kBlocked) return;  // together with another one
  machine.diodes.block(phase);
  follow_diodes();
}

void Axis::Impl::follow_diodes() {
  const int floating = machine.diodes.floating();
  const int conducting = machine.diodes.conducting();
  machine.conduction = conducting == 3   ? Conduction::kTerminals
                       : conducting == 2 ? Conduction::kSeries
                                         : Conduction::kOpen;
  machine.terminals = clarke(machine.diodes.upper());
  machine.moved_by_bus = conducting > 0;
  if (floating >= 0) {
    PhaseValues unit{};
    unit[static_cast<std::size_t>(floating)] = 1.5;  // Clarke makes it a unit vector
    machine.floating_axis = clarke(unit);
  }
  hold_blocked_phase_at_zero();
}

void Axis::Impl::hold_blocked_phase_at_zero() {
  if (machine.conduction == Conduction::kTerminals) return;
  if (machine.conduction == Conduction::kSeries) {
    const Rotation r = machine.rotation(x.data());
    const Dq u = park(machine.floating_axis, r);
    const double rest = x[Machine::kId] * u.d + x[Machine::kIq] * u.q;
    x[Machine::kId] -= rest * u.d;
    x[Machine::kIq] -= rest * u.q;
    const double left_a = std::hypot(x[Machine::kId], x[Machine::kIq]) * std::numbers::sqrt3 / 2;
    if (left_a > BodyDiodes::kZeroCurrentA) return;
    machine.diodes = {};
    machine.conduction = Conduction::kOpen;
    machine.moved_by_bus = false;
  }
  x[Machine::kId] = x[Machine::kIq] = 0;
}

void Axis::Impl::set_load(const Load& new_load) {
  validate(new_load);
  load = new_load;
  const MechanicsParameters& rotor = parameters.mechanics;
  machine.inverse_inertia = 1 / (rotor.inertia_kgm2 + load.inertia_kgm2);
  machine.viscous = rotor.viscous_nm_per_radps + load.viscous_nm_per_radps;
  machine.quadratic = load.quadratic_nm_per_radps2;
  machine.friction_nm = rotor.coulomb_nm + load.brake_torque_nm;
  machine.external_nm = load.external_torque_nm;
  decide_motion();
}

void Axis::Impl::decide_motion() {
  machine.motion =
      motion_of(x[Machine::kSpeed], machine.driving_torque(x.data()), machine.friction_nm);
}

void Axis::Impl::set_source_voltage(double source_v) {
  DcLinkParameters link = parameters.link;
  link.source_v = source_v;
  validate(link);
  parameters.link = link;
  machine.source_v = source_v;
  if (machine.ideal_source) x[Machine::kBus] = source_v;
  machine.source_feeds = x[Machine::kBus] <= source_v;
  publish();
}

bool Axis::Impl::at_rest() const {
  const bool still =
      x[Machine::kSpeed] == 0 && (machine.motion == Motion::kStuck ||
                                  (machine.motion == Motion::kFree && machine.external_nm == 0));
  const bool settled = machine.ideal_source || x[Machine::kBus] >= machine.source_v;
  return command_.mode == Bridge::kOff && machine.conduction == Conduction::kOpen && still &&
         settled;
}

PhaseValues Axis::Impl::phase_currents() const {
  if (x[Machine::kId] == 0 && x[Machine::kIq] == 0) return {};
  return inverse_clarke(
      inverse_park({x[Machine::kId], x[Machine::kIq]}, machine.rotation(x.data())));
}

void Axis::Impl::publish() {
  state = {x[Machine::kId], x[Machine::kIq], x[Machine::kSpeed], x[Machine::kAngle],
           x[Machine::kBus]};
}

Axis::Axis(const AxisParameters& parameters, Integrator integrator, const Load& load)
    : impl_(std::make_unique<Impl>(parameters, integrator, load)) {}
Axis::Axis(Axis&&) noexcept = default;
Axis& Axis::operator=(Axis&&) noexcept = default;
Axis::~Axis() = default;

void Axis::advance_to(SimTime t) {
  impl_->advance_to(t);
}
SimTime Axis::now() const {
  return impl_->now;
}
void Axis::set_bridge(const BridgeCommand& command) {
  impl_->set_bridge(command);
}
void Axis::set_load(const Load& load) {
  impl_->set_load(load);
}
void Axis::set_source_voltage(double source_v) {
  impl_->set_source_voltage(source_v);
}
const AxisState& Axis::state() const {
  return impl_->state;
}
const AxisParameters& Axis::parameters() const {
  return impl_->parameters;
}
const Load& Axis::load() const {
  return impl_->load;
}
PhaseValues Axis::phase_currents_a() const {
  return impl_->phase_currents();
}
double Axis::torque_nm() const {
  return impl_->machine.motor_torque(impl_->x.data());
}

double Axis::load_torque_nm() const {
  const Machine& m = impl_->machine;
  const Load& load = impl_->load;
  const double speed = impl_->state.speed_radps;
  const double driving = m.driving_torque(impl_->x.data());
  // Brake and Coulomb friction together hold or oppose; the brake has its share of it.
  const double dry = m.motion == Motion::kStuck ? driving : direction(m.motion) * m.friction_nm;
  const double brake = m.friction_nm > 0 ? dry * load.brake_torque_nm / m.friction_nm : 0;
  return load.external_torque_nm + brake +
         (load.viscous_nm_per_radps + load.quadratic_nm_per_radps2 * std::fabs(speed)) * speed;
}

double Axis::source_current_a() const {
  const Machine& m = impl_->machine;
  const double* x = impl_->x.data();
  return m.ideal_source ? m.electrical(x).bridge_a : m.source_current(x);
}

double Axis::electrical_angle_rad() const {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double angle = impl_->machine.motor.pole_pairs * impl_->state.angle_rad;
  const double within = angle - kTurn * std::floor(angle / kTurn);
  return within < kTurn ? within : 0;
}

bool Axis::at_rest() const {
  return impl_->at_rest();
}

AxisCounters Axis::counters() const {
  AxisCounters counters = impl_->counters;
  counters.derivative_evaluations = impl_->solver.derivative_evaluations();
  return counters;
}

}  // namespace virtdrive
