// The mechanics of an axis between two events: held inputs, modes, and the derivative.
//
// States: rotor speed and angle; with a compliant transmission also the load's speed and angle.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "plant/mechanics.h"

namespace virtdrive {

/// Dry friction of one mass, with a mode.
struct DryFriction {
  double sliding_nm = 0, breakaway_nm = 0, inverse_stribeck = 0;

  bool any() const { return breakaway_nm > 0; }
  double at(double speed) const {
    if (breakaway_nm == sliding_nm) return sliding_nm;
    const double ratio = speed * inverse_stribeck;
    return sliding_nm + (breakaway_nm - sliding_nm) * std::exp(-ratio * ratio);
  }
};

/// A play between two elastic limits: backlash, end stops. Pushes back only.
struct Play {
  enum class Side : std::uint8_t { kBetween, kLower, kUpper };
  double lower_rad = 0, upper_rad = 0, stiffness = 0, damping = 0;
  Side side = Side::kBetween;

  bool any() const { return stiffness > 0; }
  /// Against a displacement to the positive side.
  double torque(double position, double speed) const {
    if (side == Side::kUpper) {
      return std::max(0.0, stiffness * (position - upper_rad) + damping * speed);
    }
    if (side == Side::kLower) {
      return std::min(0.0, stiffness * (position - lower_rad) + damping * speed);
    }
    return 0;
  }
  /// Positive while it stays on its side; 1e-12 rad of hysteresis.
  double margin(double position) const {
    constexpr double kHysteresisRad = 1e-12;
    const double above = position - upper_rad, below = lower_rad - position;
    return kHysteresisRad + (side == Side::kUpper   ? above
                             : side == Side::kLower ? below
                                                    : -std::max(above, below));
  }
  void decide(double position) {
    side = position > upper_rad   ? Side::kUpper
           : position < lower_rad ? Side::kLower
                                  : Side::kBetween;
  }
};

struct Shaft {
  enum State { kSpeed, kAngle, kLoadSpeed, kLoadAngle };

  Shaft() = default;
  Shaft(const MechanicsParameters& mechanics, const Load& load);

  int states() const { return two_masses ? 4 : 2; }
  double load_speed(const double* x) const {
    return two_masses ? x[kLoadSpeed] : x[kSpeed] * inverse_ratio;
  }
  double load_angle(const double* x) const {
    return two_masses ? x[kLoadAngle] : x[kAngle] * inverse_ratio;
  }

  /// `drag_nm` is dry friction that the machine adds (iron).
  void derivative(const double* x, double torque_nm, double drag_nm, double* dx) const {
    dx[kAngle] = x[kSpeed];
    if (plain) {
      dx[kSpeed] =
          motion == Motion::kStuck
              ? 0
              : (torque_nm - load.external_torque_nm -
                 (viscous + load.quadratic_nm_per_radps2 * std::fabs(x[kSpeed])) * x[kSpeed] -
                 direction(motion) * (friction.sliding_nm + drag_nm)) *
                    inverse_inertia;
      return;
    }
    general_derivative(x, torque_nm, drag_nm, dx);
  }

  bool watched() const {
    return motion != Motion::kFree || load_motion != Motion::kFree || play.any() || stops.any();
  }
  /// Positive while all modes hold. Torque and drag matter while something is stuck.
  double margin(const double* x, double torque_nm, double drag_nm) const;
  /// Once the margin has gone: changes the modes that have ended, and the speeds that are then 0.
  void follow(double* x, double torque_nm, double drag_nm);
  /// All modes anew, after an input has changed.
  void decide(double* x, double torque_nm, double drag_nm);
  /// Nothing moves, and nothing will while the machine gives no torque.
  bool at_rest(const double* x) const;

  /// What the load asks of the shaft; at standstill the brake holds its share of what all dry
  /// friction holds together.
  double load_torque(const double* x, double torque_nm, double drag_nm) const;
  double step_limit_s() const { return step_limit; }

  MechanicsParameters rotor;
  Load load;
  bool two_masses = false;
  bool plain = true;  // one mass without position-dependent torque, gear or Stribeck
  double inverse_ratio = 1, inverse_inertia = 0, inverse_load_inertia = 0;
  double viscous = 0;             // of the one mass
  DryFriction friction;           // of the one mass, or of the rotor
  DryFriction load_friction;      // of the load
  Play play, stops;               // play: of the transmission
  Motion motion = Motion::kFree;  // of the one mass, or of the rotor
  Motion load_motion = Motion::kFree;
  double step_limit = std::numeric_limits<double>::infinity();

 private:
  void general_derivative(const double* x, double torque_nm, double drag_nm, double* dx) const;
  double smooth_load_torque(double speed, double angle) const;
  double coupling_torque(const double* x) const;
  double gear_factor(double passed_torque, double rotor_direction) const;
  struct Drive {
    double forward, reverse;  // torque left over to move forward (> 0), in reverse (< 0)
  };
  Drive left_at_standstill(const double* x, double torque_nm, double drag_nm) const;
  Drive load_left_at_standstill(const double* x) const;
  bool gear_holds() const { return rotor.transmission.efficiency < 1; }
  bool rotor_sticks(double drag_nm) const;
  void decide_rotor(double* x, double torque_nm, double drag_nm);
  void decide_load(double* x);
};

}  // namespace virtdrive
