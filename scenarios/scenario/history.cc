#include "scenarios/scenario/history.h"

#include <utility>

#include "core/check.h"

namespace virtdrive {

History::History(std::vector<Column> columns) : columns_(std::move(columns)) {
  whole_.values.resize(columns_.size());
  ring_.values.resize(columns_.size());
}

void History::append(Rows& rows, double time_s, std::span<const double> values) {
  rows.time_s.push_back(time_s);
  for (std::size_t i = 0; i < values.size(); ++i) rows.values[i].push_back(values[i]);
}

void History::add(SimTime time, std::span<const double> values) {
  VIRTDRIVE_CHECK(values.size() == columns_.size(), "{} values for {} columns", values.size(),
                  columns_.size());
  if (count_++ % stride_ == 0) {
    append(whole_, seconds(time), values);
    if (whole_.time_s.size() == kMostRows) thin_out();
  }
  if (ring_.time_s.size() < kLastRows) {
    append(ring_, seconds(time), values);
    return;
  }
  ring_.time_s[next_] = seconds(time);
  for (std::size_t i = 0; i < values.size(); ++i) ring_.values[i][next_] = values[i];
  next_ = (next_ + 1) % kLastRows;
}

void History::thin_out() {
  const auto halve = [](std::vector<double>& values) {
    for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
    values.resize((values.size() + 1) / 2);
  };
  halve(whole_.time_s);
  for (auto& column : whole_.values) halve(column);
  stride_ *= 2;
}

History::Rows History::end() const {
  Rows rows;
  const auto unroll = [this](const std::vector<double>& ring) {
    std::vector<double> values(ring.begin() + static_cast<std::ptrdiff_t>(next_), ring.end());
    values.insert(values.end(), ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(next_));
    return values;
  };
  rows.time_s = unroll(ring_.time_s);
  for (const auto& column : ring_.values) rows.values.push_back(unroll(column));
  return rows;
}

}  // namespace virtdrive
