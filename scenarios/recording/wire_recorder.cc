#include "scenarios/recording/wire_recorder.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "plant/motor_library.h"

namespace virtdrive {
namespace {

// What the bench chose where the options chose nothing; a motor's file loses its folder.
BenchOptions as_recorded(BenchOptions options, Bench& bench) {
  for (LineSpec& spec : options.lines) {
    const SerialLine& line = bench.line(spec.name);
    spec.baud = line.settings().baud;
    spec.duplex = line.options().duplex;
  }
  for (std::size_t i = 0; i < options.drives.size(); ++i) {
    std::vector<std::string>& motors = options.drives[i].motors;
    if (motors.empty()) motors.emplace_back(bench.drives()[i]->motor(0).name);
    for (std::string& motor : motors) motor = std::filesystem::path(motor).filename().string();
  }
  return options;
}

// What the drives were made from; files that are not there yet, and names of the library, are not.
std::vector<RecordedFile> files_of(const BenchOptions& options) {
  std::vector<RecordedFile> files;
  const auto add = [&](std::size_t drive, std::size_t role, const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    if (stream) files.push_back({drive, role, {std::istreambuf_iterator<char>(stream), {}}});
  };
  for (std::size_t i = 0; i < options.drives.size(); ++i) {
    const DriveSpec& drive = options.drives[i];
    add(i, RecordedFile::kMemory, drive.nvm);
    for (std::size_t motor = 0; motor < drive.motors.size(); ++motor) {
      if (is_motor_file(drive.motors[motor]))
        add(i, RecordedFile::kMotor + motor, drive.motors[motor]);
    }
  }
  return files;
}

}  // namespace

std::vector<RecordedLine> recorded_lines(Bench& bench, const BenchOptions& options) {
  std::vector<RecordedLine> lines;
  for (const LineSpec& spec : options.lines) {
    const SerialLine& line = bench.line(spec.name);
    lines.push_back({spec.name, std::string(bench.protocol_of(spec.name)), line.settings().baud});
  }
  return lines;
}

WireRecorder::WireRecorder(const std::string& path, Bench& bench, RecordedBench recorded,
                           WireSink* also)
    : bench_(bench) {
  const std::vector<RecordedFile> files = files_of(recorded.options);
  recorded.options = as_recorded(std::move(recorded.options), bench);
  const std::vector<RecordedLine> lines = recorded_lines(bench, recorded.options);
  std::vector<WireSink*> sinks;
  if (also != nullptr) sinks.push_back(also);
  if (!path.empty()) {
    file_ = std::make_unique<WireFile>(path, describe(recorded), lines, files);
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
