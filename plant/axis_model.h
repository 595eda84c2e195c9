// One axis between two events: winding, bridge and shaft as they are held, and the derivative.
//
// States: two of the winding (dq), the shaft's (2 or 4), with a thermal model two temperatures.
#pragma once

#include <cmath>

#include "plant/half_bridges.h"
#include "plant/machine.h"
#include "plant/shaft.h"

namespace virtdrive {

struct AxisModel {
  static constexpr int kD = 0, kQ = 1, kShaft = 2, kSpeed = 2, kAngle = 3;

  /// What the winding does at a state.
  struct Electrical {
    Winding::Point point{};
    Dq state_rate;
    Dq beyond_sine;         // of the EMF's shape
    double bridge_a = 0;    // out of the link
    double floating_v = 0;  // Conduction::kSeries: voltage of the floating terminal, by the others'
  };

  AxisModel(const Winding& w, const Shaft& s, const InverterParameters& inverter)
      : winding(w), shaft(s), on_resistance_ohm(inverter.on_resistance_ohm) {}

  int states() const { return kShaft + shaft.states() + (thermal() ? 2 : 0); }
  int temperatures_at() const { return kShaft + shaft.states(); }
  bool thermal() const { return winding.effects.thermal.winding_housing_k_per_w > 0; }

  double electrical_angle(const double* x) const { return winding.motor.pole_pairs * x[kAngle]; }
  double electrical_speed(const double* x) const { return winding.motor.pole_pairs * x[kSpeed]; }
  /// The frame of the winding's state: turns with the rotor, or is held by the brushes, with q
  /// along a - b.
  Rotation frame(const double* x) const {
    if (winding.effects.commutator) return brushes();
    return Rotation(electrical_angle(x));
  }
  double frame_speed(const double* x) const {
    return winding.effects.commutator ? 0 : electrical_speed(x);
  }

  Electrical electrical(const double* x, double bus_v) const;
  double torque(const Electrical& e, const double* x) const;
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

  PhaseValues phase_currents(const double* x) const;
  /// Terminal voltages, up to a common one where nothing ties them to a rail.
  PhaseValues terminal_voltages(const double* x, double bus_v) const;
  Dq current(const double* x) const { return winding.at({x[kD], x[kQ]}).current_a; }

  bool watched(const HalfBridges& bridges) const { return bridges.watched() || shaft.watched(); }
  double margin(const HalfBridges& bridges, const double* x, double bus_v) const;
  double step_limit_s(const double* x) const;
  double next_kink_s(const double* x) const;
  /// Takes away the current that the connection does not allow: rounding after a diode's event,
  /// all of it when a wire breaks.
  void drop_blocked_current(double* x) const;

  Winding winding;
  Shaft shaft;
  Connection connection;
  double on_resistance_ohm = 0;

 private:
  static Rotation brushes() {
    Rotation r;
    r.cosine = -0.5;
    r.sine = -std::numbers::sqrt3 / 2;
    return r;
  }
  double hold_floating_phase(const double* x, const Rotation& r, const Winding::Point& p,
                             Dq& flux_rate) const;
  void heat(const double* x, const Winding::Point& p, double* dx) const;
  Dq emf(const double* x, const Winding::Point& p, Dq beyond_sine) const {
    const double w = electrical_speed(x), frame = frame_speed(x);
    // With a commutator only the magnets' flux cuts the winding.
    if (winding.effects.commutator) {
      return {w * winding.flux_wb * beyond_sine.d, w * winding.flux_wb * (1 + beyond_sine.q)};
    }
    return {-frame * p.flux_wb.q + w * winding.flux_wb * beyond_sine.d,
            frame * p.flux_wb.d + w * winding.flux_wb * beyond_sine.q};
  }
};

inline double AxisModel::hold_floating_phase(const double* x, const Rotation& r,
                                             const Winding::Point& p, Dq& flux_rate) const {
  // The floating terminal's voltage is the one that keeps its phase current, i.u with u the phase's
  // axis in dq, where it is: d(i.u)/dt = u.di/dt + i.du/dt, du/dt = w (u.q, -u.d). It acts along u
  // with 2/3 of itself.
  const Dq u = park(connection.floating_axis, r);
  const Dq slope{p.dd * flux_rate.d + p.dq * flux_rate.q, p.qd * flux_rate.d + p.qq * flux_rate.q};
  const double drift = u.d * slope.d + u.q * slope.q +
                       frame_speed(x) * (u.q * p.current_a.d - u.d * p.current_a.q);
  const double gain = u.d * (p.dd * u.d + p.dq * u.q) + u.q * (p.qd * u.d + p.qq * u.q);
  const double along = -drift / gain;
  flux_rate.d += along * u.d;
  flux_rate.q += along * u.q;
  return 1.5 * along;
}

inline AxisModel::Electrical AxisModel::electrical(const double* x, double bus_v) const {
  Electrical e;
  e.point = winding.at({x[kD], x[kQ]});
  if (connection.conduction == Conduction::kOpen) return e;
  const Dq i = e.point.current_a;
  const double resistance = winding.resistance_ohm + on_resistance_ohm;
  Dq flux_rate{-resistance * i.d, -resistance * i.q};
  if (connection.driving || !winding.sinusoidal()) {
    const Rotation r = frame(x);
    if (!winding.sinusoidal()) e.beyond_sine = winding.emf_beyond_sine(electrical_angle(x), r);
    const Dq share = park(connection.share, r), offset = park(connection.offset_v, r);
    const Dq emf_v = emf(x, e.point, e.beyond_sine);
    flux_rate.d += bus_v * share.d + offset.d - emf_v.d;
    flux_rate.q += bus_v * share.q + offset.q - emf_v.q;
    // Terminal power balance: the link gives what the terminals take.
    e.bridge_a = 1.5 * (share.d * i.d + share.q * i.q);
    if (connection.conduction == Conduction::kSeries) {
      e.floating_v = hold_floating_phase(x, r, e.point, flux_rate);
    }
  } else {
    const Dq emf_v = emf(x, e.point, {});
    flux_rate.d -= emf_v.d;
    flux_rate.q -= emf_v.q;
  }
  e.bridge_a += connection.short_conductance * bus_v;
  e.state_rate = winding.state_rate(e.point, flux_rate);
  return e;
}

inline double AxisModel::torque(const Electrical& e, const double* x) const {
  const Winding::Point& p = e.point;
  const MachineEffects& effects = winding.effects;
  double torque = 0;
  if (connection.conduction != Conduction::kOpen) {
    const Dq i = p.current_a;
    double flux_times_i = winding.flux_wb * (e.beyond_sine.d * i.d + e.beyond_sine.q * i.q);
    flux_times_i += effects.commutator ? winding.flux_wb * i.q
                                       : p.flux_wb.d * i.q - p.flux_wb.q * i.d;
    torque = 1.5 * winding.motor.pole_pairs * flux_times_i;
  }
  if (!effects.cogging_nm.empty()) {
    torque += effects.cogging_nm.at(x[kAngle] / (2 * std::numbers::pi));
  }
  if (effects.iron_eddy_w_per_v2 > 0) {
    torque -= effects.iron_eddy_w_per_v2 * winding.motor.pole_pairs * electrical_speed(x) *
              (p.flux_wb.d * p.flux_wb.d + p.flux_wb.q * p.flux_wb.q);
  }
  return torque;
}

inline double AxisModel::derivative(const double* x, double bus_v, double* dx) const {
  const Electrical e = electrical(x, bus_v);
  dx[kD] = e.state_rate.d;
  dx[kQ] = e.state_rate.q;
  shaft.derivative(x + kShaft, torque(e, x), drag(e.point), dx + kShaft);
  if (thermal()) heat(x, e.point, dx);
  return e.bridge_a;
}

}  // namespace virtdrive
