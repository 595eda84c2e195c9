#include "scenarios/scenario/quantity.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace virtdrive {
namespace {

struct Unit {
  std::string_view name;
  std::string_view dimension;
  double factor;  // to the first of its dimension
};

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kDegPerRad = 180 / std::numbers::pi;

constexpr Unit kUnits[] = {
    {"s", "time", 1},
    {"ms", "time", 1e-3},
    {"us", "time", 1e-6},
    {"min", "time", 60},
    {"h", "time", 3600},
    {"rpm", "speed", 1},
    {"rad/s", "speed", kRpmPerRadps},
    {"deg", "angle", 1},
    {"rad", "angle", kDegPerRad},
    {"turns", "angle", 360},
    {"Nm", "torque", 1},
    {"mNm", "torque", 1e-3},
    {"uNm", "torque", 1e-6},
    {"Ncm", "torque", 1e-2},
    {"A", "current", 1},
    {"mA", "current", 1e-3},
    {"V", "voltage", 1},
    {"mV", "voltage", 1e-3},
    {"kV", "voltage", 1e3},
    {"kgm2", "inertia", 1},
    {"gcm2", "inertia", 1e-7},
    {"Hz", "frequency", 1},
    {"kHz", "frequency", 1e3},
    {"W", "power", 1},
    {"mW", "power", 1e-3},
    {"kW", "power", 1e3},
    {"J", "energy", 1},
    {"mJ", "energy", 1e-3},
    {"Ohm", "resistance", 1},
    {"mOhm", "resistance", 1e-3},
    {"H", "inductance", 1},
    {"mH", "inductance", 1e-3},
    {"uH", "inductance", 1e-6},
    {"", "ratio", 1},
    {"%", "ratio", 1e-2},
};

const Unit* find_unit(std::string_view name) {
  const auto* const it = std::ranges::find(kUnits, name, &Unit::name);
  return it == std::end(kUnits) ? nullptr : it;
}

bool leading_zero(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9';
}

std::string_view trim(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

std::optional<Quantity> parse_quantity(std::string_view text) {
  text = trim(text);
  Quantity quantity;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, quantity.value);
  if (error != std::errc{} || !std::isfinite(quantity.value) || leading_zero(text)) {
    return std::nullopt;
  }
  const std::string_view unit = trim({end, last});
  const bool number = !unit.empty() && (unit[0] == '.' || unit[0] == '-' || unit[0] == '+' ||
                                        (unit[0] >= '0' && unit[0] <= '9'));
  if (number || unit.find(' ') != std::string_view::npos) return std::nullopt;
  quantity.unit = unit;
  return quantity;
}

std::optional<double> convert(double value, std::string_view from, std::string_view to) {
  if (from == to) return value;
  const Unit* const a = find_unit(from);
  const Unit* const b = find_unit(to);
  if (a == nullptr || b == nullptr || a->dimension != b->dimension) return std::nullopt;
  return value * a->factor / b->factor;
}

std::string units_like(std::string_view unit) {
  const Unit* const known = find_unit(unit);
  if (known == nullptr) return std::string(unit);
  std::string text;
  for (const Unit& other : kUnits) {
    if (other.dimension != known->dimension || other.name.empty()) continue;
    text += fmt::format("{}{}", text.empty() ? "" : " or ", other.name);
  }
  return text;
}

std::optional<SimDuration> parse_time(std::string_view text) {
  constexpr double kLongest = 1000 * 86400.0;
  const auto quantity = parse_quantity(text);
  if (!quantity || (quantity->unit.empty() && quantity->value != 0)) return std::nullopt;
  const auto s = quantity->unit.empty() ? 0 : convert(quantity->value, quantity->unit, "s");
  if (!s || !(*s >= 0 && *s <= kLongest)) return std::nullopt;
  return from_seconds(*s);
}

std::string show_time(SimDuration duration) {
  const std::int64_t ns = duration.count();
  constexpr std::int64_t kSecond = 1'000'000'000;
  if (ns != 0 && ns % (3600 * kSecond) == 0) return fmt::format("{} h", ns / (3600 * kSecond));
  if (ns >= kSecond || ns == 0) return fmt::format("{} s", static_cast<double>(ns) / 1e9);
  if (ns >= 1'000'000) return fmt::format("{} ms", static_cast<double>(ns) / 1e6);
  return fmt::format("{} us", static_cast<double>(ns) / 1e3);
}

std::string show_instant(SimTime time) {
  std::string text = fmt::format("{:.6f}", seconds(time));
  while (text.ends_with('0') && text[text.size() - 4] != '.') text.pop_back();
  return text + " s";
}

std::string show_quantity(double value, std::string_view unit) {
  return fmt::format("{:.6g}{}{}", value, unit.empty() ? "" : " ", unit);
}

}  // namespace virtdrive
