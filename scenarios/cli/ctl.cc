#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/cli/commands.h"
#include "scenarios/control/control_commands.h"
#include "scenarios/control/control_socket.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

// The words behind a request: which of them are a name, a number, a text.
struct Shape {
  std::string_view word;
  std::string_view arguments;  // n: name, v: number, t: text; in capitals: may be left out
};
constexpr Shape kShapes[] = {{"status", ""},   {"list", ""},   {"read", "n"},  {"set", "nv"},
                             {"inject", "nV"}, {"clear", "n"}, {"power", "t"}, {"reset", ""},
                             {"rate", "v"},    {"step", "v"}};

double number_of(const std::string& text) {
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc{} || end != last) {
    throw SetupError(fmt::format("ctl: '{}' is not a number", text));
  }
  return value;
}

Json request_of(const CtlOptions& options) {
  const auto* const shape = std::ranges::find(kShapes, options.word, &Shape::word);
  if (shape == std::end(kShapes)) {
    throw SetupError(unknown_name("request", options.word, ControlCommands::words()));
  }
  Json request = {{"do", options.word}};
  std::size_t next = 0;
  for (const char kind : shape->arguments) {
    const bool optional = kind == 'V';
    if (next == options.arguments.size()) {
      if (optional) break;
      throw SetupError(fmt::format("ctl {}: expected {}", options.word,
                                   kind == 'n'   ? "a name"
                                   : kind == 't' ? "on or off"
                                                 : "a number"));
    }
    const std::string& argument = options.arguments[next++];
    if (kind == 'n')
      request["name"] = argument;
    else if (kind == 't')
      request["value"] = argument;
    else
      request["value"] = number_of(argument);
  }
  if (next < options.arguments.size()) {
    throw SetupError(
        fmt::format("ctl {}: '{}' is too much", options.word, options.arguments[next]));
  }
  if (!options.drive.empty()) request["drive"] = options.drive;
  return request;
}

void show(const std::string& word, const Json& answer) {
  if (word == "read") {
    fmt::print("{} {}\n", answer["value"].dump(), answer["unit"].get<std::string>());
  } else if (word == "list") {
    for (const Json& name : answer["names"]) {
      fmt::print("{:<30} {:<8} {:<7} {}\n", name["name"].get<std::string>(),
                 name["unit"].get<std::string>(), name["kind"].get<std::string>(),
                 name["doc"].get<std::string>());
    }
  } else if (word == "status") {
    fmt::print("{}\n", answer.dump(1));
  }
}

}  // namespace

int ctl(const CtlOptions& options) {
  const std::string line = ask_control_socket(options.socket, request_of(options).dump());
  const Json answer = Json::parse(line, nullptr, false);
  if (!answer.is_object() || !answer.contains("ok")) {
    throw SetupError(fmt::format("{}: no bench of virtdrive answers there", options.socket));
  }
  if (options.json) fmt::print("{}\n", line);
  if (answer["ok"] == true) {
    if (!options.json) show(options.word, answer);
    return kExitOk;
  }
  if (!options.json) fmt::print(stderr, "virtdrive: {}\n", answer["error"].get<std::string>());
  return kExitFailed;
}

}  // namespace virtdrive
