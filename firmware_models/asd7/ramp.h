// From one frequency to the next: a straight line, or one whose ends are rounded.
#pragma once

#include "firmware_models/asd7/settings.h"

namespace virtdrive::asd7 {

/// How fast and in what shape; frequencies are magnitudes.
struct RampRate {
  double up_hz_per_s = 1, down_hz_per_s = 1;  // > 0
  RampShape shape = RampShape::kLinear;
  double up_s = 0, down_s = 0;  // from 0 to FH and back: what lower and upper are shares of
  double lower = 0, upper = 0;  // 0..0.5: rounded near the lower, near the upper frequency
  double base_hz = 60;          // kS2: above, the slope falls with the square
};

class Ramp {
 public:
  double hz() const { return hz_; }
  /// In Hz/s, of the last step.
  double slope() const { return slope_; }
  void put(double hz);
  /// Ends exactly on the target.
  void follow(double target_hz, const RampRate& rate, double step_s);
  /// Stays where it is for a step.
  void hold() { slope_ = 0; }

 private:
  double next_slope(double distance, bool up, const RampRate& rate, double step_s) const;

  double hz_ = 0, slope_ = 0;
};

}  // namespace virtdrive::asd7
