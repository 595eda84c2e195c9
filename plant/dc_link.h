// The DC link: a source, the link capacitor, what the board itself draws, and a brake chopper.
//
//   C dV/dt = i_source - i_bridges - i_board - i_chopper
//
//   source    (E - V) / R through a diode, so that regeneration pumps the link up; or a battery,
//             which takes back as well; or without resistance ideal: V = E while it is switched on;
//             or mains behind a diode bridge (mains.h)
//   board     V / R and P / V: what drains the link when the supply is switched off
//   chopper   a resistor, on from on_v until the link has fallen to off_v; its heat is a state
#pragma once

#include <algorithm>
#include <limits>

#include "core/check.h"
#include "plant/mains.h"

namespace virtdrive {

struct BrakeChopper {
  double on_v = 0;   // 0: no chopper; else above the source voltage
  double off_v = 0;  // above 0, below on_v
  double resistance_ohm = 0;
  double heat_capacity_j_per_k = 0;
  double ambient_k_per_w = 0;  // thermal resistance
  double ambient_degc = 25;
};

struct DcLinkParameters {
  double source_v = 24;         // open-circuit voltage, >= 0; with mains only the first charge
  double resistance_ohm = 0.1;  // of source and leads; 0: ideal source
  MainsParameters mains{};      // instead of that source
  double capacitance_f = 1e-3;  // > 0 (without effect while an ideal source is on)
  bool absorbs = false;         // a battery: current may flow back
  double board_ohm = 0;         // bleeder and the like; 0: none
  double board_w = 0;           // converters: constant power down to board_cutoff_v, below it ...
  double board_cutoff_v = 5;    // ... the resistance that matches there, > 0
  BrakeChopper chopper{};
};

/// The source's diode switches this far beyond its voltage, so that rounding cannot make it
/// chatter.
inline constexpr double kSourceHysteresisV = 1e-6;

/// Throws SetupError unless every value is in its range.
void validate(const DcLinkParameters& link);

/// The link between two events: held inputs, modes, and the derivative. States: the voltage and,
/// with a chopper, its resistor's temperature; with mains, their phase and the bridge's current.
struct DcLink {
  enum State { kVoltage, kChopperDegc };

  explicit DcLink(const DcLinkParameters& parameters);

  int states() const { return 1 + (has_chopper() ? 1 : 0) + (mains.any() ? 2 : 0); }
  bool has_chopper() const { return p.chopper.on_v > 0; }
  int phase_at() const { return has_chopper() ? 2 : 1; }
  int rectifier_at() const { return phase_at() + 1; }
  bool pinned() const { return ideal && on; }

  /// `x` matters to mains only.
  double source_current(const double* x, double bridge_a) const {
    const double v = x[kVoltage];
    if (mains.any()) return x[rectifier_at()];
    if (!on) return 0;
    if (ideal) return bridge_a + board_current(v) + chopper_current(v);
    const double i = (p.source_v - v) * source_conductance;
    return p.absorbs ? i : feeds ? std::max(0.0, i) : 0;
  }
  double board_current(double v) const {
    if (!draws) return 0;
    const double cutoff = std::max(v, p.board_cutoff_v);
    // Below the cut-off P v / cutoff^2, above it P / v.
    return v * board_conductance + p.board_w * v / (cutoff * cutoff);
  }
  double chopper_current(double v) const { return chopper_on ? v / p.chopper.resistance_ohm : 0; }

  void derivative(const double* x, double bridge_a, double* dx) const {
    const double v = x[kVoltage];
    dx[kVoltage] = pinned()
                       ? 0
                       : (source_current(x, 0) - bridge_a - board_current(v) - chopper_current(v)) *
                             inverse_capacitance;
    if (has_chopper()) {
      const BrakeChopper& c = p.chopper;
      dx[kChopperDegc] =
          (v * chopper_current(v) - (x[kChopperDegc] - c.ambient_degc) / c.ambient_k_per_w) /
          c.heat_capacity_j_per_k;
    }
    if (mains.any()) {
      const double phase = x[phase_at()], i = x[rectifier_at()];
      dx[phase_at()] = mains.phase_rate();
      dx[rectifier_at()] = mains.current_rate(phase, i, v);
    }
  }

  bool watched() const { return has_diode() || mains.any() || chopper_enabled(); }
  /// Positive while the modes hold.
  double margin(const double* x) const {
    double least = std::numeric_limits<double>::infinity();
    if (has_diode()) {
      const double above = x[kVoltage] - p.source_v;
      least = kSourceHysteresisV + (feeds ? -above : above);
    }
    if (mains.any()) {
      least = mains.margin(x[phase_at()], x[rectifier_at()], x[kVoltage]);
    }
    if (chopper_enabled()) {
      least = std::min(least,
                       chopper_on ? x[kVoltage] - p.chopper.off_v : p.chopper.on_v - x[kVoltage]);
    }
    return least;
  }
  /// Changes the modes that have ended; true if any did.
  bool follow(double* x);

  void set_source(double* x, double source_v, bool switched_on);
  void set_chopper(bool enabled);
  /// Mains: to the next peak or corner of their voltage; infinite without.
  double next_corner_s(const double* x) const {
    return mains.any() ? mains.next_corner_s(x[phase_at()])
                       : std::numeric_limits<double>::infinity();
  }

  /// Nothing will change while no bridge takes or gives current. Puts the last microvolt to where
  /// the voltage tends.
  bool settle(double* x);
  /// What the time does to a settled link: the chopper's resistor cools.
  void rest(double* x, double duration_s) const;

  double step_limit_s() const {
    return mains.any() ? std::min(step_limit, mains.step_limit_s(p.capacitance_f)) : step_limit;
  }

  DcLinkParameters p;
  RectifiedMains mains;
  bool ideal = false, draws = false;
  double source_conductance = 0, inverse_capacitance = 0, board_conductance = 0;
  double step_limit = 0;
  bool on = true;     // the supply's switch
  bool feeds = true;  // the source's diode
  bool chopper_on = false;
  bool chopper_off = false;  // not enabled

 private:
  bool has_diode() const { return on && !ideal && !p.absorbs && !mains.any(); }
  bool chopper_enabled() const { return has_chopper() && !chopper_off; }
  double equilibrium_v() const;
  bool settle_on_mains(double* x);
};

}  // namespace virtdrive
