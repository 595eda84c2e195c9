// What a recording says of its bench, so that a replay can build the same: one line of JSON.
//
//   {"virtdrive":1,"seed":1,"integrator":"default",
//    "lines":[{"name":"line","timing":"real","baud":115200,"duplex":"full","echo":false}],
//    "drives":[{"kind":"toshiba-mcu","name":"","line":"","motors":["db42s03"],"load":"none",...}]}
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenarios/bench.h"

namespace virtdrive {

struct RecordedBench {
  /// Without nvm, listener and notes; motors, baud rate and duplex are named, not left to defaults.
  BenchOptions options;
  /// What was recorded beside: to look at the plant is to bring it to the present, which moves the
  /// last bits of its state. None: empty.
  std::vector<std::string> signals = {};
  SimDuration interval{};
};

/// Throws SetupError for what it cannot say: supplies that drives share.
std::string describe(const RecordedBench& bench);

/// SetupError, beginning with `where`, if that is no such text; names and values that the bench
/// itself checks are left to it.
RecordedBench parse_bench(std::string_view text, std::string_view where);

}  // namespace virtdrive
