// A motor's file: YAML, one flat mapping, units in the keys.
//
//   virtdrive_motor: 1
//   name: db42s03
//   kind: pmsm
//   pole_pairs: 4
//   phase_resistance_ohm: 0.75
//   ...
//
// The keys are declared once, in motor_keys.cc; reading, range checks, JSON schema and the table in
// docs/motors.md follow from it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/yaml_reader.h"
#include "plant/motor_library.h"

namespace virtdrive {

inline constexpr int kMotorFormat = 1;

/// A bit for each MachineKind.
using MachineKinds = std::uint8_t;
constexpr MachineKinds only(MachineKind kind) {
  return static_cast<MachineKinds>(1U << static_cast<unsigned>(kind));
}
inline constexpr MachineKinds kWithMagnets = only(MachineKind::kPmsm) | only(MachineKind::kBldc);
inline constexpr MachineKinds kThreePhase = kWithMagnets | only(MachineKind::kInduction);
inline constexpr MachineKinds kRotating = kThreePhase | only(MachineKind::kBrushedDc);
inline constexpr MachineKinds kAllKinds = kRotating | only(MachineKind::kVoiceCoil);

struct MotorKey {
  enum class Type {
    kText,
    kNumber,
    kInteger,
    kWord,
    kNumbers,  // a list
    kTable,    // a list of lists of equal size
    kMap,      // of `keys`
  };

  std::string_view name;
  Type type = Type::kNumber;
  NumberRange range{};  // of each number
  MachineKinds kinds = kAllKinds;
  bool required = false;  // of those kinds
  /// Keys of one group say the same thing in different ways: exactly one of them is needed.
  std::string_view group{};
  /// At most one of these is given; none is needed.
  std::string_view excludes{};
  /// Another key that must stand beside this one.
  std::string_view with{};
  std::vector<std::string_view> words{};  // kWord
  std::size_t least = 0, most = 0;        // values of a list
  std::vector<MotorKey> keys{};           // kMap
  std::string_view doc{};
};

/// In the order of the documents.
const std::vector<MotorKey>& motor_keys();

/// SetupError "FILE:LINE:COLUMN: ..." for anything that is missing, unknown, given twice or ways,
/// out of range, of another kind of machine, or contradicts itself.
Motor parse_motor(const YamlFile& file);

}  // namespace virtdrive
