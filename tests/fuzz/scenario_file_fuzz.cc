// A scenario file may hold anything: it is read, or refused with one line that names the place.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "scenarios/scenario/loader.h"

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
}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  virtdrive::load(text);
  virtdrive::load(std::string(virtdrive::kHead) + text);
  return 0;
}
