// Comma-separated values:
//
//   time_s,motor1.speed[rpm],bus1.voltage[V]
//   0.001000000,12.5,23.99
//
// Numbers are the shortest text that reads back as the same double.
#pragma once

#include "scenarios/output_file.h"
#include "scenarios/recording/recording_writer.h"

namespace virtdrive {

class CsvWriter : public RecordingWriter {
 public:
  CsvWriter(const std::string& path, const std::vector<Column>& columns);

  void write(SimTime time, std::span<const double> values) override;
  void close() override { file_.close(); }

 private:
  OutputFile file_;
  std::string row_;
};

}  // namespace virtdrive
