// The edges of a switched bridge: centre-aligned PWM with dead time, one period after the other.
#pragma once

#include <array>

#include "core/sim_time.h"
#include "plant/half_bridges.h"

namespace virtdrive {

class PwmEdges {
 public:
  /// A period starts; the legs' commands hold for it.
  void start_period(SimTime now, const BridgeCommand& command);
  /// When the next gate changes (kNever: none before the period's end).
  SimTime next() const;
  SimTime period_end() const { return end_; }
  /// Takes the changes that are due.
  void run(SimTime now);
  /// Gates off now, at once.
  void stop();

  const std::array<Gate, 3>& gates() const { return gates_; }

 private:
  struct Half {
    SimTime rise = kNever, fall = kNever;  // of the command
    SimTime turn_on = kNever;              // the dead time's end
    Gate wanted = Gate::kOff;
  };

  void want(std::size_t leg, Gate gate, SimTime now);

  SimDuration dead_time_{0};
  SimTime end_ = kNever;
  std::array<Half, 3> legs_{};
  std::array<Gate, 3> gates_{};
};

}  // namespace virtdrive
