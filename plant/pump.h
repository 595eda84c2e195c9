// A centrifugal pump with what it pumps into: the process that an AC drive's PI control sees.
//
//   head(q) = shut-off head * (n / n_rated)^2 - k q^2            (affinity laws)
//   C dp/dt = q - demand * K sqrt(p)                             an air vessel, and consumers
//
// A check valve keeps q at 0 or above: below the speed at which the head reaches the pressure
// nothing flows. The shaft sees the load k w^2 (`Load::quadratic_nm_per_radps2`): the torque that a
// throttled pump saves is left out. Flow settles at once; the pressure is a state.
#pragma once

#include "core/sim_time.h"

namespace virtdrive {

struct PumpParameters {
  double rated_radps = 180;  // > 0
  double rated_m3h = 10;     // > 0: flow at rated speed and demand 1
  double rated_bar = 4;      // > 0: pressure there
  double shutoff_bar = 5;    // above rated_bar + static_bar: head at rated speed without flow
  double static_bar = 0;     // >= 0: lift up to the vessel
  double vessel_m3_per_bar = 2e-3;  // > 0: what the vessel takes for a bar more
};

class Pump {
 public:
  /// Throws SetupError for parameters out of range. Starts empty of pressure at time 0.
  explicit Pump(const PumpParameters& parameters);

  /// The shaft has turned at this speed since the last call; `t` not before that.
  void advance_to(SimTime t, double speed_radps);
  /// How far consumers have opened, 0..2; 1: the rated flow at the rated pressure.
  void set_demand(double demand);

  double demand() const { return demand_; }
  double pressure_bar() const { return pressure_bar_; }
  /// Out of the pump.
  double flow_m3h() const { return flow_m3h_; }
  /// To the consumers.
  double demand_m3h() const { return demand_m3h(pressure_bar_); }

 private:
  double flow_m3h(double pressure_bar, double speed) const;
  double demand_m3h(double pressure_bar) const;

  PumpParameters p_;
  double slope_bar_;  // per (m3/h)^2
  double opening_;    // m3/h per root bar at demand 1
  double demand_ = 1;
  double pressure_bar_ = 0, flow_m3h_ = 0;
  SimTime now_ = kSimStart;
};

}  // namespace virtdrive
