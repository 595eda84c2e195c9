#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/check.h"
#include "pty/device_tap.h"
#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "pty/serial_device_endpoint.h"
#include "scenarios/cli/commands.h"
#include "scenarios/recording/bench_description.h"
#include "scenarios/recording/line_monitor.h"
#include "scenarios/recording/wire_file.h"
#include "scenarios/recording/wire_recording.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;
using protocol::Direction;
using protocol::Verdict;

/// A packet as it is shown: of a recording, or as it passes.
struct Shown {
  SimTime time;  // of its first bit
  std::string_view line;
  Direction direction;
  Verdict verdict;
  std::vector<std::uint8_t> bytes;
  std::string text;
};

std::string_view word(Verdict verdict) {
  constexpr std::string_view kWords[] = {"frame", "bad checksum", "malformed", "noise",
                                         "cut short"};
  return kWords[static_cast<std::size_t>(verdict)];
}

class Printer {
 public:
  explicit Printer(const MonitorOptions& options)
      : json_(options.json),
        color_(options.color == "always" ||
               (options.color == "auto" && isatty(STDOUT_FILENO) == 1)) {}

  void show(const Shown& packet) const {
    const std::string hex = fmt::format("{:02x}", fmt::join(packet.bytes, " "));
    if (json_)
      show_json(packet, hex);
    else
      show_text(packet, hex);
    std::fflush(stdout);
  }

 private:
  static void show_json(const Shown& packet, const std::string& hex) {
    const Json json = {{"time_ns", packet.time.time_since_epoch().count()},
                       {"line", packet.line},
                       {"from", packet.direction == Direction::kRequest ? "host" : "drive"},
                       {"verdict", word(packet.verdict)},
                       {"bytes", hex},
                       {"text", packet.text}};
    fmt::print("{}\n", json.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  void show_text(const Shown& packet, const std::string& hex) const {
    constexpr std::string_view kHost = "\x1b[36m", kDrive = "\x1b[32m", kWrong = "\x1b[31m";
    const bool good = packet.verdict == Verdict::kFrame;
    const bool host = packet.direction == Direction::kRequest;
    const std::string_view color = !good ? kWrong : host ? kHost : kDrive;
    fmt::print("[{:12.6f}] {} {}{} {}  {}{}{}\n", seconds(packet.time), packet.line,
               color_ ? color : "", host ? '>' : '<', hex,
               good ? "" : fmt::format("{}: ", word(packet.verdict)), packet.text,
               color_ ? "\x1b[0m" : "");
  }

  bool json_;
  bool color_;
};

// A recorded comment ends with the frame's times, which have a column of their own.
std::string without_times(const std::string& comment) {
  const std::size_t times = comment.rfind(" (");
  return times == std::string::npos || !comment.ends_with(" s)") ? comment
                                                                 : comment.substr(0, times);
}

int show_recording(const MonitorOptions& options) {
  const Printer printer(options);
  const std::string why = follow_wire_recording(
      options.file, [&](const WireRecording& so_far, const RecordedPacket& packet) {
        printer.show({packet.first_bit, so_far.lines[packet.line].name, packet.direction,
                      packet.verdict, packet.bytes, without_times(packet.comment)});
      });
  if (!why.empty()) fmt::print(stderr, "note: {}\n", why);
  return kExitOk;
}

// Shows what passes the tap, and lets the device's port follow the host's settings.
class TapSink final : public WireSink {
 public:
  TapSink(const Printer& printer, std::string_view line, DeviceTap& tap)
      : printer_(printer), line_(line), tap_(tap) {}

  void host_settings(std::size_t, HostInstant, const HostSettings& settings) override {
    tap_.follow(settings);
  }
  void host_write(std::size_t, HostInstant, std::span<const std::uint8_t>) override {}
  void packet(std::size_t, const WirePacket& packet) override {
    Shown shown{packet.bytes.front().begin, line_, packet.direction, packet.verdict, {},
                std::string(packet.text)};
    for (const WireByte& byte : packet.bytes) shown.bytes.push_back(byte.byte);
    printer_.show(shown);
  }

 private:
  const Printer& printer_;
  std::string_view line_;
  DeviceTap& tap_;
};

// Where the host is: an existing serial port, or a terminal that is made under this name.
std::unique_ptr<HostEndpoint> host_end(SerialLine& line, const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_character_file(path, ignored)) {
    return std::make_unique<SerialDeviceEndpoint>(line, path);
  }
  return std::make_unique<PtyEndpoint>(line, path);
}

// As a bench's recording, so that a replay can put our drive in the real one's place.
std::string description(const DriveKind& kind, const RecordedLine& line) {
  return describe({.options = {.drives = {{.kind = std::string(kind.name),
                                           .motors = {std::string(kind.default_motor)}}},
                               .lines = {{.name = line.name,
                                          .baud = line.baud,
                                          .duplex = kind.ports.front().duplex}}}});
}

int tap(const MonitorOptions& options) {
  const DriveKind& kind = find_protocol(options.protocol);
  const TtySettings settings{.baud = options.baud.value_or(kind.ports.front().baud),
                             .parity = options.parity};
  EventLoop loop;
  SerialLine line(loop,
                  {.timing = LineTiming::kIdeal, .baud = settings.baud, .parity = settings.parity});
  DeviceTap device(line, options.tap.front(), settings);
  const auto host = host_end(line, options.tap.back());

  const RecordedLine recorded{"tap", std::string(kind.table.name), settings.baud};
  const Printer printer(options);
  TapSink sink(printer, recorded.name, device);
  std::vector<WireSink*> sinks = {&sink};
  std::optional<WireFile> file;
  if (!options.wire.empty()) {
    file.emplace(options.wire, description(kind, recorded), std::vector{recorded},
                 std::vector<RecordedFile>{});
    sinks.push_back(&*file);
  }
  LineMonitor monitor(loop, line, 0, recorded.protocol, sinks);
  fmt::print(stderr, "the host's port is {}; Ctrl-C ends the tap\n", options.tap.back());
  Runner runner(loop, {.rate = 1.0});
  runner.add(device);
  runner.add(*host);
  runner.run();
  monitor.finish();
  if (file) file->close(loop.now());
  return kExitOk;
}

}  // namespace

int monitor(const MonitorOptions& options) {
  if (options.tap.empty() == options.file.empty()) {
    throw SetupError("monitor: expected a recording, or --tap DEVICE HOST");
  }
  if (options.tap.empty()) return show_recording(options);
  if (options.protocol.empty()) throw SetupError("monitor --tap: --protocol is missing");
  return tap(options);
}

}  // namespace virtdrive
