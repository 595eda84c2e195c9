// Signals written down to a file at a fixed interval of simulated time, in the format that the
// file's ending names (recording_writer.h). Equal runs give equal files.
//
//   Recorder recorder(loop, registry, "run.vcd", {"motor1.speed", "bus1.voltage"}, 1ms);
//   loop.run_until(kSimStart + 1s);
//   recorder.close();
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/recording/recording_writer.h"
#include "scenarios/recording/sampler.h"

namespace virtdrive {

class Recorder {
 public:
  /// Opens `path` anew. SetupError if the ending or a signal is unknown, the interval not above 0,
  /// or the file cannot be written.
  Recorder(EventLoop& loop, const Registry& registry, const std::string& path,
           const std::vector<std::string>& signals, SimDuration interval);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Completes the file; SetupError if that failed (disk full). Nothing is recorded afterwards.
  void close();

 private:
  std::unique_ptr<RecordingWriter> writer_;
  std::unique_ptr<Sampler> sampler_;
};

}  // namespace virtdrive
