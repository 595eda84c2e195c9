// A motor's file: YAML, one flat mapping, units in the keys.
//
//   virtdrive_motor: 1
//   name: db42s03
//   kind: pmsm
//   pole_pairs: 4
//   phase_resistance_ohm: 0.75
//   ...
//
// The keys are declared once, in kMotorKeys (motor_file.cc); reading, range checks, JSON schema and
// the table in docs/motors.md follow from it.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/yaml_reader.h"
#include "plant/motor_library.h"

namespace virtdrive {

inline constexpr int kMotorFormat = 1;

struct MotorKey {
  enum class Type { kText, kNumber, kInteger, kWord };

  std::string_view name;
  Type type = Type::kNumber;
  NumberRange range{};
  bool required = false;
  /// Keys of one group say the same thing in different ways: exactly one of them is needed.
  std::string_view group{};
  /// Another key that must stand beside this one.
  std::string_view with{};
  std::vector<std::string_view> words{};  // kWord
  std::string_view doc{};
};

std::span<const MotorKey> motor_keys();

/// SetupError "FILE:LINE:COLUMN: ..." for anything that is missing, unknown, given twice or ways,
/// out of range or contradicts itself.
Motor parse_motor(const YamlFile& file);

}  // namespace virtdrive
