#include "pty/runner.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <gtest/gtest.h>
#include <thread>

#include "pty/host_port.h"
#include "pty/pty_endpoint.h"
#include "tests/pty/child_process.h"
#include "tests/pty/temporary_folder.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

// Simulated time after which a paced run is ended, whatever went wrong: the deadline of these
// tests.
constexpr SimTime kDeadline = kSimStart + 30s;

/// Answers each byte at once with its complement, and notes when it came.
class Complement final : public SerialReceiver {
 public:
  Complement(EventLoop& loop, SerialPort& port) : loop_(loop), port_(port) {}
  void receive(std::uint8_t byte) override {
    times.push_back(loop_.now());
    in_order = in_order && loop_.next() >= loop_.now();
    const auto answer = static_cast<std::uint8_t>(~byte);
    port_.send(std::span(&answer, 1));
  }

  std::vector<SimTime> times;
  bool in_order = true;  // nothing of an earlier instant was left to do

 private:
  EventLoop& loop_;
  SerialPort& port_;
};

struct Drive {
  explicit Drive(EventLoop& loop, const std::string& link = "")
      : line(loop, {.timing = LineTiming::kIdeal}),
        device(loop, line.add_device()),
        endpoint(line, link) {
    line.device(0).attach(device);
  }
  SerialLine line;
  Complement device;
  PtyEndpoint endpoint;
};

bool exchange(HostPort& host, std::uint8_t byte) {
  host.write(Bytes{byte});
  return host.read(1, 10s) == Bytes{static_cast<std::uint8_t>(~byte)};
}

TEST(Runner, AFreeRunGoesToItsEndAsFastAsItCanAndNoFurther) {
  EventLoop loop;
  std::uint64_t ticks = 0;
  Wakeup tick;
  tick = loop.add(Phase::kControl, [&] {
    ++ticks;
    tick.at(loop.now() + 1ms);
  });
  tick.at(kSimStart + 1ms);
  Runner runner{loop, {.rate = std::nullopt, .until = kSimStart + 100s}};
  const PacingReport report = runner.run();
  EXPECT_EQ(ticks, 100'000U);
  EXPECT_EQ(loop.now(), kSimStart + 100s);
  EXPECT_EQ(report.simulated, 100s);
  EXPECT_EQ(report.rate, 0);
  EXPECT_EQ(report.overruns, 0U);
}

TEST(Runner, AFreeRunJumpsOverTimeInWhichNothingHappens) {
  EventLoop loop;
  int runs = 0;
  Wakeup wakeup = loop.add(Phase::kDevice, [&] { ++runs; });
  wakeup.at(kSimStart + 999'999h);
  const PacingReport report = Runner{loop, {.rate = std::nullopt}}.run();
  EXPECT_EQ(runs, 1);
  EXPECT_LE(report.wakeups, 3U);
}

TEST(Runner, APacedRunEndsExactlyAtItsEnd) {
  EventLoop loop;
  std::uint64_t ticks = 0;
  Wakeup tick;
  tick = loop.add(Phase::kControl, [&] {
    ++ticks;
    tick.at(loop.now() + 80us);
  });
  tick.at(kSimStart + 80us);
  Runner runner{loop, {.rate = 2, .until = kSimStart + 80ms}};
  const PacingReport report = runner.run();
  EXPECT_EQ(loop.now(), kSimStart + 80ms);
  EXPECT_EQ(ticks, 1'000U);
  EXPECT_EQ(report.simulated, 80ms);
  EXPECT_GE(report.elapsed + report.slipped, 40ms);  // paced: not before its time
  EXPECT_LE(report.wakeups, 100U);                   // control steps do not cost a wake-up each
}

TEST(Runner, BytesFromAHostWakeItAtOnce) {
  EventLoop loop;
  Drive drive{loop};
  Wakeup control;
  control = loop.add(Phase::kControl, [&] { control.at(loop.now() + 80us); });
  control.at(kSimStart + 80us);
  Runner runner{loop, {.until = kDeadline}};
  runner.add(drive.endpoint);
  bool good = true;
  std::thread host_thread([&] {
    HostPort host{drive.endpoint.path(), 115200};
    for (int i = 0; i < 200; ++i) good = exchange(host, static_cast<std::uint8_t>(i)) && good;
    runner.request_stop();
  });
  runner.run();
  host_thread.join();
  EXPECT_TRUE(good);
  EXPECT_TRUE(drive.device.in_order);
  ASSERT_EQ(drive.device.times.size(), 200U);
  // If a quantum of a millisecond were waited out, no two requests could be closer than that.
  SimDuration closest = 1s;
  for (std::size_t i = 1; i < drive.device.times.size(); ++i) {
    EXPECT_GT(drive.device.times[i], drive.device.times[i - 1]);
    closest = std::min(closest, drive.device.times[i] - drive.device.times[i - 1]);
  }
  EXPECT_LT(closest, 900us);
}

TEST(Runner, ServesSeveralEndpointsWhileNothingElseHappens) {
  EventLoop loop;
  Drive first{loop};
  Drive second{loop};
  for (const std::optional<double> rate : {std::optional<double>{1.0}, std::optional<double>{}}) {
    Runner runner{loop, {.rate = rate}};
    runner.add(first.endpoint);
    runner.add(second.endpoint);
    bool good = false;
    std::thread host_thread([&] {
      HostPort a{first.endpoint.path(), 115200};
      HostPort b{second.endpoint.path(), 115200};
      good = exchange(a, 1) && exchange(b, 2) && exchange(a, 3);
      runner.request_stop();
    });
    runner.run();
    host_thread.join();
    EXPECT_TRUE(good);
  }
}

TEST(Runner, AHostOnARealLineIsAnsweredAfterTheCharacterTimes) {
  EventLoop loop;
  SerialLine line{loop, {.baud = 9600}};
  Complement device{loop, line.add_device()};
  line.device(0).attach(device);
  PtyEndpoint endpoint{line};
  Runner runner{loop, {.until = kDeadline}};
  runner.add(endpoint);
  bool good = false;
  std::thread host_thread([&] {
    HostPort host{endpoint.path(), 9600};
    good = exchange(host, 1) && exchange(host, 2);
    runner.request_stop();
  });
  runner.run();
  host_thread.join();
  EXPECT_TRUE(good);
  ASSERT_EQ(device.times.size(), 2U);
  EXPECT_GE(device.times[1] - device.times[0], 2 * line.settings().character_time());
}

TEST(Runner, CallsForAStatusLineNowAndThen) {
  EventLoop loop;
  int calls = 0;
  Runner* stop_me = nullptr;
  RunnerOptions options{.until = kDeadline, .status_interval = 1ms};
  options.status = [&](const PacingReport& report) {
    EXPECT_EQ(report.rate, 1);
    EXPECT_GE(report.elapsed, 1ms);
    if (++calls == 3) stop_me->request_stop();
  };
  Runner runner{loop, options};
  stop_me = &runner;
  runner.run();
  EXPECT_EQ(calls, 3);
  EXPECT_LT(loop.now(), kDeadline);
}

TEST(Runner, ACallbackThatStopsTheLoopEndsTheRun) {
  for (const SimDuration at : {SimDuration{5ms}, SimDuration{10ms}, SimDuration{20ms}}) {
    for (const std::optional<double> rate : {std::optional<double>{1.0}, std::optional<double>{}}) {
      EventLoop loop;
      Wakeup stop = loop.add(Phase::kScenario, [&] { loop.stop(); });
      Wakeup after = loop.add(Phase::kRecord, [] { FAIL() << "after the stop"; });
      stop.at(kSimStart + at);
      after.at(kSimStart + 1s);
      Runner{loop, {.rate = rate, .until = kDeadline}}.run();
      EXPECT_EQ(loop.now(), kSimStart + at);
    }
  }
}

TEST(Runner, AnExceptionFromASimulationComesOutOfTheRun) {
  EventLoop loop;
  Wakeup fails = loop.add(Phase::kDevice, [] { throw SetupError("solver"); });
  fails.at(kSimStart + 1ms);
  Runner runner{loop, {.until = kDeadline}};
  EXPECT_THROW(runner.run(), SetupError);
}

TEST(Runner, ASignalEndsTheRunAndNoLinkStays) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "drive";
    ChildProcess bench{[&](const std::function<void()>& ready) {
      EventLoop loop;
      Drive drive{loop, path};
      Runner runner{loop, {.until = kDeadline}};
      runner.add(drive.endpoint);
      ready();
      const PacingReport report = runner.run();
      return report.signal == signal && loop.now() < kDeadline ? 42 : 1;
    }};
    ASSERT_TRUE(bench.ready());
    EXPECT_TRUE(std::filesystem::is_symlink(path));
    const int status = bench.end(signal);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 42);
    EXPECT_FALSE(std::filesystem::is_symlink(path));
    EXPECT_FALSE(std::filesystem::exists(path.string() + ".lock"));
  }
}

}  // namespace
}  // namespace virtdrive
