#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "core/names.h"
#include "pty/host_port.h"
#include "scenarios/cli/commands.h"
#include "scenarios/host/parameter_dump.h"
#include "scenarios/output_file.h"
#include "scenarios/scenario/yaml_words.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

// The port and the words that go over it.
struct Connection {
  explicit Connection(const HostOptions& options)
      : kind(find_protocol(options.protocol)),
        transport(std::make_unique<HostPort>(
            options.port, TtySettings{.baud = options.baud.value_or(kind.ports.front().baud),
                                      .parity = options.parity})),
        pause(*transport),
        client(kind.make_host(std::move(transport))) {}

  const DriveKind& kind;
  std::unique_ptr<HostPort> transport;
  HostPort& pause;
  std::unique_ptr<HostClient> client;
};

void need(const HostOptions& options, std::size_t least, std::size_t most, std::string_view what) {
  const std::size_t count = options.arguments.size();
  if (count >= least && count <= most) return;
  throw SetupError(fmt::format("host {}: expected {}", options.action, what));
}

void show(const HostOptions& options, const std::string& name, const Reading& reading) {
  if (options.json) {
    fmt::print("{}\n",
               Json{{"name", name}, {"value", reading.value}, {"unit", reading.unit}}.dump());
  } else {
    fmt::print("{} = {} {}\n", name, reading.value, reading.unit);
  }
}

int get(const HostOptions& options) {
  need(options, 1, 1000, "the names of parameters");
  Connection drive(options);
  for (const std::string& name : options.arguments) show(options, name, drive.client->get(name));
  return kExitOk;
}

int set(const HostOptions& options) {
  need(options, 1, 1000, "NAME=VALUE[UNIT] ...");
  Connection drive(options);
  for (const std::string& assignment : options.arguments) drive.client->set(assignment);
  return kExitOk;
}

std::int64_t whole_number(const std::string& text, std::string_view digits) {
  std::int64_t value = 0;
  const char* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  if (error == std::errc{} && end == last) return value;
  throw SetupError(fmt::format("host call: {}: '{}' is not a whole number", text, digits));
}

// FIELD=VALUE ...; what is left out is 0, the motor's number that of the document's examples.
protocol::Values parse_request(const protocol::CommandRow& row, const DriveKind& kind,
                               std::span<const std::string> words) {
  const std::vector<FlatField> fields = flat_fields(row.request);
  std::vector<std::int64_t> values(fields.size(), 0);
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    names.push_back(fields[i].name);
    if (fields[i].name == "motor_nr") values[i] = static_cast<std::int64_t>(kind.default_channel);
  }
  for (const std::string& word : words) {
    const std::size_t equals = std::min(word.find('='), word.size());
    const auto it = std::ranges::find(names, std::string_view(word).substr(0, equals));
    if (it == names.end() || equals == word.size()) {
      throw SetupError(fmt::format("host call {}: {}; expected FIELD=VALUE", row.name,
                                   unknown_name("field", word.substr(0, equals), names)));
    }
    values[static_cast<std::size_t>(it - names.begin())] =
        whole_number(word, std::string_view(word).substr(equals + 1));
  }
  protocol::Values request;
  for (const std::int64_t value : values) request.push(value);
  return request;
}

int call(const HostOptions& options) {
  need(options, 1, 1 + protocol::Values::kMaximum, "COMMAND [FIELD=VALUE ...]");
  Connection drive(options);
  const std::string& name = options.arguments.front();
  const protocol::CommandRow& row = command_named(name, drive.kind.table);
  const protocol::Values reply = drive.client->call(
      name, parse_request(row, drive.kind, std::span(options.arguments).subspan(1)));
  const std::vector<FlatField> fields = flat_fields(row.reply);
  Json json = Json::object();
  for (std::size_t i = 0; i < reply.size(); ++i) {
    const std::string field = i < fields.size() ? fields[i].name : fmt::format("value{}", i + 1);
    const double value = double(reply[i]) * (i < fields.size() ? fields[i].scale : 1);
    if (options.json)
      json[field] = value;
    else
      fmt::print("{} = {} {}\n", field, value, i < fields.size() ? fields[i].unit : "");
  }
  if (options.json) fmt::print("{}\n", json.dump());
  return kExitOk;
}

int start(const HostOptions& options) {
  need(options, 1, 1, "the speed in rpm");
  Connection drive(options);
  drive.client->start_motor(options.channels.empty() ? drive.kind.default_channel
                                                     : static_cast<std::size_t>(whole_number(
                                                           "--channel", options.channels.front())),
                            double(whole_number("start", options.arguments.front())));
  return kExitOk;
}

int stop(const HostOptions& options) {
  need(options, 0, 0, "no more words");
  Connection drive(options);
  drive.client->stop_motor(options.channels.empty() ? drive.kind.default_channel
                                                    : static_cast<std::size_t>(whole_number(
                                                          "--channel", options.channels.front())));
  return kExitOk;
}

// A drive that is silent for once is told of; the watch goes on.
int watch(const HostOptions& options) {
  need(options, 1, 1000, "the names of parameters");
  Connection drive(options);
  for (std::uint64_t round = 0; options.count == 0 || round < options.count; ++round) {
    if (round > 0) drive.pause.read(std::size_t{1} << 20, from_seconds(options.every_s));
    for (const std::string& name : options.arguments) {
      try {
        show(options, name, drive.client->get(name));
      } catch (const ClientError& error) {
        fmt::print(stderr, "{}\n", error.what());
      }
    }
    std::fflush(stdout);
  }
  return kExitOk;
}

std::vector<std::string> channels_of(const HostOptions& options) {
  return options.channels.empty() ? std::vector<std::string>{""} : options.channels;
}

int dump(const HostOptions& options) {
  need(options, 0, 1, "a file, or nothing for standard output");
  Connection drive(options);
  const std::string text =
      to_yaml(dump_parameters(*drive.client, drive.kind.table, channels_of(options)));
  if (options.arguments.empty()) {
    fmt::print("{}", text);
    return kExitOk;
  }
  OutputFile file("host dump", options.arguments.front());
  file.write(text);
  file.close();
  return kExitOk;
}

ParameterDump dump_of(const std::string& path, const DriveKind& kind) {
  ParameterDump dump = read_dump(path);
  if (dump.protocol == kind.table.name) return dump;
  throw SetupError(
      fmt::format("{}: is of protocol {}, not {}", path, dump.protocol, kind.table.name));
}

int restore(const HostOptions& options) {
  need(options, 1, 1, "the file of a dump");
  const ParameterDump wanted = dump_of(options.arguments.front(), find_protocol(options.protocol));
  Connection drive(options);
  const Restored restored = restore_parameters(*drive.client, wanted);
  for (const std::string& what : restored.written) fmt::print("{}\n", what);
  for (const std::string& what : restored.unwritten) fmt::print(stderr, "not written: {}\n", what);
  fmt::print("{} written, {} as they were, {} not written\n", restored.written.size(),
             restored.unchanged, restored.unwritten.size());
  return restored.unwritten.empty() ? kExitOk : kExitFailed;
}

// The channels that the file tells of.
std::vector<std::string> channels_of(const ParameterDump& dump) {
  std::vector<std::string> channels;
  for (const auto& [name, value] : dump.settings) {
    const std::size_t dot = name.find('.');
    const std::string channel = dot == std::string::npos ? "" : name.substr(0, dot);
    if (std::ranges::find(channels, channel) == channels.end()) channels.push_back(channel);
  }
  return channels;
}

int diff(const HostOptions& options) {
  need(options, 1, 2, "the file of a dump, and a second one or else the drive");
  const ParameterDump first = read_dump(options.arguments.front());
  ParameterDump second;
  if (options.arguments.size() == 2) {
    second = read_dump(options.arguments.back());
  } else {
    Connection drive(options);
    second = dump_parameters(*drive.client, drive.kind.table, channels_of(first));
  }
  if (first.protocol != second.protocol) {
    throw SetupError(fmt::format("host diff: {} and {} have nothing in common", first.protocol,
                                 second.protocol));
  }
  const std::vector<SettingDifference> found = differences(first, second);
  for (const SettingDifference& difference : found) {
    fmt::print("{}: {} -> {}\n", difference.name, difference.first.value_or("(none)"),
               difference.second.value_or("(none)"));
  }
  return found.empty() ? kExitOk : kExitFailed;
}

struct Deed {
  std::string_view word;
  int (*run)(const HostOptions&);
};
constexpr Deed kActions[] = {{"get", get},     {"set", set},         {"call", call},
                             {"start", start}, {"stop", stop},       {"watch", watch},
                             {"dump", dump},   {"restore", restore}, {"diff", diff}};

}  // namespace

int host(const HostOptions& options) {
  const auto* const action = std::ranges::find(kActions, options.action, &Deed::word);
  if (action != std::end(kActions)) {
    try {
      return action->run(options);
    } catch (const ClientError& error) {
      fmt::print(stderr, "virtdrive: {}\n", error.what());
      return kExitFailed;
    }
  }
  std::vector<std::string_view> words;
  for (const Deed& known : kActions) words.push_back(known.word);
  throw SetupError(unknown_name("action", options.action, words));
}

}  // namespace virtdrive
