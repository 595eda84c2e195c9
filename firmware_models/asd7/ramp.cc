#include "firmware_models/asd7/ramp.h"

#include <algorithm>
#include <cmath>

namespace virtdrive::asd7 {

void Ramp::put(double hz) {
  hz_ = hz;
  slope_ = 0;
}

void Ramp::follow(double target_hz, const RampRate& rate, double step_s) {
  const double distance = std::fabs(target_hz - hz_);
  if (distance == 0) {
    slope_ = 0;
    return;
  }
  const bool up = target_hz > hz_;
  const double slope = next_slope(distance, up, rate, step_s);
  if (slope * step_s >= distance) {
    hz_ = target_hz;
    slope_ = 0;
    return;
  }
  slope_ = up ? slope : -slope;
  hz_ += slope_ * step_s;
}

double Ramp::next_slope(double distance, bool up, const RampRate& rate, double step_s) const {
  double most = up ? rate.up_hz_per_s : rate.down_hz_per_s;
  if (rate.shape == RampShape::kLinear) return most;
  if (rate.shape == RampShape::kS2 && hz_ > rate.base_hz) {
    most *= (rate.base_hz / hz_) * (rate.base_hz / hz_);
  }
  // The slope itself has a slope: full within the rounded share of the whole ramp's time.
  const double whole_s = up ? rate.up_s : rate.down_s;
  const auto bend = [&](double share) { return most / std::max(share * whole_s, step_s); };
  const double opening = bend(up ? rate.lower : rate.upper);
  const double closing = bend(up ? rate.upper : rate.lower);
  const bool same_way = (slope_ > 0) == up;
  const double now = same_way ? std::fabs(slope_) : 0;
  constexpr double kLeast = 0.02;  // it arrives
  if (distance <= now * now / (2 * closing) + now * step_s) {
    return std::max(now - closing * step_s, kLeast * most);
  }
  return std::min(now + opening * step_s, most);
}

}  // namespace virtdrive::asd7
