// A scenario file may hold anything: it is read, or refused with one line that names the place.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "core/check.h"
#include "scenarios/scenario/loader.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

// A file is tried as it is, and as the steps of a good one, where chance finds more.
constexpr std::string_view kHead = "virtdrive-scenario: 1\nbench: {drive: toshiba-mcu}\nsteps:\n";

void load(std::string_view text) {
  try {
    parse_scenario("fuzz", text);
  } catch (const SetupError& error) {
    const std::string_view message = error.what();
    VIRTDRIVE_CHECK(message.starts_with("fuzz:"), "{}", message);
    VIRTDRIVE_CHECK(message.size() < 5000, "{} bytes", message.size());
  }
}

}  // namespace

// The corpus of bad files: each is a step away from a good one.
std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::filesystem::path> files;
  const std::string folder = VIRTDRIVE_TEST_DATA "/scenarios_bad";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  std::vector<std::vector<std::uint8_t>> seeds;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return seeds;
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  virtdrive::load(text);
  virtdrive::load(std::string(virtdrive::kHead) + text);
  return 0;
}
