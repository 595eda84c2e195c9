#include "plant/half_bridges.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of Clarke's plane: the direction of a phase.
AlphaBeta axis_of(int phase) {
  PhaseValues unit{};
  unit[static_cast<std::size_t>(phase)] = 1.5;
  return clarke(unit);
}

}  // namespace

HalfBridges::HalfBridges(const InverterParameters& inverter, std::array<bool, 3> absent)
    : inverter_(inverter), absent_(absent), healthy_(absent == std::array<bool, 3>{}) {
  lay_out_nodes();
  connect();
}

bool HalfBridges::attached(int phase) const {
  const auto x = static_cast<std::size_t>(phase);
  return !absent_[x] && !faults_.phase_open[x];
}

void HalfBridges::lay_out_nodes() {
  for (int x = 0; x < 3; ++x) node_[static_cast<std::size_t>(x)] = attached(x) ? x : -1;
  if (faults_.shorted_phases == 0) return;
  const int first = faults_.shorted_phases - 1, second = (first + 1) % 3;
  if (attached(first) && attached(second)) node_[static_cast<std::size_t>(second)] = first;
}

void HalfBridges::set_faults(const BridgeFaults& faults, const PhaseValues& current_a) {
  VIRTDRIVE_CHECK(faults.shorted_phases >= 0 && faults.shorted_phases <= 3, "shorted_phases {}",
                  faults.shorted_phases);
  const auto closed = [](SwitchFault fault) { return fault == SwitchFault::kStuckClosed; };
  const bool shorts = faults.shorted_phases != 0 || std::ranges::any_of(faults.upper, closed) ||
                      std::ranges::any_of(faults.lower, closed);
  if (shorts && inverter_.on_resistance_ohm == 0) {
    throw SetupError(
        "inverter: a shorted phase or a switch stuck closed needs on_resistance_ohm above 0, "
        "which limits the current");
  }
  if (faults == faults_) return;
  faults_ = faults;
  healthy_ = faults == BridgeFaults{} && absent_ == std::array<bool, 3>{};
  const auto broken = [](SwitchFault fault) { return fault != SwitchFault::kNone; };
  needs_edges_ =
      std::ranges::any_of(faults.upper, broken) || std::ranges::any_of(faults.lower, broken);
  lay_out_nodes();
  was_driven_ = {true, true, true};  // nodes are new: their diodes follow the currents
  const std::array<Gate, 3> wanted = std::exchange(wanted_, {});
  set_gates(wanted, share_, current_a);
}

void HalfBridges::set_gates(const std::array<Gate, 3>& gates, const PhaseValues& share,
                            const PhaseValues& current_a) {
  // A new duty for each period is what most of these calls bring.
  constexpr std::array<Gate, 3> kAllAveraged{Gate::kAveraged, Gate::kAveraged, Gate::kAveraged};
  const bool only_duty = gates == kAllAveraged && wanted_ == gates && healthy_;
  wanted_ = gates;
  share_ = share;
  if (only_duty) {
    connection_.share = clarke(share);
    connection_.driving = share[0] != share[1] || share[1] != share[2];
    connection_.plain = connection_.driving && connection_.loss_share == 0;
    return;
  }
  for (std::size_t x = 0; x < 3; ++x) {
    const bool averaged = gates[x] == Gate::kAveraged;
    bool up = gates[x] == Gate::kHigh, down = gates[x] == Gate::kLow;
    if (faults_.upper[x] != SwitchFault::kNone) up = faults_.upper[x] == SwitchFault::kStuckClosed;
    if (faults_.lower[x] != SwitchFault::kNone) {
      down = faults_.lower[x] == SwitchFault::kStuckClosed;
    }
    both_on_[x] = up && down;
    gates_[x] = averaged ? Gate::kAveraged : up ? Gate::kHigh : down ? Gate::kLow : Gate::kOff;
  }
  for (int n = 0; n < 3; ++n) {
    if (!first_of_node(n)) continue;
    const auto node = static_cast<std::size_t>(n);
    if (driven(n)) {
      diodes_[node] = Diode::kBlocked;
    } else if (was_driven_[node]) {
      take_over(n, current_a);
    }
    was_driven_[node] = driven(n);
  }
  connect();
}

bool HalfBridges::gates_off() const {
  return std::ranges::all_of(gates_, [](Gate gate) { return gate == Gate::kOff; });
}

void HalfBridges::take_over(int node, const PhaseValues& current_a) {
  const double i = node_current(node, current_a);
  diodes_[static_cast<std::size_t>(node)] = i > kZeroCurrentA    ? Diode::kLower
                                            : i < -kZeroCurrentA ? Diode::kUpper
                                                                 : Diode::kBlocked;
}

bool HalfBridges::driven(int node) const {
  for (std::size_t x = 0; x < 3; ++x) {
    if (node_[x] == node && gates_[x] != Gate::kOff) return true;
  }
  return false;
}

bool HalfBridges::conducts(int node) const {
  return driven(node) || diodes_[static_cast<std::size_t>(node)] != Diode::kBlocked;
}

int HalfBridges::conducting() const {
  int count = 0;
  for (int n = 0; n < 3; ++n) count += first_of_node(n) && conducts(n) ? 1 : 0;
  return count;
}

HalfBridges::Potential HalfBridges::potential(int node) const {
  double sum = 0;
  int on = 0;
  for (std::size_t x = 0; x < 3; ++x) {
    if (node_[x] != node || gates_[x] == Gate::kOff) continue;
    ++on;
    sum += both_on_[x]                    ? 0.5
           : gates_[x] == Gate::kAveraged ? share_[x]
           : gates_[x] == Gate::kHigh     ? 1.0
                                          : 0.0;
  }
  if (on > 0) return {sum / on, 0};
  switch (diodes_[static_cast<std::size_t>(node)]) {
    case Diode::kUpper:
      return {1, inverter_.diode_v};
    case Diode::kLower:
      return {0, -inverter_.diode_v};
    case Diode::kBlocked:
      break;
  }
  return {};
}

double HalfBridges::node_current(int node, const PhaseValues& current_a) const {
  double sum = 0;
  for (std::size_t x = 0; x < 3; ++x) sum += node_[x] == node ? current_a[x] : 0;
  return sum;
}

void HalfBridges::connect() {
  if (conducting() < 2) diodes_ = {};  // a single node has nowhere to send its current
  Connection c;
  PhaseValues share{}, offset{};
  int floating = -1, connected = 0;
  bool shorted = false;
  watched_ = some_blocked_ = referenced_ = false;
  for (int x = 0; x < 3; ++x) {
    const auto phase = static_cast<std::size_t>(x);
    const int node = node_[phase];
    const bool conducting_phase = node >= 0 && conducts(node);
    shorted = shorted || (node >= 0 && node != x);
    if (!conducting_phase) {
      floating = x;
      some_blocked_ = some_blocked_ || node >= 0;
      continue;
    }
    ++connected;
    referenced_ = true;
    const Potential p = potential(node);
    share[phase] = p.share;
    offset[phase] = p.offset_v;
    watched_ = watched_ || !driven(node);
  }
  watched_ = watched_ || some_blocked_;
  c.conduction = connected == 3   ? Conduction::kTerminals
                 : connected == 2 ? Conduction::kSeries
                                  : Conduction::kOpen;
  if (shorted && c.conduction != Conduction::kTerminals) {
    // The two shorted phases carry a current of their own; the third has none to go to.
    c.conduction = Conduction::kSeries;
    for (int x = 0; x < 3; ++x) {
      const bool pair = x == faults_.shorted_phases - 1 || x == faults_.shorted_phases % 3;
      if (!pair) floating = x;
    }
    share[static_cast<std::size_t>(floating)] = offset[static_cast<std::size_t>(floating)] = 0;
  }
  if (c.conduction == Conduction::kSeries) {
    c.floating = floating;
    c.floating_axis = axis_of(floating);
  }
  c.share = clarke(share);
  c.offset_v = clarke(offset);
  c.offset = c.offset_v.alpha != 0 || c.offset_v.beta != 0;
  c.driving = c.conduction != Conduction::kTerminals || share[0] != share[1] ||
              share[1] != share[2] || offset[0] != offset[1] || offset[1] != offset[2];
  c.short_conductance = short_conductance();
  c.loss_share = c.conduction == Conduction::kOpen ? 0 : inverter_.loss_share / std::numbers::sqrt2;
  c.plain = c.loss_share == 0 && c.driving && c.conduction == Conduction::kTerminals && !c.offset &&
            c.short_conductance == 0;
  connection_ = c;
}

double HalfBridges::short_conductance() const {
  double sum = 0;
  const double two_switches = 2 * inverter_.on_resistance_ohm;
  for (std::size_t x = 0; x < 3; ++x) {
    if (both_on_[x]) sum += 1 / two_switches;
    const std::size_t y = (x + 1) % 3;
    const bool tied = node_[x] >= 0 && node_[x] == node_[y];
    if (tied && gates_[x] != Gate::kOff && gates_[y] != Gate::kOff) {
      const auto level = [&](std::size_t leg) {
        return gates_[leg] == Gate::kAveraged ? share_[leg] : gates_[leg] == Gate::kHigh ? 1.0 : 0;
      };
      sum += std::fabs(level(x) - level(y)) / two_switches;
    }
  }
  return sum;
}

PhaseValues HalfBridges::leg_currents_a(const PhaseValues& current_a, double bus_v) const {
  PhaseValues legs = current_a;
  for (std::size_t x = 0; x < 3; ++x) {
    const std::size_t y = (x + 1) % 3;
    if (node_[x] < 0 || node_[x] != node_[y]) continue;
    const double sum = current_a[x] + current_a[y];
    const bool x_on = gates_[x] != Gate::kOff, y_on = gates_[y] != Gate::kOff;
    double across = 0;
    if (x_on && y_on) {
      const auto level = [&](std::size_t leg) {
        return gates_[leg] == Gate::kAveraged ? share_[leg] : gates_[leg] == Gate::kHigh ? 1.0 : 0;
      };
      across = (level(x) - level(y)) * bus_v / (2 * inverter_.on_resistance_ohm);
    }
    const double part = x_on == y_on ? 0.5 : x_on ? 1.0 : 0.0;
    legs[x] = part * sum + across;
    legs[y] = (1 - part) * sum - across;
  }
  return legs;
}

void HalfBridges::tie_to_rail(PhaseValues& terminal_v, double bus_v) const {
  for (int n = 0; n < 3; ++n) {
    if (!first_of_node(n) || !conducts(n)) continue;
    const double shift = potential(n).at(bus_v) - terminal_v[static_cast<std::size_t>(n)];
    for (double& v : terminal_v) v += shift;
    return;
  }
}

PhaseValues HalfBridges::terminal_voltages(PhaseValues terminal_v, double bus_v) const {
  if (!referenced_) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    return {unknown, unknown, unknown};
  }
  tie_to_rail(terminal_v, bus_v);
  for (std::size_t x = 0; x < 3; ++x) {
    if (node_[x] >= 0 && conducts(node_[x])) terminal_v[x] = potential(node_[x]).at(bus_v);
  }
  return terminal_v;
}

double HalfBridges::margin(const PhaseValues& current_a, PhaseValues terminal_v,
                           double bus_v) const {
  double least = kInfinity;
  const double beyond = inverter_.diode_v + kDiodeHysteresisV;
  if (some_blocked_) tie_to_rail(terminal_v, bus_v);
  double highest = -kInfinity, lowest = kInfinity;
  for (int n = 0; n < 3; ++n) {
    if (!first_of_node(n) || driven(n)) continue;
    const auto node = static_cast<std::size_t>(n);
    if (diodes_[node] != Diode::kBlocked) {
      const double i = node_current(n, current_a);
      least = std::min(least, (diodes_[node] == Diode::kLower ? i : -i) + kZeroCurrentA);
    } else {
      highest = std::max(highest, terminal_v[node]);
      lowest = std::min(lowest, terminal_v[node]);
    }
  }
  if (highest == -kInfinity) return least;
  if (!referenced_) return std::min(least, bus_v + 2 * beyond - (highest - lowest));
  return std::min({least, bus_v + beyond - highest, lowest + beyond});
}

bool HalfBridges::follow(const PhaseValues& current_a, PhaseValues terminal_v, double bus_v) {
  if (some_blocked_) tie_to_rail(terminal_v, bus_v);
  if (!turn_off(current_a) && !turn_on(terminal_v, bus_v)) return false;
  connect();
  return true;
}

bool HalfBridges::turn_off(const PhaseValues& current_a) {
  bool changed = false;
  for (int n = 0; n < 3; ++n) {
    const auto node = static_cast<std::size_t>(n);
    if (!first_of_node(n) || diodes_[node] == Diode::kBlocked) continue;
    const double i = node_current(n, current_a);
    if ((diodes_[node] == Diode::kLower ? i : -i) + kZeroCurrentA > 0) continue;
    diodes_[node] = Diode::kBlocked;
    changed = true;
  }
  if (changed && gates_off()) {
    // Two that share a current equally lose it when the third does: none of them sees it cross 0.
    const auto gone = [&](int n) {
      return std::fabs(node_current(n, current_a)) <= 2 * kZeroCurrentA;
    };
    if (gone(0) && gone(1) && gone(2)) diodes_ = {};
  }
  return changed;
}

bool HalfBridges::turn_on(const PhaseValues& terminal_v, double bus_v) {
  const double beyond = inverter_.diode_v + kDiodeHysteresisV;
  int highest = -1, lowest = -1;
  bool changed = false;
  for (int n = 0; n < 3; ++n) {
    if (!first_of_node(n) || conducts(n)) continue;
    const auto node = static_cast<std::size_t>(n);
    if (highest < 0 || terminal_v[node] > terminal_v[static_cast<std::size_t>(highest)]) {
      highest = n;
    }
    if (lowest < 0 || terminal_v[node] < terminal_v[static_cast<std::size_t>(lowest)]) lowest = n;
  }
  if (highest < 0) return false;
  const auto top = static_cast<std::size_t>(highest), bottom = static_cast<std::size_t>(lowest);
  if (!referenced_) {
    if (terminal_v[top] - terminal_v[bottom] < bus_v + 2 * beyond) return false;
    diodes_[top] = Diode::kUpper;
    diodes_[bottom] = Diode::kLower;
    return true;
  }
  if (terminal_v[top] >= bus_v + beyond) {
    diodes_[top] = Diode::kUpper;
    changed = true;
  }
  if (terminal_v[bottom] <= -beyond) {
    diodes_[bottom] = Diode::kLower;
    changed = true;
  }
  return changed;
}

}  // namespace virtdrive
