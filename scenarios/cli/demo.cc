#include <atomic>
#include <chrono>
#include <exception>
#include <fmt/format.h>
#include <optional>
#include <thread>

#include "devices/toshiba_mcu/client.h"
#include "firmware_models/toshiba_mcu/stage.h"
#include "pty/host_port.h"
#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "scenarios/cli/commands.h"
#include "scenarios/cli/demo_report.h"
#include "scenarios/output_file.h"
#include "scenarios/recording/sampler.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using toshiba_mcu::Stage;

constexpr std::uint8_t kMotor = 1;
constexpr std::int32_t kSpeedRpm = 2000;
constexpr double kLoadNm = 0.02;
constexpr SimDuration kRowInterval = 250ms;
constexpr SimDuration kSampleInterval = 1ms;

// The host program's side: everything goes through the pseudo-terminal, as for anybody's program.
class DemoHost {
 public:
  DemoHost(const std::string& path, int baud) : port_(path, baud), client_(port_) {}

  void play() {
    firmware_ = client_.version();
    fmt::print("firmware {}; motor {}: MaxAngAcc 1500 rad/s2, {} rpm, start\n\n", firmware_, kMotor,
               kSpeedRpm);
    client_.set(kMotor, "MaxAngAcc", {1500, 0});
    client_.set(kMotor, "Speed", {kSpeedRpm, 0});
    client_.start_motor(kMotor);
    started_tick_ = client_.motor_state(kMotor).tick_ms;
    fmt::print("{:>8}  {:<18} {:>6} {:>7} {:>8} {:>9} {:>7}  {}\n", "drive ms", "stage", "rpm",
               "target", "mA", "mNm", "bus V", "");
    watch("accelerating", 2000);
    if (std::abs(client_.motor_state(kMotor).actual_rpm - kSpeedRpm) > 40) {
      throw ClientError("the motor did not reach its speed");
    }
    load_nm = kLoadNm;
    watch(fmt::format("load {:.0f} mNm", kLoadNm * 1e3), 3000);
    load_nm = 0;
    watch("load off", 3500);
    client_.stop_motor(kMotor);
    watch("stopping", 5200);
    if (stage() != Stage::kStop) throw ClientError("the motor did not stop");
  }

  /// As the drive told it; to be asked after play().
  const std::string& firmware() const { return firmware_; }

  std::atomic<double> load_nm = 0;  // what the bench puts on the shaft: no host can do that

 private:
  Stage stage() { return static_cast<Stage>(client_.get(kMotor, "MotorStage").value); }

  // A row now and then until the drive's own clock says so many milliseconds since the start.
  void watch(const std::string& remark, std::uint32_t until_ms) {
    for (bool first = true;; first = false) {
      const toshiba_mcu::MotorState state = client_.motor_state(kMotor);
      const std::uint32_t since = state.tick_ms - started_tick_;
      fmt::print("{:>8}  {:<18} {:>6} {:>7} {:>8} {:>9.1f} {:>7.1f}  {}\n", since,
                 toshiba_mcu::name(stage()), state.actual_rpm, state.target_rpm, state.current_ma,
                 state.torque * 0.01, client_.get(kMotor, "DcLinkVoltage").value * 0.1,
                 first ? remark : "");
      std::fflush(stdout);
      if (since >= until_ms) return;
      // The drive never speaks first: to listen is to wait.
      port_.read(std::min<SimDuration>(kRowInterval, std::chrono::milliseconds(until_ms - since)));
    }
  }

  HostPort port_;
  toshiba_mcu::Client client_;
  std::string firmware_;
  std::uint32_t started_tick_ = 0;
};

std::string message_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

int demo(const DemoOptions& options) {
  DemoReport report(kMotor);
  Bench bench({.drives = {{.kind = "toshiba-mcu"}},
               .listener = [&](auto, const WireEvent& event) { report.add_frame(event); }});
  const Sampler sampler(bench.loop(), bench.registry(), report.signals(), kSampleInterval,
                        [&](SimTime time, auto values) { report.add_row(time, values); });
  PtyEndpoint port(bench.line(), options.link);
  std::optional<OutputFile> page;
  if (!options.report.empty()) page.emplace("--report", options.report);
  Runner runner(bench.loop(), {.rate = 1.0});
  runner.add(port);
  fmt::print("{} with motor {} on {}\n", bench.drive().kind().table.title,
             bench.drive().motor(kMotor).name, port.path());

  DemoHost host(port.path(), bench.line().settings().baud);
  const std::string load = fmt::format("load{}.brake_torque", kMotor);
  Wakeup load_watch;
  load_watch = bench.loop().add(Phase::kScenario, [&] {
    const double load_nm = host.load_nm;
    bench.set(load, load_nm);
    report.add_load(bench.loop().now(), load_nm);
    load_watch.at(bench.loop().now() + 10ms);
  });
  load_watch.at(bench.loop().now());

  std::exception_ptr failure;
  std::thread host_thread([&] {
    try {
      host.play();
    } catch (...) {
      failure = std::current_exception();
    }
    runner.request_stop();
  });
  const PacingReport pacing = runner.run();
  host_thread.join();
  if (page) {
    const std::string result = pacing.signal != 0 ? "interrupted"
                               : failure          ? message_of(failure)
                                                  : "as expected";
    page->write(html(report.make(bench, host.firmware(), result)));
    page->close();
  }
  if (pacing.signal != 0) {
    fmt::print(stderr, "virtdrive: interrupted\n");
    return kExitFailed;
  }
  if (failure) std::rethrow_exception(failure);

  const WireCounters wire = bench.drive().controller().wire_counters();
  fmt::print("\n{} requests, {} replies, {} bad frames, {} bytes lost, {} overruns\n",
             wire.requests, wire.replies, wire.bad_frames, wire.bytes_lost, pacing.overruns);
  if (page) fmt::print("plots of it all: {}, for any browser\n", options.report);
  fmt::print("next: ./virtdrive run toshiba-mcu --link /tmp/drive   and open /tmp/drive\n");
  return kExitOk;
}

}  // namespace virtdrive
