// A machine on its bench: inverter bridge, motor, shaft and load, on a DC link that it has to
// itself or shares with others, as one hybrid system.
//
//   Axis axis({motor, link, mechanics}, Integrator::kDefault);
//   axis.set_bridge({.mode = Bridge::kDriven, .duty = {0.6, 0.5, 0.4}, .pwm_period = 80us});
//   axis.advance_to(t);
//   axis.state().speed_radps;
//
//   DcBus bus({.source_v = 48}, Integrator::kFast);      // several axes on one link
//   Axis left({motor, {}, mechanics}, bus), right({motor, {}, mechanics}, bus);
//
// Inputs are held: what is set holds from now() on, so whoever changes one first advances the axis
// to the moment of the change. Between two inputs the axis finds its own state events (a diode
// turns on or off, the shaft stops or breaks away, the source starts or stops feeding) and runs its
// own time events (PWM edges, the dead time's new sign, the steps of a torque profile).
//
// Axes on one link are one circuit: they are integrated together, and to advance one advances all.
// An axis at rest has no part in it and costs nothing. Axes on different links share nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/sim_time.h"
#include "plant/dc_link.h"
#include "plant/inverter.h"
#include "plant/machine.h"
#include "plant/mechanics.h"
#include "plant/ode.h"

namespace virtdrive {

struct AxisParameters {
  PmsmParameters motor{};
  DcLinkParameters link{};  // of an axis with a link to itself
  MechanicsParameters mechanics{};
  InverterParameters inverter{};
  MachineEffects effects{};
};

struct AxisState {
  // Peak of the phase current; brushed: 2/sqrt(3) of it is i_q; induction machine: alpha and beta.
  double i_d_a = 0, i_q_a = 0;
  double speed_radps = 0;  // mechanical
  double angle_rad = 0;    // mechanical, counted on over the turns
  double bus_v = 0;
};

struct AxisCounters {
  std::uint64_t derivative_evaluations = 0;  // of the whole circuit, like the next two
  std::uint64_t state_events = 0;
  /// Times that more than 16 events fell upon one instant and the circuit was moved on by 100 ns
  /// with its modes held. Not 0: the trajectory is doubtful there; please report it.
  std::uint64_t stalled = 0;
  std::uint64_t time_events = 0;  // the axis' own
};

/// One step of a torque profile: from `at` on (from the profile's start) this external torque is
/// added to the load's.
struct TorqueStep {
  SimDuration at{0};
  double torque_nm = 0;
};

struct Circuit;
class AxisUnit;

/// Relative tolerance of Integrator::kDefault; absolute ones follow from the motor's ratings.
inline constexpr double kDefaultTolerance = 1e-6;

class DcBus {
 public:
  /// Starts at time 0, charged to its source. Throws SetupError for parameters out of range.
  explicit DcBus(const DcLinkParameters& parameters, Integrator integrator,
                 double tolerance = kDefaultTolerance);

  /// Integrates all axes of the bus up to `t`, not before now(). Throws SetupError if the solver
  /// fails.
  void advance_to(SimTime t);
  SimTime now() const;

  void set_source_voltage(double source_v);
  /// The supply's switch; switched off, the capacitor feeds the board and the axes.
  void set_supply(bool on);

  /// Of a link on mains: dips, lost phases, the charging contact. Levels are 0..1.5.
  void set_mains(const MainsInput& input);
  const MainsInput& mains() const;
  /// Whether the chopper may turn on; it may from the start.
  void set_chopper(bool enabled);

  const DcLinkParameters& parameters() const;
  bool supply_on() const;
  double voltage_v() const;
  /// Out of the source; an ideal source or a battery may also take back.
  double source_current_a() const;
  bool chopper_on() const;
  /// Of its resistor; ambient if there is none.
  double chopper_degc() const;
  /// All axes are at rest and the voltage has settled: to advance costs nothing.
  bool at_rest() const;

 private:
  friend class Axis;
  explicit DcBus(std::shared_ptr<Circuit> circuit) : circuit_(std::move(circuit)) {}

  std::shared_ptr<Circuit> circuit_;
};

class Axis {
 public:
  /// On a link to itself. Starts at time 0, at rest at angle 0, gates off. Throws SetupError for
  /// parameters out of range.
  Axis(const AxisParameters& parameters, Integrator integrator, const Load& load = {},
       double tolerance = kDefaultTolerance);
  /// On a bus with others (`parameters.link` is not used), as long as the bus lives. Starts at the
  /// bus' now().
  Axis(const AxisParameters& parameters, const DcBus& bus, const Load& load = {});

  /// Advances the whole bus.
  void advance_to(SimTime t);
  SimTime now() const;
  DcBus bus() const { return DcBus(circuit_); }

  void set_bridge(const BridgeCommand& command);
  /// Throws SetupError if a fault needs a resistance that the inverter has not.
  void set_bridge_faults(const BridgeFaults& faults);
  /// Throws SetupError for a load out of range.
  void set_load(const Load& load);
  /// Added to the load's external torque from now() on; empty: none. In order of time.
  void set_torque_profile(std::vector<TorqueStep> profile);
  void set_source_voltage(double source_v);
  /// Puts rotor and load to an angle and a speed (of the rotor), as a test bench's drive would.
  void set_motion(double angle_rad, double speed_radps);
  void set_temperatures(double winding_degc, double magnet_degc);

  const AxisState& state() const;
  const AxisParameters& parameters() const;
  const Load& load() const;
  const BridgeFaults& bridge_faults() const;

  /// Into the motor.
  PhaseValues phase_currents_a() const;
  /// Out of the half bridges: what shunts see when phases are shorted.
  PhaseValues leg_currents_a() const;
  /// What the bridge takes from the link.
  double link_current_a() const;
  /// At the terminals, against the lower rail; NaN where nothing ties the winding to a rail.
  PhaseValues terminal_voltages_v() const;
  /// Of an induction machine: main flux, peak, linked per phase; else 0.
  double main_flux_wb() const;
  /// Air-gap torque.
  double torque_nm() const;
  /// What the load (not the motor's own friction) asks of the shaft, positive against positive
  /// rotation. At standstill the brake holds its share of what friction and brake hold together.
  double load_torque_nm() const;
  /// At the load's side of the transmission.
  double load_speed_radps() const;
  double load_angle_rad() const;
  double winding_degc() const;
  double magnet_degc() const;
  /// Out of the source; an ideal source may also take back.
  double source_current_a() const;
  /// 0 .. 2 pi.
  double electrical_angle_rad() const;

  /// Gates off, no current, no motion: nothing can change before the next input. With the link
  /// settled as well, advancing costs nothing.
  bool at_rest() const;
  AxisCounters counters() const;

 private:
  std::shared_ptr<Circuit> circuit_;
  AxisUnit* unit_ = nullptr;  // the circuit's
};

}  // namespace virtdrive
