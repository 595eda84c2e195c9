// What a scenario says of values:
//
//   motor1.speed > 1900 rpm
//   motor1.speed = 2000 rpm +- 1 %        of the number that it belongs to
//   bus1.voltage in 23 V ... 25 V
//   drive1.stage is FOC and drive1.errors has not StallDetected
//   abs(motor1.speed) < 10 rpm or drive1.stage is Stop
//   bus1.voltage above 23 V               as >; a YAML text cannot begin with that sign
//
// `and` binds stronger than `or`. Names and units are checked when the text is read, against a
// registry; what comes of it knows numbers only, in the signals' own units.
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/signals.h"

namespace virtdrive {

/// Something wrong in a text of the language, at a byte of it.
class LanguageError : public std::runtime_error {
 public:
  LanguageError(const std::string& message, std::size_t at)
      : std::runtime_error(message), at_(at) {}
  std::size_t at() const { return at_; }

 private:
  std::size_t at_;
};

/// What a value is measured in, and the names that it may have.
struct ValueKind {
  std::string_view unit;
  const std::vector<std::string_view>* words = nullptr;
  bool bits = false;

  static ValueKind of(const Signal& signal) {
    return {signal.unit, signal.words.empty() ? nullptr : &signal.words, signal.bits};
  }
};

/// "> 1900 rpm", "= 5 V +- 1 V", "is FOC": what a value has to be.
struct Predicate {
  enum class Op { kLess, kAtMost, kMore, kAtLeast, kNear, kNotNear, kIn, kHas, kHasNot };

  Op op = Op::kNear;
  double value = 0;      // kIn: the lower end; kHas: the bit
  double tolerance = 0;  // kNear, kNotNear
  double high = 0;       // kIn
  std::string text;      // as written

  bool holds(double actual) const;
  /// How far a value is from holding, in its unit: "106.8 rpm too low". Empty where no number says.
  std::string shortfall(double actual, std::string_view unit) const;
};

/// LanguageError for what is no predicate of such a value. A number alone means "=".
Predicate parse_predicate(std::string_view text, const ValueKind& kind);

/// A value as a reader wants it: "FOC (6)", "SwOverVoltage (32)", "1873.2 rpm".
std::string show_value(double value, std::string_view unit,
                       const std::vector<std::string_view>& words, bool bits);
std::string show_value(const Signal& signal, double value);

struct Comparison {
  std::string signal;
  bool magnitude = false;  // abs(signal)
  Predicate predicate;
};

/// Comparisons joined by `and`, those joined by `or`.
struct Condition {
  std::string text;
  std::vector<std::vector<Comparison>> any_of;

  std::vector<std::string> signals() const;
};

/// LanguageError for an unknown name or unit and for what is no condition.
Condition parse_condition(std::string_view text, const Registry& registry);

/// A condition on the signals of a bench.
class LiveCondition {
 public:
  LiveCondition(const Condition& condition, const Registry& registry);

  bool met() const;
  const std::string& text() const { return text_; }
  /// The values that it judges: "motor1.speed 1873.2 rpm, drive1.stage FOC (6)".
  std::string values() const;
  /// How far the first comparison that does not hold is from it; empty where no number says.
  std::string shortfall() const;

 private:
  struct Part {
    const Signal* signal;
    bool magnitude;
    Predicate predicate;

    double value() const;
  };

  std::string text_;
  std::vector<std::vector<Part>> any_of_;
};

}  // namespace virtdrive
