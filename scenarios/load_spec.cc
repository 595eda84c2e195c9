#include "scenarios/load_spec.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

struct Kind {
  std::string_view name;
  double Load::* quantity;
  bool may_be_negative;
  std::array<Unit, 2> units;
};

constexpr Unit kNone{};
constexpr Kind kKinds[] = {
    {"brake", &Load::brake_torque_nm, false, {{{"Nm", 1}, {"mNm", 1e-3}}}},
    {"constant", &Load::external_torque_nm, true, {{{"Nm", 1}, {"mNm", 1e-3}}}},
    {"quadratic", &Load::quadratic_nm_per_radps2, false, {{{"Nm/(rad/s)^2", 1}, kNone}}},
    {"viscous", &Load::viscous_nm_per_radps, false, {{{"Nm/(rad/s)", 1}, kNone}}},
    {"inertia", &Load::inertia_kgm2, false, {{{"kgm2", 1}, {"gcm2", 1e-7}}}},
};
constexpr std::array<Unit, 2> kTimeUnits = {{{"s", 1}, {"ms", 1e-3}}};

[[noreturn]] void fail(std::string_view part, std::string_view why) {
  throw SetupError(fmt::format("--load {}: {}", part, why));
}

const Kind& find_kind(std::string_view part, std::string_view name) {
  const auto it = std::ranges::find(kKinds, name, &Kind::name);
  if (it != std::end(kKinds)) return *it;
  std::vector<std::string_view> names = {"none"};
  for (const Kind& kind : kKinds) names.push_back(kind.name);
  fail(part, unknown_name("kind of load", name, names));
}

double parse_quantity(std::string_view part, std::string_view text,
                      const std::array<Unit, 2>& units) {
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc{} || !std::isfinite(value)) {
    fail(part, fmt::format("'{}' is not a number", text));
  }
  const std::string_view unit(end, last);
  if (unit.empty()) return value;
  std::string known;
  for (const Unit& candidate : units) {
    if (candidate.name.empty()) continue;
    if (candidate.name == unit) return value * candidate.factor;
    known += fmt::format("{}{}", known.empty() ? "" : " or ", candidate.name);
  }
  fail(part, fmt::format("unknown unit '{}', expected {}", unit, known));
}

std::size_t parse_channel(std::string_view part, std::string_view text, std::size_t channels) {
  std::size_t channel = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, channel);
  if (error == std::errc{} && end == last && channel < channels) return channel;
  fail(part, fmt::format("channel '{}' is not 0 ... {}", text, channels - 1));
}

LoadStep parse_step(std::string_view part, std::size_t channels) {
  if (part.empty()) throw SetupError("--load: nothing before or behind a comma");
  const std::size_t colon = part.find(':');
  if (colon == std::string_view::npos) fail(part, "expected [CHANNEL.]KIND:VALUE[UNIT][@TIME]");
  LoadStep step;
  std::string_view name = part.substr(0, colon);
  if (const std::size_t dot = name.find('.'); dot != std::string_view::npos) {
    step.channel = parse_channel(part, name.substr(0, dot), channels);
    name.remove_prefix(dot + 1);
  }
  const Kind& kind = find_kind(part, name);
  step.quantity = kind.quantity;
  std::string_view value = part.substr(colon + 1);
  if (const std::size_t at = value.find('@'); at != std::string_view::npos) {
    const double s = parse_quantity(part, value.substr(at + 1), kTimeUnits);
    if (s < 0 || s > 1e9) fail(part, "the time must be 0 ... 1e9 s");
    step.at = kSimStart + from_seconds(s);
    value = value.substr(0, at);
  }
  step.value = parse_quantity(part, value, kind.units);
  if (step.value < 0 && !kind.may_be_negative) fail(part, "must not be negative");
  return step;
}

}  // namespace

const std::string kLoadHelp =
    "none, or [CHANNEL.]KIND:VALUE[UNIT][@TIME],...: brake (Nm, mNm; against the motion), constant "
    "(Nm, mNm; "
    "against positive rotation), quadratic (Nm/(rad/s)^2), viscous (Nm/(rad/s)), inertia (kgm2, "
    "gcm2); with @TIME (s, ms) it steps there";

std::vector<LoadStep> parse_load(std::string_view text, std::size_t channels) {
  std::vector<LoadStep> steps;
  if (text.empty() || text == "none") return steps;
  while (true) {
    const std::size_t comma = text.find(',');
    steps.push_back(parse_step(text.substr(0, comma), channels));
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  std::ranges::stable_sort(steps, {}, &LoadStep::at);
  return steps;
}

}  // namespace virtdrive
