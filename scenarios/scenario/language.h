// The words of a scenario file: one table, from which come the loader's look-up, the JSON schema
// and the check that docs/scenarios.md tells of all of them.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace virtdrive::language {

/// What an editor may expect behind a key.
enum class Shape {
  kNothing,     // the verb alone
  kText,        // a name, a sentence, bytes
  kQuantity,    // a number with a unit
  kTime,        // "1.5 s"
  kCondition,   // "motor1.speed > 1900 rpm"
  kCount,       // a whole number from 1
  kFlag,        // true, false
  kOnOff,       // on, off
  kList,        // of texts
  kParameters,  // a drive's parameters with their values
  kNames,       // names with their values
  kReply,       // done, none, error, a name of an error, or fields
  kSteps,       // steps
  kPoints,      // [[time, value], ...]
  kMilestone,   // {request: NAME, number: 3}
  kLoad,        // as --load, or kinds with their values
  kAny,         // several of these
};

struct Key {
  std::string_view name;
  Shape shape;
  std::string_view doc;  // one line
};

struct Verb {
  std::string_view name;
  Shape shape;
  std::string_view doc;
  std::vector<Key> keys;  // that may stand beside it
  bool may_be_triggered;  // `when`, `at`, `after`
  bool may_be_alone;      // needs nothing behind it
};

inline constexpr std::string_view kVersionKey = "virtdrive-scenario";
inline constexpr int kVersion = 1;

const std::vector<Verb>& verbs();
/// Beside every step.
const std::vector<Key>& step_keys();
/// Beside those that may be triggered.
const std::vector<Key>& trigger_keys();
const std::vector<Key>& file_keys();
const std::vector<Key>& bench_keys();
const std::vector<Key>& drive_keys();
const std::vector<Key>& line_keys();
const std::vector<Key>& record_keys();
const std::vector<Key>& milestone_keys();

std::vector<std::string_view> names(const std::vector<Key>& keys);

}  // namespace virtdrive::language
