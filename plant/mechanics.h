// A shaft: the rotor, what is coupled to it, and friction that truly sticks.
//
//   J dw/dt = torque - load - b w - direction * friction(w)      while it slides
//   w = 0 exactly                                                while it is stuck
//   friction(w) = Fc + (Fs - Fc) exp(-(w / ws)^2)                (Stribeck, Gaussian form)
//
// Sticking is a mode, not a steep curve: a mass that stops stays stopped while the driving torque
// is at most the breakaway friction, breaks away when it is exceeded, and a crossing of w = 0
// decides between standstill and reversal. A regularised sign function creeps under load and is
// slower to integrate.
//
// Without stiffness in the transmission rotor and load are one mass. With it they are two, each
// with its own friction, coupled by a spring and a damper, with backlash if there is any. A gear's
// loss is a share of the torque that it passes on, whichever way the power goes, so that a gear of
// low efficiency holds its load.
#pragma once

#include <cstdint>
#include <limits>

namespace virtdrive {

/// Between rotor and load. Stiffness, damping and backlash are at the load's side.
struct Transmission {
  double ratio = 1;                 // rotor turns per turn of the load, > 0
  double efficiency = 1;            // above 0 .. 1
  double stiffness_nm_per_rad = 0;  // 0: rigid
  double damping_nm_per_radps = 0;  // >= 0, with stiffness only
  double backlash_rad = 0;          // whole play, >= 0, with stiffness only
};

struct MechanicsParameters {
  double inertia_kgm2 = 0;          // of the rotor, > 0
  double viscous_nm_per_radps = 0;  // >= 0
  double coulomb_nm = 0;            // sliding, >= 0
  double stiction_nm = 0;           // breakaway; 0: as coulomb_nm, else not below it
  double stribeck_radps = 0;        // speed at which 1/e of the difference is left; > 0 with one
  Transmission transmission{};
};

/// What is coupled to the shaft, at the load's side of the transmission.
struct Load {
  double inertia_kgm2 = 0;             // >= 0; above 0 behind a transmission with stiffness
  double brake_torque_nm = 0;          // opposes the motion, holds at standstill, >= 0
  double external_torque_nm = 0;       // active like a hoist: positive opposes positive rotation
  double quadratic_nm_per_radps2 = 0;  // fan or pump: k w |w|, >= 0
  double viscous_nm_per_radps = 0;     // >= 0
  double stiction_nm = 0;              // breakaway; 0: as brake_torque_nm, else not below it
  double stribeck_radps = 0;           // > 0 with stiction_nm
  double spring_nm_per_rad = 0;        // towards spring_rest_rad, >= 0
  double spring_rest_rad = 0;
  double gravity_nm = 0;  // m g r of a lever that hangs down at angle 0: * sin(angle)
  double lower_stop_rad = -std::numeric_limits<double>::infinity();
  double upper_stop_rad = std::numeric_limits<double>::infinity();
  double stop_nm_per_rad = 0;    // stiffness of the end stops, > 0 if there is one
  double stop_nm_per_radps = 0;  // their damping, >= 0
  bool locked = false;           // held at standstill whatever the torque

  bool operator==(const Load&) const = default;
};

/// Throws SetupError unless every value is finite and in its range.
void validate(const MechanicsParameters& mechanics);
void validate(const Load& load);
void validate(const MechanicsParameters& mechanics, const Load& load);

enum class Motion : std::uint8_t {
  kFree,     // no dry friction at all: nothing to switch
  kStuck,    // speed is exactly 0
  kForward,  // sliding with friction against positive rotation
  kReverse,
};

/// +1, -1, or 0 when there is no sliding friction.
constexpr double direction(Motion motion) {
  return motion == Motion::kForward ? 1 : motion == Motion::kReverse ? -1 : 0;
}

}  // namespace virtdrive
