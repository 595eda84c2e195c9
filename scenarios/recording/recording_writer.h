// A recording's file format: rows of numbers in, a file out. The ending of the file's name chooses:
//
//   .csv   comma-separated values: spreadsheets, pandas
//   .vcd   value change dump: GTKWave
//   .mat   MATLAB level 5: MATLAB, Octave, scipy
//
// No file carries a date or a path: equal runs give equal files.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/sim_time.h"

namespace virtdrive {

struct Column {
  std::string name;  // "motor1.speed"
  std::string unit;  // "" for none
};

class RecordingWriter {
 public:
  virtual ~RecordingWriter() = default;

  /// One value a column; `time` grows from call to call. SetupError if the file can take no more.
  virtual void write(SimTime time, std::span<const double> values) = 0;
  /// Completes the file; SetupError if it could not all be written (disk full).
  virtual void close() = 0;
};

/// Opens `path` anew. SetupError for an ending that is none of the above, or if it cannot be
/// written.
std::unique_ptr<RecordingWriter> open_recording(const std::string& path,
                                                const std::vector<Column>& columns);

/// SetupError for an unknown ending; touches no file.
void check_recording_format(std::string_view path);

}  // namespace virtdrive
