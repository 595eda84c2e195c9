// What the program makes of the Hall sensors: counts and speed, from the edges and the times at
// which the capture unit saw them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/sim_time.h"

namespace virtdrive::md {

/// The place of a Hall code in the forward order 5, 1, 3, 2, 6, 4; nothing for 0 and 7.
std::optional<int> hall_sector(std::uint8_t code);

class HallCounter {
 public:
  /// The code seen at `t`. Codes 0 and 7 count nothing.
  void see(std::uint8_t code, SimTime t);

  std::int64_t count() const { return count_; }
  /// The last edge and the time between it and the one before; 0 before there were two.
  SimTime last_edge() const { return newest().time; }
  SimDuration last_interval() const;

  /// rpm from the edges of the last 10 ms (one interval at least); between edges it falls as if the
  /// next came now; 0 after 1 s without one, and 0 when the last two went opposite ways. (Assumed.)
  double rpm(SimTime now, int counts_per_turn) const;

 private:
  struct Edge {
    SimTime time = kSimStart;
    int direction = 0;  // 0: none yet
  };
  static constexpr std::size_t kEdges = 64;  // 10 ms at 6400 edges a second

  const Edge& newest() const { return edges_[(next_ + kEdges - 1) % kEdges]; }
  const Edge& before_newest(std::size_t n) const {
    return edges_[(next_ + 2 * kEdges - 1 - n) % kEdges];
  }
  void edge(int direction, SimTime t);

  std::optional<int> sector_;
  std::int64_t count_ = 0;
  std::array<Edge, kEdges> edges_{};
  std::size_t next_ = 0;
};

}  // namespace virtdrive::md
