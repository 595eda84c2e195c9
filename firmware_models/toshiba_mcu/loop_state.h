// The registers of a channel's control loop, in SI units: what the last PWM interrupt left there.
//
// The program computes with them, the oscilloscope shows them, recordings read them.
#pragma once

#include "plant/transforms.h"

namespace virtdrive::toshiba_mcu {

/// Currents are phase peaks; frequencies electrical; d and q those of the drive's own frame.
struct LoopState {
  PhaseValues current_a{};  // measured
  double i_alpha_a = 0, i_beta_a = 0;
  double id_a = 0, iq_a = 0, id_ref_a = 0, iq_ref_a = 0;
  double iq_integral_a = 0;  // the speed controller's integral part; in Force the current put in

  double vd_integral_v = 0, vq_integral_v = 0;
  double vd_v = 0, vq_v = 0;
  double v_alpha_v = 0, v_beta_v = 0;
  PhaseValues duty{};

  double theta_turns = 0;  // 0..1
  double sine = 0, cosine = 1;
  double omega_hz = 0;       // turns theta
  double omega_calc_hz = 0;  // the position estimator's; in Force calculated, not used
  double command_hz = 0;     // ramped
  double bus_v = 0;
};

}  // namespace virtdrive::toshiba_mcu
