// The one clock of a simulation, and the order in which things happen.
//
// A component registers once and gets a Wakeup: one slot that says when it wants to run next. The
// loop jumps from wake-up to wake-up; there is no time step. At one instant the order is:
//
//   1. kScenario   a load steps, a fault is injected
//   2. kBytes      a byte has arrived at a device
//   3. kDevice     a device asked to be woken (reply due, time-out)
//   4. kControl    the plant is advanced, the drive's PWM interrupt runs
//   5. kRecord     signals are written down
//
// and within one phase the order of registration. Everything is single-threaded; two loops in one
// process know nothing of each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "core/sim_time.h"

namespace virtdrive {

enum class Phase : std::uint8_t { kScenario, kBytes, kDevice, kControl, kRecord };

class EventLoop;

/// A component's place in the loop. Owned by the component; unregisters when destroyed, so it must
/// not outlive the loop.
class Wakeup {
 public:
  Wakeup() = default;
  Wakeup(Wakeup&& other) noexcept;
  Wakeup& operator=(Wakeup&& other) noexcept;
  ~Wakeup();

  /// Runs the callback at `t` (not before now); replaces what was asked for before.
  void at(SimTime t);
  void cancel();
  /// When the callback is due, kNever when it is not.
  SimTime due() const;

 private:
  friend class EventLoop;
  Wakeup(EventLoop* loop, std::size_t slot) : loop_(loop), slot_(slot) {}

  EventLoop* loop_ = nullptr;
  std::size_t slot_ = 0;
};

class EventLoop {
 public:
  using Callback = std::function<void()>;

  EventLoop() = default;
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  SimTime now() const { return now_; }

  /// Registers a callback that sleeps until its wake-up is set.
  [[nodiscard]] Wakeup add(Phase phase, Callback callback);

  /// When the next callback of any phase is due; kNever if none is.
  SimTime next() const;
  /// The same for phases up to and including `last`: what a host could notice.
  SimTime next(Phase last) const;

  /// Runs all that is due up to and including `t`, then now() == t. Returns early after stop().
  void run_until(SimTime t);
  /// Runs all that is due before `t`, then now() == t with the events of `t` still to come: the
  /// moment at which something from outside (a byte, a command) may be put in, in order.
  void run_before(SimTime t);
  /// Runs events while `t` is not passed and `condition` is false; true if it became true. The
  /// condition is checked after each instant.
  bool run_until(SimTime t, const std::function<bool()>& condition);

  /// Makes the run in progress return after the current callback. The next run goes on from there.
  void stop() { stopped_ = true; }
  /// True if that ended the last run.
  bool stopped() const { return stopped_; }

  /// Callbacks run so far: equal for equal runs.
  std::uint64_t events() const { return events_; }

 private:
  friend class Wakeup;

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct Slot {
    SimTime due = kNever;
    Phase phase{};
    std::uint32_t order = 0;  // of registration
    std::uint32_t heap_index = 0;
    bool used = false;
    Callback callback;
  };

  bool before(std::size_t a, std::size_t b) const;
  void set(std::size_t slot, SimTime t);
  void remove(std::size_t slot);
  void place(std::size_t heap_index, std::size_t slot);
  void sift(std::size_t heap_index);
  void run_next();

  SimTime now_ = kSimStart;
  bool stopped_ = false;
  std::uint32_t registered_ = 0;
  std::uint64_t events_ = 0;
  std::size_t running_ = kNone;    // the slot whose callback is running
  std::deque<Slot> slots_;         // a deque: a running callback stays where it is when others come
  std::vector<std::size_t> heap_;  // slot numbers, the earliest first; sleeping slots at the bottom
};

}  // namespace virtdrive
