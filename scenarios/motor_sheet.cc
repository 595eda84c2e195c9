#include "scenarios/motor_sheet.h"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "plant/motor_curves.h"
#include "plant/motor_file.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRpmPerRadps = 30 / std::numbers::pi;

struct Quantity {
  std::string_view key;  // of the JSON object; SI, as its suffix says
  std::string_view label;
  double value;
  std::string_view unit;  // takes an SI prefix; "rpm" and the like do not
  std::string_view note{};
};
struct Section {
  std::string_view name;
  std::vector<Quantity> quantities;
};

std::string_view counted(CurrentRating counted_as) {
  constexpr std::string_view kWords[] = {"peak", "rms", "dc"};
  return kWords[static_cast<std::size_t>(counted_as)];
}

std::vector<Section> sections(const Motor& motor) {
  const MotorRating& r = motor.rating;
  const PmsmParameters& e = motor.electrical;
  const MotorConstants k = motor_constants(motor);
  std::vector<Quantity> rating = {
      {"rated_voltage_v", "voltage", r.voltage_v, "V", "DC link"},
      {"rated_current_a", "current", r.current_a, "A", counted(r.counted_as)}};
  const auto add_if_known = [&](const Quantity& quantity) {
    if (quantity.value > 0) rating.push_back(quantity);
  };
  add_if_known({"peak_current_a", "peak current", r.peak_current_a, "A", counted(r.counted_as)});
  add_if_known({"rated_speed_rpm", "speed", r.speed_rpm, "rpm"});
  add_if_known({"rated_torque_nm", "torque", r.torque_nm, "Nm"});
  add_if_known({"rated_power_w", "power", rated_power_w(r), "W"});
  add_if_known({"maximum_speed_rpm", "maximum speed", r.maximum_speed_rpm, "rpm"});
  return {
      {"rating", rating},
      {"parameters",
       {{"pole_pairs", "pole pairs", static_cast<double>(e.pole_pairs), ""},
        {"phase_resistance_ohm", "phase resistance", e.resistance_ohm, "Ohm"},
        {"d_axis_inductance_h", "inductance, d axis", e.inductance_d_h, "H"},
        {"q_axis_inductance_h", "inductance, q axis", e.inductance_q_h, "H"},
        {"magnet_flux_wb", "magnet flux", e.flux_wb, "Wb", "peak, of a phase"},
        {"rotor_inertia_kgm2", "rotor inertia", motor.mechanics.inertia_kgm2, "kg m2"},
        {"viscous_friction_nm_per_radps", "viscous friction", motor.mechanics.viscous_nm_per_radps,
         "Nm s"},
        {"coulomb_friction_nm", "Coulomb friction", motor.mechanics.coulomb_nm, "Nm"}}},
      {"derived",
       {{"torque_constant_nm_per_a", "torque constant", k.torque_constant_nm_per_a, "Nm/A",
         "of the phase current's peak"},
        {"torque_constant_nm_per_arms", "", k.torque_constant_nm_per_arms, "Nm/A", "of its rms"},
        {"emf_v_per_radps", "EMF constant", k.emf_v_per_radps, "V s", "phase peak, mechanical"},
        {"line_emf_vrms_per_krpm", "", k.line_emf_vrms_per_krpm, "V",
         "rms at 1000 rpm, line to line"},
        {"speed_constant_rpm_per_v", "speed constant", k.speed_constant_rpm_per_v, "rpm/V",
         "of the line-to-line peak"},
        {"motor_constant_nm_per_rtw", "motor constant", k.motor_constant_nm_per_rtw, "Nm/sqrt(W)"},
        {"electrical_time_constant_s", "electrical time constant", k.electrical_time_constant_s,
         "s", "Lq / R"},
        {"mechanical_time_constant_s", "mechanical time constant", k.mechanical_time_constant_s,
         "s", "J R / (1.5 p2 psi2)"},
        {"rated_torque_nm", "torque at rated current", k.rated_torque_nm, "Nm",
         "at the shaft, low speed"},
        {"base_speed_rpm", "base speed", k.base_radps * kRpmPerRadps, "rpm",
         "of full torque, at rated voltage"},
        {"no_load_speed_rpm", "no-load speed", k.no_load_radps * kRpmPerRadps, "rpm",
         "id = 0, at rated voltage"},
        {"stall_current_a", "stall current", k.stall_current_a, "A", "peak, Vdc / sqrt(3) / R"},
        {"characteristic_current_a", "characteristic current", k.characteristic_current_a, "A",
         "psi / Ld: of a short circuit at speed"}}},
  };
}

// "1.05 mH"; rpm and numbers as they are.
std::string with_prefix(double value, std::string_view unit) {
  if (!std::isfinite(value)) return "none";
  if (value == 0 || unit.empty() || unit.starts_with("rpm") || unit == "kg m2" || unit == "Nm s") {
    return fmt::format("{:.5g} {}", value, unit);
  }
  constexpr std::string_view kPrefixes[] = {"n", "u", "m", "", "k", "M"};
  const int group =
      std::clamp(static_cast<int>(std::floor(std::log10(std::abs(value)) / 3)), -3, 2);
  return fmt::format("{:.4g} {}{}", value / std::pow(1000, group),
                     kPrefixes[static_cast<std::size_t>(group + 3)], unit);
}

Json json_of(const Section& section) {
  Json object;
  for (const Quantity& quantity : section.quantities) object[quantity.key] = quantity.value;
  return object;
}

Json schema_of(const MotorKey& key) {
  Json schema;
  switch (key.type) {
    case MotorKey::Type::kText:
      schema["type"] = "string";
      schema["minLength"] = 1;
      break;
    case MotorKey::Type::kInteger:
      schema["type"] = "integer";
      break;
    case MotorKey::Type::kNumber:
      schema["type"] = "number";
      break;
    case MotorKey::Type::kWord:
      schema["enum"] = key.words;
      break;
  }
  if (std::isfinite(key.range.minimum)) {
    schema[key.range.above_minimum ? "exclusiveMinimum" : "minimum"] = key.range.minimum;
  }
  if (std::isfinite(key.range.maximum)) schema["maximum"] = key.range.maximum;
  schema["description"] = key.range.unit.empty() ? std::string(key.doc)
                                                 : fmt::format("{} [{}]", key.doc, key.range.unit);
  return schema;
}

// One of the keys of each group.
Json alternatives() {
  std::vector<std::string_view> groups;
  for (const MotorKey& key : motor_keys()) {
    if (!key.group.empty() && std::ranges::find(groups, key.group) == groups.end()) {
      groups.push_back(key.group);
    }
  }
  Json all = Json::array();
  for (const std::string_view group : groups) {
    Json choice = Json::array();
    for (const MotorKey& key : motor_keys()) {
      if (key.group == group) choice.push_back({{"required", {key.name}}});
    }
    all.push_back({{"oneOf", choice}});
  }
  return all;
}

}  // namespace

std::string motor_text(const Motor& motor) {
  std::string text =
      fmt::format("{}: {}\nsource: {}\n", motor.name, motor.description, motor.source);
  if (!motor.assumed.empty()) text += fmt::format("assumed: {}\n", motor.assumed);
  for (const Section& section : sections(motor)) {
    text += fmt::format("\n{}\n", section.name);
    for (const Quantity& quantity : section.quantities) {
      std::string line = fmt::format("  {:<26}{:<16}{}", quantity.label,
                                     with_prefix(quantity.value, quantity.unit), quantity.note);
      line.erase(line.find_last_not_of(' ') + 1);
      text += line + '\n';
    }
  }
  return text;
}

std::string motor_json(const Motor& motor) {
  Json json;
  json["name"] = motor.name;
  json["description"] = motor.description;
  json["kind"] = "pmsm";
  json["source"] = motor.source;
  json["assumed"] = motor.assumed;
  for (const Section& section : sections(motor)) {
    json[section.name] = json_of(section);
    if (section.name == "rating")
      json[section.name]["rated_current_as"] = counted(motor.rating.counted_as);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string motor_schema() {
  Json schema;
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "virtdrive motor";
  schema["description"] = "Made by 'virtdrive motor --schema' from the table the program reads by";
  schema["type"] = "object";
  schema["additionalProperties"] = false;
  Json& properties = schema["properties"];
  Json required = Json::array();
  Json dependent = Json::object();
  for (const MotorKey& key : motor_keys()) {
    properties[key.name] = schema_of(key);
    if (key.required) required.push_back(key.name);
    if (!key.with.empty()) dependent[key.name] = {key.with};
  }
  properties["name"]["pattern"] = "^[a-z0-9-]{1,40}$";
  schema["required"] = required;
  schema["dependentRequired"] = dependent;
  schema["allOf"] = alternatives();
  return schema.dump(2) + '\n';
}

std::string motor_key_table() {
  std::string table = "| key | unit | range | needed | meaning |\n|---|---|---|---|---|\n";
  for (const MotorKey& key : motor_keys()) {
    NumberRange range = key.range;
    range.unit = {};
    const std::string needed = key.required         ? "yes"
                               : !key.group.empty() ? fmt::format("one of: {}", key.group)
                               : !key.with.empty()  ? fmt::format("with `{}`", key.with)
                                                    : "";
    const std::string values = key.type == MotorKey::Type::kWord
                                   ? fmt::format("{}", fmt::join(key.words, ", "))
                               : key.type == MotorKey::Type::kText ? "text"
                                                                   : range.text();
    table += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, key.range.unit, values, needed,
                         key.doc);
  }
  return table;
}

}  // namespace virtdrive
