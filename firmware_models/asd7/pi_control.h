// PI control of a process by the output frequency. Set-point and process value are in Hz: that of
// the frequency command, and an analog input's by its two points.
#pragma once

#include <algorithm>

namespace virtdrive::asd7 {

class PiControl {
 public:
  struct Gains {
    double proportional = 0.3;  // Hz per Hz
    double integral_per_s = 0.2;
    double filter_s = 0.1;
    double least_hz = 0, most_hz = 60;
  };
  /// Starts from an output and a process value.
  void start(double output_hz, double feedback_hz) {
    integral_hz_ = output_hz;
    feedback_hz_ = feedback_hz;
  }
  double step(double command_hz, double feedback_hz, const Gains& g, double step_s) {
    feedback_hz_ += (feedback_hz - feedback_hz_) * std::min(1.0, step_s / (g.filter_s + step_s));
    const double error = command_hz - feedback_hz_;
    const double wanted = integral_hz_ + g.proportional * error;
    // No wind-up: the integral stops at the limit that the output meets.
    const bool stuck = (wanted > g.most_hz && error > 0) || (wanted < g.least_hz && error < 0);
    if (!stuck) integral_hz_ += g.integral_per_s * error * step_s;
    integral_hz_ = std::clamp(integral_hz_, g.least_hz, g.most_hz);
    return std::clamp(integral_hz_ + g.proportional * error, g.least_hz, g.most_hz);
  }
  double feedback_hz() const { return feedback_hz_; }

 private:
  double integral_hz_ = 0, feedback_hz_ = 0;
};

}  // namespace virtdrive::asd7
