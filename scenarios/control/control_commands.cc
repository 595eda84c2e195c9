#include "scenarios/control/control_commands.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

struct Context {
  Bench& bench;
  Runner& runner;
  const Json& request;
};

std::string text_of(const Json& request, const char* key) {
  if (!request.contains(key) || !request[key].is_string()) {
    throw SetupError(fmt::format("\"{}\": expected a text", key));
  }
  return request[key];
}

double number_of(const Json& request, const char* key, double low, double high) {
  if (!request.contains(key) || !request[key].is_number()) {
    throw SetupError(fmt::format("\"{}\": expected a number", key));
  }
  const double value = request[key];
  if (!(value >= low && value <= high)) {
    throw SetupError(fmt::format("\"{}\": {} is not {} ... {}", key, value, low, high));
  }
  return value;
}

BenchDrive& drive_of(const Context& c) {
  return c.request.contains("drive") ? c.bench.drive(text_of(c.request, "drive")) : c.bench.drive();
}

// JSON has no infinity.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json read(const Context& c) {
  const Signal& signal = c.bench.registry().signal(text_of(c.request, "name"));
  return {{"value", number(signal.read())}, {"unit", signal.unit}};
}

Json set(const Context& c) {
  constexpr double kMost = 1e300;
  c.bench.set(text_of(c.request, "name"), number_of(c.request, "value", -kMost, kMost));
  return Json::object();
}

Json inject(const Context& c) {
  const double severity = c.request.contains("value") ? number_of(c.request, "value", 0, 1e12) : 1;
  c.bench.registry().inject(text_of(c.request, "name"), severity);
  return Json::object();
}

Json clear(const Context& c) {
  const std::string name = text_of(c.request, "name");
  if (name == "all")
    c.bench.registry().clear_faults();
  else
    c.bench.registry().clear(name);
  return Json::object();
}

Json power(const Context& c) {
  const std::string value = text_of(c.request, "value");
  if (value != "on" && value != "off") throw SetupError("\"value\": expected \"on\" or \"off\"");
  if (value == "on")
    drive_of(c).power_on();
  else
    drive_of(c).power_off();
  return Json::object();
}

Json reset(const Context& c) {
  drive_of(c).reset();
  return Json::object();
}

Json rate(const Context& c) {
  if (!c.runner.set_rate(number_of(c.request, "value", 0, 1000))) {
    throw SetupError("a run with --rate max has no rate to be changed");
  }
  return {{"rate", c.runner.rate()}};
}

Json step(const Context& c) {
  constexpr double kLongest = 1e6;
  const double s = number_of(c.request, "value", 0, kLongest);
  if (!c.runner.step(from_seconds(s))) throw SetupError("step: stand still first: rate 0");
  return Json::object();
}

Json list(const Context& c) {
  Json names = Json::array();
  const auto& inputs = c.bench.registry().inputs();
  for (const Signal& signal : c.bench.registry().signals()) {
    const auto it = std::ranges::find(inputs, signal.name,
                                      [](const Input& input) { return input.signal.name; });
    names.push_back({{"name", signal.name},
                     {"unit", signal.unit},
                     {"kind", it == inputs.end() ? "signal"
                              : it->fault        ? "fault"
                                                 : "input"},
                     {"doc", signal.doc}});
  }
  return {{"names", names}};
}

Json status(const Context& c) {
  Json drives = Json::array();
  for (const auto& drive : c.bench.drives()) {
    const WireCounters wire = drive->controller().wire_counters();
    drives.push_back({{"name", drive->name()},
                      {"kind", drive->kind().name},
                      {"powered", drive->powered()},
                      {"status", drive->controller().status()},
                      {"requests", wire.requests},
                      {"replies", wire.replies},
                      {"bad_frames", wire.bad_frames},
                      {"bytes_lost", wire.bytes_lost}});
  }
  Json faults = Json::object();
  for (const Input& input : c.bench.registry().inputs()) {
    if (!input.fault) continue;
    const double value = input.signal.read();
    if (value != 0) faults[input.signal.name] = number(value);
  }
  Json signals = Json::object();
  for (const Signal& signal : c.bench.registry().signals()) {
    signals[signal.name] = number(signal.read());
  }
  return {{"rate", c.runner.rate()},
          {"seed", c.bench.seed()},
          {"drives", drives},
          {"faults", faults},
          {"signals", signals}};
}

struct Command {
  std::string_view word;
  Json (*run)(const Context&);
};
constexpr Command kCommands[] = {
    {"status", status}, {"list", list},   {"read", read},   {"set", set},   {"inject", inject},
    {"clear", clear},   {"power", power}, {"reset", reset}, {"rate", rate}, {"step", step}};

Json carry_out(const Context& c) {
  const std::string word = text_of(c.request, "do");
  const auto* const it = std::ranges::find(kCommands, word, &Command::word);
  if (it == std::end(kCommands)) {
    throw SetupError(unknown_name("request", word, ControlCommands::words()));
  }
  return it->run(c);
}

}  // namespace

std::vector<std::string_view> ControlCommands::words() {
  std::vector<std::string_view> words;
  for (const Command& command : kCommands) words.push_back(command.word);
  return words;
}

std::string ControlCommands::answer(std::string_view text) {
  const Json request = Json::parse(text, nullptr, false);
  Json reply = Json::object();
  if (request.is_object() && request.contains("id")) reply["id"] = request["id"];
  try {
    if (!request.is_object()) throw SetupError("expected a JSON object in a line");
    const Json result = carry_out({bench_, runner_, request});
    reply["ok"] = true;
    reply["time_s"] = seconds(bench_.loop().now());
    reply.update(result);
  } catch (const SetupError& error) {
    reply["ok"] = false;
    reply["error"] = error.what();
  }
  return reply.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace virtdrive
