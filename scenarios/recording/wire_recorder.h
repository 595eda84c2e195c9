// Records the lines of a bench to a file: see wire_file.h.
//
//   WireRecorder recorder("run.pcapng", bench, options);
//   bench.run_for(1s);
//   recorder.close();
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/recording/bench_description.h"
#include "scenarios/recording/line_monitor.h"
#include "scenarios/recording/wire_file.h"

namespace virtdrive {

/// A bench's lines, as recordings number them.
std::vector<RecordedLine> recorded_lines(Bench& bench, const BenchOptions& options);

class WireRecorder {
 public:
  /// To be made before time begins to pass; `recorded.options` are what the bench was made from.
  /// `also` hears what is written down; without a path, only that does. SetupError if the file
  /// cannot be written.
  WireRecorder(const std::string& path, Bench& bench, RecordedBench recorded,
               WireSink* also = nullptr);

  /// Completes the file; SetupError if that failed (disk full). Nothing is recorded afterwards.
  void close();

 private:
  Bench& bench_;
  std::unique_ptr<WireFile> file_;
  std::vector<std::unique_ptr<LineMonitor>> monitors_;
};

}  // namespace virtdrive
