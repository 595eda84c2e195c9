#include "firmware_models/md/protections.h"

#include <algorithm>
#include <cmath>

namespace virtdrive::md {
namespace {

constexpr std::array<std::int32_t, 9> kTimeMs = {15'000, 10, 1, 4'000, 1, 10, 1'000, 2'000, 600};
constexpr double kLeastOutput = 50;
constexpr double kStallOutput = 100;

}  // namespace

double derating(double heat_sink_degc) {
  const double hot = (heat_sink_degc - kDeratingFromDegc) / (kOverTempDegc - kDeratingFromDegc);
  return 1 - 0.5 * std::clamp(hot, 0.0, 1.0);
}

bool Protections::lasts(Cause cause, bool there) {
  std::int32_t& time_ms = there_ms_[cause];
  time_ms = there ? std::min(time_ms + 1, kTimeMs[cause]) : 0;
  return time_ms == kTimeMs[cause];
}

bool Protections::watch(const Watched& now) {
  std::uint8_t bits = 0;
  const double off_rpm = std::fabs(now.reference_rpm - now.rpm);
  const bool speed_off =
      now.speed_control && now.reference_rpm != 0 && off_rpm > 0.3 * std::fabs(now.reference_rpm);
  if (lasts(kSpeedOff, speed_off)) bits |= kCtrlFail;
  if (lasts(kLinkHigh, now.bus_v > now.over_v)) bits |= kOverVolt;
  if (lasts(kHot, now.heat_sink_degc > kOverTempDegc)) bits |= kOverTemp;
  if (lasts(kLoaded, now.mean_current_a > now.max_load_a)) bits |= kOverLoad;
  if (lasts(kOverCurrent, now.current_a > 1.5 * now.max_load_a)) bits |= kOverLoad;
  if (lasts(kNoHall, now.hall == 0 || now.hall == 7)) bits |= kHallFail;
  const bool against = now.rpm * now.output < 0 && std::fabs(now.output) > kLeastOutput &&
                       std::fabs(now.rpm) > 0.05 * now.max_rpm;
  if (lasts(kAgainst, against)) bits |= kInvVel;
  const bool standing =
      now.watches_stall && std::fabs(now.output) > kStallOutput && std::fabs(now.rpm) < 1;
  if (lasts(kStanding, standing)) {
    bits |= kStall;
    if (now.speed_control) bits |= kCtrlFail;
  }
  const bool no_encoder = lasts(kNoEncoder, now.encoder_expected && !now.encoder_moves &&
                                                std::fabs(now.output) > kLeastOutput);
  if (bits == 0 && !no_encoder) return false;
  const bool news = (bits & ~status_) != 0 || (no_encoder && status2_ == 0);
  status_ = static_cast<std::uint8_t>(status_ | bits | kAlarm);
  if (no_encoder) status2_ |= kEncFail;
  last_ = status_;
  return news;
}

void Protections::reset() {
  status_ = status2_ = 0;
  there_ms_ = {};
}

}  // namespace virtdrive::md
