#include "plant/axis_model.h"

#include <limits>
#include <numbers>

namespace virtdrive {

double AxisModel::torque(const double* x) const {
  Electrical e;
  e.point = winding.at({x[kD], x[kQ]});
  if (!winding.sinusoidal()) {
    e.beyond_sine = winding.emf_beyond_sine(electrical_angle(x), frame(x));
  }
  return torque(e, x);
}

void AxisModel::heat(const double* x, const Winding::Point& p, double* dx) const {
  const ThermalParameters& t = winding.effects.thermal;
  const double* degc = x + temperatures_at();
  const Dq i = p.current_a;
  const double copper_w = 1.5 * winding.resistance_ohm * (i.d * i.d + i.q * i.q);
  const double w = electrical_speed(x);
  const double flux2 = p.flux_wb.d * p.flux_wb.d + p.flux_wb.q * p.flux_wb.q;
  const double iron_w = (winding.effects.iron_eddy_w_per_v2 * w * w +
                         winding.effects.iron_hysteresis_w * std::fabs(w)) *
                        flux2;
  const double to_housing = (degc[0] - degc[1]) / t.winding_housing_k_per_w;
  const double to_ambient = (degc[1] - t.ambient_degc) / t.housing_ambient_k_per_w;
  dx[temperatures_at()] = (copper_w - to_housing) / t.winding_j_per_k;
  dx[temperatures_at() + 1] = (to_housing + iron_w - to_ambient) / t.housing_j_per_k;
}

PhaseValues AxisModel::phase_currents(const double* x) const {
  const Dq i = current(x);
  if (i.d == 0 && i.q == 0) return {};
  return inverse_clarke(inverse_park(i, frame(x)));
}

PhaseValues AxisModel::terminal_voltages(const double* x, double bus_v) const {
  PhaseValues v{};
  if (connection.conduction == Conduction::kTerminals) return v;  // nobody asks
  if (connection.conduction == Conduction::kSeries) {
    v = inverse_clarke({connection.share.alpha * bus_v + connection.offset_v.alpha,
                        connection.share.beta * bus_v + connection.offset_v.beta});
    // The plane drops the common voltage: the floating terminal is given as 0, put it there.
    const double common = v[static_cast<std::size_t>(connection.floating)];
    for (double& terminal : v) terminal -= common;
    v[static_cast<std::size_t>(connection.floating)] = electrical(x, bus_v).floating_v;
    return v;
  }
  const Rotation r = frame(x);
  const Dq beyond =
      winding.sinusoidal() ? Dq{} : winding.emf_beyond_sine(electrical_angle(x), r);
  return inverse_clarke(inverse_park(emf(x, winding.at({x[kD], x[kQ]}), beyond), r));
}

double AxisModel::margin(const HalfBridges& bridges, const double* x, double bus_v) const {
  double least = std::numeric_limits<double>::infinity();
  if (bridges.watched()) {
    const PhaseValues v =
        bridges.looks_at_voltages() ? terminal_voltages(x, bus_v) : PhaseValues{};
    least = bridges.margin(phase_currents(x), v, bus_v);
  }
  if (!shaft.watched()) return least;
  const bool torque_matters = shaft.motion == Motion::kStuck || shaft.motion == Motion::kFree;
  const double drag_nm =
      winding.effects.iron_hysteresis_w > 0 ? drag(winding.at({x[kD], x[kQ]})) : 0;
  return std::min(least, shaft.margin(x + kShaft, torque_matters ? torque(x) : 0, drag_nm));
}

double AxisModel::step_limit_s(const double* x) const {
  const double l = winding.least_inductance_h();
  const double r = winding.resistance_ohm + on_resistance_ohm;
  const double electrical = r > 0 ? l / r / 5 : std::numeric_limits<double>::infinity();
  return std::min(
      {50e-6, electrical, shaft.step_limit_s(), 0.1 / (std::fabs(electrical_speed(x)) + 1)});
}

double AxisModel::next_kink_s(const double* x) const {
  const double distance = winding.corner_distance_rad();
  const double speed = electrical_speed(x);
  if (distance == 0 || speed == 0) return std::numeric_limits<double>::infinity();
  // A step that ends at a corner leaves it a hair behind.
  const double place = electrical_angle(x) / distance;
  const double hair = 1e-9;
  const double ahead = speed > 0 ? std::floor(place + hair) + 1 - place
                                 : place - (std::ceil(place - hair) - 1);
  return ahead * distance / std::fabs(speed);
}

void AxisModel::drop_blocked_current(double* x) const {
  if (connection.conduction == Conduction::kTerminals) return;
  const Dq state{x[kD], x[kQ]};
  Dq i = winding.at(state).current_a;
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
  const Dq allowed = winding.state_with_current(state, i);
  x[kD] = allowed.d;
  x[kQ] = allowed.q;
}

}  // namespace virtdrive
