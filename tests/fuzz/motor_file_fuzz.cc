// A motor's file with anything in it: it is read, or refused with a place; what was read is a
// motor.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "plant/motor_data.h"
#include "plant/motor_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

void read(std::string_view text) {
  try {
    const Motor motor = parse_motor(YamlFile("fuzz.yaml", text));
    validate(motor.electrical);
    validate(motor.mechanics);
    validate(motor.effects);
    const Winding winding(motor.electrical, motor.effects);
    VIRTDRIVE_CHECK(winding.least_inductance_h() > 0, "{}", winding.least_inductance_h());
  } catch (const SetupError& error) {
    const std::string_view message = error.what();
    VIRTDRIVE_CHECK(message.starts_with("fuzz.yaml:"), "{}", message);
    VIRTDRIVE_CHECK(message.find('\n') == std::string_view::npos, "{}", message);
  }
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::vector<std::uint8_t>> seeds;
  for (const auto& file : motor_data()) seeds.emplace_back(file.text.begin(), file.text.end());
  return seeds;
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  virtdrive::read({reinterpret_cast<const char*>(data), size});
  return 0;
}
