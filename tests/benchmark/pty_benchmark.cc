// Requests per second over a pseudo-terminal, against the least that any program could do.
//
// A host thread writes 11 bytes and waits for 5, with blocking calls on the slave. The other side
// is (a) a thread that does nothing but read() and write() on the master, (b) the product: Runner,
// PtyEndpoint, an ideal SerialLine and a device that answers at once. Both in this process, one
// after the other, several rounds.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <fmt/core.h>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "pty/tty_settings.h"

namespace virtdrive {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kRequest = 11;
constexpr std::size_t kReply = 5;
constexpr int kRounds = 5;
constexpr int kExchanges = 10'000;

struct Result {
  double rate = 0;  // exchanges per second
  double p50_us = 0;
  double p99_us = 0;
};

/// The host: the same for both, so that only the other side differs.
Result exchange(const std::string& path) {
  const FileDescriptor tty{::open(path.c_str(), O_RDWR | O_NOCTTY)};
  if (!tty || !set_raw(tty.get(), {115200, 1}, RawFor::kHost)) std::abort();
  const std::array<std::uint8_t, kRequest> request{0x11, 0x03, 0x13};
  std::array<std::uint8_t, kReply> reply{};
  std::vector<double> latency_us;
  latency_us.reserve(kExchanges);
  Clock::time_point begin;
  for (int i = -500; i < kExchanges; ++i) {
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
  return {kExchanges / total.count(), latency_us[kExchanges / 2],
          latency_us[kExchanges * 99 / 100]};
}

Result bare_echo() {
  FileDescriptor master{posix_openpt(O_RDWR | O_NOCTTY)};
  if (!master || unlockpt(master.get()) != 0) std::abort();
  const std::string path = ptsname(master.get());
  const FileDescriptor keeper{::open(path.c_str(), O_RDWR | O_NOCTTY)};
  if (!set_raw(keeper.get(), {115200, 1}, RawFor::kHost)) std::abort();
  std::thread echo([&] {
    std::array<std::uint8_t, 256> bytes{};
    std::size_t got = 0;
    for (int i = -500; i < kExchanges; ++i) {
      for (; got < kRequest;) {
        const ssize_t size = ::read(master.get(), bytes.data(), bytes.size());
        if (size <= 0) std::abort();
        got += static_cast<std::size_t>(size);
      }
      got -= kRequest;
      if (::write(master.get(), bytes.data(), kReply) != kReply) std::abort();
    }
  });
  const Result result = exchange(path);
  echo.join();
  return result;
}

class AnswerAtOnce final : public SerialReceiver {
 public:
  explicit AnswerAtOnce(SerialPort& port) : port_(port) {}
  void receive(std::uint8_t byte) override {
    request_[count_++] = byte;
    if (count_ < kRequest) return;
    count_ = 0;
    port_.send(std::span(request_).first(kReply));
  }

 private:
  SerialPort& port_;
  std::array<std::uint8_t, kRequest> request_{};
  std::size_t count_ = 0;
};

Result product() {
  EventLoop loop;
  SerialLine line{loop, {.timing = LineTiming::kIdeal}};
  AnswerAtOnce device{line.device_port()};
  line.attach(device);
  PtyEndpoint endpoint{line};
  Runner runner{loop, {}};
  runner.add(endpoint);
  Result result;
  std::thread host([&] {
    result = exchange(endpoint.path());
    runner.request_stop();
  });
  runner.run();
  host.join();
  return result;
}

void print(const char* name, const Result& result) {
  fmt::print("{:<10} {:>8.0f} /s   p50 {:>6.1f} us   p99 {:>6.1f} us\n", name, result.rate,
             result.p50_us, result.p99_us);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

int benchmark() {
  std::vector<double> ratios;
  std::vector<double> p99_us;
  std::vector<double> bare_p99_us;
  for (int round = 0; round < kRounds; ++round) {
    const Result bare = bare_echo();
    const Result ours = product();
    print("bare echo", bare);
    print("virtdrive", ours);
    ratios.push_back(ours.rate / bare.rate);
    p99_us.push_back(ours.p99_us);
    bare_p99_us.push_back(bare.p99_us);
  }
  constexpr double kTarget = 0.4;
  fmt::print(
      "medians of {} rounds: {:.2f} of the bare echo's rate (target >= {}), p99 {:.0f} us "
      "(target < 200 on an idle machine; the bare echo has {:.0f})\n",
      kRounds, median(ratios), kTarget, median(p99_us), median(bare_p99_us));
  return median(ratios) >= kTarget ? 0 : 1;
}

}  // namespace
}  // namespace virtdrive

int main() {
  return virtdrive::benchmark();
}
