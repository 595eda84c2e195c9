#include "scenarios/scenario/loader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/load_spec.h"
#include "scenarios/scenario/bench_reader.h"
#include "scenarios/scenario/language.h"
#include "scenarios/scenario/probe_host.h"
#include "scenarios/scenario/quantity.h"
#include "scenarios/scenario/yaml_words.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using language::Verb;

constexpr SimDuration kReadInterval = 50ms;
constexpr SimDuration kReplyPatience = 500ms;  // as the clients'
constexpr SimDuration kSilence = 100ms;
constexpr SimDuration kSampleInterval = 1ms;
constexpr std::size_t kMostSteps = 2000;
constexpr std::size_t kMostBytes = 4096;
constexpr int kDeepestRepeat = 4;

const Verb* find_verb(std::string_view name) {
  const auto it = std::ranges::find(language::verbs(), name, &Verb::name);
  return it == language::verbs().end() ? nullptr : &*it;
}

std::string joined(const std::vector<std::string>& parts) {
  return fmt::format("{}", fmt::join(parts, ", "));
}

// The step at `first` or later that has the label.
std::size_t labelled(const YamlValue& label, const std::vector<Step>& steps, std::size_t first) {
  std::vector<std::string_view> labels;
  for (std::size_t i = first; i < steps.size(); ++i) {
    if (steps[i].label.empty()) continue;
    if (steps[i].label == label.text()) return i;
    labels.push_back(steps[i].label);
  }
  label.fail(labels.empty() ? fmt::format("no later step has the label '{}'", label.text())
                            : unknown_name("label of a later step", label.text(), labels));
}

class Loader {
 public:
  explicit Loader(const YamlFile& file) : file_(file) {}

  Scenario load();

 private:
  struct Context {
    const YamlMap& map;
    const YamlValue& value;  // the verb's
    const Verb& verb;
  };
  using Reader = Action (Loader::*)(const Context&, std::string& text);

  static Reader reader_of(std::string_view verb);

  void read_head(const YamlMap& root);
  void read_record(const YamlMap& root);
  std::vector<Step> read_steps(const YamlValue& value, int depth);
  Step read_step(const YamlValue& value);
  Step read_verb(const YamlValue& value, const YamlMap* map, const Verb& verb);
  std::optional<Trigger> read_trigger(const YamlMap& map, std::string& text);
  Milestone read_milestone(const YamlValue& value, std::string& text);

  Action read_start(const Context& c, std::string& text);
  Action read_stop(const Context& c, std::string& text);
  Action read_set(const Context& c, std::string& text);
  Action read_read(const Context& c, std::string& text);
  Action read_call(const Context& c, std::string& text);
  Action read_raw(const Context& c, std::string& text);
  Action read_wait(const Context& c, std::string& text);
  Action read_expect(const Context& c, std::string& text);
  Action read_watch(const Context& c, std::string& text);
  Action read_apply(const Context& c, std::string& text);
  Action read_ramp(const Context& c, std::string& text);
  Action read_profile(const Context& c, std::string& text);
  Action read_inject(const Context& c, std::string& text);
  Action read_clear(const Context& c, std::string& text);
  Action read_power(const Context& c, std::string& text);
  Action read_reset(const Context& c, std::string& text);
  Action read_host(const Context& c, std::string& text);
  Action read_note(const Context& c, std::string& text);
  Action read_repeat(const Context& c, std::string& text);

  // Parts of steps.
  BenchDrive& drive_of(const YamlMap& map) const;
  std::size_t channel_of(const YamlMap& map, const BenchDrive& drive) const;
  ExpectedReply reply_of(const YamlMap& map, const BenchDrive& drive, std::string& text) const;
  ExpectedReply reply_of(const YamlValue& value, const BenchDrive& drive, std::string& text) const;
  Condition condition_of(const YamlValue& value) const;
  std::vector<NamedValue> inputs_of(const YamlValue& value, bool faults, std::string& text) const;
  const Input& input_named(const Place& at, std::string_view name, bool fault) const;
  double input_value(const YamlValue& value, const Input& input) const;

  const YamlFile& file_;
  Scenario scenario_;
  std::unique_ptr<Bench> bench_;  // for its names; nothing runs on it
  std::size_t count_ = 0;
  int depth_ = 0;
  std::optional<YamlValue> until_;  // of the watch that was read last
};

Scenario Loader::load() {
  const YamlValue root_value = file_.root();
  const YamlMap root = checked_map(root_value, language::names(language::file_keys()));
  read_head(root);
  scenario_.bench = read_bench(root["bench"]);
  try {
    bench_ = std::make_unique<Bench>(scenario_.bench);
  } catch (const SetupError& error) {
    root["bench"].fail(error.what());
  }
  read_start_parameters(root["bench"], *bench_, scenario_.bench);
  read_record(root);
  scenario_.steps = read_steps(root["steps"], 0);
  return std::move(scenario_);
}

void Loader::read_head(const YamlMap& root) {
  if (!root.has(language::kVersionKey)) {
    root.self().fail(
        fmt::format("{}: {} is missing: this is no scenario, or one of no known format",
                    language::kVersionKey, language::kVersion));
  }
  const YamlValue version = root[language::kVersionKey];
  if (version.integer() != language::kVersion) {
    version.fail(fmt::format("format {}; this program reads format {}", version.integer(),
                             language::kVersion));
  }
  const std::string stem = std::filesystem::path(file_.name()).stem().string();
  scenario_.file = file_.name();
  scenario_.name = root.has("name") ? root["name"].text(100) : stem;
  if (root.has("about")) scenario_.about = root["about"].text(2000);
  if (root.has("source")) scenario_.source = root["source"].text(300);
  if (root.has("seed")) {
    scenario_.seed = static_cast<std::uint64_t>(root["seed"].integer({.minimum = 0}));
  }
  if (!root.has("tags")) return;
  for (const YamlValue& tag : root["tags"].list(0, 20)) scenario_.tags.push_back(tag.text(40));
}

void Loader::read_record(const YamlMap& root) {
  scenario_.interval = kSampleInterval;
  if (!root.has("record")) return;
  const YamlMap record = checked_map(root["record"], language::names(language::record_keys()));
  if (record.has("interval")) {
    scenario_.interval = time_of(record["interval"]);
    if (scenario_.interval < 10us) record["interval"].fail("expected 10 us or more");
  }
  if (!record.has("signals")) return;
  for (const YamlValue& name : record["signals"].list(0, 40)) {
    try {
      scenario_.signals.push_back(bench_->registry().signal(name.text()).name);
    } catch (const SetupError& error) {
      name.fail(error.what());
    }
  }
}

// --- Steps ---------------------------------------------------------------------------------------

std::vector<Step> Loader::read_steps(const YamlValue& value, int depth) {
  if (depth > kDeepestRepeat)
    value.fail(fmt::format("repeated {} deep at the most", kDeepestRepeat));
  const int before = std::exchange(depth_, depth);
  std::vector<Step> steps;
  std::vector<std::pair<std::size_t, YamlValue>> untils;  // a watch, and the label that ends it
  for (const YamlValue& item : value.list(1)) {
    if (++count_ > kMostSteps) item.fail(fmt::format("more than {} steps", kMostSteps));
    steps.push_back(read_step(item));
    if (until_) untils.emplace_back(steps.size() - 1, *std::exchange(until_, std::nullopt));
  }
  for (const auto& [watch, label] : untils) {
    std::get<Watch>(steps[watch].action).until = labelled(label, steps, watch + 1);
  }
  depth_ = before;
  return steps;
}

std::vector<std::string_view> verb_names() {
  std::vector<std::string_view> names;
  for (const Verb& verb : language::verbs()) names.push_back(verb.name);
  return names;
}

Step Loader::read_step(const YamlValue& value) {
  if (value.kind() == YamlKind::kText) {
    const std::string word = value.text();
    const Verb* const verb = find_verb(word);
    if (verb == nullptr) value.fail(unknown_name("step", word, verb_names()));
    if (!verb->may_be_alone)
      value.fail(fmt::format("{0}: expected something behind it: '{0}: ...'", word));
    return read_verb(value, nullptr, *verb);
  }
  const YamlMap map = value.map();
  const Verb* verb = nullptr;
  for (const std::string_view key : map.keys()) {
    const Verb* const candidate = find_verb(key);
    if (candidate == nullptr) continue;
    if (verb != nullptr) {
      map.fail_at_key(key,
                      fmt::format("'{}' and '{}' are two steps; expected one", verb->name, key));
    }
    verb = candidate;
  }
  if (verb == nullptr) {
    if (map.keys().empty()) value.fail("an empty step");
    map.fail_at_key(map.keys().front(), unknown_name("step", map.keys().front(), verb_names()));
  }
  return read_verb(value, &map, *verb);
}

Step Loader::read_verb(const YamlValue& value, const YamlMap* map, const Verb& verb) {
  Step step{.place = value.position(),
            .verb = std::string(verb.name),
            .text = {},
            .label = {},
            .action = Note{},
            .trigger = {}};
  static const YamlFile nothing("", "{}");
  const YamlMap none = nothing.root().map();
  const YamlMap& keys = map != nullptr ? *map : none;
  if (map != nullptr) {
    std::vector<std::string_view> known = {verb.name};
    for (const auto& key : verb.keys) known.push_back(key.name);
    for (const auto& key : language::step_keys()) known.push_back(key.name);
    if (verb.may_be_triggered) {
      for (const auto& key : language::trigger_keys()) known.push_back(key.name);
    }
    check_keys(*map, known);
    if (map->has("label")) step.label = (*map)["label"].text(60);
  }
  const YamlValue behind = map != nullptr ? (*map)[verb.name] : value;
  step.text = verb.name;
  step.action = (this->*reader_of(verb.name))({keys, behind, verb}, step.text);
  if (verb.may_be_triggered) step.trigger = read_trigger(keys, step.text);
  return step;
}

Loader::Reader Loader::reader_of(std::string_view verb) {
  struct Entry {
    std::string_view verb;
    Reader reader;
  };
  static constexpr Entry kReaders[] = {
      {"start", &Loader::read_start},     {"stop", &Loader::read_stop},
      {"set", &Loader::read_set},         {"read", &Loader::read_read},
      {"call", &Loader::read_call},       {"raw", &Loader::read_raw},
      {"wait", &Loader::read_wait},       {"expect", &Loader::read_expect},
      {"always", &Loader::read_watch},    {"never", &Loader::read_watch},
      {"apply", &Loader::read_apply},     {"ramp", &Loader::read_ramp},
      {"profile", &Loader::read_profile}, {"inject", &Loader::read_inject},
      {"clear", &Loader::read_clear},     {"power", &Loader::read_power},
      {"reset", &Loader::read_reset},     {"host", &Loader::read_host},
      {"note", &Loader::read_note},       {"repeat", &Loader::read_repeat}};
  const auto* const it = std::ranges::find(kReaders, verb, &Entry::verb);
  VIRTDRIVE_CHECK(it != std::end(kReaders), "no reader for '{}'", verb);
  return it->reader;
}

// --- Triggers ------------------------------------------------------------------------------------

std::optional<Trigger> Loader::read_trigger(const YamlMap& map, std::string& text) {
  if (!map.has("when") && !map.has("at") && !map.has("after")) return std::nullopt;
  Trigger trigger;
  if (map.has("after")) {
    trigger.after = time_of(map["after"]);
    text += fmt::format(", {} after", show_time(trigger.after));
  } else {
    text += ",";
  }
  if (map.has("at")) trigger.at = read_milestone(map["at"], text);
  if (map.has("when")) {
    trigger.when = condition_of(map["when"]);
    text += fmt::format(" {} {}", trigger.at ? "while" : "when", trigger.when->text);
  }
  if (!map.has("at") && !map.has("when")) text += " this";
  return trigger;
}

Milestone Loader::read_milestone(const YamlValue& value, std::string& text) {
  const YamlMap map = checked_map(value, language::names(language::milestone_keys()));
  if (map.has("request") == map.has("reply")) value.fail("expected `request` or `reply`");
  const BenchDrive& drive = drive_of(map);
  Milestone milestone{
      .drive = drive.name(),
      .kind = map.has("request") ? Milestone::Kind::kRequest : Milestone::Kind::kReply,
      .frame = {},
      .number = 1};
  const YamlValue name = map[map.has("request") ? "request" : "reply"];
  milestone.frame = command_named(name, drive.kind().table).name;
  if (map.has("number")) {
    milestone.number =
        static_cast<std::size_t>(map["number"].integer({.minimum = 1, .maximum = 1e9}));
  }
  text += fmt::format(" at {} {} {}", name.name(), milestone.frame, milestone.number);
  return milestone;
}

// --- Parts of steps ------------------------------------------------------------------------------

BenchDrive& Loader::drive_of(const YamlMap& map) const {
  if (!map.has("drive")) return bench_->drive();
  const YamlValue value = map["drive"];
  if (bench_->drive().name().empty()) {
    value.fail("the only drive of this bench has no name; leave `drive` out");
  }
  try {
    return bench_->drive(value.text());
  } catch (const SetupError& error) {
    value.fail(error.what());
  }
}

std::size_t Loader::channel_of(const YamlMap& map, const BenchDrive& drive) const {
  if (!map.has("channel")) return drive.kind().default_channel;
  return static_cast<std::size_t>(
      map["channel"].integer({.minimum = 0, .maximum = static_cast<double>(drive.channels() - 1)}));
}

ExpectedReply Loader::reply_of(const YamlMap& map, const BenchDrive& drive,
                               std::string& text) const {
  return map.has("reply") ? reply_of(map["reply"], drive, text) : ExpectedReply{};
}

ExpectedReply Loader::reply_of(const YamlValue& value, const BenchDrive& drive,
                               std::string& text) const {
  using Kind = ExpectedReply::Kind;
  constexpr std::pair<std::string_view, Kind> kWords[] = {{"done", Kind::kDone},
                                                          {"none", Kind::kNone},
                                                          {"error", Kind::kError},
                                                          {"anything", Kind::kAnything}};
  ExpectedReply reply{.text = value.text()};
  text += fmt::format(", reply {}", reply.text);
  std::vector<std::string_view> known;
  for (const auto& [word, kind] : kWords) {
    known.push_back(word);
    reply.kind = kind;
    if (word == reply.text) return reply;
  }
  reply.kind = Kind::kCode;
  for (const protocol::CodeRow& row : drive.kind().table.errors) {
    known.push_back(row.name);
    reply.code = row.code;
    if (row.name == reply.text) return reply;
  }
  value.fail(unknown_name("reply", reply.text, known));
}

Condition Loader::condition_of(const YamlValue& value) const {
  const std::string text = value.text();
  try {
    return parse_condition(text, bench_->registry());
  } catch (const LanguageError& error) {
    fail_inside(file_.name(), value, error);
  }
}

const Input& Loader::input_named(const Place& at, std::string_view name, bool fault) const {
  std::vector<std::string_view> known;
  for (const Input& input : bench_->registry().inputs()) {
    if (input.fault != fault) continue;
    if (input.signal.name == name) return input;
    known.push_back(input.signal.name);
  }
  const std::string_view kind = fault ? "fault" : "input";
  const bool of_the_other_kind = std::ranges::any_of(
      bench_->registry().inputs(), [&](const Input& input) { return input.signal.name == name; });
  if (of_the_other_kind) {
    at.fail(fault ? fmt::format("{} is an input; use `apply`", name)
                  : fmt::format("{} is a fault; use `inject`", name));
  }
  const auto& signals = bench_->registry().signals();
  if (std::ranges::find(signals, name, &Signal::name) != signals.end()) {
    at.fail(fmt::format("{} can be read only; it follows from what the bench does", name));
  }
  if (known.empty()) at.fail(fmt::format("unknown {} '{}': this bench has none", kind, name));
  at.fail(unknown_name(kind, name, known));
}

double Loader::input_value(const YamlValue& value, const Input& input) const {
  const double number = number_of(value, input.signal.unit);
  if (!(number >= input.minimum && number <= input.maximum)) {
    value.fail(fmt::format("{}: outside of {} ... {}", show_quantity(number, input.signal.unit),
                           show_quantity(input.minimum, ""),
                           show_quantity(input.maximum, input.signal.unit)));
  }
  return number;
}

std::vector<NamedValue> Loader::inputs_of(const YamlValue& value, bool faults,
                                          std::string& text) const {
  std::vector<NamedValue> values;
  const YamlMap map = value.map();
  if (map.keys().empty()) value.fail("expected names with their values");
  std::vector<std::string> parts;
  for (const std::string_view name : map.keys()) {
    const YamlValue behind = map[name];
    const Input& input = input_named(Place(map, name), name, faults);
    values.emplace_back(name, input_value(behind, input));
    parts.push_back(fmt::format("{} {}", name, behind.text()));
  }
  text += " " + joined(parts);
  return values;
}

// --- Host steps ----------------------------------------------------------------------------------

Action Loader::read_start(const Context& c, std::string& text) {
  BenchDrive& drive = drive_of(c.map);
  StartMotor start{drive.name(), channel_of(c.map, drive), number_of(c.value, "rpm"), {}};
  if (std::abs(start.rpm) > 1e6) c.value.fail("expected at most 1e6 rpm");
  text += fmt::format(" motor {} at {}", start.channel, show_quantity(start.rpm, "rpm"));
  start.reply = reply_of(c.map, drive, text);
  return start;
}

Action Loader::read_stop(const Context& c, std::string& text) {
  if (c.value.kind() != YamlKind::kNothing &&
      !(c.value.kind() == YamlKind::kText && c.value.text() == "stop")) {
    c.value.fail("stop: expected nothing behind it; `channel: 2` stands beside it");
  }
  BenchDrive& drive = drive_of(c.map);
  StopMotor stop{drive.name(), channel_of(c.map, drive), {}};
  text += fmt::format(" motor {}", stop.channel);
  stop.reply = reply_of(c.map, drive, text);
  return stop;
}

Action Loader::read_set(const Context& c, std::string& text) {
  BenchDrive& drive = drive_of(c.map);
  SetParameters set{drive.name(), {}, {}};
  const YamlMap map = c.value.map();
  if (map.keys().empty()) c.value.fail("expected parameters with their values");
  std::vector<std::string> parts;
  for (const std::string_view name : map.keys()) {
    const std::string value = map[name].text();
    set.assignments.push_back(assignment(name, value));
    check_words(Place(map, name), drive,
                [&](HostClient& host) { host.set(set.assignments.back()); });
    parts.push_back(fmt::format("{} {}", name, value));
  }
  text += " " + joined(parts);
  set.reply = reply_of(c.map, drive, text);
  return set;
}

Action Loader::read_read(const Context& c, std::string& text) {
  BenchDrive& drive = drive_of(c.map);
  const std::string what = c.value.text();
  const std::size_t space = std::min(what.find(' '), what.size());
  ReadParameter read{.drive = drive.name(),
                     .parameter = what.substr(0, space),
                     .wanted = {},
                     .unit = {},
                     .every = kReadInterval,
                     .reply = {}};
  text += fmt::format(" {}", what);
  check_words(c.value, drive, [&](HostClient& host) { host.get(read.parameter); });
  const std::size_t behind = what.find_first_not_of(' ', space);
  if (behind != std::string::npos) {
    read.unit = unit_written(std::string_view(what).substr(behind));
    check_unit(c.value, drive.kind().table, read.parameter, read.unit);
    try {
      read.wanted = parse_predicate(std::string_view(what).substr(behind), {.unit = read.unit});
    } catch (const LanguageError& error) {
      fail_inside(file_.name(), c.value, LanguageError(error.what(), error.at() + behind));
    }
  }
  for (const std::string_view key : {"within", "every"}) {
    if (!c.map.has(key)) continue;
    if (!read.wanted)
      c.map.fail_at_key(key, fmt::format("{} goes with a comparison: NAME = 6", key));
    (key == "within" ? read.within : read.every) = time_of(c.map[key]);
  }
  if (read.every < 1ms) c.map["every"].fail("expected 1 ms or more");
  if (c.map.has("within")) text += fmt::format(" within {}", show_time(read.within));
  read.reply = reply_of(c.map, drive, text);
  if (read.wanted && read.reply.kind != ExpectedReply::Kind::kDone) {
    c.map.fail_at_key("reply", "a reading that is compared has to be answered");
  }
  return read;
}

Action Loader::read_call(const Context& c, std::string& text) {
  BenchDrive& drive = drive_of(c.map);
  const protocol::CommandRow& row = command_named(c.value, drive.kind().table);
  CallCommand call{
      .drive = drive.name(), .command = c.value.text(), .request = {}, .fields = {}, .reply = {}};
  text += fmt::format(" {}", call.command);
  const auto request = flat_fields(row.request);
  const auto reply = flat_fields(row.reply);
  std::vector<std::int64_t> values(request.size(), 0);
  for (std::size_t i = 0; i < request.size(); ++i) {
    if (request[i].name == "motor_nr") {
      values[i] = static_cast<std::int64_t>(drive.kind().default_channel);
    }
  }
  if (c.map.has("with")) {
    const YamlMap with = c.map["with"].map();
    std::vector<std::string> parts;
    for (const std::string_view name : with.keys()) {
      const std::size_t i = field_named(Place(with, name), request, name);
      values[i] = with[name].integer();
      parts.push_back(fmt::format("{} {}", name, values[i]));
    }
    text += " " + joined(parts);
  }
  for (const std::int64_t value : values) call.request.push(value);
  for (std::size_t i = 0; i < reply.size(); ++i) {
    call.fields.push_back({reply[i].name, i, reply[i].scale, std::string(reply[i].unit), {}});
  }
  check_words(c.value, drive, [&](HostClient& host) { host.call(call.command, call.request); });
  if (!c.map.has("reply")) return call;
  const YamlValue wanted = c.map["reply"];
  if (wanted.kind() != YamlKind::kMap) {
    call.reply = reply_of(wanted, drive, text);
    return call;
  }
  const YamlMap fields = wanted.map();
  std::vector<std::string> parts;
  for (const std::string_view name : fields.keys()) {
    CallCommand::Field& field = call.fields[field_named(Place(fields, name), reply, name)];
    const YamlValue value = fields[name];
    const std::string predicate = value.text();
    try {
      field.wanted = parse_predicate(predicate, {.unit = field.unit});
    } catch (const LanguageError& error) {
      fail_inside(file_.name(), value, error);
    }
    parts.push_back(fmt::format("{} {}", name, predicate));
  }
  text += fmt::format(", reply {}", joined(parts));
  return call;
}

Action Loader::read_raw(const Context& c, std::string& text) {
  SendRaw raw{.drive = drive_of(c.map).name(), .parts = {}, .reply = {}};
  std::vector<YamlValue> items;
  if (c.value.kind() == YamlKind::kList)
    items = c.value.list(1);
  else
    items.push_back(c.value);
  SimDuration pause{};
  std::size_t count = 0;
  for (const YamlValue& item : items) {
    const std::string part = item.text(3 * kMostBytes);
    text += " " + part;
    if (const auto time = parse_time(part); time && !parse_bytes(part)) {
      pause += *time;
      continue;
    }
    const auto bytes = parse_bytes(part);
    if (!bytes)
      item.fail(fmt::format("'{}': expected bytes as 11 02 0a, or a pause as 20 ms", part));
    SendRaw::Part& sent = raw.parts.emplace_back(SendRaw::Part{std::exchange(pause, {}), {}});
    for (const auto& byte : *bytes) {
      if (!byte) item.fail("?? stands in replies only");
      sent.bytes.push_back(*byte);
    }
    count += sent.bytes.size();
    if (count > kMostBytes) item.fail(fmt::format("more than {} bytes", kMostBytes));
  }
  if (raw.parts.empty()) c.value.fail("expected bytes: 11 02 0a");
  raw.within = kReplyPatience;
  if (c.map.has("reply")) {
    raw.judged = true;
    const YamlValue value = c.map["reply"];
    const std::string reply = value.text(3 * kMostBytes);
    text += fmt::format(", reply {}", reply);
    if (reply == "none") {
      raw.within = kSilence;
    } else {
      const auto bytes = parse_bytes(reply);
      if (!bytes) value.fail(fmt::format("'{}': expected bytes as 11 02 ??, or none", reply));
      raw.reply = *bytes;
    }
  }
  if (c.map.has("within")) {
    if (!raw.judged) c.map.fail_at_key("within", "within goes with a reply");
    raw.within = time_of(c.map["within"]);
  }
  return raw;
}

// --- Time, conditions ----------------------------------------------------------------------------

Action Loader::read_wait(const Context& c, std::string& text) {
  const std::string what = c.value.text();
  text += " " + what;
  if (const auto time = parse_time(what)) {
    if (c.map.has("within")) c.map.fail_at_key("within", "within goes with a condition");
    return WaitFor{*time};
  }
  if (parse_quantity(what)) c.value.fail(time_message(what));
  WaitUntil wait{condition_of(c.value), {}};
  if (!c.map.has("within")) {
    c.value.fail("a wait for a condition needs a limit: `within: 2 s`");
  }
  wait.within = time_of(c.map["within"]);
  text += fmt::format(" within {}", show_time(wait.within));
  return wait;
}

Action Loader::read_expect(const Context& c, std::string& text) {
  Expect expect{condition_of(c.value), {}, {}};
  text += " " + expect.condition.text;
  if (c.map.has("within")) {
    expect.within = time_of(c.map["within"]);
    text += fmt::format(" within {}", show_time(expect.within));
  }
  if (c.map.has("for")) {
    expect.hold = time_of(c.map["for"]);
    text += fmt::format(" for {}", show_time(expect.hold));
  }
  return expect;
}

Action Loader::read_watch(const Context& c, std::string& text) {
  Watch watch{condition_of(c.value), c.verb.name == "never", std::nullopt};
  text += " " + watch.condition.text;
  if (c.map.has("until")) {
    const YamlValue label = c.map["until"];
    text += fmt::format(" until '{}'", label.text(60));
    until_ = label;
  }
  return watch;
}

// --- The bench -----------------------------------------------------------------------------------

Action Loader::read_apply(const Context& c, std::string& text) {
  Apply apply{.inputs = inputs_of(c.value, false, text), .lasts = {}};
  if (c.map.has("for")) {
    apply.lasts = time_of(c.map["for"]);
    text += fmt::format(" for {}", show_time(*apply.lasts));
  }
  return apply;
}

bool background_of(const YamlMap& map) {
  return map.has("background") && map["background"].flag();
}

Action Loader::read_ramp(const Context& c, std::string& text) {
  Ramp ramp{inputs_of(c.value, false, text), {}, background_of(c.map)};
  if (!c.map.has("over")) c.value.fail("a ramp needs its time: `over: 2 s`");
  ramp.over = time_of(c.map["over"]);
  text += fmt::format(" over {}", show_time(ramp.over));
  return ramp;
}

Action Loader::read_profile(const Context& c, std::string& text) {
  const std::string name = c.value.text();
  const Input& input = input_named(c.value, name, false);
  Profile profile{
      .input = name, .points = {}, .linear = true, .repeat = 1, .background = background_of(c.map)};
  if (!c.map.has("points")) c.value.fail("a profile needs its points: [[0 s, 0 Nm], [1 s, 1 Nm]]");
  for (const YamlValue& point : c.map["points"].list(2, 10'000)) {
    const auto pair = point.list(2, 2);
    const SimDuration at = time_of(pair[0]);
    if (profile.points.empty() ? at != SimDuration{} : at <= profile.points.back().at) {
      pair[0].fail(profile.points.empty() ? "the first point is at 0 s"
                                          : "a point's time is later than the one's before");
    }
    profile.points.push_back({at, input_value(pair[1], input)});
  }
  if (c.map.has("shape")) profile.linear = c.map["shape"].word({"linear", "steps"}) == 0;
  if (c.map.has("times")) {
    profile.repeat =
        static_cast<std::size_t>(c.map["times"].integer({.minimum = 1, .maximum = 1e6}));
  }
  text += fmt::format(" {}, {} points over {}, {} time{}", name, profile.points.size(),
                      show_time(profile.points.back().at), profile.repeat,
                      profile.repeat == 1 ? "" : "s");
  return profile;
}

Action Loader::read_inject(const Context& c, std::string& text) {
  Inject inject;
  if (c.value.kind() == YamlKind::kText) {
    const std::string name = c.value.text();
    inject.faults.emplace_back(input_named(c.value, name, true).signal.name, 1);
    text += " " + name;
  } else {
    inject.faults = inputs_of(c.value, true, text);
  }
  if (c.map.has("for")) {
    inject.lasts = time_of(c.map["for"]);
    text += fmt::format(" for {}", show_time(*inject.lasts));
  }
  return inject;
}

Action Loader::read_clear(const Context& c, std::string& text) {
  Clear clear;
  std::vector<YamlValue> names;
  if (c.value.kind() == YamlKind::kList)
    names = c.value.list(1);
  else
    names.push_back(c.value);
  for (const YamlValue& value : names) {
    const std::string name = value.text();
    text += " " + name;
    if (name == "all" && names.size() == 1) return clear;
    clear.faults.push_back(input_named(value, name, true).signal.name);
  }
  return clear;
}

Action Loader::read_power(const Context& c, std::string& text) {
  Power power{drive_of(c.map).name(), c.value.word({"off", "on"}) == 1, {}};
  text += power.on ? " on" : " off";
  if (c.map.has("for")) {
    power.lasts = time_of(c.map["for"]);
    text += fmt::format(" for {}", show_time(*power.lasts));
  }
  return power;
}

Action Loader::read_reset(const Context& c, std::string&) {
  if (c.value.kind() != YamlKind::kNothing &&
      !(c.value.kind() == YamlKind::kText && c.value.text() == "reset")) {
    c.value.fail("reset: expected nothing behind it; `drive: NAME` stands beside it");
  }
  return Reset{drive_of(c.map).name()};
}

Action Loader::read_host(const Context& c, std::string& text) {
  RunHost host{.command = c.value.text(), .timeout = 30s, .rate = 1, .exit_code = 0, .output = {}};
  text += " " + host.command;
  check_placeholders(c.value, host.command, scenario_.bench);
  if (c.map.has("timeout")) {
    host.timeout = time_of(c.map["timeout"]);
    if (host.timeout <= SimDuration{}) c.map["timeout"].fail("expected more than 0 s");
  }
  if (c.map.has("rate")) host.rate = c.map["rate"].number({.minimum = 1e-3, .maximum = 1e3});
  if (c.map.has("exit")) {
    host.exit_code = static_cast<int>(c.map["exit"].integer({.minimum = 0, .maximum = 255}));
  }
  if (c.map.has("output")) host.output = c.map["output"].text();
  return host;
}

Action Loader::read_note(const Context& c, std::string& text) {
  text = c.value.text(300);
  return Note{};
}

Action Loader::read_repeat(const Context& c, std::string& text) {
  Repeat repeat{static_cast<std::size_t>(c.value.integer({.minimum = 1, .maximum = 10'000'000})),
                {}};
  if (!c.map.has("steps")) c.value.fail("repeat needs its steps");
  text += fmt::format(" {} times", repeat.count);
  repeat.steps = read_steps(c.map["steps"], depth_ + 1);
  return repeat;
}

}  // namespace

Scenario load_scenario(const std::string& path) {
  return Loader(YamlFile::read(path)).load();
}

Scenario parse_scenario(const std::string& name, std::string_view text) {
  return Loader(YamlFile(name, text)).load();
}

}  // namespace virtdrive
