// Which of a bridge's switches and diodes conduct: the mode automaton of the three half bridges.
//
// A half bridge whose gates are on is a voltage. One whose gates are off conducts through the lower
// diode (a current into the motor) or the upper one (out of it), or blocks. The diodes' states
// persist: one turns off only when its current falls through 0 (by 1 uA), a blocked one turns on
// only when its terminal passes a rail (by 1 uV beyond the forward voltage). When nothing ties the
// winding to a rail, two diodes turn on together, when the EMF between two lines exceeds the link:
// rectification. With these two rules and the hysteresis an open phase that touches a rail at zero
// current cannot cycle in no time.
//
// Whoever owns it gives it the currents and voltages and acts on what the winding then sees, the
// Connection.
#pragma once

#include <array>
#include <cstdint>

#include "plant/inverter.h"
#include "plant/transforms.h"

namespace virtdrive {

/// A current up to this is none.
inline constexpr double kZeroCurrentA = 1e-6;
/// A diode turns on this far beyond its forward voltage.
inline constexpr double kDiodeHysteresisV = 1e-6;

enum class Gate : std::uint8_t { kOff, kLow, kHigh, kAveraged };
enum class Diode : std::uint8_t { kBlocked, kUpper, kLower };

/// How currents can flow in the winding.
enum class Conduction : std::uint8_t {
  kTerminals,  // three terminal voltages are given
  kSeries,     // one phase carries no current
  kOpen,       // none does
};

/// What the winding sees between two events.
struct Connection {
  Conduction conduction = Conduction::kOpen;
  bool driving = false;          // false: all terminals at one potential
  bool plain = false;            // driving through three terminals, and nothing but shares
  AlphaBeta share;               // terminal voltages as shares of the bus voltage ...
  AlphaBeta offset_v;            // ... and what diodes add to them
  bool offset = false;           // there is something
  AlphaBeta floating_axis;       // kSeries: direction of the phase without current
  int floating = -1;             // kSeries: that phase
  double short_conductance = 0;  // across the link, through switches that fight each other
  double loss_share = 0;         // link current that switches lose, per peak of the phase current
};

class HalfBridges {
 public:
  /// `open` as by construction: a machine without a winding there.
  explicit HalfBridges(const InverterParameters& inverter = {}, std::array<bool, 3> absent = {});

  /// Throws SetupError if a fault would short the link through no resistance.
  void set_faults(const BridgeFaults& faults, const PhaseValues& current_a);
  const BridgeFaults& faults() const { return faults_; }
  bool healthy() const { return healthy_; }
  /// True if a switch's fault makes what happens within a PWM period matter.
  bool needs_edges() const { return needs_edges_; }

  /// `share` matters to Gate::kAveraged. A half bridge that loses its gates goes on conducting
  /// through the diode that its current asks for.
  void set_gates(const std::array<Gate, 3>& gates, const PhaseValues& share,
                 const PhaseValues& current_a);
  bool gates_off() const;

  const Connection& connection() const { return connection_; }
  /// True if a mode can end without a command.
  bool watched() const { return watched_; }
  /// True if `terminal_v` matters to margin() and follow().
  bool looks_at_voltages() const { return some_blocked_; }

  /// Positive while all diodes stay as they are. `terminal_v` may float by a common voltage.
  double margin(const PhaseValues& current_a, PhaseValues terminal_v, double bus_v) const;
  /// Turns off the diodes whose current is gone, or else on those whose voltage asks for it; false
  /// if nothing changed.
  bool follow(const PhaseValues& current_a, PhaseValues terminal_v, double bus_v);

  Diode diode(int phase) const { return diodes_[static_cast<std::size_t>(phase)]; }
  /// Against the lower rail, from voltages up to a common one; NaN where nothing ties the winding
  /// to a rail.
  PhaseValues terminal_voltages(PhaseValues terminal_v, double bus_v) const;
  /// Out of the half bridges: with phases shorted to each other more than what enters the motor.
  PhaseValues leg_currents_a(const PhaseValues& current_a, double bus_v) const;

 private:
  // A node is a terminal, or two that are shorted, known by the first of its phases.
  struct Potential {
    double share = 0, offset_v = 0;
    double at(double bus_v) const { return share * bus_v + offset_v; }
  };

  bool attached(int phase) const;
  bool first_of_node(int phase) const { return node_[phase] == phase; }
  bool driven(int node) const;
  bool conducts(int node) const;
  int conducting() const;
  bool referenced() const { return referenced_; }
  Potential potential(int node) const;
  double node_current(int node, const PhaseValues& current_a) const;
  void tie_to_rail(PhaseValues& terminal_v, double bus_v) const;
  bool turn_off(const PhaseValues& current_a);
  bool turn_on(const PhaseValues& terminal_v, double bus_v);
  void take_over(int node, const PhaseValues& current_a);
  void lay_out_nodes();
  void connect();
  double short_conductance() const;

  InverterParameters inverter_;
  std::array<bool, 3> absent_{};
  bool healthy_ = true;  // no fault, no phase absent
  bool needs_edges_ = false;
  BridgeFaults faults_;
  std::array<int, 3> node_{0, 1, 2};  // of each phase; -1: not attached
  std::array<Gate, 3> wanted_{};      // as commanded
  std::array<Gate, 3> gates_{};       // after faults
  std::array<bool, 3> both_on_{};     // a leg that shorts the link
  std::array<bool, 3> was_driven_{};  // by node
  PhaseValues share_{};
  std::array<Diode, 3> diodes_{};  // by node
  Connection connection_;
  bool watched_ = false, some_blocked_ = false, referenced_ = false;
};

}  // namespace virtdrive
