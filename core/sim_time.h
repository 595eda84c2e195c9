// Simulated time: int64 nanoseconds since the start of a simulation.
//
// SimClock has no now(): nothing that uses this header can ask what time it is in the world
// outside. The event loop knows the simulated time; only pty/ relates it to a wall clock.
#pragma once

#include <chrono>
#include <cstdint>

namespace virtdrive {

struct SimClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<SimClock>;
  static constexpr bool is_steady = true;
};

using SimDuration = SimClock::duration;
using SimTime = SimClock::time_point;

/// The start of every simulation.
inline constexpr SimTime kSimStart{};

/// Later than any event: "never".
inline constexpr SimTime kNever = SimTime::max();

/// Seconds as a double, for physics and plots. Exact to 1 ns up to 52 days.
constexpr double seconds(SimDuration d) {
  return static_cast<double>(d.count()) * 1e-9;
}
constexpr double seconds(SimTime t) {
  return seconds(t.time_since_epoch());
}

/// The nearest nanosecond to a number of seconds.
constexpr SimDuration from_seconds(double s) {
  return SimDuration{static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5))};
}

}  // namespace virtdrive
