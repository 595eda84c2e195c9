#include "pty/line_settings.h"

#include <algorithm>
#include <cstdlib>

namespace virtdrive {

SimDuration LineSettings::time_of(std::int64_t count) const {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  if (timing == LineTiming::kIdeal) return SimDuration{0};
  return SimDuration{count * character_bits() * kNsPerSecond / baud};
}

bool understand_each_other(const LineSettings& a, const LineSettings& b) {
  if (a.data_bits != b.data_bits || a.parity != b.parity) return false;
  return a.baud == b.baud || std::abs(a.baud - b.baud) <= kBaudTolerance * std::min(a.baud, b.baud);
}

}  // namespace virtdrive
