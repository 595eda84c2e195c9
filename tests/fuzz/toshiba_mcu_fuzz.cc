// A drive that hears anything: no crash, no hang, bounded memory, and after any burst it answers a
// good request as the drive would.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/check.h"
#include "scenarios/bench.h"
#include "tests/devices/vectors.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t kVersionRequest[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
const std::vector<std::uint8_t> kVersionReply = {0x11, 0x14, 0x03, 0x0a, 0x0a, 0x13};

// The longest request has 54 bytes: after so many noughts any telegram that was under way is over.
void end_any_telegram(Bench& bench) {
  for (int i = 0; i < 54; ++i) {
    constexpr std::uint8_t kNought[] = {0};
    bench.line().host_send(kNought);
    bench.loop().run_until(bench.loop().now() + 5ms);
  }
}

void hear(std::span<const std::uint8_t> bytes) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}},
               .lines = {{.timing = LineTiming::kIdeal}},
               .integrator = Integrator::kFast});
  std::vector<std::uint8_t> heard;
  bench.line().on_host_byte([&](std::uint8_t byte, SimTime) { heard.push_back(byte); });
  // A first byte tells how the burst is cut into pieces, a millisecond apart.
  const std::size_t piece = bytes.empty() ? 1 : 1 + bytes.front() % 64;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    bench.line().host_send(part);
    bench.loop().run_until(bench.loop().now() + 1ms);
    bytes = bytes.subspan(part.size());
  }
  end_any_telegram(bench);
  heard.clear();
  bench.line().host_send(kVersionRequest);
  bench.loop().run_until(bench.loop().now() + 5ms);
  VIRTDRIVE_CHECK(heard == kVersionReply, "{} bytes instead of the version", heard.size());
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::vector<std::uint8_t>> seeds;
  for (const Vector& vector : read_vectors("vectors_toshiba_mcu.csv")) {
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
