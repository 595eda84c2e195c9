#include "pty/pacer.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace virtdrive {

Pacer::Pacer(double rate, SimTime sim, WallTime wall) : rate_(rate), sim_(sim), wall_(wall) {
  VIRTDRIVE_CHECK(std::isfinite(rate) && rate > 0, "a pacing rate of {}", rate);
  report_.rate = rate;
}

SimTime Pacer::sim_at(WallTime wall) const {
  const double ns = std::floor(static_cast<double>((wall - wall_).count()) * rate_);
  return sim_ + SimDuration{static_cast<std::int64_t>(ns)};
}

WallTime Pacer::wall_at(SimTime sim) const {
  if (rate_ == 0) return sim <= sim_ ? wall_ : WallTime::max();
  const double ns = std::ceil(static_cast<double>((sim - sim_).count()) / rate_);
  const WallDuration left = WallTime::max() - wall_;
  if (ns >= static_cast<double>(left.count())) return WallTime::max();
  return wall_ + WallDuration{static_cast<std::int64_t>(ns)};
}

void Pacer::set_rate(double rate, SimTime sim, WallTime wall) {
  VIRTDRIVE_CHECK(std::isfinite(rate) && rate >= 0, "a pacing rate of {}", rate);
  rate_ = report_.rate = rate;
  sim_ = sim;
  wall_ = wall;
  late_ = false;
}

void Pacer::resume(SimTime planned, WallTime wall) {
  if (rate_ == 0) return;  // nothing is ever late
  const WallDuration lag = std::max(WallDuration{0}, wall - wall_at(planned));
  report_.max_lag = std::max(report_.max_lag, lag);
  if (lag > kOverrun && !late_) ++report_.overruns;
  late_ = lag > kOverrun;
  if (lag <= kMaxLag) return;
  ++report_.slips;
  report_.slipped += lag;
  wall_ += lag;
  late_ = false;
}

}  // namespace virtdrive
