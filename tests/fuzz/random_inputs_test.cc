// A fuzz target's function on its seeds, whole, cut, spliced and flipped: a taste of the fuzzer in
// every build.
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes hostile(RandomStream& random, const std::vector<Bytes>& seeds) {
  Bytes bytes;
  const std::size_t parts = 1 + random.bits() % 4;
  for (std::size_t i = 0; i < parts; ++i) {
    Bytes part = seeds[random.bits() % seeds.size()];
    if (random.bits() % 3 == 0) part.resize(random.bits() % (part.size() + 1));
    for (std::size_t flips = random.bits() % 4; flips > 0 && !part.empty(); --flips) {
      part[random.bits() % part.size()] ^= static_cast<std::uint8_t>(random.bits());
    }
    bytes.insert(bytes.end(), part.begin(), part.end());
    if (random.bits() % 2 == 0) break;
  }
  return bytes;
}

TEST(FuzzTarget, SurvivesItsSeedsWholeCutAndFlipped) {
  const std::vector<Bytes> seeds = fuzz_seeds();
  ASSERT_FALSE(seeds.empty());
  for (const Bytes& seed : seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());
  RandomStream random = Seed{1}.stream("fuzz");
  for (int i = 0; i < 300; ++i) {
    const Bytes bytes = hostile(random, seeds);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
}

}  // namespace
}  // namespace virtdrive
