#include "scenarios/recording/bench_description.h"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "scenarios/recording/wire_format.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kLowestBaud = 50;
constexpr std::int64_t kHighestBaud = 12'000'000;

// Reads an object's members by name and knows at the end which were not asked for.
class Reader {
 public:
  Reader(const Json& json, std::string_view where) : where_(where), json_(json) {
    if (!json_.is_object()) fail("is no description of a bench");
  }

  const Json* member(const char* name) {
    const auto it = json_.find(name);
    if (it == json_.end()) return nullptr;
    known_.push_back(name);
    return &*it;
  }
  const Json& required(const char* name) {
    const Json* const value = member(name);
    if (value == nullptr) fail(fmt::format("lacks '{}'", name));
    return *value;
  }
  std::string text(const char* name) {
    const Json& value = required(name);
    if (!value.is_string()) fail(fmt::format("'{}' is no text", name));
    return value.get<std::string>();
  }
  std::string choice(const char* name, std::string_view a, std::string_view b) {
    const std::string value = text(name);
    if (value != a && value != b) fail(fmt::format("'{}' is neither {} nor {}", name, a, b));
    return value;
  }
  bool flag(const char* name) {
    const Json& value = required(name);
    if (!value.is_boolean()) fail(fmt::format("'{}' is neither true nor false", name));
    return value.get<bool>();
  }
  std::int64_t number(const char* name, std::int64_t minimum, std::int64_t maximum) {
    const Json& value = required(name);
    const bool small = value.is_number_integer() &&
                       (!value.is_number_unsigned() || value.get<std::uint64_t>() <= INT64_MAX);
    if (!small || value.get<std::int64_t>() < minimum || value.get<std::int64_t>() > maximum) {
      fail(fmt::format("'{}' is no number {} ... {}", name, minimum, maximum));
    }
    return value.get<std::int64_t>();
  }
  std::uint64_t seed(const char* name) {
    const Json& value = required(name);
    if (!value.is_number_unsigned()) fail(fmt::format("'{}' is no seed", name));
    return value.get<std::uint64_t>();
  }
  std::vector<std::string> texts(const char* name) {
    const Json& values = required(name);
    const auto is_text = [](const Json& value) { return value.is_string(); };
    if (!values.is_array() || !std::ranges::all_of(values, is_text)) {
      fail(fmt::format("'{}' is no list of texts", name));
    }
    return values.get<std::vector<std::string>>();
  }
  const Json& objects(const char* name) {
    const Json& values = required(name);
    if (!values.is_array() || values.empty()) fail(fmt::format("'{}' is no list", name));
    return values;
  }
  void no_others() {
    for (const auto& [name, value] : json_.items()) {
      if (std::ranges::find(known_, name) == known_.end()) {
        fail(fmt::format("has '{}', which this version does not know", name));
      }
    }
  }

 private:
  [[noreturn]] void fail(std::string_view what) const {
    throw SetupError(fmt::format("{}: the bench's description {}", where_, what));
  }

  std::string_view where_;
  const Json& json_;
  std::vector<std::string> known_;
};

LineSpec parse_line(const Json& json, std::string_view where) {
  Reader reader(json, where);
  LineSpec line;
  line.name = reader.text("name");
  line.timing =
      reader.choice("timing", "real", "ideal") == "ideal" ? LineTiming::kIdeal : LineTiming::kReal;
  line.baud = static_cast<int>(reader.number("baud", kLowestBaud, kHighestBaud));
  line.duplex = reader.choice("duplex", "full", "half") == "half" ? Duplex::kHalf : Duplex::kFull;
  line.echo = reader.flag("echo");
  reader.no_others();
  return line;
}

DriveSpec parse_drive(const Json& json, std::string_view where) {
  Reader reader(json, where);
  DriveSpec drive;
  drive.kind = reader.text("kind");
  drive.name = reader.text("name");
  drive.line = reader.text("line");
  drive.other_lines = reader.texts("other_lines");
  drive.motors = reader.texts("motors");
  drive.load = reader.text("load");
  drive.set = reader.texts("set");
  drive.lenient = reader.flag("lenient");
  reader.no_others();
  return drive;
}

}  // namespace

std::string describe(const RecordedBench& bench) {
  const BenchOptions& options = bench.options;
  if (!options.supplies.empty()) {
    throw SetupError("a recording of the wire cannot describe supplies that drives share");
  }
  Json lines = Json::array();
  for (const LineSpec& line : options.lines) {
    lines.push_back({{"name", line.name},
                     {"timing", line.timing == LineTiming::kIdeal ? "ideal" : "real"},
                     {"baud", line.baud.value_or(0)},
                     {"duplex", line.duplex == Duplex::kHalf ? "half" : "full"},
                     {"echo", line.echo}});
  }
  Json drives = Json::array();
  for (const DriveSpec& drive : options.drives) {
    drives.push_back({{"kind", drive.kind},
                      {"name", drive.name},
                      {"line", drive.line},
                      {"other_lines", drive.other_lines},
                      {"motors", drive.motors},
                      {"load", drive.load},
                      {"set", drive.set},
                      {"lenient", drive.lenient}});
  }
  Json json = {{"virtdrive", wire_format::kVersion},
               {"seed", options.seed},
               {"integrator", options.integrator == Integrator::kFast ? "fast" : "default"},
               {"lines", lines},
               {"drives", drives}};
  if (!bench.signals.empty()) {
    json["signals"] = bench.signals;
    json["interval_ns"] = bench.interval.count();
  }
  return json.dump();
}

RecordedBench parse_bench(std::string_view text, std::string_view where) {
  const Json json = Json::parse(text, nullptr, false);
  Reader reader(json, where);
  reader.number("virtdrive", wire_format::kVersion, wire_format::kVersion);
  RecordedBench bench;
  BenchOptions& options = bench.options;
  options.seed = reader.seed("seed");
  options.integrator = reader.choice("integrator", "default", "fast") == "fast"
                           ? Integrator::kFast
                           : Integrator::kDefault;
  options.lines.clear();
  for (const Json& line : reader.objects("lines")) options.lines.push_back(parse_line(line, where));
  for (const Json& drive : reader.objects("drives")) {
    options.drives.push_back(parse_drive(drive, where));
  }
  if (reader.member("signals") != nullptr) {
    bench.signals = reader.texts("signals");
    bench.interval = SimDuration{reader.number("interval_ns", 1000, 1'000'000'000'000)};
  }
  reader.no_others();
  return bench;
}

}  // namespace virtdrive
