// A 7-Series drive that hears anything, in its own protocol or as Modbus RTU: no crash, no hang,
// bounded memory, and when the line has been silent for a while it answers a good request.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/check.h"
#include "scenarios/bench.h"
#include "tests/devices/vectors.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

/// Longer than a frame that is cut short, a reset, and the longest wait time.
constexpr SimDuration kQuiet = 2200ms;

// Whatever bytes did to its number and its time to answer: a request without a number is for it,
// and an answer may be of a drive that is tripped.
bool answers(Bench& bench, Bytes& heard, const Bytes& request, std::span<const Bytes> wanted) {
  heard.clear();
  bench.line().host_send(request);
  const auto heard_it = [&] { return heard.size() >= wanted.front().size() + 5; };
  bench.run_until(bench.loop().now() + kQuiet, heard_it);
  return std::ranges::any_of(
      wanted, [&](const Bytes& bytes) { return !std::ranges::search(heard, bytes).empty(); });
}

void hear(std::string_view drive, std::span<const std::uint8_t> bytes, const Bytes& request,
          std::span<const Bytes> wanted) {
  Bench bench({.drives = {{.kind = std::string(drive)}},
               .lines = {{.timing = LineTiming::kIdeal}},
               .integrator = Integrator::kFast});
  Bytes heard;
  bench.line().on_host_byte([&](std::uint8_t byte, SimTime) { heard.push_back(byte); });
  const LineSettings before = bench.line().device(0).settings();
  // A first byte tells how the burst is cut into pieces, twenty milliseconds apart.
  const std::size_t piece = bytes.empty() ? 1 : 1 + bytes.front() % 64;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    bench.line().host_send(part);
    bench.run_for(20ms);
    bytes = bytes.subspan(part.size());
  }
  if (request.empty()) return;
  bench.run_for(kQuiet);
  if (bench.line().device(0).settings() != before) return;  // it was told so, and then reset
  VIRTDRIVE_CHECK(answers(bench, heard, request, wanted), "{}: {} bytes and no answer", drive,
                  heard.size());
}

Bytes text(std::string_view characters) {
  return {characters.begin(), characters.end()};
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::vector<std::uint8_t>> seeds;
  // How the burst is cut: in pieces of 64 to the one, of 63 to the other.
  for (const auto& [first, file] : {std::pair{std::uint8_t{63}, "vectors_asd7.csv"},
                                    std::pair{std::uint8_t{62}, "vectors_asd7_modbus.csv"}}) {
    for (const Vector& vector : read_vectors(file)) {
      if (!is_request(vector)) continue;
      seeds.push_back({first});
      seeds.back().insert(seeds.back().end(), vector.bytes.begin(), vector.bytes.end());
    }
  }
  return seeds;
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace virtdrive;
  if (size > 0 && data[0] % 2 != 0) {
    const Bytes wanted[] = {text("(R0999"), text("(r0999")};
    hear("asd7", {data, size}, text("(R0999)\r"), wanted);
  } else {
    // Its unit may have become any: that it goes on is all there is to see.
    hear("asd7-modbus", {data, size}, {}, {});
  }
  return 0;
}
