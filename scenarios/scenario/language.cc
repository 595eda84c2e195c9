#include "scenarios/scenario/language.h"

namespace virtdrive::language {
namespace {

constexpr Key kDrive{"drive", Shape::kText, "The drive's name, where the bench has several"};
constexpr Key kChannel{"channel", Shape::kCount, "The motor's number; the drive's own if left out"};
constexpr Key kReply{
    "reply", Shape::kReply,
    "What the drive has to answer: done (if left out), none, error, the name of an "
    "error, anything"};
constexpr Key kBackground{"background", Shape::kFlag, "true: the next step does not wait for it"};

}  // namespace

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> table = {
      {"start",
       Shape::kQuantity,
       "Sets the speed and starts a motor",
       {kChannel, kDrive, kReply},
       false,
       false},
      {"stop", Shape::kNothing, "Stops a motor", {kChannel, kDrive, kReply}, false, true},
      {"set",
       Shape::kParameters,
       "Writes parameters, one request each",
       {kDrive, kReply},
       false,
       false},
      {"read",
       Shape::kCondition,
       "Reads a parameter; with a comparison it has to be so",
       {{"within", Shape::kTime, "Reads again and again until it is so, at most for so long"},
        {"every", Shape::kTime, "Between two readings (50 ms)"},
        kDrive,
        kReply},
       false,
       false},
      {"call",
       Shape::kText,
       "Sends a command of the protocol",
       {{"with", Shape::kNames, "The request's fields; those left out are 0"},
        {"reply", Shape::kReply, "As above, or the reply's fields with what they have to be"},
        kDrive},
       false,
       false},
      {"raw",
       Shape::kAny,
       "Sends bytes as they are: hexadecimal, or a list of bytes and pauses",
       {{"reply", Shape::kText, "The answer byte for byte; ?? is any byte; none is silence"},
        {"within", Shape::kTime, "For the whole answer, or for the silence (500 ms, 100 ms)"},
        kDrive},
       false,
       false},
      {"wait",
       Shape::kAny,
       "Lets time pass: so long, or until a condition holds",
       {{"within", Shape::kTime, "A condition has to hold within this time"}},
       false,
       false},
      {"expect",
       Shape::kCondition,
       "A condition has to hold",
       {{"within", Shape::kTime, "It may take so long to come true"},
        {"for", Shape::kTime, "It has to stay so, without a break"}},
       false,
       false},
      {"always",
       Shape::kCondition,
       "From here on a condition has to hold",
       {{"until", Shape::kText, "Ends when the step with this label begins"}},
       false,
       false},
      {"never",
       Shape::kCondition,
       "From here on a condition must not hold",
       {{"until", Shape::kText, "Ends when the step with this label begins"}},
       false,
       false},
      {"apply",
       Shape::kNames,
       "Gives inputs of the bench a value",
       {{"for", Shape::kTime, "Then what was before comes back"}},
       true,
       false},
      {"ramp",
       Shape::kNames,
       "Moves inputs steadily to a value",
       {{"over", Shape::kTime, "So long"}, kBackground},
       true,
       false},
      {"profile",
       Shape::kText,
       "Moves an input through points",
       {{"points", Shape::kPoints, "[time, value] each, from 0 s on, growing"},
        {"shape", Shape::kText, "linear (if left out) or steps"},
        {"times", Shape::kCount, "So often one after the other"},
        kBackground},
       true,
       false},
      {"inject",
       Shape::kAny,
       "Makes a fault be there: a name, or names with their severity",
       {{"for", Shape::kTime, "Then it goes"}},
       true,
       false},
      {"clear", Shape::kAny, "Makes a fault go: a name, a list, or all", {}, true, false},
      {"power",
       Shape::kOnOff,
       "Switches a drive's supply of its electronics",
       {{"for", Shape::kTime, "Then the other way round"}, kDrive},
       true,
       false},
      {"reset", Shape::kNothing, "Starts a drive's controller anew", {kDrive}, true, true},
      {"host",
       Shape::kText,
       "Runs a program of yours at the bench's terminals, paced by the clock",
       {{"timeout", Shape::kTime, "Of real time (30 s)"},
        {"rate", Shape::kQuantity, "Simulated seconds per second (1)"},
        {"exit", Shape::kCount, "The exit code that it has to have (0)"},
        {"output", Shape::kText, "A text that it has to print"}},
       false,
       false},
      {"note", Shape::kText, "A line for the report", {}, true, false},
      {"repeat",
       Shape::kCount,
       "Does steps again and again",
       {{"steps", Shape::kSteps, "The steps"}},
       false,
       false},
  };
  return table;
}

const std::vector<Key>& step_keys() {
  static const std::vector<Key> keys = {
      {"label", Shape::kText, "A name for the step, for reports and for `until`"}};
  return keys;
}

const std::vector<Key>& trigger_keys() {
  static const std::vector<Key> keys = {
      {"when", Shape::kCondition, "Not now but as soon as this holds"},
      {"at", Shape::kMilestone, "Not now but at a frame on the line"},
      {"after", Shape::kTime, "So long later"}};
  return keys;
}

const std::vector<Key>& file_keys() {
  static const std::vector<Key> keys = {
      {kVersionKey, Shape::kCount, "The version of this language: 1"},
      {"name", Shape::kText, "What is shown, in a few words"},
      {"about", Shape::kText, "What is shown and why, in a sentence or more"},
      {"source", Shape::kText, "Where it stands that the drive does so"},
      {"tags", Shape::kList, "Words to choose scenarios by; 'long' is left out unless asked for"},
      {"seed", Shape::kCount, "Of all noise, unless --seed says otherwise"},
      {"bench", Shape::kAny, "The bench"},
      {"record", Shape::kAny, "What the report plots beside what the steps name"},
      {"steps", Shape::kSteps, "What is done, one after the other"}};
  return keys;
}

const std::vector<Key>& drive_keys() {
  static const std::vector<Key> keys = {
      {"name", Shape::kText, "Goes before the names of its signals"},
      {"drive", Shape::kText, "The kind of drive"},
      {"line", Shape::kText, "The line it hangs on"},
      {"ports", Shape::kNames, "Lines at its further ports: {ttl232: second, can: bus}"},
      {"motor", Shape::kAny, "The motor, or a list with one a channel"},
      {"load", Shape::kLoad, "The load: as --load, or kinds with their values"},
      {"set", Shape::kParameters, "Parameters that it starts with"},
      {"lenient", Shape::kFlag, "Forgives a host what a real drive does not"}};
  return keys;
}

const std::vector<Key>& line_keys() {
  static const std::vector<Key> keys = {
      {"name", Shape::kText, "Its name"},
      {"timing", Shape::kText, "real, or ideal: characters take no time"},
      {"baud", Shape::kCount, "Baud rate, if not the drive's own"}};
  return keys;
}

const std::vector<Key>& bench_keys() {
  static const std::vector<Key> keys = [] {
    std::vector<Key> all = {
        {"drives", Shape::kAny, "Several drives; instead of `drive` and what belongs to it"},
        {"lines", Shape::kAny, "Several lines; instead of `line` and `baud`"},
        {"baud", Shape::kCount, "Baud rate, if not the drive's own"},
        {"integrator", Shape::kText, "fast (if left out) or default, which errs less"}};
    for (const Key& key : drive_keys()) {
      if (key.name == "name" || key.name == "line") continue;
      all.push_back(key);
    }
    all.push_back({"line", Shape::kText, "real (if left out), or ideal: characters take no time"});
    return all;
  }();
  return keys;
}

const std::vector<Key>& record_keys() {
  static const std::vector<Key> keys = {{"signals", Shape::kList, "Names of signals"},
                                        {"interval", Shape::kTime, "Between two samples (1 ms)"}};
  return keys;
}

const std::vector<Key>& milestone_keys() {
  static const std::vector<Key> keys = {
      {"request", Shape::kText, "A command that the drive hears"},
      {"reply", Shape::kText, "A command whose answer it begins to send"},
      {"number", Shape::kCount, "The first (if left out), second, ..."},
      kDrive};
  return keys;
}

std::vector<std::string_view> names(const std::vector<Key>& keys) {
  std::vector<std::string_view> names;
  for (const Key& key : keys) names.push_back(key.name);
  return names;
}

}  // namespace virtdrive::language
