// Drives a simulation by the wall clock, and lets the world outside in.
//
//   paced   simulated time follows the wall clock at a factor (see Pacer)
//   free    as fast as possible
//
// Bytes from outside wake the runner at once: the loop is brought to that moment, the endpoint puts
// them in, the loop runs that moment, and what came of it goes out. Otherwise the runner sleeps
// until a host could notice something, or for a millisecond: control steps in between are caught up
// with together. SIGINT, SIGTERM and SIGHUP end run() like any other stop, so destructors run.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "core/event_loop.h"
#include "pty/host_endpoint.h"
#include "pty/pacer.h"

namespace virtdrive {

struct RunnerOptions {
  std::optional<double> rate = 1.0;                 // simulated seconds per second, > 0; none: free
  SimTime until = kNever;                           // the run ends when the loop has got there
  std::function<void(const PacingReport&)> status;  // called now and then, e.g. for a status line
  WallDuration status_interval = std::chrono::milliseconds{200};
};

class Runner {
 public:
  /// Takes SIGINT, SIGTERM and (unless it is ignored) SIGHUP from here on, until it is destroyed.
  Runner(EventLoop& loop, RunnerOptions options);
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;
  ~Runner();

  /// The endpoint must outlive the runner.
  void add(HostEndpoint& endpoint);

  /// Runs until the end of time, a signal, request_stop(), or EventLoop::stop() by a callback.
  PacingReport run();

  /// Of a paced run under way, called from within it (an endpoint, a callback): simulated seconds
  /// per second from now on; 0 stands still, and what a host says waits. False if it runs free.
  bool set_rate(double rate);
  /// 0 while it stands still or runs free.
  double rate() const { return pacer_ ? pacer_->rate() : 0; }
  /// Of a run that stands still: lets so much simulated time pass at once. False if it does not.
  bool step(SimDuration time);

  /// Ends run() soon. May be called from any thread and from a signal handler.
  void request_stop();

 private:
  struct Outside;

  void run_paced();
  void run_free();
  bool advance(SimTime target);
  void wait_until(WallTime wall);
  void show_status(WallTime wall);
  PacingReport report(WallTime wall) const;

  EventLoop& loop_;
  RunnerOptions options_;
  std::unique_ptr<Outside> outside_;
  std::optional<Pacer> pacer_;
  SimTime sim_begin_ = kSimStart;
  WallTime wall_begin_;
  WallTime next_status_;
  std::uint64_t wakeups_ = 0;
};

}  // namespace virtdrive
