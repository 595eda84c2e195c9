// Conditions kept in view while simulated time passes, whoever lets it pass: judged after the
// events of an instant, at most every 20 us and at least every millisecond. Costs nothing while
// there are none.
#pragma once

#include <cstddef>
#include <functional>
#include <list>

#include "core/event_loop.h"
#include "scenarios/scenario/condition.h"

namespace virtdrive {

class Watcher {
 public:
  struct Watched {
    LiveCondition condition;
    bool awaited;                // whether it is to come true; else false
    std::function<void()> then;  // called once; it is watched no longer
  };
  using Id = std::list<Watched>::iterator;

  explicit Watcher(EventLoop& loop);
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  /// Judged for the first time at the end of the present instant.
  Id add(Watched watched);
  void remove(Id id);

 private:
  void look();

  EventLoop& loop_;
  std::list<Watched> watched_;
  Wakeup due_;
};

}  // namespace virtdrive
