// A board that hears anything on its three consoles: no crash, no hang, bounded memory, and after
// any burst it answers a good packet and a good line as it should.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/check.h"
#include "scenarios/bench.h"
#include "tests/devices/vectors.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t kProtocolRequest[] = {0xAA, 0x7F, 0x00, 0x00, 0x7F};
const std::vector<std::uint8_t> kProtocolReply = {0x00, 0x03, 0x20, 0x00, 0x04, 0x27};
const std::string kAnyAddress = "ADDR 127\r";

class Listener {
 public:
  explicit Listener(Bench& bench) : bench_(bench) {
    bench.line().on_host_byte([this](std::uint8_t byte, SimTime) { heard_.push_back(byte); });
  }
  std::vector<std::uint8_t> ask(std::span<const std::uint8_t> bytes, SimDuration time = 5ms) {
    heard_.clear();
    bench_.line().host_send(bytes);
    bench_.loop().run_until(bench_.loop().now() + time);
    return heard_;
  }

 private:
  Bench& bench_;
  std::vector<std::uint8_t> heard_;
};

// A packet has at most 260 bytes; the CR ends the line that further noughts are. A request is
// handled before the next byte comes. RESET takes 100 ms, an absolute encoder 150 more.
void end_anything(Listener& host) {
  host.ask({}, 300ms);
  for (int i = 0; i < 260; ++i) {
    constexpr std::uint8_t kNought[] = {0};
    host.ask(kNought, 200us);
  }
  constexpr std::uint8_t kEnd[] = {'\r'};
  host.ask(kEnd);
  host.ask({}, 300ms);
}

void hear(std::span<const std::uint8_t> bytes) {
  Bench bench({.drives = {{.kind = "rzt1"}},
               .lines = {{.timing = LineTiming::kIdeal}},
               .integrator = Integrator::kFast});
  Listener host(bench);
  // A first byte tells how the burst is cut into pieces, 200 us apart.
  const std::size_t piece = bytes.empty() ? 1 : 1 + bytes.front() % 64;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    host.ask(part, 200us);
    bytes = bytes.subspan(part.size());
  }
  end_anything(host);
  const std::string line = "1" + kAnyAddress;
  const std::vector<std::uint8_t> typed(line.begin(), line.end());
  const auto prompt = host.ask(typed);
  VIRTDRIVE_CHECK((prompt == std::vector<std::uint8_t>{'\r', '\n', '>'}), "{} bytes as prompt",
                  prompt.size());
  const auto reply = host.ask(kProtocolRequest);
  VIRTDRIVE_CHECK(reply == kProtocolReply, "{} bytes as module data", reply.size());
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::vector<std::uint8_t>> seeds;
  for (const Vector& vector : read_vectors("vectors_rzt1.csv")) {
    if (vector.direction != "request") continue;
    seeds.push_back({63});  // how the burst is cut: in pieces of 64
    seeds.back().insert(seeds.back().end(), vector.bytes.begin(), vector.bytes.end());
  }
  return seeds;
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  virtdrive::hear({data, size});
  return 0;
}
