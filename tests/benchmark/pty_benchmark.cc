// Requests per second over a pseudo-terminal, against the least that any program could do.
//
// A host thread asks for the motor's state, 5 bytes, and waits for 24, with blocking calls on the
// slave. The other side is (a) a thread that does nothing but read() and write() on the master,
// (b) a Toshiba drive on an ideal line: runner, endpoint, line, device, firmware. Both in this
// process, by turns. Counters: exchanges per second, `of_bare` relative to (a) of the same round,
// percentiles of the time from write() to the last byte read; medians of the rounds.
//
// At 115200 baud the answer's last byte is due 5 characters, 1 ms and 24 characters after the
// request; `late` tells how much later the host has it.
#include <algorithm>
#include <array>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "pty/tty_settings.h"
#include "scenarios/bench.h"

namespace virtdrive {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kRequest = 5;
constexpr std::size_t kReply = 24;
constexpr int kRounds = 5;
constexpr int kWarmUp = 200;
constexpr double kDueUs = 1000 + (kRequest + kReply) * 10 * 1e6 / 115200;

struct Result {
  double rate = 0;  // exchanges per second
  double p50_us = 0;
  double p99_us = 0;
};

constexpr int kExchanges = 10'000;

/// The host: the same for both, so that only the other side differs.
Result exchange(const std::string& path, int exchanges) {
  const FileDescriptor tty{::open(path.c_str(), O_RDWR | O_NOCTTY)};
  if (!tty || !set_raw(tty.get(), {115200, 1}, RawFor::kHost)) std::abort();
  const std::array<std::uint8_t, kRequest> request{0x11, 0x02, 0x01, 0x09, 0x13};
  std::array<std::uint8_t, kReply> reply{};
  std::vector<double> latency_us;
  latency_us.reserve(static_cast<std::size_t>(exchanges));
  Clock::time_point begin;
  for (int i = -kWarmUp; i < exchanges; ++i) {
    const Clock::time_point sent = Clock::now();
    if (i == 0) begin = sent;
    if (::write(tty.get(), request.data(), request.size()) != kRequest) std::abort();
    for (std::size_t got = 0; got < kReply;) {
      const ssize_t size = ::read(tty.get(), reply.data() + got, kReply - got);
      if (size <= 0) std::abort();
      got += static_cast<std::size_t>(size);
    }
    const std::chrono::duration<double, std::micro> took = Clock::now() - sent;
    if (i >= 0) latency_us.push_back(took.count());
  }
  const std::chrono::duration<double> total = Clock::now() - begin;
  std::sort(latency_us.begin(), latency_us.end());
  return {exchanges / total.count(), latency_us[latency_us.size() / 2],
          latency_us[latency_us.size() * 99 / 100]};
}

Result bare_echo(int exchanges) {
  FileDescriptor master{posix_openpt(O_RDWR | O_NOCTTY)};
  if (!master || unlockpt(master.get()) != 0) std::abort();
  const std::string path = ptsname(master.get());
  const FileDescriptor keeper{::open(path.c_str(), O_RDWR | O_NOCTTY)};
  if (!set_raw(keeper.get(), {115200, 1}, RawFor::kHost)) std::abort();
  std::thread echo([&] {
    std::array<std::uint8_t, 256> bytes{};
    std::size_t got = 0;
    for (int i = -kWarmUp; i < exchanges; ++i) {
      for (; got < kRequest;) {
        const ssize_t size = ::read(master.get(), bytes.data(), bytes.size());
        if (size <= 0) std::abort();
        got += static_cast<std::size_t>(size);
      }
      got -= kRequest;
      if (::write(master.get(), bytes.data(), kReply) != kReply) std::abort();
    }
  });
  const Result result = exchange(path, exchanges);
  echo.join();
  return result;
}

Result drive(LineTiming timing, bool turning, int exchanges) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .lines = {{.timing = timing}}});
  if (turning) {
    bench.host()->start_motor(1, 2000);
    bench.run_for(std::chrono::seconds(4));
  }
  PtyEndpoint endpoint{bench.line()};
  Runner runner{bench.loop(), {}};
  runner.add(endpoint);
  Result result;
  std::thread host([&] {
    result = exchange(endpoint.path(), exchanges);
    runner.request_stop();
  });
  runner.run();
  host.join();
  return result;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

template <class Run>
void measure(benchmark::State& state, const Run& run) {
  std::vector<double> rate, p50, p99, of_bare;
  for (auto _ : state) {
    const Result bare = bare_echo(kExchanges);
    const Result result = run();
    state.SetIterationTime(kExchanges / result.rate);
    rate.push_back(result.rate);
    p50.push_back(result.p50_us);
    p99.push_back(result.p99_us);
    of_bare.push_back(result.rate / bare.rate);
  }
  state.counters["per_second"] = median(rate);
  state.counters["of_bare"] = median(of_bare);
  state.counters["p50_us"] = median(p50);
  state.counters["p99_us"] = median(p99);
}

void bare(benchmark::State& state) {
  measure(state, [] { return bare_echo(kExchanges); });
}
void ideal_line_motor_stopped(benchmark::State& state) {
  measure(state, [] { return drive(LineTiming::kIdeal, false, kExchanges); });
}
void ideal_line_motor_turning(benchmark::State& state) {
  measure(state, [] { return drive(LineTiming::kIdeal, true, kExchanges); });
}

void real_line_115200(benchmark::State& state) {
  constexpr int kFew = 500;  // 3.5 ms each
  for (auto _ : state) {
    const Result result = drive(LineTiming::kReal, false, kFew);
    state.SetIterationTime(kFew / result.rate);
    state.counters["due_us"] = kDueUs;
    state.counters["late_p50_us"] = result.p50_us - kDueUs;
    state.counters["late_p99_us"] = result.p99_us - kDueUs;
  }
}

BENCHMARK(bare)->UseManualTime()->Iterations(kRounds)->Unit(benchmark::kMillisecond);
BENCHMARK(ideal_line_motor_stopped)
    ->UseManualTime()
    ->Iterations(kRounds)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(ideal_line_motor_turning)
    ->UseManualTime()
    ->Iterations(kRounds)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(real_line_115200)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace virtdrive

BENCHMARK_MAIN();
