// What a motor can do at steady state, by its equations and two limits: derived constants, torque
// over speed, operating points with their losses.
//
//   const SteadyMotor steady(motor);
//   const MotorConstants k = motor_constants(steady);
//   const auto point = most_torque(steady, limits_of(motor), 300);
//
// Method. Three phases: in the rotor frame at constant currents,
//   v = R i + w x psi(i),   torque = 1.5 p (psi_d iq - psi_q id) - (b w + Tc)
// within |i| <= the current limit and |v| <= Vdc / sqrt(3), the longest vector that space-vector
// modulation puts out without distortion. Of an EMF that is no sine its fundamental counts: that is
// the machine under vector control; block commutation reaches less, for each commutation takes
// time. Two terminals: u = R i + K w within |u| <= Vdc. Losses are those of copper and friction;
// the inverter's, the iron's and those of the ripple are left out. Field weakening is a drive's
// choice: the curves show what is possible with it. A voice coil's "torque" is its force, its
// "speed" m/s.
#pragma once

#include <optional>

#include "plant/motor_library.h"

namespace virtdrive {

/// A motor prepared for many points. Valid as long as its Motor.
class SteadyMotor {
 public:
  SteadyMotor(const Motor& motor);  // NOLINT: a motor is what it says

  const Motor& motor() const { return *motor_; }
  /// Brushes or a coil: one current, `q`, in one winding.
  bool two_terminals() const { return motor_->effects.commutator; }
  bool saturated() const { return map_.has_value(); }

  /// Of the equivalent sine machine, or of the one winding between its terminals.
  double resistance_ohm() const { return machine_.resistance_ohm; }
  const PmsmParameters& machine() const { return machine_; }
  Dq flux_wb(Dq current_a) const;
  double air_gap_nm(Dq current_a) const;
  Dq voltage_v(Dq current_a, double speed_radps) const;
  double friction_nm(double speed_radps) const;
  /// Copper loss is this times R times the square of the current.
  double phases() const { return two_terminals() ? 1 : 1.5; }

 private:
  const Motor* motor_;
  PmsmParameters machine_;
  std::optional<FluxMap> map_;  // with saturation
};

struct MotorConstants {
  double torque_constant_nm_per_a = 0;     // per peak of the phase current, id = 0
  double torque_constant_nm_per_arms = 0;  // per rms
  double emf_v_per_radps = 0;              // per phase, peak, mechanical speed
  double line_emf_vrms_per_krpm = 0;
  double speed_constant_rpm_per_v = 0;    // per volt of the line-to-line EMF's peak ("kv")
  double motor_constant_nm_per_rtw = 0;   // torque per root of copper loss
  double electrical_time_constant_s = 0;  // Lq / R; infinite without resistance
  double mechanical_time_constant_s = 0;  // J R / (1.5 p^2 psi^2), voltage-driven, no inductance
  double rated_peak_a = 0;                // peak of the phase current at the rated current
  double characteristic_current_a = 0;    // psi / Ld: of a short circuit at high speed, peak
  double stall_current_a = 0;             // (Vdc / sqrt(3)) / R at standstill, peak
  double no_load_radps = 0;               // at rated voltage with id = 0, friction only
  double base_radps = 0;                  // up to where rated current gives its full torque
  double rated_torque_nm = 0;             // at the shaft, at low speed and rated current
};

MotorConstants motor_constants(const SteadyMotor& steady);

/// Of three phases both as peaks of a phase's sine, of two terminals what is between them.
struct DriveLimits {
  double voltage_v = 0;
  double current_a = 0;
};
/// At rated voltage, with the rated or (`peak`) the peak current.
DriveLimits limits_of(const Motor& motor, bool peak = false);

struct OperatingPoint {
  double speed_radps = 0;
  double torque_nm = 0;  // at the shaft
  Dq current_a;
  Dq voltage_v;
  double output_w = 0;  // at the shaft
  double input_w = 0;   // into the motor's terminals

  double current_peak_a() const;
  /// 0 unless both powers are positive.
  double efficiency() const;
};

/// The most torque at a speed >= 0; none if no current within the limits holds this speed.
std::optional<OperatingPoint> most_torque(const SteadyMotor& steady, const DriveLimits& limits,
                                          double speed_radps);

/// The least current for a shaft torque >= 0 at a speed >= 0: maximum torque per ampere, and above
/// the voltage limit as much negative id as it takes; none if it is out of reach.
std::optional<OperatingPoint> least_current(const SteadyMotor& steady, const DriveLimits& limits,
                                            double torque_nm, double speed_radps);

}  // namespace virtdrive
