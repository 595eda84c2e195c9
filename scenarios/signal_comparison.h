// Holds signals, as they are sampled, against a table of them that was recorded before.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/sim_time.h"

namespace virtdrive {

/// The first value that is not as it was.
struct SignalDivergence {
  std::string signal;  // with its unit: "motor1.speed[rpm]"
  SimTime time;
  double recorded = 0;
  double replayed = 0;
};

class SignalComparison {
 public:
  /// `path` is a CSV file of 'run --record' with `count` signals. A value may be off by `tolerance`
  /// of the largest size that its signal was recorded with; 0: by nothing. SetupError, with the
  /// line, for a file that cannot be used.
  SignalComparison(const std::string& path, std::size_t count, double tolerance);

  /// Rows in the order of time. What comes behind the table's end is not compared.
  void see(SimTime time, std::span<const double> values);

  std::size_t rows_compared() const { return next_; }
  const std::optional<SignalDivergence>& divergence() const { return divergence_; }

 private:
  struct Row {
    SimTime time;
    std::vector<double> values;
  };

  std::vector<std::string> names_;
  std::vector<Row> rows_;
  std::vector<double> allowed_;  // of each signal
  std::size_t next_ = 0;
  std::optional<SignalDivergence> divergence_;
};

}  // namespace virtdrive
