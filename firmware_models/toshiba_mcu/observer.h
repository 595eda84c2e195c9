// The angle without a sensor: open loop in Force, led by the back-EMF in FOC.
//
// The d-axis back-EMF is zero while the frame lies on the rotor and positive when it leads:
//   Ed = Vd - R Id + w L Iq,   w = w_base - sign(w_base) Kp Ed,   theta += w / PWM frequency
// w_base is the ramped command; with an encoder for speed, what that measures.
#pragma once

#include "firmware_models/toshiba_mcu/loop_state.h"
#include "firmware_models/toshiba_mcu/scaling.h"
#include "firmware_models/toshiba_mcu/stage.h"

namespace virtdrive::toshiba_mcu {

class Observer {
 public:
  /// One PWM period on. Stages other than Force and FOC hold the angle.
  void advance(Stage stage, double base_hz, const Scaling& scaling, LoopState& now);
  /// The frame goes to angle 0: the rotor will be pulled there.
  void align(LoopState& now);

  /// Half a turn on, with every quantity of the frame taken along: the vectors stay where they are.
  static void turn_frame_over(LoopState& now);

  /// Electrical turns since the reset, in whole and parts: goes on over starts and stops.
  double electrical_turns() const { return turns_; }

 private:
  double turns_ = 0;
};

}  // namespace virtdrive::toshiba_mcu
