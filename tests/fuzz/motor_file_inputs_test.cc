// The fuzz target's function on the motor library, mutated: a taste of the fuzzer in every build.
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/random.h"
#include "plant/motor_data.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace virtdrive {
namespace {

std::string hostile(RandomStream& random) {
  const auto files = motor_data();
  std::string text(files[random.bits() % files.size()].text);
  constexpr std::string_view kPieces[] = {"[",  "{",     "&a ", "*a",    "!!x ", "\n",
                                          "\t", ": ",    "- ",  "'",     "\"",   "#",
                                          "-",  "1e999", "010", "---\n", "? "};
  for (std::size_t edits = 1 + random.bits() % 6; edits > 0; --edits) {
    const std::size_t at = random.bits() % (text.size() + 1);
    switch (random.bits() % 4) {
      case 0:
        text.insert(at, kPieces[random.bits() % std::size(kPieces)]);
        break;
      case 1:
        text.erase(at, random.bits() % 20);
        break;
      case 2:
        if (at < text.size()) text[at] = static_cast<char>(random.bits());
        break;
      default:
        text.insert(at, text.substr(random.bits() % text.size(), random.bits() % 60));
    }
  }
  return text;
}

TEST(FuzzTarget, SurvivesTheMotorLibraryMutated) {
  RandomStream random = Seed{1}.stream("fuzz");
  for (int i = 0; i < 1000; ++i) {
    const std::string text = hostile(random);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  }
}

}  // namespace
}  // namespace virtdrive
