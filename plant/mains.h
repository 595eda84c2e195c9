// Mains behind a diode bridge: what feeds the link of an AC drive, with ripple, dips, lost phases
// and the resistor that limits the charging current.
//
//   L di/dt = e(phase) - (R + charging resistor) i - v      while the bridge conducts, else i = 0
//   e       = the highest of the phases' voltages less the lowest (one phase: |voltage|)
//
// i is the current on the bridge's DC side and never falls below 0: that is an event, as is e
// passing v. R and L are those of the loop that two diodes close: both lines, and a choke in the
// link. What is left out is the overlap of two diodes of three-phase bridges while L of the lines
// hands over from one to the other; it does not exist in a choke, nor with one phase, nor where the
// current falls to 0 between two pulses, as it does in small drives.
#pragma once

#include <array>
#include <limits>

namespace virtdrive {

struct MainsParameters {
  int phases = 0;             // 0: no mains; 1 or 3
  double voltage_v = 0;       // rms, between two lines, > 0
  double frequency_hz = 60;   // > 0
  double resistance_ohm = 0;  // of the loop, >= 0
  double inductance_h = 0;    // of the loop, > 0
  double charging_ohm = 0;    // in series while the contact is open, >= 0
};

/// What can change while it runs.
struct MainsInput {
  std::array<double, 3> level{1, 1, 1};  // of each phase's voltage: a dip, 0..1.5
  std::array<bool, 3> connected{true, true, true};
  bool contact = true;  // across the charging resistor

  bool operator==(const MainsInput&) const = default;
};

/// Throws SetupError unless every value is in its range.
void validate(const MainsParameters& mains);

/// The bridge between two events. Its states, the phase of the mains (rad) and its current, are
/// part of the link's.
class RectifiedMains {
 public:
  explicit RectifiedMains(const MainsParameters& parameters);

  bool any() const { return p.phases > 0; }
  void set_input(const MainsInput& input);
  const MainsInput& input() const { return input_; }

  /// e.
  double rectified_v(double phase_rad) const;
  /// The highest e of a turn.
  double peak_v() const { return peak_v_; }
  /// From one peak of e to the next.
  double pulse_s() const { return pulse_s_; }
  double phase_rate() const { return omega_; }
  double current_rate(double phase_rad, double current_a, double link_v) const {
    if (!conducts) return 0;
    return (rectified_v(phase_rad) - resistance_ohm_ * current_a - link_v) * inverse_inductance_;
  }
  double margin(double phase_rad, double current_a, double link_v) const;
  /// Changes the mode if it has ended; true if it has.
  bool follow(double phase_rad, double& current_a, double link_v);
  /// To the next peak or corner of e: neither is stepped over, so that no short pulse is missed.
  double next_corner_s(double phase_rad) const;
  /// Where a link comes to rest, on the average, that takes this current.
  double resting_v(double current_a) const;
  double resting_ripple_v(double current_a, double capacitance_f) const {
    return current_a * pulse_s_ / capacitance_f;
  }
  double step_limit_s(double capacitance_f) const;

  MainsParameters p;
  bool conducts = false;

 private:
  void prepare();

  MainsInput input_;
  std::array<double, 3> peak_of_phase_{};
  bool balanced_ = true;
  double omega_ = 0, corner_rad_ = 1, peak_v_ = 0, pulse_s_ = 0;
  double resistance_ohm_ = 0, inverse_inductance_ = 0;
};

}  // namespace virtdrive
