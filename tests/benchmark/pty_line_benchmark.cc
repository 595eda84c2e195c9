// What a byte costs on a simulated line, against the least that any line could do.
//
// The host says 5 bytes, a device answers with 24, and so on. The yardstick is an event loop that
// wakes for each byte at its instant and hands it to one receiver; it knows no settings, no queue
// and no second talker. Both by turns in the same process. `ns_per_byte` is for a byte on the
// wires, whoever hears it; `of_bare` is relative to the yardstick; medians of the rounds.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <deque>
#include <vector>

#include "pty/serial_line.h"

namespace virtdrive {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int kRounds = 15;
constexpr int kExchanges = 20'000;
constexpr std::size_t kRequest = 5;
constexpr std::size_t kReply = 24;
constexpr double kBytes = kExchanges * double{kRequest + kReply};
constexpr LineSettings kLine{.baud = 115200};

class Sum final : public SerialReceiver {
 public:
  void receive(std::uint8_t byte) override { sum += byte; }
  std::uint64_t sum = 0;
};

double ns_per_byte(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / kBytes;
}

double bare() {
  EventLoop loop;
  Sum receiver;
  std::size_t left = 0;
  Wakeup wakeup;
  wakeup = loop.add(Phase::kBytes, [&] {
    receiver.receive(0x55);
    if (--left > 0) wakeup.at(loop.now() + kLine.character_time());
  });
  const auto say = [&](std::size_t count, SimDuration patience) {
    left = count;
    wakeup.at(loop.now() + kLine.character_time());
    loop.run_until(loop.now() + patience);
  };
  const Clock::time_point begin = Clock::now();
  for (int i = 0; i < kExchanges; ++i) {
    say(kRequest, 1500us);
    say(kReply, 2500us);
  }
  benchmark::DoNotOptimize(receiver.sum);
  return ns_per_byte(begin);
}

/// The devices answer in turn; with `clash`, two at once.
double line(Duplex duplex, std::size_t stations, bool clash) {
  EventLoop loop;
  SerialLine line(loop, kLine, {.duplex = duplex});
  std::deque<Sum> devices(stations);
  for (Sum& device : devices) line.add_device().attach(device);
  std::uint64_t host = 0;
  line.on_host_byte([&](std::uint8_t byte, SimTime) { host += byte; });
  const std::vector<std::uint8_t> request(kRequest, 0x55);
  const std::vector<std::uint8_t> reply(kReply, 0x33);
  const std::vector<std::uint8_t> other(kReply, 0x0F);
  const Clock::time_point begin = Clock::now();
  for (std::size_t i = 0; i < kExchanges; ++i) {
    line.host_send(request);
    loop.run_until(loop.now() + 1500us);
    line.device(i % stations).send(reply);
    if (clash) line.device((i + 1) % stations).send(other);
    loop.run_until(loop.now() + 2500us);
  }
  benchmark::DoNotOptimize(host);
  return ns_per_byte(begin);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void measure(benchmark::State& state, Duplex duplex, bool clash) {
  std::vector<double> cost, of_bare;
  for (auto _ : state) {
    const double yardstick = bare();
    cost.push_back(line(duplex, static_cast<std::size_t>(state.range(0)), clash));
    of_bare.push_back(cost.back() / yardstick);
    state.SetIterationTime(cost.back() * kBytes * 1e-9);
  }
  state.counters["ns_per_byte"] = median(cost);
  state.counters["bytes_per_s"] = 1e9 / median(cost);
  state.counters["of_bare"] = median(of_bare);
}

void full_duplex(benchmark::State& state) {
  measure(state, Duplex::kFull, false);
}
void half_duplex(benchmark::State& state) {
  measure(state, Duplex::kHalf, false);
}
void half_duplex_two_answer_at_once(benchmark::State& state) {
  measure(state, Duplex::kHalf, true);
}

BENCHMARK(full_duplex)->Arg(1)->UseManualTime()->Iterations(kRounds);
BENCHMARK(half_duplex)->Arg(1)->Arg(4)->Arg(32)->UseManualTime()->Iterations(kRounds);
BENCHMARK(half_duplex_two_answer_at_once)->Arg(4)->Arg(32)->UseManualTime()->Iterations(kRounds);

}  // namespace
}  // namespace virtdrive

BENCHMARK_MAIN();
