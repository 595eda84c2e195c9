// Value change dump (IEEE 1364-2005, clause 18) as GTKWave reads it: a real variable a column, in a
// scope a component, changes only. The format knows no units: they stand in a comment.
#pragma once

#include <vector>

#include "scenarios/output_file.h"
#include "scenarios/recording/recording_writer.h"

namespace virtdrive {

class VcdWriter : public RecordingWriter {
 public:
  VcdWriter(const std::string& path, const std::vector<Column>& columns);

  void write(SimTime time, std::span<const double> values) override;
  /// Marks the last instant too, so that a viewer shows the whole recording.
  void close() override;

 private:
  void write_time();

  OutputFile file_;
  std::vector<std::string> codes_;  // what stands for a column in the changes
  std::vector<double> last_;        // empty before the first row
  std::string text_;
  SimTime now_ = kSimStart;
  bool time_written_ = true;
};

}  // namespace virtdrive
