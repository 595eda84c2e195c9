// Motors by name or from a file, each with where its numbers come from.
//
//   const Motor motor = find_motor("db42s03");           // of the library:
//   data/motors/db42s03.yaml const Motor mine = find_motor("bench/my_motor.yaml");  // a copy that
//   was edited
//
// What a file may say: plant/motor_file.h and docs/motors.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plant/machine.h"
#include "plant/mechanics.h"
#include "plant/pmsm.h"

namespace virtdrive {

enum class MachineKind {
  kPmsm,       // three phases, the EMF a sine unless told otherwise
  kBldc,       // three phases, the EMF a trapezoid unless told otherwise
  kBrushedDc,  // two terminals
  kVoiceCoil,  // two terminals, moves along a line: 1 rad stands for 1 m, 1 Nm for 1 N
  kInduction,  // three phases, a cage
};
/// As files call it: "pmsm", "bldc", "brushed_dc", "voice_coil", "induction".
std::string_view kind_name(MachineKind kind);

/// How a data sheet counts a current.
enum class CurrentRating {
  kPeak,  // peak of a sinusoidal phase current
  kRms,   // its rms value
  kDc,    // of block commutation: what flows in the supply at full duty
};

/// As the data sheet prints it; 0: not told.
struct MotorRating {
  double voltage_v = 0;  // of the DC link
  double current_a = 0;
  CurrentRating counted_as = CurrentRating::kPeak;  // both currents
  double peak_current_a = 0;                        // for a short time
  double speed_rpm = 0;
  double torque_nm = 0;          // of a voice coil: its force in N
  double power_w = 0;            // at the shaft
  double maximum_speed_rpm = 0;  // what the rotor bears
  double frequency_hz = 0;       // of an induction machine's supply
};

struct Motor {
  std::string name;         // lower case
  std::string description;  // one line
  MachineKind kind = MachineKind::kPmsm;
  MotorRating rating;
  PmsmParameters electrical;  // holds the rated current too
  MachineEffects effects;     // beyond the linear machine with a sinusoidal EMF
  MechanicsParameters mechanics;
  std::string source;
  std::string assumed;  // what no source gives; "" if nothing is
};

/// All built-in motors, in the order of their names.
std::vector<Motor> motor_library();
std::vector<std::string_view> motor_names();

/// Whether that is the path of a motor's file: it ends in .yaml or .yml or has a slash in it.
bool is_motor_file(std::string_view name_or_path);

/// A built-in motor, or one from a file.
/// SetupError with the nearest names for an unknown one, with file, line and column for a bad file.
Motor find_motor(std::string_view name_or_path);

/// The peak of the phase current whose torque and loss a rated current stands for: sqrt(2) of an
/// rms value; of a block current (two phases, 120 degrees) the fundamental, 2 sqrt(3) / pi.
double phase_peak_a(double current_a, CurrentRating counted_as);

/// Of the rating: told, or torque times speed; 0 if neither is known.
double rated_power_w(const MotorRating& rating);

}  // namespace virtdrive
