// Signals over a whole run in a bounded memory: every sample of a short one, fewer of a long one,
// and always all of the last ones, which tell how it ended.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/sim_time.h"

namespace virtdrive {

class History {
 public:
  struct Column {
    std::string name;
    std::string unit;
    std::vector<std::string_view> words;
    bool bits = false;
  };
  struct Rows {
    std::vector<double> time_s;
    std::vector<std::vector<double>> values;  // one vector a column
  };

  /// Rows kept of the whole, and of the end.
  static constexpr std::size_t kMostRows = 16384;
  static constexpr std::size_t kLastRows = 2048;

  History() = default;
  explicit History(std::vector<Column> columns);

  void add(SimTime time, std::span<const double> values);

  const std::vector<Column>& columns() const { return columns_; }
  /// The whole run, thinned out evenly if it was long.
  const Rows& whole() const { return whole_; }
  /// The last kLastRows samples.
  Rows end() const;

 private:
  static void append(Rows& rows, double time_s, std::span<const double> values);
  void thin_out();

  std::vector<Column> columns_;
  Rows whole_;
  std::size_t stride_ = 1;  // samples for each row of the whole
  std::size_t count_ = 0;
  Rows ring_;
  std::size_t next_ = 0;  // place in the ring
};

}  // namespace virtdrive
