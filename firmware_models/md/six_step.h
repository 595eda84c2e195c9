// Six-step commutation: which two phases carry the current in each Hall sector, the third floats.
//
// The Hall sensors sit so that their edges are 30 electrical degrees behind the zeros of the EMF
// between lines: in each sector the EMF of the chosen pair is at its top.
#pragma once

#include "plant/inverter.h"

namespace virtdrive::md {

/// Where the sensors' pattern begins, electrical.
inline constexpr double kHallOffsetRad = 0.52359877559829887;  // 30 degrees

struct PhasePair {
  std::size_t source;  // the current goes in here
  std::size_t sink;    // and comes out here
};

/// For torque towards CCW (positive) in a sector 0..5.
PhasePair pair_of(int sector);

/// The bridge for an output of -1..1 of the DC link in a sector.
BridgeCommand six_step(int sector, double output, SimDuration pwm_period);
/// The same at the end of a sector, with the leg that joins in the next one: each conducts for more
/// than 120 degrees.
BridgeCommand six_step_overlapped(int sector, double output, SimDuration pwm_period);

/// The current of the pair, positive where it makes torque towards CCW (A).
double pair_current_a(int sector, const PhaseValues& current_a);
/// The same where three legs conduct: the one that is alone on its side carries it all.
double overlapped_current_a(int sector, const PhaseValues& current_a);

}  // namespace virtdrive::md
