// What scenario files are made of, read from YAML: quantities, times, bytes, names of a protocol.
// Each throws SetupError "FILE:LINE:COLUMN: ..." at the place of what is wrong.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/yaml_reader.h"
#include "devices/protocol/table.h"
#include "scenarios/scenario/condition.h"

namespace virtdrive {

/// Where something stands in a file: a value, or a key.
class Place {
 public:
  Place(const YamlValue& value) : value_(&value) {}  // NOLINT: a value is a place
  Place(const YamlMap& map, std::string_view key) : map_(&map), key_(key) {}

  [[noreturn]] void fail(std::string_view message) const;

 private:
  const YamlValue* value_ = nullptr;
  const YamlMap* map_ = nullptr;
  std::string_view key_;
};

/// Refuses keys that are not among those known, with the nearest ones.
void check_keys(const YamlMap& map, const std::vector<std::string_view>& known);
YamlMap checked_map(const YamlValue& value, const std::vector<std::string_view>& known);

/// A number in `unit`, from any that measures the same.
double number_of(const YamlValue& value, std::string_view unit);
SimDuration time_of(const YamlValue& value);
std::string time_message(std::string_view text);

/// Throws a LanguageError of a value's text, at its place in the file.
[[noreturn]] void fail_inside(const std::string& file, const YamlValue& value,
                              const LanguageError& error);

/// "11 02 0a ??", with or without the spaces; ?? is no byte. Nothing if it is no such text.
std::optional<std::vector<std::optional<std::uint8_t>>> parse_bytes(std::string_view text);

/// "NAME=VALUEUNIT", as the drives' words take it, from "VALUE UNIT".
std::string assignment(std::string_view name, std::string_view value);

/// The unit of the first number in a predicate; "" for none.
std::string unit_written(std::string_view predicate);
/// Refuses a unit that the parameter, "[CHANNEL.]NAME", cannot be told in.
void check_unit(const Place& place, const protocol::ProtocolTable& table,
                std::string_view parameter, std::string_view unit);

/// A command or function, "[CHANNEL.]NAME".
/// "[CHANNEL.]NAME" of a command or a function; SetupError with the nearest names for another.
const protocol::CommandRow& command_named(std::string_view text,
                                          const protocol::ProtocolTable& table);
const protocol::CommandRow& command_named(const YamlValue& value,
                                          const protocol::ProtocolTable& table);

/// A payload's numbers one by one: groups and repetitions counted out as "entry.0.id".
struct FlatField {
  std::string name;
  double scale;
  std::string_view unit;
};
std::vector<FlatField> flat_fields(std::span<const protocol::Field> fields);
std::size_t field_named(const Place& place, const std::vector<FlatField>& fields,
                        std::string_view name);

}  // namespace virtdrive
