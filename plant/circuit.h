// The axes of one DC link, integrated together: the loop between events.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "plant/axis.h"
#include "plant/axis_model.h"
#include "plant/pwm.h"

namespace virtdrive {

/// An axis as its commands and events change it. Its states lie in the circuit's vector while it is
/// active, in its own while it rests.
class AxisUnit {
 public:
  AxisUnit(const AxisParameters& p, const Load& l);

  void set_bridge(const BridgeCommand& command, SimTime now, double bus_v);
  void set_bridge_faults(const BridgeFaults& faults, SimTime now, double bus_v);
  void set_load(const Load& new_load);
  void set_torque_profile(std::vector<TorqueStep> profile, SimTime now);
  void set_motion(double angle_rad, double speed_radps);
  void set_temperatures(double winding_degc, double magnet_degc);

  SimTime next_time_event() const { return std::min(next_time_event_, next_step_at_); }
  void take_time_event(SimTime now, double bus_v);
  /// Changes what has ended; true if anything did.
  bool follow(double bus_v);
  /// Where an integration ends: takes away what rounding left.
  void tidy() {
    model.drop_blocked_current(x);
    model.drop_last_flux(x);
  }
  void update_temperatures();
  /// Cools for as long as it has rested.
  void rest(double duration_s);

  bool at_rest() const;
  PhaseValues phase_currents() const { return model.phase_currents(x); }
  double torque() const { return model.torque(x); }
  double drag() const { return model.drag(model.point(x)); }
  double winding_degc() const;
  double magnet_degc() const;

  AxisParameters parameters;
  Load load;
  HalfBridges bridges;
  AxisModel model;
  std::vector<double> own_states, relative, absolute;
  double* x = nullptr;  // its states, wherever they are
  bool active = false;
  AxisState published;
  std::uint64_t time_events = 0;

 private:
  void apply(SimTime now, double bus_v);
  void drive(SimTime now, double bus_v);
  void short_circuit(SimTime now);
  void set_gates(const std::array<Gate, 3>& gates, const PhaseValues& share = {});
  void follow_bridges();
  void set_shaft();
  bool switched() const { return parameters.inverter.switched || bridges.needs_edges(); }

  BridgeCommand command_;
  SimTime command_at_ = kSimStart;  // start of the PWM period in progress
  SimTime next_time_event_ = kNever;
  bool shorted_part_ = false;  // of a pulsed short's period
  PwmEdges edges_;
  std::vector<TorqueStep> profile_;
  SimTime profile_start_ = kSimStart;
  std::size_t next_step_ = 0;
  SimTime next_step_at_ = kNever;
  double profile_nm_ = 0;
  double winding_degc_, magnet_degc_;  // without a thermal model
};

struct Circuit {
  Circuit(const DcLinkParameters& parameters, Integrator integrator, double tolerance);

  AxisUnit& add(const AxisParameters& parameters, const Load& load);
  void advance_to(SimTime t);
  /// After any input: modes that have ended by it, and who takes part from now on.
  void inputs_changed(AxisUnit* unit = nullptr);
  void set_source(double source_v, bool on);
  void set_mains(const MainsInput& input);
  void set_chopper(bool enabled);
  double bus_v() const { return x[DcLink::kVoltage]; }
  double source_current() const;
  bool at_rest() const { return active.empty() && settled; }

  // The system that OdeSolver integrates: the link, then the active axes.
  int states() const { return static_cast<int>(x.size()); }
  void derivative(const double* state, double* dx) const {
    const double v = state[DcLink::kVoltage];
    double bridge_a = 0;
    std::size_t at = link_states;
    for (const AxisUnit* unit : active) {
      bridge_a += unit->model.derivative(state + at, v, dx + at);
      at += unit->own_states.size();
    }
    link.derivative(state, bridge_a, dx);
  }
  bool watched() const {
    if (held) return false;
    if (link.watched()) return true;
    for (const AxisUnit* unit : active) {
      if (unit->model.watched(unit->bridges)) return true;
    }
    return false;
  }
  /// A diode may turn on and off again within a step.
  bool short_steps() const {
    return std::ranges::any_of(active, [](const AxisUnit* u) { return u->bridges.watched(); });
  }
  double margin(const double* state) const {
    double least = link.margin(state);
    std::size_t at = link_states;
    for (const AxisUnit* unit : active) {
      least = std::min(least, unit->model.margin(unit->bridges, state + at, state[0]));
      at += unit->own_states.size();
    }
    return least;
  }
  double step_limit_s(const double* state) const {
    double limit = link.step_limit_s();
    std::size_t at = link_states;
    for (const AxisUnit* unit : active) {
      limit = std::min(limit, unit->model.step_limit_s(state + at, state[0]));
      at += unit->own_states.size();
    }
    return limit;
  }
  double next_kink_s(const double* state) const {
    double next = std::numeric_limits<double>::infinity();
    std::size_t at = link_states;
    for (const AxisUnit* unit : active) {
      next = std::min(next, unit->model.next_kink_s(state + at));
      at += unit->own_states.size();
    }
    return next;
  }
  const double* relative_tolerance() const { return relative.data(); }
  const double* absolute_tolerance() const { return absolute.data(); }

  DcLink link;
  std::size_t link_states;
  double tolerance;
  std::vector<std::unique_ptr<AxisUnit>> units;
  std::vector<AxisUnit*> active;
  std::vector<double> x, relative, absolute;
  bool held = false;     // the modes are held whatever the margin says
  bool settled = false;  // the link, while no axis is active
  bool thermal = false;  // some active axis warms up
  OdeSolver<Circuit> solver;
  SimTime now = kSimStart;
  AxisCounters counters;

 private:
  bool follow();
  void integrate(double duration_s);
  void choose_active();
  bool axes_without_current() const;
  SimDuration next_corner() const;
};

}  // namespace virtdrive
