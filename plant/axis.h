// One machine on its bench: inverter bridge, DC link, motor, shaft and load as one hybrid system.
//
//   Axis axis({motor, inverter, link, mechanics}, Integrator::kDefault);
//   axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.6, 0.5, 0.4}, .pwm_period = 80us});
//   axis.advance_to(t);
//   axis.state().speed_radps;
//
// Inputs are held: what is set holds from now() on, so whoever changes one first advances the axis
// to the moment of the change. Between two inputs the axis finds its own state events (a diode's
// current reaches 0, the shaft stops or breaks away, the source starts or stops feeding) and runs
// its own time events (the gates within a period of a pulsed short, the dead time's new sign).
// Two axes share nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "core/sim_time.h"
#include "plant/dc_link.h"
#include "plant/inverter.h"
#include "plant/mechanics.h"
#include "plant/ode.h"
#include "plant/pmsm.h"

namespace virtdrive {

struct AxisParameters {
  PmsmParameters motor{};
  DcLinkParameters link{};
  MechanicsParameters mechanics{};
};

struct AxisState {
  double i_d_a = 0, i_q_a = 0;  // peak of the phase current
  double speed_radps = 0;       // mechanical
  double angle_rad = 0;         // mechanical, counted on over the turns
  double bus_v = 0;
};

struct AxisCounters {
  std::uint64_t derivative_evaluations = 0;
  std::uint64_t state_events = 0;
  std::uint64_t time_events = 0;  // the axis' own
  /// Times that more than 16 events fell upon one instant and the axis was moved on by 100 ns with
  /// its modes held. Not 0: the trajectory is doubtful there; please report it.
  std::uint64_t stalled = 0;
};

class Axis {
 public:
  /// Starts at time 0, at rest at angle 0, gates off, the link charged to its source. Throws
  /// SetupError for parameters out of range.
  Axis(const AxisParameters& parameters, Integrator integrator, const Load& load = {});
  Axis(Axis&&) noexcept;
  Axis& operator=(Axis&&) noexcept;
  ~Axis();

  /// Integrates up to `t`, not before now(). Throws SetupError if the solver fails.
  void advance_to(SimTime t);
  SimTime now() const;

  void set_bridge(const BridgeCommand& command);
  /// Throws SetupError for a load out of range.
  void set_load(const Load& load);
  void set_source_voltage(double source_v);

  const AxisState& state() const;
  const AxisParameters& parameters() const;
  const Load& load() const;

  /// Into the motor.
  PhaseValues phase_currents_a() const;
  /// Air-gap torque.
  double torque_nm() const;
  /// What the load (not the motor's own friction) asks of the shaft, positive against positive
  /// rotation. At standstill the brake holds its share of what friction and brake hold together.
  double load_torque_nm() const;
  /// Out of the source; an ideal source may also take back.
  double source_current_a() const;
  /// 0 .. 2 pi.
  double electrical_angle_rad() const;

  /// Gates off, no current, no motion, the link settled: nothing can change before the next input,
  /// and advancing costs nothing.
  bool at_rest() const;
  AxisCounters counters() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace virtdrive
