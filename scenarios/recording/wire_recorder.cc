#include "scenarios/recording/wire_recorder.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

// What the bench chose where the options chose nothing.
BenchOptions with_defaults_named(BenchOptions options, Bench& bench) {
  for (LineSpec& spec : options.lines) {
    const SerialLine& line = bench.line(spec.name);
    spec.baud = line.settings().baud;
    spec.duplex = line.options().duplex;
  }
  for (std::size_t i = 0; i < options.drives.size(); ++i) {
    std::vector<std::string>& motors = options.drives[i].motors;
    const BenchDrive& drive = *bench.drives()[i];
    if (motors.empty()) motors.emplace_back(drive.motor(0).name);
  }
  return options;
}

std::vector<RecordedMemory> memories(const BenchOptions& options) {
  std::vector<RecordedMemory> memories;
  for (std::size_t i = 0; i < options.drives.size(); ++i) {
    std::ifstream stream(options.drives[i].nvm, std::ios::binary);
    if (!stream) continue;  // not there yet
    memories.push_back({i, {std::istreambuf_iterator<char>(stream), {}}});
  }
  return memories;
}

}  // namespace

std::vector<RecordedLine> recorded_lines(Bench& bench, const BenchOptions& options) {
  std::vector<RecordedLine> lines;
  for (const LineSpec& spec : options.lines) {
    SerialLine& line = bench.line(spec.name);
    const auto& drives = bench.drives();
    const auto on_it =
        std::ranges::find_if(drives, [&](const auto& drive) { return &drive->line() == &line; });
    VIRTDRIVE_CHECK(on_it != drives.end(), "line '{}' has no drive", spec.name);
    lines.push_back({spec.name, std::string((*on_it)->kind().table.name), line.settings().baud});
  }
  return lines;
}

WireRecorder::WireRecorder(const std::string& path, Bench& bench, RecordedBench recorded,
                           WireSink* also)
    : bench_(bench) {
  const std::vector<RecordedMemory> held = memories(recorded.options);
  recorded.options = with_defaults_named(std::move(recorded.options), bench);
  const std::vector<RecordedLine> lines = recorded_lines(bench, recorded.options);
  std::vector<WireSink*> sinks;
  if (also != nullptr) sinks.push_back(also);
  if (!path.empty()) {
    file_ = std::make_unique<WireFile>(path, describe(recorded), lines, held);
    sinks.push_back(file_.get());
  }
  for (const RecordedLine& line : lines) {
    monitors_.push_back(std::make_unique<LineMonitor>(bench.loop(), bench.line(line.name),
                                                      monitors_.size(), line.protocol, sinks));
  }
}

void WireRecorder::close() {
  for (const auto& monitor : monitors_) monitor->finish();
  monitors_.clear();
  if (file_) file_->close(bench_.loop().now());
}

}  // namespace virtdrive
