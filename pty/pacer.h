// How simulated time follows the wall clock: a schedule, and the account of how well it was kept.
//
// It reads no clock and does not sleep; whoever drives it says what time it is. A simulation that
// is late runs flat out until it has caught up; one that is later than kMaxLag gives the lost time
// up: the schedule slips, and a later instant of the wall clock belongs to the same simulated one.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/sim_time.h"

namespace virtdrive {

using WallDuration = std::chrono::nanoseconds;
using WallTime = std::chrono::time_point<std::chrono::steady_clock, WallDuration>;

struct PacingReport {
  double rate = 0;             // simulated per real second asked for; 0: as fast as possible
  SimDuration simulated{};     // by this run
  WallDuration elapsed{};      // of the wall clock
  std::uint64_t wakeups = 0;   // times the simulation was advanced
  std::uint64_t overruns = 0;  // times the lag went over kOverrun
  std::uint64_t slips = 0;     // times it went over kMaxLag and the time was given up
  WallDuration slipped{};      // given up in all
  WallDuration max_lag{};
  int signal = 0;  // SIGINT or SIGTERM if that ended the run
};

class Pacer {
 public:
  static constexpr WallDuration kOverrun = std::chrono::milliseconds{10};
  static constexpr WallDuration kMaxLag = std::chrono::milliseconds{50};

  /// `sim` belongs to `wall`; `rate` (> 0) simulated seconds pass in a second.
  Pacer(double rate, SimTime sim, WallTime wall);

  /// The simulated instant that belongs to `wall`, and the other way round; WallTime::max() for
  /// kNever.
  SimTime sim_at(WallTime wall) const;
  WallTime wall_at(SimTime sim) const;

  double rate() const { return rate_; }
  /// From now on, when `sim` belongs to `wall`, time passes at `rate`; 0: it stands still.
  void set_rate(double rate, SimTime sim, WallTime wall);

  /// It is `wall`, and the simulation was to go on from `planned`: takes the lag down, and slips.
  void resume(SimTime planned, WallTime wall);

  /// Overruns, slips and lag so far.
  const PacingReport& report() const { return report_; }

 private:
  double rate_;
  SimTime sim_;  // these two belong together
  WallTime wall_;
  bool late_ = false;  // in an overrun that is counted already
  PacingReport report_;
};

}  // namespace virtdrive
