// The V/f curve: which voltage belongs to a frequency.
#pragma once

#include <algorithm>

#include "firmware_models/asd7/settings.h"

namespace virtdrive::asd7 {

struct VoltageCurve {
  VoltsPerHertz kind = VoltsPerHertz::kConstantTorque;
  double motor_v = 0;  // rms, line to line, at the base frequency and above
  double base_hz = 60;
  double boost = 0;   // share of motor_v at 0 Hz
  double drop_v = 0;  // automatic boost: the stator's drop at the present current

  /// Line to line, rms.
  double at(double hz) const {
    const double x = std::min(hz / base_hz, 1.0);
    switch (kind) {
      case VoltsPerHertz::kConstantTorque:
        return motor_v * (boost + (1 - boost) * x);
      case VoltsPerHertz::kVariableTorque:
        return motor_v * (boost + (1 - boost) * x * x);
      case VoltsPerHertz::kAutomaticBoost:
      case VoltsPerHertz::kAutomaticBoostAndSlip:
        return std::min(motor_v, motor_v * x + drop_v);
    }
    return 0;
  }
};

}  // namespace virtdrive::asd7
