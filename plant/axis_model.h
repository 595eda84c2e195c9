// One axis between two events: winding, bridge and shaft as they are held, and the derivative.
//
// States: two of the winding (dq; of an induction machine alpha, beta), the shaft's (2 or 4), with
// a thermal model two temperatures, of an induction machine the main flux (2).
#pragma once

#include <cmath>
#include <limits>

#include "plant/half_bridges.h"
#include "plant/machine.h"
#include "plant/shaft.h"

namespace virtdrive {

struct AxisModel {
  /// An induction machine's field turns by 0.1 rad in this at 64 Hz; its leakage is slower.
  static constexpr double kCageStepS = 250e-6;
  static constexpr int kD = 0, kQ = 1, kShaft = 2, kSpeed = 2, kAngle = 3;

  /// What the winding does at a state.
  struct Electrical {
    Winding::Point point{};
    Dq state_rate;
    Dq main_flux_rate;      // of an induction machine
    Dq cage_emf_v;          // the same while the stator's current is held
    Dq beyond_sine;         // of the EMF's shape
    double bridge_a = 0;    // out of the link
    double floating_v = 0;  // Conduction::kSeries: voltage of the floating terminal, by the others'
  };

  AxisModel(const Winding& w, const Shaft& s) : winding(w), shaft(s) {}

  int states() const { return flux_at() + (winding.cage() ? 2 : 0); }
  int flux_at() const { return temperatures_at() + (thermal() ? 2 : 0); }
  int temperatures_at() const { return kShaft + shaft.states(); }
  bool thermal() const { return winding.effects.thermal.winding_housing_k_per_w > 0; }

  double electrical_angle(const double* x) const { return winding.motor.pole_pairs * x[kAngle]; }
  double electrical_speed(const double* x) const { return winding.motor.pole_pairs * x[kSpeed]; }
  /// The frame of the winding's state: turns with the rotor, or is held by the brushes, with q
  /// along a - b.
  Rotation frame(const double* x) const {
    if (winding.effects.commutator) return brushes();
    if (winding.cage()) return {};
    return Rotation(electrical_angle(x));
  }
  double frame_speed(const double* x) const {
    return winding.effects.commutator || winding.cage() ? 0 : electrical_speed(x);
  }

  Electrical electrical(const double* x, double bus_v) const {
    return electrical(x, bus_v, [&] { return frame(x); });
  }
  /// `rotation()` gives the frame where it is needed.
  template <class Frame>
  [[gnu::always_inline]] Electrical electrical(const double* x, double bus_v,
                                               const Frame& rotation) const;
  [[gnu::always_inline]] double torque(const Electrical& e, const double* x) const;
  double torque(const double* x) const;
  /// Dry friction by hysteresis of the iron.
  double drag(const Winding::Point& p) const {
    const double factor = winding.effects.iron_hysteresis_w;
    if (factor == 0) return 0;
    return factor * winding.motor.pole_pairs *
           (p.flux_wb.d * p.flux_wb.d + p.flux_wb.q * p.flux_wb.q);
  }

  /// dx/dt of the axis' states; returns its current out of the link.
  double derivative(const double* x, double bus_v, double* dx) const;

  PhaseValues phase_currents(const double* x) const { return phase_currents(x, frame(x)); }
  PhaseValues phase_currents(const double* x, const Rotation& r) const;
  /// Both, as far as the half bridges ask for them: what their modes are judged by.
  struct Phases {
    PhaseValues current_a{}, terminal_v{};
  };
  Phases phases(const HalfBridges& bridges, const double* x, double bus_v) const {
    const Rotation r = frame(x);
    return {phase_currents(x, r),
            bridges.looks_at_voltages() ? terminal_voltages(x, bus_v, r) : PhaseValues{}};
  }
  /// Terminal voltages, up to a common one where nothing ties them to a rail.
  PhaseValues terminal_voltages(const double* x, double bus_v) const {
    return terminal_voltages(x, bus_v, frame(x));
  }
  PhaseValues terminal_voltages(const double* x, double bus_v, const Rotation& r) const;
  Dq current(const double* x) const { return point(x).current_a; }
  Dq main_flux(const double* x) const { return {x[flux_at()], x[flux_at() + 1]}; }
  Winding::Point point(const double* x) const {
    return winding.cage() ? cage_point(x, cage_at(x)) : winding.at({x[kD], x[kQ]});
  }

  bool watched(const HalfBridges& bridges) const { return bridges.watched() || shaft.watched(); }
  double margin(const HalfBridges& bridges, const double* x, double bus_v) const;
  double shaft_margin(const double* x) const;
  double step_limit_s(const double* x, double bus_v) const {
    const double turn = connection.conduction == Conduction::kOpen ? open_turn_rad(x, bus_v) : 0.1;
    return std::min({winding.cage() ? kCageStepS : 50e-6, winding.step_limit_s(),
                     shaft.step_limit_s(), turn / (std::fabs(electrical_speed(x)) + 1)});
  }
  double next_kink_s(const double* x) const {
    return winding.corner_distance_rad() == 0 ? std::numeric_limits<double>::infinity()
                                              : next_corner_s(x);
  }
  /// Takes away the current that the connection does not allow: rounding after a diode's event,
  /// all of it when a wire breaks.
  void drop_blocked_current(double* x) const;
  /// What is left of a field that nothing feeds any more.
  void drop_last_flux(double* x) const;
  bool without_flux(const double* x) const {
    return !winding.cage() || (x[flux_at()] == 0 && x[flux_at() + 1] == 0);
  }

  Winding winding;
  Shaft shaft;
  Connection connection;

 private:
  SquirrelCage::Point cage_at(const double* x) const {
    return winding.cage()->at({x[kD], x[kQ]}, main_flux(x), electrical_speed(x));
  }
  Winding::Point cage_point(const double* x, const SquirrelCage::Point& cage) const {
    const double leakage = winding.cage()->parameters.stator_leakage_h;
    const Dq psi = main_flux(x);
    return {{x[kD], x[kQ]}, {psi.d + leakage * x[kD], psi.q + leakage * x[kQ]},
            cage.dd,        cage.dq,
            cage.dq,        cage.qq};
  }
  static Rotation brushes() {
    Rotation r;
    r.cosine = -0.5;
    r.sine = -std::numbers::sqrt3 / 2;
    return r;
  }
  double hold_floating_phase(const double* x, const Rotation& r, const Winding::Point& p,
                             Dq& flux_rate) const;
  double cogging_and_iron(const Winding::Point& p, const double* x) const;
  double open_turn_rad(const double* x, double bus_v) const;
  double next_corner_s(const double* x) const;
  void heat(const double* x, const Winding::Point& p, double* dx) const;
  Dq emf(const double* x, const Winding::Point& p, Dq beyond_sine) const {
    const double w = electrical_speed(x), frame = frame_speed(x);
    // With a commutator only the magnets' flux cuts the winding.
    if (winding.effects.commutator) {
      return {w * winding.loop.flux_wb * beyond_sine.d,
              w * winding.loop.flux_wb * (1 + beyond_sine.q)};
    }
    return {-frame * p.flux_wb.q + w * winding.loop.flux_wb * beyond_sine.d,
            frame * p.flux_wb.d + w * winding.loop.flux_wb * beyond_sine.q};
  }
};

template <class Frame>
inline AxisModel::Electrical AxisModel::electrical(const double* x, double bus_v,
                                                   const Frame& rotation) const {
  Electrical e;
  const bool cage = winding.cage() != nullptr;
  if (cage) {
    const SquirrelCage::Point rotor = cage_at(x);
    e.point = cage_point(x, rotor);
    e.cage_emf_v = e.main_flux_rate = rotor.emf_v;
  } else {
    e.point = winding.at({x[kD], x[kQ]});
  }
  if (connection.conduction == Conduction::kOpen) return e;
  const Dq i = e.point.current_a;
  const double resistance = winding.loop.resistance_ohm;
  Dq flux_rate{-resistance * i.d, -resistance * i.q};
  if (connection.driving || !winding.sinusoidal()) {
    const Rotation r = rotation();
    if (!winding.sinusoidal()) e.beyond_sine = winding.emf_beyond_sine(electrical_angle(x), r);
    const Dq share = park(connection.share, r);
    const Dq emf_v = cage ? e.cage_emf_v : emf(x, e.point, e.beyond_sine);
    flux_rate.d += bus_v * share.d - emf_v.d;
    flux_rate.q += bus_v * share.q - emf_v.q;
    if (connection.offset) {
      const Dq offset = park(connection.offset_v, r);
      flux_rate.d += offset.d;
      flux_rate.q += offset.q;
    }
    // Terminal power balance: the link gives what the terminals take.
    e.bridge_a = 1.5 * (share.d * i.d + share.q * i.q);
    if (connection.conduction == Conduction::kSeries) {
      e.floating_v = hold_floating_phase(x, r, e.point, flux_rate);
    }
  } else {
    const Dq emf_v = cage ? e.cage_emf_v : emf(x, e.point, {});
    flux_rate.d -= emf_v.d;
    flux_rate.q -= emf_v.q;
  }
  e.bridge_a += connection.short_conductance * bus_v;
  if (connection.loss_share > 0) e.bridge_a += connection.loss_share * std::hypot(i.d, i.q);
  e.state_rate = winding.state_rate(e.point, flux_rate);
  if (cage) {
    const double leakage = winding.cage()->parameters.stator_leakage_h;
    e.main_flux_rate.d += flux_rate.d - leakage * e.state_rate.d;
    e.main_flux_rate.q += flux_rate.q - leakage * e.state_rate.q;
  }
  return e;
}

inline double AxisModel::torque(const Electrical& e, const double* x) const {
  const Winding::Point& p = e.point;
  const MachineEffects& effects = winding.effects;
  double torque = 0;
  if (connection.conduction != Conduction::kOpen) {
    const Dq i = p.current_a;
    double flux_times_i = winding.loop.flux_wb * (e.beyond_sine.d * i.d + e.beyond_sine.q * i.q);
    flux_times_i +=
        effects.commutator ? winding.loop.flux_wb * i.q : p.flux_wb.d * i.q - p.flux_wb.q * i.d;
    torque = 1.5 * winding.motor.pole_pairs * flux_times_i;
  }
  if (winding.shaft_effects()) torque += cogging_and_iron(p, x);
  return torque;
}

inline double AxisModel::derivative(const double* x, double bus_v, double* dx) const {
  if (winding.plain() && connection.plain) {
    // What most axes are most of the time, without the general winding's generality.
    const Dq i{x[kD], x[kQ]};
    const Dq share = park(connection.share, Rotation(electrical_angle(x)));
    const Dq slope = current_derivative(winding.loop, i, {bus_v * share.d, bus_v * share.q},
                                        electrical_speed(x));
    dx[kD] = slope.d;
    dx[kQ] = slope.q;
    shaft.derivative(x + kShaft, torque_nm(winding.loop, i), 0, dx + kShaft);
    return 1.5 * (share.d * i.d + share.q * i.q);
  }
  const Electrical e = electrical(x, bus_v);
  dx[kD] = e.state_rate.d;
  dx[kQ] = e.state_rate.q;
  shaft.derivative(x + kShaft, torque(e, x), drag(e.point), dx + kShaft);
  if (thermal()) heat(x, e.point, dx);
  if (winding.cage()) {
    dx[flux_at()] = e.main_flux_rate.d;
    dx[flux_at() + 1] = e.main_flux_rate.q;
  }
  return e.bridge_a;
}

}  // namespace virtdrive
