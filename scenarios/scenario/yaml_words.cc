#include "scenarios/scenario/yaml_words.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/scenario/quantity.h"

namespace virtdrive {

void Place::fail(std::string_view message) const {
  if (value_ != nullptr) value_->fail(message);
  map_->fail_at_key(key_, message);
}

void check_keys(const YamlMap& map, const std::vector<std::string_view>& known) {
  for (const std::string_view key : map.keys()) {
    if (std::ranges::find(known, key) == known.end()) {
      map.fail_at_key(key, unknown_name("key", key, known));
    }
  }
}

YamlMap checked_map(const YamlValue& value, const std::vector<std::string_view>& known) {
  const YamlMap map = value.map();
  check_keys(map, known);
  return map;
}

double number_of(const YamlValue& value, std::string_view unit) {
  const std::string text = value.text(100);
  const auto quantity = parse_quantity(text);
  if (!quantity) {
    value.fail(fmt::format("'{}' is not a number{}", text,
                           unit.empty() ? "" : fmt::format(" with its unit, as 1 {}", unit)));
  }
  if (quantity->value == 0 && quantity->unit.empty()) return 0;
  if (const auto number = convert(quantity->value, quantity->unit, unit)) return *number;
  if (unit.empty()) {
    value.fail(fmt::format("'{}': this has no unit; leave '{}' out", text, quantity->unit));
  }
  value.fail(quantity->unit.empty()
                 ? fmt::format("'{}' needs a unit: {}", text, units_like(unit))
                 : fmt::format("'{}': the unit must be {}", text, units_like(unit)));
}

std::string time_message(std::string_view text) {
  return fmt::format("'{}' is not a time: expected a number of us, ms, s, min or h, as 1.5 s",
                     text);
}

SimDuration time_of(const YamlValue& value) {
  const std::string text = value.text(100);
  const auto time = parse_time(text);
  if (!time) value.fail(time_message(text));
  return *time;
}

void fail_inside(const std::string& file, const YamlValue& value, const LanguageError& error) {
  const YamlPosition at = value.position();
  throw SetupError(fmt::format("{}:{}:{}: {}", file, at.line,
                               at.column + static_cast<int>(error.at()) + (value.quoted() ? 1 : 0),
                               error.what()));
}

std::optional<std::vector<std::optional<std::uint8_t>>> parse_bytes(std::string_view text) {
  std::vector<std::optional<std::uint8_t>> bytes;
  while (true) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    if (text.empty()) break;
    if (text.starts_with("??")) {
      bytes.emplace_back();
    } else {
      std::uint8_t byte = 0;
      const char* const end = text.data() + 2;
      if (text.size() < 2) return std::nullopt;
      const auto [stop, error] = std::from_chars(text.data(), end, byte, 16);
      if (error != std::errc{} || stop != end) return std::nullopt;
      bytes.emplace_back(byte);
    }
    text.remove_prefix(2);
  }
  if (bytes.empty()) return std::nullopt;
  return bytes;
}

std::string assignment(std::string_view name, std::string_view value) {
  std::string text = fmt::format("{}=", name);
  for (const char c : value) {
    if (c != ' ') text += c;
  }
  return text;
}

std::string unit_written(std::string_view predicate) {
  const std::size_t digit = predicate.find_first_of("0123456789");
  if (digit == std::string_view::npos) return {};
  std::string_view rest = predicate.substr(digit);
  rest = rest.substr(0, std::min(rest.find("+-"), rest.find("...")));
  const auto quantity = parse_quantity(rest);
  return quantity ? quantity->unit : std::string();
}

void check_unit(const Place& place, const protocol::ProtocolTable& table,
                std::string_view parameter, std::string_view unit) {
  const std::string_view name = parameter.substr(parameter.rfind('.') + 1);
  const auto row = std::ranges::find_if(
      table.parameters, [&](const auto& r) { return edit_distance(r.name, name) == 0; });
  if (row == table.parameters.end()) return;
  std::vector<std::string_view> labels;
  for (const protocol::UnitCode& code : row->units) labels.push_back(code.label);
  if (labels.empty() && !row->unit.empty()) labels.push_back(row->unit);
  if (labels.empty() && unit.empty()) return;
  if (labels.empty()) {
    place.fail(fmt::format("{} has no unit; leave '{}' out", row->name, unit));
  }
  for (const std::string_view label : labels) {
    if (!unit.empty() && convert(1, label, unit)) return;
  }
  if (unit.empty()) {
    place.fail(fmt::format("{} needs a unit: {}", row->name, fmt::join(labels, " or ")));
  }
  place.fail(unknown_name(fmt::format("unit of {}", row->name), unit, labels));
}

const protocol::CommandRow& command_named(std::string_view text,
                                          const protocol::ProtocolTable& table) {
  const std::string_view name = text.substr(text.rfind('.') + 1);
  std::vector<std::string_view> names;
  for (const auto& rows : {table.commands, table.functions}) {
    const auto it = std::ranges::find(rows, name, &protocol::CommandRow::name);
    if (it != rows.end()) return *it;
    for (const protocol::CommandRow& row : rows) names.push_back(row.name);
  }
  throw SetupError(unknown_name("command", name, names));
}

const protocol::CommandRow& command_named(const YamlValue& value,
                                          const protocol::ProtocolTable& table) {
  const std::string text = value.text();
  try {
    return command_named(text, table);
  } catch (const SetupError& error) {
    value.fail(error.what());
  }
}

std::vector<FlatField> flat_fields(std::span<const protocol::Field> fields) {
  std::vector<FlatField> flat;
  for (const protocol::Field& field : fields) {
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::string name =
          field.count == 1 ? std::string(field.name) : fmt::format("{}.{}", field.name, i);
      if (field.members.empty()) {
        flat.push_back({name, field.scale, field.unit});
        continue;
      }
      for (FlatField& member : flat_fields(field.members)) {
        flat.push_back({fmt::format("{}.{}", name, member.name), member.scale, member.unit});
      }
    }
  }
  return flat;
}

std::size_t field_named(const Place& place, const std::vector<FlatField>& fields,
                        std::string_view name) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].name == name) return i;
    names.push_back(fields[i].name);
  }
  if (names.empty()) place.fail(fmt::format("'{}': there are no fields", name));
  place.fail(unknown_name("field", name, names));
}

}  // namespace virtdrive
