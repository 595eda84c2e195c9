#include "scenarios/scenario/watcher.h"

#include <algorithm>
#include <utility>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kSoonest = 20us;
constexpr SimDuration kLatest = 1ms;

}  // namespace

Watcher::Watcher(EventLoop& loop)
    : loop_(loop), due_(loop.add(Phase::kRecord, [this] { look(); })) {}

Watcher::Id Watcher::add(Watched watched) {
  watched_.push_back(std::move(watched));
  due_.at(loop_.now());
  return std::prev(watched_.end());
}

void Watcher::remove(Id id) {
  watched_.erase(id);
}

void Watcher::look() {
  for (auto it = watched_.begin(); it != watched_.end();) {
    const auto current = it++;
    if (current->condition.met() != current->awaited) continue;
    const auto then = std::move(current->then);
    watched_.erase(current);
    then();
  }
  if (watched_.empty()) return;
  const SimTime now = loop_.now();
  due_.at(std::clamp(loop_.next(), now + kSoonest, now + kLatest));
}

}  // namespace virtdrive
