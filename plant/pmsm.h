// The permanent-magnet synchronous machine in its rotor frame: linear inductances, Ld != Lq, a
// sinusoidal EMF.
//
//   Ld did/dt = vd - R id + we Lq iq
//   Lq diq/dt = vq - R iq - we (Ld id + psi)
//   torque    = 1.5 p (psi iq + (Ld - Lq) id iq)
//
// (R. H. Park 1929; in this form e.g. W. Leonhard, "Control of Electrical Drives", chapter 14.)
// Amplitude-invariant: a current is the peak of the phase current, psi the peak flux per phase.
#pragma once

#include "plant/transforms.h"

namespace virtdrive {

struct PmsmParameters {
  int pole_pairs = 1;
  double resistance_ohm = 0;   // per phase, >= 0
  double inductance_d_h = 0;   // per phase, > 0
  double inductance_q_h = 0;   // per phase, > 0
  double flux_wb = 0;          // of the magnets, linked per phase, peak
  double rated_current_a = 1;  // as the data sheet prints it; scales tolerances only
};

/// Throws SetupError unless every value is finite and in its range.
void validate(const PmsmParameters& motor);

/// dI/dt in A/s. `speed_radps` is electrical.
inline Dq current_derivative(const PmsmParameters& motor, Dq current_a, Dq voltage_v,
                             double speed_radps) {
  const double flux_d = motor.inductance_d_h * current_a.d + motor.flux_wb;
  const double flux_q = motor.inductance_q_h * current_a.q;
  return {(voltage_v.d - motor.resistance_ohm * current_a.d + speed_radps * flux_q) /
              motor.inductance_d_h,
          (voltage_v.q - motor.resistance_ohm * current_a.q - speed_radps * flux_d) /
              motor.inductance_q_h};
}

/// Air-gap torque in Nm.
inline double torque_nm(const PmsmParameters& motor, Dq current_a) {
  return 1.5 * motor.pole_pairs *
         (motor.flux_wb + (motor.inductance_d_h - motor.inductance_q_h) * current_a.d) *
         current_a.q;
}

/// The voltage that holds a current at a constant speed (electrical).
Dq steady_state_voltage_v(const PmsmParameters& motor, Dq current_a, double speed_radps);

/// Maximum torque per ampere: the split of a current of this peak (sign: the torque's) that gives
/// the most torque.
Dq mtpa_current_a(const PmsmParameters& motor, double amplitude_a);

}  // namespace virtdrive
