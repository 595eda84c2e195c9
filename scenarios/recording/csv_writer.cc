#include "scenarios/recording/csv_writer.h"

#include <fmt/format.h>
#include <iterator>

namespace virtdrive {

CsvWriter::CsvWriter(const std::string& path, const std::vector<Column>& columns)
    : file_("--record", path) {
  row_ = "time_s";
  for (const Column& column : columns) {
    row_ += ',' + column.name;
    if (!column.unit.empty()) row_ += '[' + column.unit + ']';
  }
  row_ += '\n';
  file_.write(row_);
}

void CsvWriter::write(SimTime time, std::span<const double> values) {
  const std::int64_t ns = time.time_since_epoch().count();
  row_.clear();
  fmt::format_to(std::back_inserter(row_), "{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
  for (const double value : values) fmt::format_to(std::back_inserter(row_), ",{}", value);
  row_ += '\n';
  file_.write(row_);
}

}  // namespace virtdrive
