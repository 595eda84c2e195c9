// What the demo's page shows, collected in memory while it runs: a motor's signals each millisecond
// and the frames on the line.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "scenarios/bench.h"
#include "scenarios/report/html_report.h"

namespace virtdrive {

class DemoReport {
 public:
  /// Of the demo's 6 s; a demo that hangs is not collected for ever.
  static constexpr std::size_t kMaximumRows = 60'000;
  static constexpr std::size_t kMaximumFrames = 20'000;

  explicit DemoReport(std::size_t channel);

  /// The names of what a row holds.
  const std::vector<std::string>& signals() const { return signals_; }

  void add_row(SimTime time, std::span<const double> values);
  void add_frame(const WireEvent& event);
  /// What the bench puts on the shaft, told again and again: a change is a moment of the page.
  void add_load(SimTime time, double brake_nm);

  /// `firmware` as the drive told it, `result` in a few words.
  Report make(Bench& bench, const std::string& firmware, const std::string& result) const;

 private:
  std::vector<double> column(std::string_view name, double factor = 1) const;

  std::size_t channel_;
  TimeAxis axis_;
  std::vector<std::string> signals_;
  std::vector<std::vector<double>> columns_;
  std::vector<Event> frames_;
  double load_nm_ = 0;
};

}  // namespace virtdrive
