#include "scenarios/signal_comparison.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <string_view>

#include "core/check.h"

namespace virtdrive {
namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> number(std::string_view cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

}  // namespace

SignalComparison::SignalComparison(const std::string& path, std::size_t count, double tolerance) {
  std::ifstream stream(path);
  if (!stream) throw SetupError(fmt::format("{}: cannot be read", path));
  std::string line;
  std::getline(stream, line);
  const auto header = cells_of(line);
  if (header.front() != "time_s" || header.size() != count + 1) {
    throw SetupError(fmt::format(
        "{}: expected a CSV file of 'run --record' with the {} signals of the recording", path,
        count));
  }
  names_.assign(header.begin() + 1, header.end());
  allowed_.assign(count, 0);
  for (std::size_t at = 2; std::getline(stream, line); ++at) {
    Row row;
    for (const std::string_view cell : cells_of(line)) {
      const auto value = number(cell);
      if (!value) throw SetupError(fmt::format("{}:{}: '{}' is not a number", path, at, cell));
      row.values.push_back(*value);
    }
    if (row.values.size() != count + 1) {
      throw SetupError(
          fmt::format("{}:{}: {} columns instead of {}", path, at, row.values.size(), count + 1));
    }
    row.time = kSimStart + from_seconds(row.values.front());
    row.values.erase(row.values.begin());
    for (std::size_t i = 0; i < count; ++i) {
      allowed_[i] = std::max(allowed_[i], tolerance * std::abs(row.values[i]));
    }
    rows_.push_back(std::move(row));
  }
}

void SignalComparison::see(SimTime time, std::span<const double> values) {
  if (divergence_ || next_ == rows_.size()) return;
  const Row& row = rows_[next_++];
  VIRTDRIVE_CHECK(values.size() == names_.size(), "{} values of {}", values.size(), names_.size());
  for (std::size_t i = 0; i < values.size() && !divergence_; ++i) {
    const bool same = std::abs(values[i] - row.values[i]) <= allowed_[i] ||
                      (std::isnan(values[i]) && std::isnan(row.values[i]));
    if (!same || row.time != time) divergence_ = {names_[i], time, row.values[i], values[i]};
  }
}

}  // namespace virtdrive
