// One rotating mass with friction that truly sticks.
//
//   J dw/dt = torque - external - (b + k |w|) w - direction * friction      while it slides
//   w = 0 exactly                                                           while it is stuck
//
// Sticking is a mode, not a steep curve: a mass that stops stays stopped while the driving torque
// (torque - external) is at most the friction (Coulomb friction plus brake), breaks away when it is
// exceeded, and a crossing of w = 0 decides between standstill and reversal. A regularised sign
// function creeps under load and is slower to integrate.
#pragma once

#include <cstdint>

namespace virtdrive {

struct MechanicsParameters {
  double inertia_kgm2 = 0;          // of the rotor, > 0
  double viscous_nm_per_radps = 0;  // >= 0
  double coulomb_nm = 0;            // >= 0, sliding and breakaway alike
};

/// What is coupled to the shaft, as seen at the motor.
struct Load {
  double inertia_kgm2 = 0;             // added to the rotor's, >= 0
  double brake_torque_nm = 0;          // opposes the motion, holds at standstill, >= 0
  double external_torque_nm = 0;       // active like a hoist: positive opposes positive rotation
  double quadratic_nm_per_radps2 = 0;  // fan or pump: k w |w|, >= 0
  double viscous_nm_per_radps = 0;     // >= 0

  bool operator==(const Load&) const = default;
};

/// Throws SetupError unless every value is finite and in its range.
void validate(const MechanicsParameters& mechanics);
void validate(const Load& load);

enum class Motion : std::uint8_t {
  kFree,     // no dry friction at all: nothing to switch
  kStuck,    // speed is exactly 0
  kForward,  // sliding with friction against positive rotation
  kReverse,
};

/// The motion that follows from a speed (which has just become 0, or not) and, at standstill, from
/// the driving torque (motor minus external) against the friction.
Motion motion_of(double speed_radps, double driving_torque_nm, double friction_nm);

/// +1, -1, or 0 when there is no sliding friction.
constexpr double direction(Motion motion) {
  return motion == Motion::kForward ? 1 : motion == Motion::kReverse ? -1 : 0;
}

}  // namespace virtdrive
