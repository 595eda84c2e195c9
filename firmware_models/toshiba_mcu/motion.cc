#include "firmware_models/toshiba_mcu/motion.h"

#include <algorithm>
#include <cmath>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kSecondsPerMinute = 60;
// The command is slowed down a little earlier than the ramp would: the motor follows late.
constexpr double kRampShare = 0.8;
constexpr double kSlowestRpm = 1;
constexpr double kCreepPerSecond = 4;  // of the distance left, at the very end

}  // namespace

void Motion::begin(Kind kind, double distance_turns, const Profile& profile) {
  kind_ = kind;
  profile_ = profile;
  profile_.approach_rpm = std::min(profile.approach_rpm, profile.max_rpm);
  sign_ = distance_turns < 0 ? -1 : 1;
}

double Motion::speed_rpm(double left_turns, double acceleration_turns_per_s2,
                         double resolution_turns) {
  // Turns end where the number is reached; a position may be passed and is then crept back to.
  const bool there =
      kind_ == Kind::kTurn ? sign_ * left_turns <= 0 : std::abs(left_turns) < resolution_turns / 2;
  if (there) {
    kind_ = Kind::kNone;
    return 0;
  }
  const double left = std::abs(left_turns);
  const double approach = profile_.approach_rpm / kSecondsPerMinute;
  double speed = approach;
  if (left > profile_.approach_turns) {
    const double brake = 2 * kRampShare * acceleration_turns_per_s2;
    speed = std::sqrt(approach * approach + brake * (left - profile_.approach_turns));
  } else if (kind_ == Kind::kLinear) {
    speed = std::clamp(kCreepPerSecond * left, kSlowestRpm / kSecondsPerMinute, approach);
  }
  return std::copysign(std::min(speed * kSecondsPerMinute, profile_.max_rpm), left_turns);
}

}  // namespace virtdrive::toshiba_mcu
