#include "scenarios/recording/recorder.h"

namespace virtdrive {

Recorder::Recorder(EventLoop& loop, const Registry& registry, const std::string& path,
                   const std::vector<std::string>& signals, SimDuration interval) {
  check_recording_format(path);
  sampler_ = std::make_unique<Sampler>(
      loop, registry, signals, interval,
      [this](SimTime time, std::span<const double> values) { writer_->write(time, values); });
  std::vector<Column> columns;
  for (const Signal* signal : sampler_->signals()) columns.push_back({signal->name, signal->unit});
  writer_ = open_recording(path, columns);
}

void Recorder::close() {
  sampler_.reset();
  writer_->close();
}

}  // namespace virtdrive
