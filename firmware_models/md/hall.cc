#include "firmware_models/md/hall.h"

#include <algorithm>
#include <chrono>

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kWindow = 10ms;
constexpr SimDuration kStandstill = 1s;

}  // namespace

std::optional<int> hall_sector(std::uint8_t code) {
  constexpr std::array<int, 8> kSector = {-1, 1, 3, 2, 5, 0, 4, -1};
  const int sector = kSector[code & 7];
  return sector < 0 ? std::nullopt : std::optional(sector);
}

void HallCounter::see(std::uint8_t code, SimTime t) {
  const auto sector = hall_sector(code);
  if (!sector) return;
  if (sector_) {
    const int forward = (*sector - *sector_ + 6) % 6;
    // Half a turn at once tells no direction: it goes on as before.
    const int steps =
        forward < 3 || (forward == 3 && newest().direction > 0) ? forward : forward - 6;
    for (int i = 0; i < steps; ++i) edge(1, t);
    for (int i = 0; i > steps; --i) edge(-1, t);
  }
  sector_ = sector;
}

void HallCounter::edge(int direction, SimTime t) {
  count_ += direction;
  edges_[next_] = {t, direction};
  next_ = (next_ + 1) % kEdges;
}

SimDuration HallCounter::last_interval() const {
  const Edge& before = before_newest(1);
  return before.direction == newest().direction && before.direction != 0
             ? newest().time - before.time
             : SimDuration{};
}

double HallCounter::rpm(SimTime now, int counts_per_turn) const {
  const Edge& last = newest();
  const SimDuration age = now - last.time;
  if (last.direction == 0 || before_newest(1).direction != last.direction || age > kStandstill) {
    return 0;
  }
  std::size_t n = 1;
  while (n + 1 < kEdges && before_newest(n + 1).direction == last.direction &&
         now - before_newest(n + 1).time <= kWindow) {
    ++n;
  }
  const double interval_s = seconds(last.time - before_newest(n).time) / static_cast<double>(n);
  const double slowest_s = std::max({interval_s, seconds(age), 1e-9});
  return last.direction * 60 / (counts_per_turn * slowest_s);
}

}  // namespace virtdrive::md
