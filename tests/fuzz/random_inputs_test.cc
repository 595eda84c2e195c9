// The fuzz targets' function on golden frames, cut and flipped: a taste of the fuzzer in every
// build.
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/devices/vectors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace virtdrive {
namespace {

std::vector<std::uint8_t> hostile(RandomStream& random, const std::vector<Vector>& vectors) {
  std::vector<std::uint8_t> bytes;
  const std::size_t frames = 1 + random.bits() % 8;
  for (std::size_t i = 0; i < frames; ++i) {
    std::vector<std::uint8_t> frame = vectors[random.bits() % vectors.size()].bytes;
    if (random.bits() % 3 == 0) frame.resize(random.bits() % (frame.size() + 1));
    if (random.bits() % 3 == 0 && !frame.empty()) {
      frame[random.bits() % frame.size()] ^= static_cast<std::uint8_t>(random.bits());
    }
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  return bytes;
}

TEST(FuzzTarget, SurvivesGoldenFramesCutAndFlipped) {
  std::vector<Vector> vectors;
  for (const char* file :
       {"vectors_toshiba_mcu.csv", "vectors_rzt1.csv", "vectors_md485.csv", "vectors_asd7.csv"}) {
    const auto more = read_vectors(file);
    ASSERT_FALSE(more.empty()) << file;
    vectors.insert(vectors.end(), more.begin(), more.end());
  }
  RandomStream random = Seed{1}.stream("fuzz");
  for (int i = 0; i < 200; ++i) {
    const auto bytes = hostile(random, vectors);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
}

}  // namespace
}  // namespace virtdrive
