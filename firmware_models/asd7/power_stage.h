// What lies between the program and the motor: the bridge with its modulator, two current
// detectors, the link's divider. A voltage vector is given each turn of the modulator and holds
// until the next one, averaged over the carrier; the dead time is compensated by the modulator.
#pragma once

#include "core/random.h"
#include "plant/axis.h"
#include "plant/sensors.h"

namespace virtdrive::asd7 {

struct Measured {
  PhaseValues current_a{};
  AlphaBeta current;    // peak
  double current2 = 0;  // square of the rms value
  double bus_v = 0;
};

class PowerStage {
 public:
  /// `name` names the noise's stream.
  PowerStage(Axis& axis, double rated_current_a, double full_scale_v, const Seed& seed);

  Measured sample();
  /// Phase voltages as a vector (peak), cut to what the link can give; `bus_v` as measured.
  /// Returns what it gives.
  AlphaBeta put(AlphaBeta voltage_v, double bus_v);
  void off();
  bool on() const { return on_; }

 private:
  Axis& axis_;
  RandomStream noise_;
  CurrentSensor detector_;
  VoltageSensor divider_;
  bool on_ = false;
};

}  // namespace virtdrive::asd7
