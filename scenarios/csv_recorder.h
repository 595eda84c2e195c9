// Signals written down at a fixed interval of simulated time, as comma-separated values:
//
//   time_s,motor1.speed[rpm],bus1.voltage[V]
//   0.001000000,12.5,23.99
//
// A row holds the state at the end of its instant (Phase::kRecord). Numbers are the shortest text
// that reads back as the same double, so equal runs give equal files.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "core/signals.h"

namespace virtdrive {

class CsvRecorder {
 public:
  /// Opens `path` anew. SetupError if a signal is unknown, the interval not above 0, or the file
  /// cannot be written.
  CsvRecorder(EventLoop& loop, const Registry& registry, const std::string& path,
              const std::vector<std::string>& signals, SimDuration interval);

  /// Writes out what is buffered; SetupError if that failed (disk full).
  void close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void record();

  EventLoop& loop_;
  std::string path_;
  SimDuration interval_;
  std::vector<const Signal*> signals_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::string row_;
  Wakeup due_;
};

}  // namespace virtdrive
