// A MATLAB level 5 file: a column vector `time` in seconds, one a signal (motor1_speed), and the
// struct `units` with a text a signal. Its header's date is left out: equal runs give equal files.
//
// The format wants to know how long a vector is before its first number: the values are kept in
// memory up to a stated maximum and written by close().
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "scenarios/recording/recording_writer.h"

struct _mat_t;  // matio's file

namespace virtdrive {

/// Names as MATLAB takes them, in order: other characters than letters, digits and '_' become '_';
/// a '_' is added to what is already taken.
std::vector<std::string> mat_names(const std::vector<Column>& columns);

class MatWriter : public RecordingWriter {
 public:
  /// 128 MiB, time included: four signals at the default interval of 1 ms for 55 minutes.
  static constexpr std::size_t kMaximumValues = std::size_t{1} << 24;

  MatWriter(const std::string& path, const std::vector<Column>& columns,
            std::size_t maximum_values = kMaximumValues);

  /// Beyond the maximum: writes the file with all rows so far, then SetupError.
  void write(SimTime time, std::span<const double> values) override;
  void close() override;

 private:
  struct CloseMat {
    void operator()(_mat_t* file) const;
  };

  void write_vector(const std::string& name, std::vector<double>& values);
  void write_units();
  void check_written();
  [[noreturn]] void fail_to_write();

  std::string path_;
  std::vector<Column> columns_;
  std::size_t maximum_values_;
  std::unique_ptr<_mat_t, CloseMat> file_;
  std::vector<double> time_;
  std::vector<std::vector<double>> values_;  // a vector a column
};

}  // namespace virtdrive
