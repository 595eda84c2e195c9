#include "scenarios/scenario/schema.h"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/drive.h"
#include "scenarios/scenario/language.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;
using language::Key;
using language::Shape;
using language::Verb;

constexpr const char* kQuantity = R"(^-?(\d|\.\d).*$)";
constexpr const char* kTime = R"(^\s*((\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?\s*(us|ms|s|min|h)|0)\s*$)";

Json text() {
  return {{"type", "string"}};
}
Json scalar() {
  return {{"type", {"string", "number", "boolean"}}};
}
Json reference(const std::string& name) {
  return {{"$ref", "#/$defs/" + name}};
}
Json any_of(std::initializer_list<Json> schemas) {
  return {{"anyOf", Json(schemas)}};
}
Json list_of(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}

Json shape(Shape shape) {
  switch (shape) {
    case Shape::kNothing:
      return {{"type", "null"}};
    case Shape::kText:
    case Shape::kCondition:
      return scalar();
    case Shape::kQuantity:
      return any_of({{{"type", "number"}}, {{"type", "string"}, {"pattern", kQuantity}}});
    case Shape::kTime:
      return any_of({{{"const", 0}}, {{"type", "string"}, {"pattern", kTime}}});
    case Shape::kCount:
      return {{"type", "integer"}, {"minimum", 0}};
    case Shape::kFlag:
      return {{"type", "boolean"}};
    case Shape::kOnOff:
      return {{"enum", {"on", "off", true, false}}};
    case Shape::kList:
      return list_of(scalar());
    case Shape::kParameters:
      return reference("parameters");
    case Shape::kNames:
      return {{"type", "object"}, {"additionalProperties", scalar()}};
    case Shape::kReply:
      return any_of({reference("reply"), {{"type", "object"}}});
    case Shape::kSteps:
      return reference("steps");
    case Shape::kPoints:
      return list_of({{"type", "array"}, {"items", scalar()}, {"minItems", 2}, {"maxItems", 2}});
    case Shape::kMilestone:
      return reference("milestone");
    case Shape::kLoad:
      return any_of({text(), {{"type", "object"}, {"additionalProperties", scalar()}}});
    case Shape::kAny:
      return Json::object();
  }
  return Json::object();
}

void add(Json& properties, const Key& key, Json schema) {
  schema["description"] = key.doc;
  properties[std::string(key.name)] = std::move(schema);
}

Json properties_of(const std::vector<Key>& keys) {
  Json properties = Json::object();
  for (const Key& key : keys) add(properties, key, shape(key.shape));
  return properties;
}

Json object(Json properties, std::initializer_list<const char*> required = {}) {
  Json schema = {{"type", "object"}, {"properties", std::move(properties)}};
  if (required.size() > 0) schema["required"] = required;
  schema["additionalProperties"] = false;
  return schema;
}

// Parameters of all drives; a channel may go before the name.
Json parameters() {
  Json properties = Json::object();
  for (const DriveKind& drive : drive_catalogue()) {
    for (const protocol::ParameterRow& row : drive.table.parameters) {
      Json& property = properties[std::string(row.name)];
      property = scalar();
      property["description"] = fmt::format("{}: {}", drive.name, row.doc);
    }
  }
  return {{"type", "object"},
          {"minProperties", 1},
          {"properties", properties},
          {"patternProperties", {{R"(^\w+\.)", scalar()}}},
          {"additionalProperties", false}};
}

template <class Rows>
Json names_of(Rows protocol::ProtocolTable::* rows) {
  std::vector<std::string> names;
  for (const DriveKind& drive : drive_catalogue()) {
    for (const auto& row : drive.table.*rows) {
      if (std::ranges::find(names, row.name) == names.end()) names.emplace_back(row.name);
    }
  }
  return names;
}

Json reply() {
  Json words = {"done", "none", "error", "anything"};
  for (const Json& name : names_of(&protocol::ProtocolTable::errors)) {
    if (std::ranges::find(words, name) == words.end()) words.push_back(name);
  }
  return {{"enum", words}};
}

Json milestone() {
  Json properties = properties_of(language::milestone_keys());
  const Json commands = {{"enum", names_of(&protocol::ProtocolTable::commands)}};
  properties["request"].update(commands);
  properties["reply"].update(commands);
  Json schema = object(std::move(properties));
  schema["oneOf"] = {{{"required", {"request"}}}, {{"required", {"reply"}}}};
  return schema;
}

// What stands behind the verb itself.
Json behind(const Verb& verb) {
  if (verb.name == "call") {
    Json names = names_of(&protocol::ProtocolTable::commands);
    for (const Json& function : names_of(&protocol::ProtocolTable::functions)) {
      if (std::ranges::find(names, function) == names.end()) names.push_back(function);
    }
    return {{"anyOf", {{{"enum", names}}, {{"pattern", R"(^\w+\.)"}}}}};
  }
  if (verb.name == "raw") return any_of({scalar(), list_of(scalar())});
  if (verb.name == "inject") return any_of({text(), shape(Shape::kNames)});
  if (verb.name == "clear") return any_of({text(), list_of(text())});
  return shape(verb.shape);
}

Json step(const Verb& verb) {
  Json properties = Json::object();
  add(properties, {verb.name, verb.shape, verb.doc}, behind(verb));
  const auto add_all = [&](const std::vector<Key>& keys) {
    for (const Key& key : keys) add(properties, key, shape(key.shape));
  };
  add_all(verb.keys);
  if (verb.name == "raw") properties["reply"] = scalar();
  if (verb.may_be_triggered) add_all(language::trigger_keys());
  add_all(language::step_keys());
  Json schema = object(std::move(properties));
  schema["required"] = {std::string(verb.name)};
  return schema;
}

Json steps() {
  Json alone = Json::array();
  Json kinds = Json::array();
  for (const Verb& verb : language::verbs()) {
    if (verb.may_be_alone) alone.push_back(verb.name);
    kinds.push_back(step(verb));
  }
  kinds.push_back({{"enum", alone}});
  return {{"type", "array"}, {"minItems", 1}, {"items", {{"anyOf", kinds}}}};
}

Json drive_names() {
  Json names = Json::array();
  for (const DriveKind& drive : drive_catalogue()) names.push_back(drive.name);
  return {{"enum", names}};
}

Json drive_properties(Json properties) {
  properties["drive"].update(drive_names());
  properties["motor"].update(any_of({text(), list_of(text())}));
  return properties;
}

Json bench() {
  Json properties = drive_properties(properties_of(language::bench_keys()));
  properties["line"]["enum"] = {"real", "ideal"};
  properties["integrator"]["enum"] = {"fast", "default"};
  properties["drives"].update(
      list_of(object(drive_properties(properties_of(language::drive_keys())), {"name", "drive"})));
  Json lines = properties_of(language::line_keys());
  lines["timing"]["enum"] = {"real", "ideal"};
  properties["lines"].update(list_of(object(std::move(lines), {"name"})));
  return object(std::move(properties));
}

}  // namespace

std::string scenario_schema() {
  Json properties = properties_of(language::file_keys());
  properties[std::string(language::kVersionKey)] = {{"const", language::kVersion}};
  properties["bench"] = reference("bench");
  properties["record"] = object(properties_of(language::record_keys()));
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", "virtdrive scenario"}};
  schema.update(object(std::move(properties), {"virtdrive-scenario", "bench", "steps"}));
  schema["$defs"] = {{"bench", bench()},
                     {"parameters", parameters()},
                     {"reply", reply()},
                     {"milestone", milestone()},
                     {"steps", steps()}};
  return schema.dump(1) + "\n";
}

}  // namespace virtdrive
