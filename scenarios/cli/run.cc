#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <unistd.h>

#include "core/check.h"
#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "pty/serial_device_endpoint.h"
#include "pty/tcp_endpoint.h"
#include "scenarios/cli/commands.h"
#include "scenarios/control/control_commands.h"
#include "scenarios/control/control_socket.h"
#include "scenarios/recording/recorder.h"
#include "scenarios/recording/wire_recorder.h"

namespace virtdrive {
namespace {

constexpr std::string_view kEraseLine = "\r\x1b[K";

// Tells on standard error what happens: a status line that is rewritten in place on a terminal,
// frames as they pass with --trace. Standard output carries the ready line and the report only.
class Console {
 public:
  explicit Console(bool quiet) : status_(!quiet && isatty(STDERR_FILENO) == 1) {}

  void print_line(std::string_view text) {
    fmt::print(stderr, "{}{}\n", status_shown_ ? kEraseLine : "", text);
    status_shown_ = false;
  }
  void show_status(std::string_view text) {
    if (!status_) return;
    fmt::print(stderr, "{}{}", kEraseLine, text);
    std::fflush(stderr);
    status_shown_ = true;
  }
  void end_status() {
    if (status_shown_) fmt::print(stderr, "\n");
    status_shown_ = false;
  }

 private:
  bool status_;
  bool status_shown_ = false;
};

std::string hex(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, " "));
}

void trace(Console& console, const WireEvent& event) {
  constexpr std::string_view kMarks[] = {">", "<", "!", "!"};
  console.print_line(fmt::format("[{:12.6f}] {} {}  {}", seconds(event.time),
                                 kMarks[static_cast<std::size_t>(event.kind)], hex(event.bytes),
                                 event.text));
}

struct Start {
  std::size_t channel;
  double rpm;
};

// [CHANNEL:]RPM
Start parse_start(const std::string& text, const DriveKind& kind) {
  Start start{kind.default_channel, 0};
  std::string_view rpm = text;
  const char* const last = text.data() + text.size();
  if (const std::size_t colon = text.find(':'); colon != std::string::npos) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + colon, start.channel);
    if (error != std::errc{} || end != text.data() + colon || start.channel >= kind.channels) {
      throw SetupError(
          fmt::format("--start {}: the channel must be 0 ... {}", text, kind.channels - 1));
    }
    rpm.remove_prefix(colon + 1);
  }
  const auto [end, error] = std::from_chars(rpm.data(), last, start.rpm);
  if (error != std::errc{} || end != last || !(std::abs(start.rpm) <= 1e6)) {
    throw SetupError(fmt::format("--start {}: expected [CHANNEL:]RPM", text));
  }
  return start;
}

void start_motor(Bench& bench, const Start& start) {
  try {
    bench.host()->start_motor(start.channel, start.rpm);
  } catch (const ClientError& error) {
    throw SetupError(fmt::format("--start: {}", error.what()));
  }
}

// Where the host is: a pseudo-terminal unless the options say otherwise.
struct Port {
  std::unique_ptr<HostEndpoint> endpoint;
  std::string address;                     // what a host opens
  std::string terminal;                    // of a pseudo-terminal, behind the link
  std::function<std::uint64_t()> overrun;  // bytes lost because the host did not read
};

template <class Endpoint>
Port make_port(std::unique_ptr<Endpoint> endpoint, std::string address, std::string terminal = "") {
  const Endpoint& opened = *endpoint;
  return {std::move(endpoint), std::move(address), std::move(terminal),
          [&opened] { return opened.counters().overrun; }};
}

Port open_port(const RunOptions& options, SerialLine& line) {
  if (!options.tcp.empty() || !options.rfc2217.empty()) {
    const bool raw = options.rfc2217.empty();
    auto tcp = std::make_unique<TcpEndpoint>(line, raw ? options.tcp : options.rfc2217,
                                             raw ? TcpMode::kRaw : TcpMode::kRfc2217);
    const std::string address = (raw ? "tcp://" : "rfc2217://") + tcp->address();
    return make_port(std::move(tcp), address);
  }
  if (!options.port.empty()) {
    if (options.rate != 1.0) {
      throw SetupError("--port: a real wire keeps real time; leave --rate at 1");
    }
    return make_port(std::make_unique<SerialDeviceEndpoint>(line, options.port), options.port);
  }
  auto pty = std::make_unique<PtyEndpoint>(line, options.link);
  const std::string path = pty->path(), terminal = pty->terminal();
  return make_port(std::move(pty), path, terminal);
}

// "db42s03", or one name a channel.
std::string motors_of(const BenchDrive& drive) {
  std::string names(drive.motor(0).name);
  bool same = true;
  for (std::size_t i = 1; i < drive.channels(); ++i) {
    names += fmt::format(",{}", drive.motor(i).name);
    same = same && drive.motor(i).name == drive.motor(0).name;
  }
  return same ? std::string(drive.motor(0).name) : names;
}

void announce(const RunOptions& options, Bench& bench, const Port& port) {
  const BenchDrive& drive = bench.drive();
  const int baud = bench.line().settings().baud;
  if (options.json) {
    const nlohmann::ordered_json ready = {{"event", "ready"},     {"drive", drive.kind().name},
                                          {"port", port.address}, {"terminal", port.terminal},
                                          {"baud", baud},         {"motor", motors_of(drive)},
                                          {"seed", bench.seed()}, {"pid", getpid()}};
    fmt::print("{}\n", ready.dump());
  } else {
    fmt::print("ready: {} on {} at {} baud, motor {}, seed {}\n", drive.kind().name, port.address,
               baud, motors_of(drive), bench.seed());
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output cannot be written");
}

std::string status_line(Bench& bench, const Port& port, const PacingReport& pacing) {
  const WireCounters wire = bench.drive().controller().wire_counters();
  std::string text = fmt::format("{:.1f} s | {} | {} requests", seconds(bench.loop().now()),
                                 bench.drive().controller().status(), wire.requests);
  const auto count = [&](std::uint64_t n, std::string_view what) {
    if (n > 0) text += fmt::format(" | {} {}", n, what);
  };
  count(wire.bad_frames, "bad");
  count(wire.bytes_lost, "bytes lost while busy");
  count(port.overrun(), "bytes not read by the host");
  count(bench.line().counters().garbled, "bytes at a wrong baud rate");
  count(pacing.overruns, "overruns");
  return text;
}

void report(const RunOptions& options, Bench& bench, const Port& port, const PacingReport& pacing,
            Console& console) {
  const WireCounters wire = bench.drive().controller().wire_counters();
  const double simulated = seconds(bench.loop().now());
  const double elapsed = seconds(SimDuration(pacing.elapsed));
  if (options.json) {
    const nlohmann::ordered_json end = {{"event", "end"},
                                        {"simulated_s", simulated},
                                        {"elapsed_s", elapsed},
                                        {"requests", wire.requests},
                                        {"replies", wire.replies},
                                        {"bad_frames", wire.bad_frames},
                                        {"bytes_lost_busy", wire.bytes_lost},
                                        {"bytes_lost_unread", port.overrun()},
                                        {"bytes_garbled", bench.line().counters().garbled},
                                        {"overruns", pacing.overruns},
                                        {"slips", pacing.slips},
                                        {"max_lag_ms", seconds(SimDuration(pacing.max_lag)) * 1e3},
                                        {"seed", bench.seed()},
                                        {"signal", pacing.signal}};
    fmt::print("{}\n", end.dump());
    return;
  }
  console.end_status();
  console.print_line(fmt::format(
      "{:.3f} s simulated in {:.3f} s; {} requests, {} replies, {} bad frames; bytes "
      "lost: {} while "
      "busy, {} not read; {} overruns, largest lag {:.1f} ms; seed {}",
      simulated, elapsed, wire.requests, wire.replies, wire.bad_frames, wire.bytes_lost,
      port.overrun(), pacing.overruns, seconds(SimDuration(pacing.max_lag)) * 1e3, bench.seed()));
}

// Further terminals, each on a line of its own at one of the drive's further ports.
struct FurtherLine {
  std::size_t port;
  std::string name;
  std::string link;
};

std::vector<FurtherLine> further_lines(const RunOptions& options) {
  std::vector<FurtherLine> lines;
  if (!options.link2.empty()) lines.push_back({1, "line2", options.link2});
  if (!options.link3.empty()) lines.push_back({2, "line3", options.link3});
  if (options.can_link.empty()) return lines;
  const DriveKind& kind = find_drive(options.bench.drives[0].kind);
  const auto can = std::ranges::find_if(kind.ports, &PortKind::can);
  if (can == kind.ports.end()) {
    throw SetupError(fmt::format("--can-link: {} has no CAN port", kind.name));
  }
  const auto port = static_cast<std::size_t>(can - kind.ports.begin());
  if (std::ranges::find(lines, port, &FurtherLine::port) != lines.end()) {
    throw SetupError(fmt::format("--link{}: that port of {} is CAN; --can-link alone is enough",
                                 port + 1, kind.name));
  }
  lines.push_back({port, "can", options.can_link});
  return lines;
}

void add_further_lines(const std::vector<FurtherLine>& lines, BenchOptions& bench) {
  std::vector<std::string>& others = bench.drives[0].other_lines;
  for (const FurtherLine& line : lines) {
    bench.lines.push_back({.name = line.name, .timing = bench.lines[0].timing});
    others.resize(std::max(others.size(), line.port));
    others[line.port - 1] = line.name;
  }
}

}  // namespace

int run(const RunOptions& options) {
  Console console(options.json);
  BenchOptions bench_options = options.bench;
  bench_options.notes = [&console](std::string_view text) {
    console.print_line(fmt::format("note: {}", text));
  };
  if (options.trace) {
    bench_options.listener = [&console](auto, const WireEvent& event) { trace(console, event); };
  }
  if (options.signals.empty() != options.record.empty()) {
    throw SetupError("--record FILE and --signals NAME,... go together");
  }
  const std::vector<FurtherLine> further = further_lines(options);
  add_further_lines(further, bench_options);
  Bench bench(bench_options);
  std::optional<Start> start;
  if (!options.start.empty()) start = parse_start(options.start, bench.drive().kind());
  const Port port = open_port(options, bench.line());
  std::vector<std::unique_ptr<PtyEndpoint>> others;
  for (const FurtherLine& line : further) {
    others.push_back(std::make_unique<PtyEndpoint>(bench.line(line.name), line.link));
  }
  std::optional<Recorder> recorder;
  if (!options.record.empty()) {
    recorder.emplace(bench.loop(), bench.registry(), options.record, options.signals,
                     from_seconds(options.interval_s));
  }
  std::optional<WireRecorder> wire;
  if (!options.wire.empty()) {
    wire.emplace(options.wire, bench,
                 RecordedBench{bench_options, options.signals, from_seconds(options.interval_s)});
  }
  if (start) start_motor(bench, *start);
  const SimTime until = options.duration_s ? kSimStart + from_seconds(*options.duration_s) : kNever;
  Runner runner(bench.loop(),
                {.rate = options.rate, .until = until, .status = [&](const auto& now) {
                   console.show_status(status_line(bench, port, now));
                 }});
  ControlCommands commands(bench, runner);
  std::optional<ControlSocket> control;
  if (!options.control.empty()) {
    control.emplace(options.control,
                    [&](std::string_view request) { return commands.answer(request); });
    runner.add(*control);
  }
  runner.add(*port.endpoint);
  for (const auto& other : others) runner.add(*other);
  announce(options, bench, port);
  if (!options.rate && !options.duration_s) {
    console.print_line("free run: simulated time passes much faster than a host program expects");
  }
  const PacingReport pacing = runner.run();
  if (wire) wire->close();
  if (recorder) recorder->close();
  report(options, bench, port, pacing, console);
  return kExitOk;
}

}  // namespace virtdrive
