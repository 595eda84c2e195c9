#include "plant/axis_model.h"

#include <limits>
#include <numbers>

namespace virtdrive {

double AxisModel::torque(const double* x) const {
  Electrical e;
  e.point = point(x);
  if (!winding.sinusoidal()) {
    e.beyond_sine = winding.emf_beyond_sine(electrical_angle(x), frame(x));
  }
  return torque(e, x);
}

double AxisModel::cogging_and_iron(const Winding::Point& p, const double* x) const {
  const MachineEffects& effects = winding.effects;
  double torque = 0;
  if (!effects.cogging_nm.empty()) {
    torque += effects.cogging_nm.at(x[kAngle] / (2 * std::numbers::pi));
  }
  if (effects.iron_eddy_w_per_v2 > 0) {
    torque -= effects.iron_eddy_w_per_v2 * winding.motor.pole_pairs * electrical_speed(x) *
              (p.flux_wb.d * p.flux_wb.d + p.flux_wb.q * p.flux_wb.q);
  }
  return torque;
}

void AxisModel::heat(const double* x, const Winding::Point& p, double* dx) const {
  const ThermalParameters& t = winding.effects.thermal;
  const double* degc = x + temperatures_at();
  const Dq i = p.current_a;
  const double copper_w = 1.5 * winding.resistance_ohm() * (i.d * i.d + i.q * i.q);
  double rotor_w = 0;  // leaves through shaft and air: counted to the housing
  if (winding.cage()) {
    const Dq rotor = cage_at(x).rotor_current_a;
    rotor_w =
        1.5 * winding.cage()->rotor_resistance_ohm() * (rotor.d * rotor.d + rotor.q * rotor.q);
  }
  const double w = electrical_speed(x);
  const double flux2 = p.flux_wb.d * p.flux_wb.d + p.flux_wb.q * p.flux_wb.q;
  const double iron_w = (winding.effects.iron_eddy_w_per_v2 * w * w +
                         winding.effects.iron_hysteresis_w * std::fabs(w)) *
                        flux2;
  const double to_housing = (degc[0] - degc[1]) / t.winding_housing_k_per_w;
  const double to_ambient = (degc[1] - t.ambient_degc) / t.housing_ambient_k_per_w;
  dx[temperatures_at()] = (copper_w - to_housing) / t.winding_j_per_k;
  dx[temperatures_at() + 1] = (to_housing + iron_w + rotor_w - to_ambient) / t.housing_j_per_k;
}

double AxisModel::hold_floating_phase(const double* x, const Rotation& r, const Winding::Point& p,
                                      Dq& flux_rate) const {
  // The floating terminal's voltage is the one that keeps its phase current, i.u with u the phase's
  // axis in dq, where it is: d(i.u)/dt = u.di/dt + i.du/dt, du/dt = w (u.q, -u.d). It acts along u
  // with 2/3 of itself.
  const Dq u = park(connection.floating_axis, r);
  const Dq slope{p.dd * flux_rate.d + p.dq * flux_rate.q, p.qd * flux_rate.d + p.qq * flux_rate.q};
  const double drift =
      u.d * slope.d + u.q * slope.q + frame_speed(x) * (u.q * p.current_a.d - u.d * p.current_a.q);
  const double gain = u.d * (p.dd * u.d + p.dq * u.q) + u.q * (p.qd * u.d + p.qq * u.q);
  const double along = -drift / gain;
  flux_rate.d += along * u.d;
  flux_rate.q += along * u.q;
  return 1.5 * along;
}

PhaseValues AxisModel::phase_currents(const double* x, const Rotation& r) const {
  const Dq i = current(x);
  if (i.d == 0 && i.q == 0) return {};
  return inverse_clarke(inverse_park(i, r));
}

PhaseValues AxisModel::terminal_voltages(const double* x, double bus_v, const Rotation& r) const {
  PhaseValues v{};
  if (connection.conduction == Conduction::kTerminals) return v;  // nobody asks
  if (connection.conduction == Conduction::kSeries) {
    v = inverse_clarke({connection.share.alpha * bus_v + connection.offset_v.alpha,
                        connection.share.beta * bus_v + connection.offset_v.beta});
    // The plane drops the common voltage: the floating terminal is given as 0, put it there.
    const double common = v[static_cast<std::size_t>(connection.floating)];
    for (double& terminal : v) terminal -= common;
    v[static_cast<std::size_t>(connection.floating)] =
        electrical(x, bus_v, [&] { return r; }).floating_v;
    return v;
  }
  if (winding.cage()) return inverse_clarke(inverse_park(cage_at(x).emf_v, r));
  const Dq beyond = winding.sinusoidal() ? Dq{} : winding.emf_beyond_sine(electrical_angle(x), r);
  return inverse_clarke(inverse_park(emf(x, winding.at({x[kD], x[kQ]}), beyond), r));
}

double AxisModel::margin(const HalfBridges& bridges, const double* x, double bus_v) const {
  double least = std::numeric_limits<double>::infinity();
  if (bridges.watched()) {
    const Phases p = phases(bridges, x, bus_v);
    least = bridges.margin(p.current_a, p.terminal_v, bus_v);
  }
  return std::min(least, shaft_margin(x));
}

double AxisModel::shaft_margin(const double* x) const {
  if (!shaft.watched()) return std::numeric_limits<double>::infinity();
  if (shaft.motion != Motion::kStuck) return shaft.margin(x + kShaft, 0, 0);
  return shaft.margin(x + kShaft, torque(x), drag(point(x)));
}

/// An EMF whose peak exceeds the link passes it for a sliver of each sixth of a turn: steps must be
/// short beside that, or they leap over it.
double AxisModel::open_turn_rad(const double* x, double bus_v) const {
  const Dq flux = point(x).flux_wb;
  const double peak_v =
      std::numbers::sqrt3 * std::hypot(flux.d, flux.q) * std::fabs(electrical_speed(x));
  constexpr double kOfShapes = 1.2;  // a trapezoid's line voltage is up to 15 % higher
  return kOfShapes * peak_v > bus_v ? 0.01 : 0.1;
}

double AxisModel::next_corner_s(const double* x) const {
  const double distance = winding.corner_distance_rad();
  const double speed = electrical_speed(x);
  if (speed == 0) return std::numeric_limits<double>::infinity();
  // A step that ends at a corner leaves it a hair behind.
  const double place = electrical_angle(x) / distance;
  const double hair = 1e-9;
  const double ahead =
      speed > 0 ? std::floor(place + hair) + 1 - place : place - (std::ceil(place - hair) - 1);
  return ahead * distance / std::fabs(speed);
}

void AxisModel::drop_blocked_current(double* x) const {
  if (connection.conduction == Conduction::kTerminals) return;
  const Dq state{x[kD], x[kQ]};
  Dq i = current(x);
  if (connection.conduction == Conduction::kSeries) {
    const Dq u = park(connection.floating_axis, frame(x));
    const double rest = i.d * u.d + i.q * u.q;
    if (rest == 0) return;
    i = {i.d - rest * u.d, i.q - rest * u.q};
  } else if (i.d == 0 && i.q == 0) {
    return;
  } else {
    i = {};
  }
  if (const SquirrelCage* cage = winding.cage()) {
    const Dq rotor = cage->rotor_flux_wb(state, main_flux(x));
    const Dq psi = cage->main_flux_wb(rotor, i);
    x[flux_at()] = psi.d;
    x[flux_at() + 1] = psi.q;
  }
  const Dq allowed = winding.state_with_current(state, i);
  x[kD] = allowed.d;
  x[kQ] = allowed.q;
}

void AxisModel::drop_last_flux(double* x) const {
  const SquirrelCage* cage = winding.cage();
  if (cage == nullptr || connection.conduction != Conduction::kOpen || without_flux(x)) return;
  const Dq psi = main_flux(x);
  if (std::hypot(psi.d, psi.q) > cage->no_flux_wb()) return;
  x[flux_at()] = x[flux_at() + 1] = 0;
}

}  // namespace virtdrive
