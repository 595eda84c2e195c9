#include "plant/motor_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

using Type = MotorKey::Type;

constexpr std::string_view kFormatKey = "virtdrive_motor";
constexpr double kRadpsPerKrpm = 1000 * std::numbers::pi / 30;

const std::vector<MotorKey>& key_table() {
  static const std::vector<MotorKey> keys = {
      {.name = kFormatKey,
       .type = Type::kInteger,
       .range = {.minimum = kMotorFormat, .maximum = kMotorFormat},
       .required = true,
       .doc = "Version of this format"},
      {.name = "name",
       .type = Type::kText,
       .required = true,
       .doc = "Lower-case letters, digits and hyphens"},
      {.name = "description", .type = Type::kText, .required = true, .doc = "One line"},
      {.name = "kind",
       .type = Type::kWord,
       .required = true,
       .words = {"pmsm"},
       .doc = "`pmsm`: permanent magnets, sinusoidal EMF"},
      {.name = "source",
       .type = Type::kText,
       .required = true,
       .doc = "Where the numbers come from: data sheet and edition, paper, measurement"},
      {.name = "assumed", .type = Type::kText, .doc = "What no source gives, and why this value"},

      {.name = "rated_voltage_v",
       .range = {.minimum = 0.1, .maximum = 2000, .unit = "V"},
       .required = true,
       .doc = "DC link"},
      {.name = "rated_current_a",
       .range = {.minimum = 1e-3, .maximum = 1e4, .unit = "A"},
       .required = true,
       .doc = "Continuous, counted as `rated_current_as` says"},
      {.name = "rated_current_as",
       .type = Type::kWord,
       .words = {"peak", "rms", "dc"},
       .doc = "`peak` (default) or `rms` of a sinusoidal phase current, or `dc`: the supply's in "
              "block commutation. Holds for `peak_current_a` too"},
      {.name = "peak_current_a",
       .range = {.minimum = 1e-3, .maximum = 1e5, .unit = "A"},
       .doc = "For a short time; draws the outer torque curve"},
      {.name = "rated_speed_rpm",
       .range = {.minimum = 0.1, .maximum = 5e5, .unit = "rpm"},
       .doc = "At rated torque"},
      {.name = "rated_torque_nm",
       .range = {.minimum = 1e-6, .maximum = 1e5, .unit = "Nm"},
       .doc = "Continuous"},
      {.name = "rated_power_w",
       .range = {.minimum = 1e-3, .maximum = 1e7, .unit = "W"},
       .doc = "At the shaft; within 25 % of torque times speed where both are given"},
      {.name = "maximum_speed_rpm",
       .range = {.minimum = 0.1, .maximum = 5e5, .unit = "rpm"},
       .doc = "What the rotor bears; ends the curves"},

      {.name = "pole_pairs",
       .type = Type::kInteger,
       .range = {.minimum = 1, .maximum = 100},
       .required = true,
       .doc = "Half the number of poles"},
      {.name = "phase_resistance_ohm",
       .range = {.minimum = 0, .maximum = 1e4, .unit = "Ohm"},
       .group = "resistance",
       .doc = "One phase of the star, at 20 ... 25 degC"},
      {.name = "line_resistance_ohm",
       .range = {.minimum = 0, .maximum = 1e4, .unit = "Ohm"},
       .group = "resistance",
       .doc = "Between two terminals: twice the phase's"},
      {.name = "d_axis_inductance_h",
       .range = {.minimum = 0, .maximum = 10, .above_minimum = true, .unit = "H"},
       .group = "inductance",
       .with = "q_axis_inductance_h",
       .doc = "Per phase, along the magnets"},
      {.name = "q_axis_inductance_h",
       .range = {.minimum = 0, .maximum = 10, .above_minimum = true, .unit = "H"},
       .with = "d_axis_inductance_h",
       .doc = "Per phase, across the magnets"},
      {.name = "phase_inductance_h",
       .range = {.minimum = 0, .maximum = 10, .above_minimum = true, .unit = "H"},
       .group = "inductance",
       .doc = "Per phase, both axes alike (magnets on the surface)"},
      {.name = "line_inductance_h",
       .range = {.minimum = 0, .maximum = 10, .above_minimum = true, .unit = "H"},
       .group = "inductance",
       .doc = "Between two terminals, both axes alike: twice the phase's"},
      {.name = "magnet_flux_wb",
       .range = {.minimum = 0, .maximum = 10, .unit = "Wb"},
       .group = "magnets",
       .doc = "Of the magnets, linked with one phase, peak"},
      {.name = "torque_constant_nm_per_a",
       .range = {.minimum = 0, .maximum = 1000, .above_minimum = true, .unit = "Nm/A"},
       .group = "magnets",
       .doc = "Torque per ampere of the phase current's peak (of Iq)"},
      {.name = "torque_constant_nm_per_arms",
       .range = {.minimum = 0, .maximum = 1000, .above_minimum = true, .unit = "Nm/A"},
       .group = "magnets",
       .doc = "Torque per ampere of the phase current's rms value"},
      {.name = "line_emf_vrms_per_krpm",
       .range = {.minimum = 0, .maximum = 1e5, .above_minimum = true, .unit = "V"},
       .group = "magnets",
       .doc = "EMF between two terminals at 1000 rpm, rms"},
      {.name = "line_emf_vpk_per_krpm",
       .range = {.minimum = 0, .maximum = 1e5, .above_minimum = true, .unit = "V"},
       .group = "magnets",
       .doc = "EMF between two terminals at 1000 rpm, peak"},

      {.name = "rotor_inertia_kgm2",
       .range = {.minimum = 0, .maximum = 1e4, .above_minimum = true, .unit = "kg m2"},
       .required = true,
       .doc = "1 gcm2 = 1e-7 kg m2"},
      {.name = "viscous_friction_nm_per_radps",
       .range = {.minimum = 0, .maximum = 1e3, .unit = "Nm s"},
       .doc = "Grows with speed; 0 if left out"},
      {.name = "coulomb_friction_nm",
       .range = {.minimum = 0, .maximum = 1e4, .unit = "Nm"},
       .doc = "Sliding and breakaway alike, cogging's mean loss included; 0 if left out"},
  };
  return keys;
}

// The values of a file behind their keys.
class Sheet {
 public:
  explicit Sheet(const YamlFile& file) : map_(file.root().map(names())) {
    map_[kFormatKey].integer(key(kFormatKey).range);  // first: another version, other rules
    for (const MotorKey& each : key_table()) {
      if (each.required && !map_.has(each.name)) {
        map_.self().fail(fmt::format("{} is missing: {}", each.name, each.doc));
      }
    }
    check_groups();
  }

  bool has(std::string_view name) const { return map_.has(name); }
  double number(std::string_view name) const { return map_[name].number(key(name).range); }
  double number_or(std::string_view name, double otherwise) const {
    return has(name) ? number(name) : otherwise;
  }
  int integer(std::string_view name) const {
    return static_cast<int>(map_[name].integer(key(name).range));
  }
  std::size_t word_or(std::string_view name, std::size_t otherwise) const {
    return has(name) ? map_[name].word(key(name).words) : otherwise;
  }
  std::string text_or(std::string_view name, std::string otherwise) const {
    if (!has(name)) return otherwise;
    std::string text = map_[name].text();
    if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; })) {
      map_[name].fail(fmt::format("{}: expected one line of text", name));
    }
    return text;
  }
  YamlValue operator[](std::string_view name) const { return map_[name]; }

 private:
  static std::vector<std::string_view> names() {
    std::vector<std::string_view> names;
    for (const MotorKey& each : key_table()) names.push_back(each.name);
    return names;
  }
  static const MotorKey& key(std::string_view name) {
    const auto it = std::ranges::find(key_table(), name, &MotorKey::name);
    VIRTDRIVE_CHECK(it != key_table().end(), "{}", name);
    return *it;
  }

  void check_groups() const {
    for (const MotorKey& first : key_table()) {
      if (!first.with.empty() && has(first.name) && !has(first.with)) {
        map_.fail_at_key(first.name, fmt::format("{} needs {} beside it", first.name, first.with));
      }
      if (first.group.empty()) continue;
      std::string choices;
      std::string_view given;
      for (const MotorKey& each : key_table()) {
        if (each.group != first.group) continue;
        choices += (choices.empty() ? "" : ", ") + std::string(each.name);
        if (!has(each.name)) continue;
        if (!given.empty()) {
          map_.fail_at_key(each.name, fmt::format("{} and {} say the same; expected one of them",
                                                  each.name, given));
        }
        given = each.name;
      }
      if (given.empty()) {
        map_.self().fail(fmt::format("{} is missing; expected one of {}", first.group, choices));
      }
    }
  }

  YamlMap map_;
};

std::string read_name(const Sheet& sheet) {
  constexpr std::size_t kMost = 40;
  std::string name = sheet["name"].text(kMost);
  const bool good = std::ranges::all_of(
      name, [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '-'; });
  if (!good) sheet["name"].fail("name: expected lower-case letters, digits and hyphens only");
  return name;
}

MotorRating read_rating(const Sheet& sheet) {
  const MotorRating rating{
      .voltage_v = sheet.number("rated_voltage_v"),
      .current_a = sheet.number("rated_current_a"),
      .counted_as = static_cast<CurrentRating>(sheet.word_or("rated_current_as", 0)),
      .peak_current_a = sheet.number_or("peak_current_a", 0),
      .speed_rpm = sheet.number_or("rated_speed_rpm", 0),
      .torque_nm = sheet.number_or("rated_torque_nm", 0),
      .power_w = sheet.number_or("rated_power_w", 0),
      .maximum_speed_rpm = sheet.number_or("maximum_speed_rpm", 0)};
  if (rating.peak_current_a > 0 && rating.peak_current_a < rating.current_a) {
    sheet["peak_current_a"].fail(fmt::format("peak_current_a is {}, below rated_current_a of {} A",
                                             rating.peak_current_a, rating.current_a));
  }
  if (rating.maximum_speed_rpm > 0 && rating.maximum_speed_rpm < rating.speed_rpm) {
    sheet["maximum_speed_rpm"].fail(
        fmt::format("maximum_speed_rpm is {}, below rated_speed_rpm of {} rpm",
                    rating.maximum_speed_rpm, rating.speed_rpm));
  }
  const double product_w = rating.torque_nm * rating.speed_rpm * std::numbers::pi / 30;
  if (rating.power_w > 0 && product_w > 0 && std::abs(rating.power_w / product_w - 1) > 0.25) {
    sheet["rated_power_w"].fail(
        fmt::format("rated_power_w is {}, but rated torque times rated speed is {:.4g} W",
                    rating.power_w, product_w));
  }
  return rating;
}

double read_flux_wb(const Sheet& sheet, int pole_pairs) {
  if (sheet.has("magnet_flux_wb")) return sheet.number("magnet_flux_wb");
  // Torque = 1.5 p psi iq.
  if (sheet.has("torque_constant_nm_per_a")) {
    return sheet.number("torque_constant_nm_per_a") / (1.5 * pole_pairs);
  }
  if (sheet.has("torque_constant_nm_per_arms")) {
    return sheet.number("torque_constant_nm_per_arms") / (1.5 * std::numbers::sqrt2 * pole_pairs);
  }
  // Between two terminals sqrt(3) of the phase's EMF, which is p w psi.
  const double peak_v = sheet.has("line_emf_vpk_per_krpm")
                            ? sheet.number("line_emf_vpk_per_krpm")
                            : sheet.number("line_emf_vrms_per_krpm") * std::numbers::sqrt2;
  return peak_v / (std::numbers::sqrt3 * pole_pairs * kRadpsPerKrpm);
}

PmsmParameters read_pmsm(const Sheet& sheet) {
  PmsmParameters motor;
  motor.pole_pairs = sheet.integer("pole_pairs");
  motor.resistance_ohm = sheet.has("line_resistance_ohm") ? sheet.number("line_resistance_ohm") / 2
                                                          : sheet.number("phase_resistance_ohm");
  if (sheet.has("d_axis_inductance_h")) {
    motor.inductance_d_h = sheet.number("d_axis_inductance_h");
    motor.inductance_q_h = sheet.number("q_axis_inductance_h");
  } else {
    motor.inductance_d_h = sheet.has("line_inductance_h") ? sheet.number("line_inductance_h") / 2
                                                          : sheet.number("phase_inductance_h");
    motor.inductance_q_h = motor.inductance_d_h;
  }
  motor.flux_wb = read_flux_wb(sheet, motor.pole_pairs);
  motor.rated_current_a = sheet.number("rated_current_a");
  return motor;
}

}  // namespace

std::span<const MotorKey> motor_keys() {
  return key_table();
}

Motor parse_motor(const YamlFile& file) {
  const Sheet sheet(file);
  sheet.word_or("kind", 0);
  Motor motor{
      .name = read_name(sheet),
      .description = sheet.text_or("description", ""),
      .rating = read_rating(sheet),
      .electrical = read_pmsm(sheet),
      .mechanics = {.inertia_kgm2 = sheet.number("rotor_inertia_kgm2"),
                    .viscous_nm_per_radps = sheet.number_or("viscous_friction_nm_per_radps", 0),
                    .coulomb_nm = sheet.number_or("coulomb_friction_nm", 0)},
      .source = sheet.text_or("source", ""),
      .assumed = sheet.text_or("assumed", "")};
  // A reluctance machine needs no magnets, but then its axes must differ.
  if (motor.electrical.flux_wb == 0 &&
      motor.electrical.inductance_d_h == motor.electrical.inductance_q_h) {
    sheet["magnet_flux_wb"].fail(
        "magnet_flux_wb is 0 and both axes have the same inductance: such a machine has no torque");
  }
  return motor;
}

}  // namespace virtdrive
