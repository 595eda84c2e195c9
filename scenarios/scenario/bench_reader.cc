#include "scenarios/scenario/bench_reader.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/scenario/language.h"
#include "scenarios/scenario/yaml_words.h"

namespace virtdrive {
namespace {

// Calls `look_up`, and says what it refuses at a place.
template <class LookUp>
decltype(auto) at_place(const Place& place, LookUp&& look_up) {
  try {
    return look_up();
  } catch (const SetupError& error) {
    std::string_view message = error.what();
    constexpr std::string_view kOption = "--load ";  // a file has no options
    if (message.starts_with(kOption)) message.remove_prefix(kOption.size());
    place.fail(message);
  }
}

LineTiming timing_of(const YamlValue& value) {
  return value.word({"real", "ideal"}) == 0 ? LineTiming::kReal : LineTiming::kIdeal;
}

int baud_of(const YamlValue& value) {
  return static_cast<int>(value.integer({.minimum = 50, .maximum = 4e6, .unit = "bit/s"}));
}

std::string load_of(const YamlValue& value, const DriveKind& kind) {
  std::string load;
  if (value.kind() == YamlKind::kMap) {
    const YamlMap map = value.map();
    for (const std::string_view part : map.keys()) {
      const std::string text =
          fmt::format("{}:{}", part, assignment("", map[part].text()).substr(1));
      at_place(Place(map, part), [&] { return parse_load(text, kind.channels); });
      load += (load.empty() ? "" : ",") + text;
    }
  } else {
    load = value.text();
    at_place(value, [&] { return parse_load(load, kind.channels); });
  }
  return load;
}

std::vector<std::string> motors_of(const YamlValue& value, const DriveKind& kind) {
  std::vector<YamlValue> names;
  if (value.kind() == YamlKind::kList)
    names = value.list(1);
  else
    names.push_back(value);
  if (names.size() != 1 && names.size() != kind.channels) {
    value.fail(fmt::format("{} motors; {} has {} channels: name one, or one each", names.size(),
                           kind.name, kind.channels));
  }
  std::vector<std::string> motors;
  for (const YamlValue& name : names) {
    motors.push_back(name.text());
    at_place(name, [&] { return find_motor(motors.back()); });
  }
  return motors;
}

std::string line_of(const YamlValue& value, const std::vector<LineSpec>& lines) {
  std::string name = value.text(40);
  std::vector<std::string_view> names;
  for (const LineSpec& line : lines) names.push_back(line.name);
  if (std::ranges::find(names, name) == names.end()) value.fail(unknown_name("line", name, names));
  return name;
}

// {can: LINE}: in the order of the drive's ports, the first one left out.
std::vector<std::string> other_lines_of(const YamlValue& value, const DriveKind& kind,
                                        const std::vector<LineSpec>& lines) {
  const YamlMap map = value.map();
  std::vector<std::string_view> names;
  for (const PortKind& port : kind.ports) names.push_back(port.name);
  names.erase(names.begin());
  std::vector<std::string> others(names.size());
  for (const std::string_view port : map.keys()) {
    const auto it = std::ranges::find(names, port);
    if (it == names.end()) map.fail_at_key(port, unknown_name("further port", port, names));
    others[static_cast<std::size_t>(it - names.begin())] = line_of(map[port], lines);
  }
  return others;
}

DriveSpec drive_of(const YamlMap& map, const std::vector<LineSpec>& lines) {
  DriveSpec drive;
  const YamlValue kind_name = map["drive"];
  drive.kind = kind_name.text();
  const DriveKind& kind =
      at_place(kind_name, [&]() -> const DriveKind& { return find_drive(drive.kind); });
  if (map.has("motor")) drive.motors = motors_of(map["motor"], kind);
  if (map.has("load")) drive.load = load_of(map["load"], kind);
  if (map.has("ports")) drive.other_lines = other_lines_of(map["ports"], kind, lines);
  if (map.has("lenient")) drive.lenient = map["lenient"].flag();
  return drive;
}

void check_new(const YamlValue& value, std::string_view kind, const std::string& name,
               const std::vector<std::string>& names) {
  if (std::ranges::find(names, name) != names.end()) {
    value.fail(fmt::format("two {}s named '{}'", kind, name));
  }
}

std::vector<LineSpec> lines_of(const YamlValue& value) {
  std::vector<LineSpec> lines;
  std::vector<std::string> names;
  for (const YamlValue& item : value.list(1, 16)) {
    const YamlMap map = checked_map(item, language::names(language::line_keys()));
    LineSpec line{.name = map["name"].text(40)};
    check_new(map["name"], "line", line.name, names);
    if (map.has("timing")) line.timing = timing_of(map["timing"]);
    if (map.has("baud")) line.baud = baud_of(map["baud"]);
    names.push_back(line.name);
    lines.push_back(line);
  }
  return lines;
}

std::vector<DriveSpec> drives_of(const YamlValue& value, const std::vector<LineSpec>& lines) {
  std::vector<DriveSpec> drives;
  std::vector<std::string> names;
  for (const YamlValue& item : value.list(1, 16)) {
    const YamlMap map = checked_map(item, language::names(language::drive_keys()));
    DriveSpec drive = drive_of(map, lines);
    drive.name = map["name"].text(40);
    check_new(map["name"], "drive", drive.name, names);
    names.push_back(drive.name);
    if (map.has("line")) drive.line = line_of(map["line"], lines);
    drives.push_back(std::move(drive));
  }
  return drives;
}

void refuse_beside(const YamlMap& map, std::string_view key,
                   std::initializer_list<std::string_view> others) {
  for (const std::string_view other : others) {
    if (map.has(other))
      map.fail_at_key(other, fmt::format("'{}' does not go with '{}'", other, key));
  }
}

}  // namespace

BenchOptions read_bench(const YamlValue& value) {
  const YamlMap map = checked_map(value, language::names(language::bench_keys()));
  BenchOptions options{.integrator = Integrator::kFast};
  if (map.has("integrator")) {
    options.integrator =
        map["integrator"].word({"fast", "default"}) == 0 ? Integrator::kFast : Integrator::kDefault;
  }
  if (map.has("lines")) {
    refuse_beside(map, "lines", {"line", "baud"});
    options.lines = lines_of(map["lines"]);
  } else {
    LineSpec& line = options.lines.front();
    if (map.has("line")) line.timing = timing_of(map["line"]);
    if (map.has("baud")) line.baud = baud_of(map["baud"]);
  }
  if (map.has("drives")) {
    refuse_beside(map, "drives", {"drive", "motor", "load", "set", "ports", "lenient"});
    options.drives = drives_of(map["drives"], options.lines);
  } else {
    options.drives = {drive_of(map, options.lines)};
  }
  return options;
}

void read_start_parameters(const YamlValue& value, Bench& bench, BenchOptions& options) {
  const YamlMap map = value.map();
  std::vector<YamlMap> drives;
  if (map.has("drives")) {
    for (const YamlValue& drive : map["drives"].list()) drives.push_back(drive.map());
  } else {
    drives.push_back(map);
  }
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (!drives[i].has("set")) continue;
    const YamlMap set = drives[i]["set"].map();
    for (const std::string_view name : set.keys()) {
      const std::string text = assignment(name, set[name].text());
      at_place(Place(set, name), [&] { bench.drives()[i]->controller().set_parameter(text); });
      options.drives[i].set.push_back(text);
    }
  }
}

void check_placeholders(const YamlValue& value, std::string_view command,
                        const BenchOptions& options) {
  std::vector<std::string_view> lines;
  for (const LineSpec& line : options.lines) lines.push_back(line.name);
  for (std::size_t at = 0; (at = command.find("{port", at)) != std::string_view::npos; ++at) {
    const std::size_t end = command.find('}', at);
    if (end == std::string_view::npos) value.fail("expected a } behind {port");
    const std::string_view inside = command.substr(at + 5, end - at - 5);
    if (inside.empty()) continue;
    if (inside[0] != ':') value.fail("expected {port} or {port:LINE}");
    if (std::ranges::find(lines, inside.substr(1)) == lines.end()) {
      value.fail(unknown_name("line", inside.substr(1), lines));
    }
  }
}

}  // namespace virtdrive
