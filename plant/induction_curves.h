// An induction machine on a stiff sinusoidal supply, at steady state: its equivalent circuit.
//
//   const InductionPoint rated = induction_at_power(motor, rated_supply(motor), 750);
//   const InductionPoint locked = induction_point(motor, rated_supply(motor), 1);
//
// T circuit per phase with the main inductance that belongs to the main flux it finds; friction and
// iron loss act on the shaft, as they do in the model that is integrated (machine.h). Temperatures
// are those that the parameters refer to.
#pragma once

#include "plant/motor_library.h"

namespace virtdrive {

struct InductionSupply {
  double line_v = 0;  // rms, between two lines
  double frequency_hz = 0;
};
/// Of the motor's rating.
InductionSupply rated_supply(const Motor& motor);

struct InductionPoint {
  double slip = 0;
  double speed_radps = 0;
  double air_gap_nm = 0;    // without iron loss
  double torque_nm = 0;     // at the shaft
  double current_a = 0;     // rms
  double main_flux_wb = 0;  // peak
  double input_w = 0, output_w = 0;
  double power_factor = 0;

  double efficiency() const { return input_w > 0 && output_w > 0 ? output_w / input_w : 0; }
};

/// Slip 1: standstill, 0: synchronous, below 0: generating.
InductionPoint induction_point(const Motor& motor, const InductionSupply& supply, double slip);
/// Where the shaft gives this power, on the stable side of the breakdown torque.
InductionPoint induction_at_power(const Motor& motor, const InductionSupply& supply,
                                  double power_w);
/// Of the most torque at the shaft.
InductionPoint induction_breakdown(const Motor& motor, const InductionSupply& supply);
/// Shaft torque 0.
InductionPoint induction_no_load(const Motor& motor, const InductionSupply& supply);

}  // namespace virtdrive
