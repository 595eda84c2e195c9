#include "scenarios/csv_recorder.h"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <iterator>

#include "core/check.h"

namespace virtdrive {

CsvRecorder::CsvRecorder(EventLoop& loop, const Registry& registry, const std::string& path,
                         const std::vector<std::string>& signals, SimDuration interval)
    : loop_(loop),
      path_(path),
      interval_(interval),
      due_(loop.add(Phase::kRecord, [this] { record(); })) {
  if (interval <= SimDuration{}) throw SetupError("--interval: must be above 0");
  for (const std::string& name : signals) signals_.push_back(&registry.signal(name));
  file_.reset(std::fopen(path.c_str(), "w"));
  if (!file_) {
    throw SetupError(fmt::format("--record {}: cannot be written: {}", path, std::strerror(errno)));
  }
  row_ = "time_s";
  for (const Signal* signal : signals_) {
    row_ += ',' + signal->name;
    if (!signal->unit.empty()) row_ += '[' + signal->unit + ']';
  }
  row_ += '\n';
  std::fwrite(row_.data(), 1, row_.size(), file_.get());
  due_.at(loop.now());
}

void CsvRecorder::record() {
  const std::int64_t ns = loop_.now().time_since_epoch().count();
  row_.clear();
  fmt::format_to(std::back_inserter(row_), "{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
  for (const Signal* signal : signals_) {
    fmt::format_to(std::back_inserter(row_), ",{}", signal->read());
  }
  row_ += '\n';
  std::fwrite(row_.data(), 1, row_.size(), file_.get());
  due_.at(loop_.now() + interval_);
}

void CsvRecorder::close() {
  if (!file_) return;
  const bool good = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  file_.reset();
  if (!good) throw SetupError(fmt::format("--record {}: not all of it could be written", path_));
}

}  // namespace virtdrive
