#include "plant/motor_library.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "core/names.h"
#include "plant/motor_data.h"
#include "plant/motor_file.h"

namespace virtdrive {
namespace {

constexpr std::string_view kExtension = ".yaml";

std::string_view motor_name(const EmbeddedFile& file) {
  return file.name.substr(0, file.name.size() - kExtension.size());
}

Motor built_in(const EmbeddedFile& file) {
  return parse_motor(YamlFile(std::string(file.name), file.text));
}

}  // namespace

std::vector<Motor> motor_library() {
  std::vector<Motor> motors;
  for (const EmbeddedFile& file : motor_data()) motors.push_back(built_in(file));
  return motors;
}

std::vector<std::string_view> motor_names() {
  std::vector<std::string_view> names;
  for (const EmbeddedFile& file : motor_data()) names.push_back(motor_name(file));
  return names;
}

bool is_motor_file(std::string_view text) {
  return text.find('/') != std::string_view::npos || text.ends_with(".yaml") ||
         text.ends_with(".yml");
}

Motor find_motor(std::string_view name_or_path) {
  if (is_motor_file(name_or_path)) return parse_motor(YamlFile::read(std::string(name_or_path)));
  const auto found = std::ranges::find(motor_data(), name_or_path, motor_name);
  if (found != motor_data().end()) return built_in(*found);
  throw SetupError(unknown_name("motor", name_or_path, motor_names()) +
                   " 'virtdrive list motors' shows them; a file of your own is named by its path, "
                   "e.g. ./my_motor.yaml");
}

std::string_view kind_name(MachineKind kind) {
  constexpr std::string_view kNames[] = {"pmsm", "bldc", "brushed_dc", "voice_coil", "induction"};
  return kNames[static_cast<std::size_t>(kind)];
}

double phase_peak_a(double current_a, CurrentRating counted_as) {
  switch (counted_as) {
    case CurrentRating::kPeak:
      return current_a;
    case CurrentRating::kRms:
      return current_a * std::numbers::sqrt2;
    case CurrentRating::kDc:
      return current_a * 2 * std::numbers::sqrt3 / std::numbers::pi;
  }
  VIRTDRIVE_CHECK(false, "{}", static_cast<int>(counted_as));
}

double rated_power_w(const MotorRating& rating) {
  if (rating.power_w > 0) return rating.power_w;
  return rating.torque_nm * rating.speed_rpm * std::numbers::pi / 30;
}

}  // namespace virtdrive
