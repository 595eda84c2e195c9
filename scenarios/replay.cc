#include "scenarios/replay.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <utility>

#include "core/check.h"
#include "plant/motor_library.h"
#include "scenarios/recording/bench_description.h"
#include "scenarios/recording/sampler.h"
#include "scenarios/recording/wire_recorder.h"

namespace virtdrive {
namespace {

using protocol::Direction;

// The recording's files, while a replay runs.
class GivenFiles {
 public:
  GivenFiles(const WireRecording& recording, const std::string& name) : name_(name) {
    if (!recording.files.empty()) folder_ = make_folder();
  }
  ~GivenFiles() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  GivenFiles(const GivenFiles&) = delete;
  GivenFiles& operator=(const GivenFiles&) = delete;

  /// Puts the drives' files in the place of those that they were made from.
  void give(const WireRecording& recording, std::vector<DriveSpec>& drives) const {
    for (const RecordedFile& file : recording.files) {
      const bool memory = file.role == RecordedFile::kMemory;
      const std::size_t motor = file.role - RecordedFile::kMotor;
      if (file.drive >= drives.size() || (!memory && motor >= drives[file.drive].motors.size())) {
        throw SetupError(fmt::format("{}: holds a file for a drive that it has not", name_));
      }
      std::string& path = memory ? drives[file.drive].nvm : drives[file.drive].motors[motor];
      path = write(file, memory ? "memory" : path);
    }
    for (const DriveSpec& drive : drives) {
      for (const std::string& motor : drive.motors) {
        if (is_motor_file(motor) && !motor.starts_with(folder_.string() + "/")) {
          throw SetupError(fmt::format("{}: does not hold the motor's file {}", name_, motor));
        }
      }
    }
  }

 private:
  static std::filesystem::path make_folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "virtdrive-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw SetupError(
          fmt::format("no temporary folder {} can be made: {}", pattern, std::strerror(errno)));
    }
    return pattern;
  }

  // Under the name that it had: a motor's file is described by it.
  std::string write(const RecordedFile& file, const std::string& file_name) const {
    const auto place = folder_ / fmt::format("drive{}-{}", file.drive, file.role);
    const auto path = place / std::filesystem::path(file_name).filename();
    std::filesystem::create_directory(place);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(file.content.data()), std::ssize(file.content));
    return path.string();
  }

  std::string name_;
  std::filesystem::path folder_;  // empty: there are no files
};

// Holds what the drives say on one line against the recording.
class Comparison {
 public:
  Comparison(const RecordedLine& line, SimDuration tolerance)
      : name_(line.name), tolerance_(tolerance) {}

  void expect(const RecordedPacket& packet) { expected_.push_back(&packet); }

  void hear(const WirePacket& packet) {
    for (const WireByte& byte : packet.bytes) {
      if (divergence_) return;
      if (!left()) return extra(packet, byte);
      const RecordedPacket& recorded = *expected_[packet_];
      if (recorded.bytes[byte_] != byte.byte ||
          std::chrono::abs(recorded.last_bits[byte_] - byte.end) > tolerance_) {
        diverge(next_expected(), heard(packet, byte));
        return;
      }
      ++same_;
      if (++byte_ == recorded.bytes.size()) {
        byte_ = 0;
        ++packet_;
      }
    }
  }
  /// What was recorded and did not come is a divergence too.
  void finish() {
    if (!divergence_ && left()) diverge(next_expected(), std::nullopt);
  }
  /// A recording that was cut short does not know what came next.
  void allow_more() { more_allowed_ = true; }

  std::uint64_t same() const { return same_; }
  const std::optional<Divergence>& divergence() const { return divergence_; }

 private:
  bool left() const { return packet_ < expected_.size(); }
  void extra(const WirePacket& packet, const WireByte& byte) {
    if (!more_allowed_) diverge(std::nullopt, heard(packet, byte));
  }
  void diverge(std::optional<DriveByte> recorded, std::optional<DriveByte> replayed) {
    divergence_ = Divergence{name_, same_, std::move(recorded), std::move(replayed)};
  }
  DriveByte next_expected() const {
    const RecordedPacket& packet = *expected_[packet_];
    return {packet.bytes[byte_], packet.last_bits[byte_], packet.bytes, packet.comment};
  }
  static DriveByte heard(const WirePacket& packet, const WireByte& byte) {
    DriveByte heard{byte.byte, byte.end, {}, std::string(packet.text)};
    for (const WireByte& each : packet.bytes) heard.packet.push_back(each.byte);
    return heard;
  }

  std::string name_;
  SimDuration tolerance_;
  std::vector<const RecordedPacket*> expected_;
  std::size_t packet_ = 0;  // of expected_, and the byte in it, that come next
  std::size_t byte_ = 0;
  std::uint64_t same_ = 0;
  bool more_allowed_ = false;
  std::optional<Divergence> divergence_;
};

class Comparisons final : public WireSink {
 public:
  /// Calls `diverged` at the first divergence.
  Comparisons(const WireRecording& recording, SimDuration tolerance, std::function<void()> diverged)
      : diverged_(std::move(diverged)) {
    for (const RecordedLine& line : recording.lines) lines_.emplace_back(line, tolerance);
    for (const RecordedPacket& packet : recording.packets) {
      if (packet.direction == Direction::kReply) lines_[packet.line].expect(packet);
    }
    if (recording.cut_short.empty()) return;
    for (Comparison& line : lines_) line.allow_more();
  }

  void host_settings(std::size_t, HostInstant, const HostSettings&) override {}
  void host_write(std::size_t, HostInstant, std::span<const std::uint8_t>) override {}
  void packet(std::size_t line, const WirePacket& packet) override {
    if (packet.direction != Direction::kReply) return;
    lines_[line].hear(packet);
    if (lines_[line].divergence()) diverged_();
  }
  void finish() {
    for (Comparison& line : lines_) line.finish();
  }

  std::optional<Divergence> divergence() const {
    for (const Comparison& line : lines_) {
      if (line.divergence()) return line.divergence();
    }
    return std::nullopt;
  }
  std::uint64_t same() const {
    std::uint64_t same = 0;
    for (const Comparison& line : lines_) same += line.same();
    return same;
  }

 private:
  std::function<void()> diverged_;
  std::vector<Comparison> lines_;
};

RecordedBench bench_of(const WireRecording& recording, const std::string& name,
                       const GivenFiles& files, const ReplayOptions& options) {
  RecordedBench bench = parse_bench(recording.bench, name);
  files.give(recording, bench.options.drives);
  if (options.seed) bench.options.seed = *options.seed;
  for (DriveSpec& drive : bench.options.drives) {
    if (!options.motors.empty()) drive.motors = options.motors;
    if (!options.load.empty()) drive.load = options.load;
    drive.set.insert(drive.set.end(), options.set.begin(), options.set.end());
  }
  bench.options.notes = options.notes;
  return bench;
}

// Does what the hosts did, each thing where it stood among the loop's events.
void act(Bench& bench, const std::vector<RecordedLine>& lines, const HostAction& action) {
  if (action.when.before_events)
    bench.loop().run_before(action.when.time);
  else
    bench.loop().run_until(action.when.time);
  SerialLine& line = bench.line(lines[action.line].name);
  if (action.settings)
    line.set_host(*action.settings);
  else
    line.host_send(action.bytes);
}

}  // namespace

ReplayResult replay(const WireRecording& recording, const std::string& name,
                    const ReplayOptions& options) {
  const GivenFiles files(recording, name);
  const RecordedBench recorded = bench_of(recording, name, files, options);
  Bench bench(recorded.options);
  const std::vector<RecordedLine> lines = recorded_lines(bench, recorded.options);
  if (lines != recording.lines) {
    if (!recording.cut_short.empty()) {
      throw SetupError(fmt::format("{}, before anything happened", recording.cut_short));
    }
    throw SetupError(fmt::format("{}: its lines are not those of the bench it describes", name));
  }
  std::optional<SignalComparison> signals;
  if (!options.signals.empty()) {
    if (recorded.signals.empty()) {
      throw SetupError(fmt::format("{}: no signals were recorded beside (run --record)", name));
    }
    signals.emplace(options.signals, recorded.signals.size(), options.signal_tolerance);
  }
  bool over = false;
  std::optional<Sampler> sampler;
  if (!recorded.signals.empty()) {
    sampler.emplace(bench.loop(), bench.registry(), recorded.signals, recorded.interval,
                    [&](SimTime time, auto values) {
                      if (!signals) return;
                      signals->see(time, values);
                      if (!signals->divergence() || !options.wire.empty()) return;
                      over = true;
                      bench.loop().stop();
                    });
  }
  Comparisons comparisons(recording, options.tolerance, [&] {
    if (!options.wire.empty()) return;
    over = true;
    bench.loop().stop();
  });
  WireRecorder recorder(options.wire, bench, recorded, &comparisons);

  ReplayResult result;
  for (const HostAction& action : recording.actions) {
    act(bench, lines, action);
    if (over) break;
    result.host_bytes += action.bytes.size();
  }
  if (!over) bench.run_until(recording.end);
  recorder.close();
  if (!over) comparisons.finish();
  result.drive_bytes = comparisons.same();
  result.end = bench.loop().now();
  result.divergence = comparisons.divergence();
  if (signals) {
    result.rows = signals->rows_compared();
    result.signal_divergence = signals->divergence();
  }
  return result;
}

}  // namespace virtdrive
