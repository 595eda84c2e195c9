#include "scenarios/scenario/condition.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/scenario/quantity.h"

namespace virtdrive {
namespace {

using Op = Predicate::Op;

constexpr bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n';
}

// A text and how far it has been read.
class Cursor {
 public:
  explicit Cursor(std::string_view text, std::size_t offset = 0) : text_(text), offset_(offset) {}

  void skip_spaces() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  bool done() {
    skip_spaces();
    return at_ == text_.size();
  }
  bool take(std::string_view token) {
    skip_spaces();
    if (!text_.substr(at_).starts_with(token)) return false;
    at_ += token.size();
    return true;
  }
  // A word: letters and what follows them up to a space; not taken if it is not this one.
  bool take_word(std::string_view word) {
    skip_spaces();
    if (peek() != word) return false;
    at_ += word.size();
    return true;
  }
  std::string_view peek() {
    skip_spaces();
    std::size_t end = at_;
    while (end < text_.size() && !is_space(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }
  // Up to one of the delimiters or a space.
  std::string_view take_until(std::string_view delimiters) {
    skip_spaces();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) &&
           delimiters.find(text_[at_]) == std::string_view::npos) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }
  // The rest, up to a mark that stands anywhere in it; the mark is taken too.
  std::string_view take_up_to(std::string_view mark, bool& found) {
    const std::size_t end = text_.find(mark, at_);
    found = end != std::string_view::npos;
    const std::string_view part = text_.substr(at_, found ? end - at_ : std::string_view::npos);
    at_ = found ? end + mark.size() : text_.size();
    return part;
  }
  std::string_view rest() const { return text_.substr(at_); }
  std::size_t place() const { return offset_ + at_; }
  [[noreturn]] void fail(const std::string& message) { fail_at(message, place()); }
  [[noreturn]] static void fail_at(const std::string& message, std::size_t at) {
    throw LanguageError(message, at);
  }

 private:
  std::string_view text_;
  std::size_t offset_;
  std::size_t at_ = 0;
};

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

double number_in(std::string_view text, std::string_view unit, std::size_t at) {
  text = trim(text);
  const auto quantity = parse_quantity(text);
  if (!quantity) {
    Cursor::fail_at(text.empty() ? fmt::format("expected a number{}",
                                               unit.empty() ? "" : fmt::format(" in {}", unit))
                                 : fmt::format("'{}' is not a number with a unit", text),
                    at);
  }
  if (quantity->value == 0 && quantity->unit.empty()) return 0;
  if (const auto value = convert(quantity->value, quantity->unit, unit)) return *value;
  if (unit.empty()) {
    Cursor::fail_at(
        fmt::format("'{}': the value has no unit; leave '{}' out", text, quantity->unit), at);
  }
  Cursor::fail_at(quantity->unit.empty()
                      ? fmt::format("'{}' needs a unit: {}", text, units_like(unit))
                      : fmt::format("'{}': the unit must be {}", text, units_like(unit)),
                  at);
}

Op take_operator(Cursor& cursor, const ValueKind& kind) {
  const auto has_words = [&] {
    if (kind.words == nullptr) cursor.fail("this value has no names; compare it with a number");
  };
  if (cursor.take("<=")) return Op::kAtMost;
  if (cursor.take(">=")) return Op::kAtLeast;
  if (cursor.take("!=")) return Op::kNotNear;
  if (cursor.take("==")) return Op::kNear;
  if (cursor.take("<")) return Op::kLess;
  if (cursor.take(">")) return Op::kMore;
  if (cursor.take("=")) return Op::kNear;
  if (cursor.take_word("above")) return Op::kMore;
  if (cursor.take_word("below")) return Op::kLess;
  if (cursor.take_word("in")) return Op::kIn;
  if (cursor.take_word("is")) return cursor.take_word("not") ? Op::kNotNear : Op::kNear;
  if (cursor.take_word("has")) {
    has_words();
    if (!kind.bits) cursor.fail("'has' is for values made of bits; use 'is'");
    return cursor.take_word("not") ? Op::kHasNot : Op::kHas;
  }
  return Op::kNear;  // a value alone
}

// A name of the value's, as its number; nothing if `text` is a number.
std::optional<double> word_in(std::string_view text, const ValueKind& kind, std::size_t at) {
  text = trim(text);
  if (text.empty() || kind.words == nullptr || parse_quantity(text)) return std::nullopt;
  const auto it = std::ranges::find(*kind.words, text);
  if (it == kind.words->end()) {
    Cursor::fail_at(unknown_name("value", text, *kind.words), at);
  }
  return static_cast<double>(it - kind.words->begin());
}

Predicate take_predicate(Cursor cursor, const ValueKind& kind) {
  Predicate predicate;
  predicate.text = trim(cursor.rest());
  predicate.op = take_operator(cursor, kind);
  cursor.skip_spaces();
  const std::size_t at = cursor.place();
  bool found = false;
  if (predicate.op == Op::kHas || predicate.op == Op::kHasNot) {
    const auto bit = word_in(cursor.rest(), kind, at);
    if (!bit) cursor.fail("expected a name behind 'has'");
    predicate.value = *bit;
    return predicate;
  }
  if (predicate.op == Op::kIn) {
    predicate.value = number_in(cursor.take_up_to("...", found), kind.unit, at);
    if (!found) cursor.fail("expected a range: 23 V ... 25 V");
    cursor.skip_spaces();
    predicate.high = number_in(cursor.rest(), kind.unit, cursor.place());
    if (predicate.high < predicate.value) {
      Cursor::fail_at("the range ends before it begins", at);
    }
    return predicate;
  }
  const std::string_view centre = trim(cursor.take_up_to("+-", found));
  if (const auto word = word_in(centre, kind, at)) {
    predicate.value = kind.bits ? std::exp2(*word) : *word;
    if (found) cursor.fail("a name has no tolerance");
    return predicate;
  }
  predicate.value = number_in(centre, kind.unit, at);
  if (!found) return predicate;
  if (predicate.op != Op::kNear && predicate.op != Op::kNotNear) {
    cursor.fail("'+-' goes with = and != only");
  }
  cursor.skip_spaces();
  const auto share = parse_quantity(cursor.rest());
  predicate.tolerance = share && share->unit == "%"
                            ? std::abs(predicate.value) * share->value / 100
                            : number_in(cursor.rest(), kind.unit, cursor.place());
  if (predicate.tolerance < 0) cursor.fail("a tolerance is not negative");
  return predicate;
}

Comparison take_comparison(std::string_view text, std::size_t offset, const Registry& registry) {
  Cursor cursor(text, offset);
  Comparison comparison;
  comparison.magnitude = cursor.take("abs(");
  cursor.skip_spaces();
  const std::size_t at = cursor.place();
  comparison.signal = cursor.take_until("<>=!)");
  if (comparison.signal.empty()) cursor.fail("expected a condition: SIGNAL > VALUE");
  if (comparison.magnitude && !cursor.take(")")) cursor.fail("expected a ) behind the name");
  const Signal* signal = nullptr;
  try {
    signal = &registry.signal(comparison.signal);
  } catch (const SetupError& error) {
    Cursor::fail_at(error.what(), at);
  }
  if (cursor.done()) {
    cursor.fail(fmt::format("expected a comparison behind {}: {} > VALUE", comparison.signal,
                            comparison.signal));
  }
  const std::size_t rest_at = cursor.place();
  comparison.predicate = take_predicate(Cursor(cursor.rest(), rest_at), ValueKind::of(*signal));
  return comparison;
}

// Calls take(part, offset) for the parts between a word.
template <class Take>
void split(std::string_view text, std::size_t offset, std::string_view word, Take&& take) {
  const std::string separator = fmt::format(" {} ", word);
  while (true) {
    const std::size_t at = text.find(separator);
    take(text.substr(0, at), offset);
    if (at == std::string_view::npos) return;
    text.remove_prefix(at + separator.size());
    offset += at + separator.size();
  }
}

}  // namespace

bool Predicate::holds(double actual) const {
  const auto bit = [&] {
    return (static_cast<std::uint64_t>(actual) >> static_cast<unsigned>(value) & 1) != 0;
  };
  switch (op) {
    case Op::kLess:
      return actual < value;
    case Op::kAtMost:
      return actual <= value;
    case Op::kMore:
      return actual > value;
    case Op::kAtLeast:
      return actual >= value;
    case Op::kNear:
      return std::abs(actual - value) <= tolerance;
    case Op::kNotNear:
      return !(std::abs(actual - value) <= tolerance);
    case Op::kIn:
      return actual >= value && actual <= high;
    case Op::kHas:
      return bit();
    case Op::kHasNot:
      return !bit();
  }
  VIRTDRIVE_CHECK(false, "{}", static_cast<int>(op));
  return false;
}

std::string Predicate::shortfall(double actual, std::string_view unit) const {
  double low = -std::numeric_limits<double>::infinity();
  double up = std::numeric_limits<double>::infinity();
  switch (op) {
    case Op::kLess:
    case Op::kAtMost:
      up = value;
      break;
    case Op::kMore:
    case Op::kAtLeast:
      low = value;
      break;
    case Op::kNear:
      low = value - tolerance;
      up = value + tolerance;
      break;
    case Op::kIn:
      low = value;
      up = high;
      break;
    default:
      return {};
  }
  if (actual < low) return show_quantity(low - actual, unit) + " too low";
  if (actual > up) return show_quantity(actual - up, unit) + " too high";
  return {};
}

Predicate parse_predicate(std::string_view text, const ValueKind& kind) {
  return take_predicate(Cursor(text), kind);
}

std::string show_value(double value, std::string_view unit,
                       const std::vector<std::string_view>& words, bool bits) {
  if (words.empty()) return show_quantity(value, unit);
  const auto number = static_cast<std::uint64_t>(std::max(0.0, value));
  if (!bits) {
    return number < words.size() ? fmt::format("{} ({})", words[number], number)
                                 : fmt::format("{}", number);
  }
  std::string names;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if ((number >> i & 1) != 0) names += fmt::format("{}{}", names.empty() ? "" : "+", words[i]);
  }
  return names.empty() ? "none (0)" : fmt::format("{} ({})", names, number);
}

std::string show_value(const Signal& signal, double value) {
  return show_value(value, signal.unit, signal.words, signal.bits);
}

std::vector<std::string> Condition::signals() const {
  std::vector<std::string> names;
  for (const auto& all : any_of) {
    for (const Comparison& comparison : all) names.push_back(comparison.signal);
  }
  return names;
}

Condition parse_condition(std::string_view text, const Registry& registry) {
  Condition condition{.text = std::string(trim(text)), .any_of = {}};
  split(text, 0, "or", [&](std::string_view all, std::size_t offset) {
    auto& comparisons = condition.any_of.emplace_back();
    split(all, offset, "and", [&](std::string_view one, std::size_t at) {
      comparisons.push_back(take_comparison(one, at, registry));
    });
  });
  return condition;
}

LiveCondition::LiveCondition(const Condition& condition, const Registry& registry)
    : text_(condition.text) {
  for (const auto& all : condition.any_of) {
    auto& parts = any_of_.emplace_back();
    for (const Comparison& comparison : all) {
      parts.push_back(
          {&registry.signal(comparison.signal), comparison.magnitude, comparison.predicate});
    }
  }
}

double LiveCondition::Part::value() const {
  const double value = signal->read();
  return magnitude ? std::abs(value) : value;
}

bool LiveCondition::met() const {
  return std::ranges::any_of(any_of_, [](const auto& all) {
    return std::ranges::all_of(all,
                               [](const Part& part) { return part.predicate.holds(part.value()); });
  });
}

std::string LiveCondition::values() const {
  std::string text;
  std::vector<const Signal*> told;
  for (const auto& all : any_of_) {
    for (const Part& part : all) {
      if (std::ranges::find(told, part.signal) != told.end()) continue;
      told.push_back(part.signal);
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", part.signal->name,
                          show_value(*part.signal, part.signal->read()));
    }
  }
  return text;
}

std::string LiveCondition::shortfall() const {
  for (const auto& all : any_of_) {
    for (const Part& part : all) {
      const double value = part.value();
      if (part.predicate.holds(value)) continue;
      return part.signal->words.empty() ? part.predicate.shortfall(value, part.signal->unit) : "";
    }
  }
  return {};
}

}  // namespace virtdrive
