#include "firmware_models/toshiba_mcu/external_speed.h"

#include <algorithm>
#include <cmath>

#include "firmware_models/toshiba_mcu/scaling.h"

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kDeadShare = 0.05;
constexpr double kServoShortestUs = 1000;
constexpr double kServoLongestUs = 2000;
constexpr double kServoMiddleUs = 1500;

// -1..1 with the dead zones at 0 and at the ends.
double with_dead_zones(double share) {
  const double magnitude = std::abs(share);
  if (magnitude < kDeadShare) return 0;
  return std::copysign(magnitude > 1 - kDeadShare ? 1 : magnitude, share);
}

}  // namespace

double wanted_share(ExternalSpeed method, const SpeedSignals& signals) {
  const double sign = signals.reverse ? -1 : 1;
  switch (method) {
    case ExternalSpeed::kNone:
      return 0;
    case ExternalSpeed::kAdc:
      return sign * std::clamp(signals.adc_counts, 0, kAdcMaximum) / kAdcMaximum;
    case ExternalSpeed::kPwm:
      return sign * with_dead_zones(std::clamp(signals.pwm_high, 0.0, 1.0));
    case ExternalSpeed::kServoBothWays:
    case ExternalSpeed::kServoOneWay:
      break;
  }
  if (signals.servo_us <= 0) return 0;
  const double pulse = std::clamp(signals.servo_us, kServoShortestUs, kServoLongestUs);
  if (method == ExternalSpeed::kServoBothWays) {
    return with_dead_zones((pulse - kServoMiddleUs) / (kServoLongestUs - kServoMiddleUs));
  }
  return sign * with_dead_zones((pulse - kServoShortestUs) / (kServoLongestUs - kServoShortestUs));
}

}  // namespace virtdrive::toshiba_mcu
