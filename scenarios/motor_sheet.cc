#include "scenarios/motor_sheet.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "plant/induction_curves.h"
#include "plant/motor_curves.h"
#include "plant/motor_file.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr MachineKind kKinds[] = {MachineKind::kPmsm, MachineKind::kBldc, MachineKind::kBrushedDc,
                                  MachineKind::kVoiceCoil, MachineKind::kInduction};

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

std::vector<Quantity> rating_of(const Motor& motor) {
  const MotorRating& r = motor.rating;
  std::vector<Quantity> rating = {
      {"rated_voltage_v", "voltage", r.voltage_v, "V", "DC link"},
      {"rated_current_a", "current", r.current_a, "A", counted(r.counted_as)}};
  const auto add_if_known = [&](const Quantity& quantity) {
    if (quantity.value > 0) rating.push_back(quantity);
  };
  add_if_known({"peak_current_a", "peak current", r.peak_current_a, "A", counted(r.counted_as)});
  add_if_known({"rated_speed_rpm", "speed", r.speed_rpm, "rpm"});
  if (motor.kind == MachineKind::kVoiceCoil) {
    add_if_known({"rated_force_n", "force", r.torque_nm, "N"});
  } else {
    add_if_known({"rated_torque_nm", "torque", r.torque_nm, "Nm"});
    add_if_known({"rated_power_w", "power", rated_power_w(r), "W"});
  }
  add_if_known({"rated_frequency_hz", "frequency", r.frequency_hz, "Hz"});
  add_if_known({"maximum_speed_rpm", "maximum speed", r.maximum_speed_rpm, "rpm"});
  return rating;
}

// Of three phases.
std::vector<Section> sections_by_phase(const Motor& motor, const MotorConstants& k) {
  const PmsmParameters& e = motor.electrical;
  return {
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

std::vector<Section> sections_by_terminals(const Motor& motor, const SteadyMotor& steady,
                                           const MotorConstants& k) {
  const bool turns = motor.kind == MachineKind::kBrushedDc;
  const PmsmParameters& m = steady.machine();
  const MechanicsParameters& mechanics = motor.mechanics;
  std::vector<Quantity> parameters = {
      {"line_resistance_ohm", "resistance", m.resistance_ohm, "Ohm", "between the terminals"},
      {"line_inductance_h", "inductance", m.inductance_q_h, "H", "between the terminals"}};
  std::vector<Quantity> derived = {
      {"electrical_time_constant_s", "electrical time constant", k.electrical_time_constant_s, "s",
       "L / R"},
      {"mechanical_time_constant_s", "mechanical time constant", k.mechanical_time_constant_s, "s",
       turns ? "J R / K2" : "m R / K2"},
      {"stall_current_a", "stall current", k.stall_current_a, "A", "at rated voltage"}};
  if (turns) {
    parameters.push_back({"torque_constant_nm_per_adc", "torque constant", m.flux_wb, "Nm/A"});
    parameters.push_back({"rotor_inertia_kgm2", "rotor inertia", mechanics.inertia_kgm2, "kg m2"});
    parameters.push_back({"viscous_friction_nm_per_radps", "viscous friction",
                          mechanics.viscous_nm_per_radps, "Nm s"});
    parameters.push_back({"coulomb_friction_nm", "Coulomb friction", mechanics.coulomb_nm, "Nm"});
    derived.push_back(
        {"speed_constant_rpm_per_v", "speed constant", k.speed_constant_rpm_per_v, "rpm/V"});
    derived.push_back(
        {"motor_constant_nm_per_rtw", "motor constant", k.motor_constant_nm_per_rtw, "Nm/sqrt(W)"});
    derived.push_back(
        {"rated_torque_nm", "torque at rated current", k.rated_torque_nm, "Nm", "at the shaft"});
    derived.push_back({"no_load_speed_rpm", "no-load speed", k.no_load_radps * kRpmPerRadps, "rpm",
                       "at rated voltage"});
    derived.push_back({"stall_torque_nm", "stall torque", k.stall_current_a * m.flux_wb, "Nm"});
  } else {
    parameters.push_back({"force_constant_n_per_a", "force constant", m.flux_wb, "N/A"});
    parameters.push_back({"moving_mass_kg", "moving mass", mechanics.inertia_kgm2, "kg"});
    parameters.push_back({"viscous_friction_n_per_mps", "viscous friction",
                          mechanics.viscous_nm_per_radps, "N s/m"});
    parameters.push_back({"coulomb_friction_n", "Coulomb friction", mechanics.coulomb_nm, "N"});
    derived.push_back(
        {"motor_constant_n_per_rtw", "motor constant", k.motor_constant_nm_per_rtw, "N/sqrt(W)"});
    derived.push_back({"rated_force_n", "force at rated current", k.rated_torque_nm, "N"});
    derived.push_back(
        {"no_load_speed_mps", "no-load speed", k.no_load_radps, "m/s", "at rated voltage"});
  }
  return {{"parameters", parameters}, {"derived", derived}};
}

// On the rated supply.
std::vector<Section> sections_of_induction(const Motor& motor) {
  const CageParameters& c = *motor.effects.cage;
  const InductionSupply supply = rated_supply(motor);
  const InductionPoint rated = induction_at_power(motor, supply, rated_power_w(motor.rating));
  const InductionPoint idle = induction_no_load(motor, supply);
  const InductionPoint most = induction_breakdown(motor, supply);
  const InductionPoint locked = induction_point(motor, supply, 1);
  return {
      {"rating", rating_of(motor)},
      {"parameters",
       {{"pole_pairs", "pole pairs", static_cast<double>(motor.electrical.pole_pairs), ""},
        {"phase_resistance_ohm", "stator resistance", motor.electrical.resistance_ohm, "Ohm",
         "per phase"},
        {"rotor_resistance_ohm", "rotor resistance", c.rotor_resistance_ohm, "Ohm",
         "referred to the stator"},
        {"stator_leakage_h", "stator leakage", c.stator_leakage_h, "H"},
        {"rotor_leakage_h", "rotor leakage", c.rotor_leakage_h, "H", "referred to the stator"},
        {"main_inductance_h", "main inductance", c.main_inductance_h, "H", "unsaturated"},
        {"saturation_flux_wb", "saturation flux", c.saturation_flux_wb, "Wb", "halves it"},
        {"rotor_inertia_kgm2", "rotor inertia", motor.mechanics.inertia_kgm2, "kg m2"},
        {"viscous_friction_nm_per_radps", "viscous friction", motor.mechanics.viscous_nm_per_radps,
         "Nm s"},
        {"coulomb_friction_nm", "Coulomb friction", motor.mechanics.coulomb_nm, "Nm"}}},
      {"derived",
       {{"supply_v", "supply", supply.line_v, "V", "rms, between two lines"},
        {"rated_power_speed_rpm", "speed at rated power", rated.speed_radps * kRpmPerRadps, "rpm"},
        {"rated_power_torque_nm", "torque at rated power", rated.torque_nm, "Nm"},
        {"rated_power_current_a", "current at rated power", rated.current_a, "A", "rms"},
        {"power_factor", "power factor", rated.power_factor, ""},
        {"efficiency", "efficiency", rated.efficiency(), ""},
        {"no_load_current_a", "no-load current", idle.current_a, "A", "rms"},
        {"locked_rotor_current_a", "locked-rotor current", locked.current_a, "A", "rms"},
        {"locked_rotor_torque_nm", "locked-rotor torque", locked.air_gap_nm, "Nm"},
        {"breakdown_torque_nm", "breakdown torque", most.torque_nm, "Nm"},
        {"breakdown_slip", "breakdown slip", most.slip, ""},
        {"rotor_time_constant_s", "rotor time constant",
         (c.rotor_leakage_h + c.main_inductance_h) / c.rotor_resistance_ohm, "s"}}}};
}

std::vector<Section> sections(const Motor& motor) {
  if (motor.kind == MachineKind::kInduction) return sections_of_induction(motor);
  const SteadyMotor steady(motor);
  const MotorConstants k = motor_constants(steady);
  std::vector<Section> all = steady.two_terminals() ? sections_by_terminals(motor, steady, k)
                                                    : sections_by_phase(motor, k);
  all.insert(all.begin(), {"rating", rating_of(motor)});
  return all;
}

// What the machine has beyond R, L and K.
std::string effects_text(const Motor& motor) {
  const MachineEffects& e = motor.effects;
  std::vector<std::string_view> words;
  if (motor.kind == MachineKind::kBldc) words.push_back("trapezoidal EMF");
  if (motor.kind == MachineKind::kPmsm && !e.emf.table.empty()) words.push_back("shaped EMF");
  if (e.saturation) words.push_back("saturation in closed form");
  if (e.flux_map) words.push_back("flux map");
  if (e.cage && e.cage->saturation_flux_wb > 0) words.push_back("saturation of the main flux");
  if (!e.cogging_nm.empty()) words.push_back("cogging");
  if (e.iron_eddy_w_per_v2 > 0 || e.iron_hysteresis_w > 0) words.push_back("iron loss");
  if (e.thermal.winding_housing_k_per_w > 0) words.push_back("temperatures");
  if (motor.mechanics.stiction_nm > 0) words.push_back("breakaway friction");
  return words.empty() ? "" : fmt::format("models: {}\n", fmt::join(words, ", "));
}

// "1.05 mH"; rpm and numbers as they are.
std::string with_prefix(double value, std::string_view unit) {
  if (!std::isfinite(value)) return "none";
  if (value == 0 || unit.empty() || unit.starts_with("rpm") || unit == "kg m2" ||
      unit.ends_with(" s") || unit.ends_with("s/m")) {
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

void add_range(Json& schema, const NumberRange& range) {
  if (std::isfinite(range.minimum)) {
    schema[range.above_minimum ? "exclusiveMinimum" : "minimum"] = range.minimum;
  }
  if (std::isfinite(range.maximum)) schema["maximum"] = range.maximum;
}

Json schema_of(const MotorKey& key) {
  Json schema, item = {{"type", "number"}};
  add_range(item, key.range);
  switch (key.type) {
    case MotorKey::Type::kText:
      schema = {{"type", "string"}, {"minLength", 1}};
      break;
    case MotorKey::Type::kInteger:
      schema = item;
      schema["type"] = "integer";
      break;
    case MotorKey::Type::kNumber:
      schema = item;
      break;
    case MotorKey::Type::kWord:
      schema["enum"] = key.words;
      break;
    case MotorKey::Type::kNumbers:
      schema = {
          {"type", "array"}, {"items", item}, {"minItems", key.least}, {"maxItems", key.most}};
      break;
    case MotorKey::Type::kTable:
      schema = {{"type", "array"}, {"items", {{"type", "array"}, {"items", item}}}};
      break;
    case MotorKey::Type::kMap:
      schema = {{"type", "object"}, {"additionalProperties", false}, {"required", Json::array()}};
      for (const MotorKey& inner : key.keys) {
        schema["properties"][inner.name] = schema_of(inner);
        schema["required"].push_back(inner.name);
      }
      break;
  }
  schema["description"] = key.range.unit.empty() ? std::string(key.doc)
                                                 : fmt::format("{} [{}]", key.doc, key.range.unit);
  return schema;
}

// What holds for one kind of machine: keys it needs, keys it has not, one key of each group.
Json rules_of(MachineKind kind) {
  Json required = Json::array(), none = Json::object(), choices = Json::array();
  std::vector<std::string_view> groups;
  for (const MotorKey& key : motor_keys()) {
    if ((key.kinds & only(kind)) == 0) {
      none[key.name] = false;
      continue;
    }
    if (key.required && key.kinds != kAllKinds) required.push_back(key.name);
    if (!key.group.empty() && std::ranges::find(groups, key.group) == groups.end()) {
      groups.push_back(key.group);
    }
  }
  for (const std::string_view group : groups) {
    Json choice = Json::array();
    for (const MotorKey& key : motor_keys()) {
      if (key.group == group && (key.kinds & only(kind)) != 0) {
        choice.push_back({{"required", {key.name}}});
      }
    }
    choices.push_back({{"oneOf", choice}});
  }
  return {{"if", {{"properties", {{"kind", {{"const", kind_name(kind)}}}}}}},
          {"then", {{"required", required}, {"properties", none}, {"allOf", choices}}}};
}

std::string kinds_text(MachineKinds kinds) {
  if (kinds == kAllKinds) return "all";
  std::string text;
  for (const MachineKind kind : kKinds) {
    if ((kinds & only(kind)) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(kind_name(kind));
  }
  return text;
}

std::string values_text(const MotorKey& key) {
  NumberRange range = key.range;
  range.unit = {};
  switch (key.type) {
    case MotorKey::Type::kText:
      return "text";
    case MotorKey::Type::kWord:
      return fmt::format("{}", fmt::join(key.words, ", "));
    case MotorKey::Type::kNumbers:
      return fmt::format("list of {} ... {} numbers", key.least, key.most);
    case MotorKey::Type::kTable:
      return "list of lists";
    case MotorKey::Type::kMap:
      return "keys below";
    case MotorKey::Type::kNumber:
    case MotorKey::Type::kInteger:
      break;
  }
  return range.text();
}

void add_key_rows(std::string& table, const std::vector<MotorKey>& keys, std::string_view within) {
  for (const MotorKey& key : keys) {
    const std::string needed = key.required         ? "yes"
                               : !key.group.empty() ? fmt::format("one of: {}", key.group)
                               : !key.with.empty()  ? fmt::format("with `{}`", key.with)
                                                    : "";
    table += fmt::format("| `{}{}` | {} | {} | {} | {} | {} |\n", within, key.name, key.range.unit,
                         values_text(key), kinds_text(key.kinds), needed, key.doc);
    add_key_rows(table, key.keys, fmt::format("{}: ", key.name));
  }
}

}  // namespace

std::string motor_text(const Motor& motor) {
  std::string text =
      fmt::format("{}: {}\nsource: {}\n", motor.name, motor.description, motor.source);
  if (!motor.assumed.empty()) text += fmt::format("assumed: {}\n", motor.assumed);
  text += fmt::format("kind: {}\n", kind_name(motor.kind)) + effects_text(motor);
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
  json["kind"] = kind_name(motor.kind);
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
    if (key.required && key.kinds == kAllKinds) required.push_back(key.name);
    if (!key.with.empty()) dependent[key.name] = {key.with};
  }
  properties["name"]["pattern"] = "^[a-z0-9-]{1,40}$";
  schema["required"] = required;
  schema["dependentRequired"] = dependent;
  schema["allOf"] = Json::array();
  for (const MachineKind kind : kKinds) schema["allOf"].push_back(rules_of(kind));
  return schema.dump(2) + '\n';
}

std::string motor_key_table() {
  std::string table =
      "| key | unit | values | kinds | needed | meaning |\n|---|---|---|---|---|---|\n";
  add_key_rows(table, motor_keys(), "");
  return table;
}

}  // namespace virtdrive
