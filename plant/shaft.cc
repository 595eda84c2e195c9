#include "plant/shaft.h"

namespace virtdrive {
namespace {

/// A speed so far beyond 0 the wrong way is a stop: a shaft that just breaks away starts at 0.
constexpr double kStoppedRadps = 1e-9;
/// Breakaway needs a hair more than the friction that stops.
constexpr double kBreakaway = 1 + 1e-9;
constexpr double kBreakawayNm = 1e-15;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

DryFriction dry_friction(double sliding_nm, double stiction_nm, double stribeck_radps) {
  return {sliding_nm, std::max(sliding_nm, stiction_nm),
          stribeck_radps > 0 ? 1 / stribeck_radps : 0};
}

}  // namespace

Shaft::Shaft(const MechanicsParameters& mechanics, const Load& l) : rotor(mechanics), load(l) {
  const Transmission& t = rotor.transmission;
  two_masses = t.stiffness_nm_per_rad > 0;
  inverse_ratio = 1 / t.ratio;
  const bool stopped = std::isfinite(load.lower_stop_rad) || std::isfinite(load.upper_stop_rad);
  if (stopped) {
    stops = {load.lower_stop_rad, load.upper_stop_rad, load.stop_nm_per_rad,
             load.stop_nm_per_radps};
  }
  load_friction = dry_friction(load.brake_torque_nm, load.stiction_nm, load.stribeck_radps);
  friction = dry_friction(rotor.coulomb_nm, rotor.stiction_nm, rotor.stribeck_radps);
  viscous = rotor.viscous_nm_per_radps;
  const double reflected = load.inertia_kgm2 * inverse_ratio * inverse_ratio;
  if (two_masses) {
    plain = false;
    inverse_inertia = 1 / rotor.inertia_kgm2;
    inverse_load_inertia = 1 / load.inertia_kgm2;
    if (t.backlash_rad > 0) {
      play = {-t.backlash_rad / 2, t.backlash_rad / 2, t.stiffness_nm_per_rad,
              t.damping_nm_per_radps};
    }
  } else {
    inverse_inertia = 1 / (rotor.inertia_kgm2 + reflected);
    plain = t.ratio == 1 && t.efficiency == 1 && load.spring_nm_per_rad == 0 &&
            load.gravity_nm == 0 && !stopped && friction.sliding_nm == friction.breakaway_nm &&
            load_friction.sliding_nm == load_friction.breakaway_nm;
    if (plain) {
      viscous += load.viscous_nm_per_radps;
      friction.sliding_nm += load_friction.sliding_nm;
      friction.breakaway_nm += load_friction.breakaway_nm;
    }
  }
  // A tenth of a radian of the fastest oscillation, and half of the fastest damping.
  const auto limit = [&](double stiffness, double damping, double inverse_mass) {
    if (stiffness > 0) {
      step_limit = std::min(step_limit, 0.1 / std::sqrt(stiffness * inverse_mass));
    }
    if (damping > 0) step_limit = std::min(step_limit, 0.5 / (damping * inverse_mass));
  };
  const double load_mass =
      two_masses ? inverse_load_inertia : inverse_inertia / (inverse_ratio * inverse_ratio);
  if (two_masses) {
    const double both = inverse_inertia * inverse_ratio * inverse_ratio + inverse_load_inertia;
    limit(t.stiffness_nm_per_rad, t.damping_nm_per_radps, both);
  }
  limit(load.spring_nm_per_rad, 0, load_mass);
  limit(std::fabs(load.gravity_nm), 0, load_mass);
  limit(stops.stiffness, stops.damping, load_mass);
}

double Shaft::smooth_load_torque(double speed, double angle) const {
  double torque =
      load.external_torque_nm +
      (load.viscous_nm_per_radps + load.quadratic_nm_per_radps2 * std::fabs(speed)) * speed +
      load.spring_nm_per_rad * (angle - load.spring_rest_rad);
  if (load.gravity_nm != 0) torque += load.gravity_nm * std::sin(angle);
  if (stops.any()) torque += stops.torque(angle, speed);
  return torque;
}

double Shaft::coupling_torque(const double* x) const {
  const double twist = x[kAngle] * inverse_ratio - x[kLoadAngle];
  const double rate = x[kSpeed] * inverse_ratio - x[kLoadSpeed];
  if (play.any()) return play.torque(twist, rate);
  const Transmission& t = rotor.transmission;
  return t.stiffness_nm_per_rad * twist + t.damping_nm_per_radps * rate;
}

/// Torque at the gear's input per torque at its output: the loss is paid by the side that drives.
double Shaft::gear_factor(double passed_torque, double rotor_direction) const {
  const double efficiency = rotor.transmission.efficiency;
  return passed_torque * rotor_direction > 0 ? 1 / efficiency : efficiency;
}

void Shaft::general_derivative(const double* x, double torque_nm, double drag_nm,
                               double* dx) const {
  const double speed = x[kSpeed];
  const double way = motion == Motion::kFree ? speed : direction(motion);
  const double own = torque_nm - rotor.viscous_nm_per_radps * speed -
                     direction(motion) * (friction.at(speed) + drag_nm);
  const double load_speed_now = load_speed(x);
  const double load_demand = smooth_load_torque(load_speed_now, load_angle(x));
  if (two_masses) {
    const double coupling = coupling_torque(x);
    const double demand = coupling * inverse_ratio * gear_factor(coupling, way);
    dx[kSpeed] = motion == Motion::kStuck ? 0 : (own - demand) * inverse_inertia;
    dx[kLoadAngle] = x[kLoadSpeed];
    dx[kLoadSpeed] =
        load_motion == Motion::kStuck
            ? 0
            : (coupling - load_demand - direction(load_motion) * load_friction.at(load_speed_now)) *
                  inverse_load_inertia;
    return;
  }
  if (motion == Motion::kStuck) {
    dx[kSpeed] = 0;
    return;
  }
  const double demand =
      (load_demand + direction(motion) * load_friction.at(load_speed_now)) * inverse_ratio;
  if (!gear_holds()) {
    dx[kSpeed] = (own - demand) * inverse_inertia;
    return;
  }
  const double reflected = load.inertia_kgm2 * inverse_ratio * inverse_ratio;
  // The sign of what the gear passes on does not depend on its loss.
  const double passed = demand * rotor.inertia_kgm2 + reflected * own;
  const double factor = gear_factor(passed, way);
  dx[kSpeed] = (own - factor * demand) / (rotor.inertia_kgm2 + factor * reflected);
}

Shaft::Drive Shaft::left_at_standstill(const double* x, double torque_nm, double drag_nm) const {
  if (plain) {
    const double left = torque_nm - load.external_torque_nm;
    const double dry = (friction.breakaway_nm + drag_nm) * kBreakaway + kBreakawayNm;
    return {left - dry, left + dry};
  }
  const double own_dry = (friction.breakaway_nm + drag_nm) * kBreakaway + kBreakawayNm;
  double demand, load_dry = 0;
  if (two_masses) {
    demand = coupling_torque(x);
  } else {
    demand = smooth_load_torque(0, load_angle(x));
    load_dry = load_friction.breakaway_nm * kBreakaway;
  }
  const double forward = demand + load_dry, reverse = demand - load_dry;
  return {torque_nm - own_dry - forward * inverse_ratio * gear_factor(forward, 1),
          torque_nm + own_dry - reverse * inverse_ratio * gear_factor(reverse, -1)};
}

Shaft::Drive Shaft::load_left_at_standstill(const double* x) const {
  const double left = coupling_torque(x) - smooth_load_torque(0, x[kLoadAngle]);
  const double dry = load_friction.breakaway_nm * kBreakaway + kBreakawayNm;
  return {left - dry, left + dry};
}

bool Shaft::rotor_sticks(double drag_nm) const {
  return friction.any() || drag_nm > 0 || gear_holds() || (!two_masses && load_friction.any());
}

double Shaft::margin(const double* x, double torque_nm, double drag_nm) const {
  double least = kInfinity;
  if (motion == Motion::kStuck) {
    if (two_masses || !load.locked) {
      const Drive left = left_at_standstill(x, torque_nm, drag_nm);
      least = std::min(-left.forward, left.reverse);
    }
  } else if (motion != Motion::kFree) {
    least = direction(motion) * x[kSpeed] + kStoppedRadps;
  }
  if (plain) return least;
  if (load_motion == Motion::kStuck) {
    if (!load.locked) {
      const Drive left = load_left_at_standstill(x);
      least = std::min({least, -left.forward, left.reverse});
    }
  } else if (load_motion != Motion::kFree) {
    least = std::min(least, direction(load_motion) * x[kLoadSpeed] + kStoppedRadps);
  }
  if (play.any()) least = std::min(least, play.margin(x[kAngle] * inverse_ratio - x[kLoadAngle]));
  if (stops.any()) least = std::min(least, stops.margin(load_angle(x)));
  return least;
}

void Shaft::decide_rotor(double* x, double torque_nm, double drag_nm) {
  if (!two_masses && load.locked) {
    x[kSpeed] = 0;
    motion = Motion::kStuck;
  } else if (!rotor_sticks(drag_nm)) {
    motion = Motion::kFree;
  } else if (x[kSpeed] != 0) {
    motion = x[kSpeed] > 0 ? Motion::kForward : Motion::kReverse;
  } else {
    const Drive left = left_at_standstill(x, torque_nm, drag_nm);
    motion = left.forward >= 0   ? Motion::kForward
             : left.reverse <= 0 ? Motion::kReverse
                                 : Motion::kStuck;
  }
}

void Shaft::decide_load(double* x) {
  if (!two_masses) return;
  if (load.locked) {
    x[kLoadSpeed] = 0;
    load_motion = Motion::kStuck;
  } else if (!load_friction.any()) {
    load_motion = Motion::kFree;
  } else if (x[kLoadSpeed] != 0) {
    load_motion = x[kLoadSpeed] > 0 ? Motion::kForward : Motion::kReverse;
  } else {
    const Drive left = load_left_at_standstill(x);
    load_motion = left.forward >= 0   ? Motion::kForward
                  : left.reverse <= 0 ? Motion::kReverse
                                      : Motion::kStuck;
  }
}

void Shaft::decide(double* x, double torque_nm, double drag_nm) {
  if (play.any()) play.decide(x[kAngle] * inverse_ratio - x[kLoadAngle]);
  if (stops.any()) stops.decide(load_angle(x));
  decide_rotor(x, torque_nm, drag_nm);
  decide_load(x);
}

void Shaft::follow(double* x, double torque_nm, double drag_nm) {
  // A shaft that has just stopped, or that stood and now breaks away, is at 0 both times.
  const auto stopped = [](Motion m, double speed) {
    return m == Motion::kStuck || (m != Motion::kFree && direction(m) * speed <= -kStoppedRadps);
  };
  if (stopped(motion, x[kSpeed])) x[kSpeed] = 0;
  if (two_masses && stopped(load_motion, x[kLoadSpeed])) x[kLoadSpeed] = 0;
  decide(x, torque_nm, drag_nm);
}

bool Shaft::at_rest(const double* x) const {
  if (x[kSpeed] != 0 || (two_masses && x[kLoadSpeed] != 0)) return false;
  if (motion == Motion::kStuck) return !two_masses || load_motion == Motion::kStuck;
  return plain && motion == Motion::kFree && load.external_torque_nm == 0;
}

double Shaft::load_torque(const double* x, double torque_nm, double drag_nm) const {
  if (two_masses) return coupling_torque(x);
  const double speed = load_speed(x), angle = load_angle(x);
  const double smooth = smooth_load_torque(speed, angle);
  const double ours = plain ? load.brake_torque_nm : load_friction.at(speed);
  if (motion != Motion::kStuck) return smooth + direction(motion) * ours;
  const double breakaway =
      plain ? friction.breakaway_nm + drag_nm
            : friction.breakaway_nm + drag_nm + load_friction.breakaway_nm * inverse_ratio;
  const double held = torque_nm - smooth * inverse_ratio;
  const double share = plain ? load.brake_torque_nm : load_friction.breakaway_nm;
  return smooth + (breakaway > 0 ? held * share / breakaway : held / inverse_ratio);
}

}  // namespace virtdrive
