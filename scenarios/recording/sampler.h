// Reads signals at a fixed interval of simulated time. A row holds the state at the end of its
// instant (Phase::kRecord); the first row is that of the present instant.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "core/signals.h"

namespace virtdrive {

class Sampler {
 public:
  using Sink = std::function<void(SimTime time, std::span<const double> values)>;

  /// SetupError if a signal is unknown or the interval not above 0.
  Sampler(EventLoop& loop, const Registry& registry, const std::vector<std::string>& signals,
          SimDuration interval, Sink sink);
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;

  const std::vector<const Signal*>& signals() const { return signals_; }

 private:
  void sample();

  EventLoop& loop_;
  SimDuration interval_;
  Sink sink_;
  std::vector<const Signal*> signals_;
  std::vector<double> row_;
  Wakeup due_;
};

}  // namespace virtdrive
