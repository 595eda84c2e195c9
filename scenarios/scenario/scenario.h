// A scenario as it was read from its file: a bench and what is done with it, step by step. All that
// a file can get wrong has been checked: the names and units of signals, inputs, faults, parameters
// and commands exist on this bench.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/yaml_reader.h"
#include "devices/protocol/payload.h"
#include "scenarios/bench.h"
#include "scenarios/scenario/condition.h"

namespace virtdrive {

/// What a host step wants of the drive.
struct ExpectedReply {
  enum class Kind {
    kDone,     // an answer that is no error
    kNone,     // silence
    kError,    // any error
    kCode,     // this error
    kAnything  // it may do as it likes
  };
  Kind kind = Kind::kDone;
  std::int64_t code = 0;
  std::string text = "done";
};

using NamedValue = std::pair<std::string, double>;  // in the name's own unit

// --- What a step does ----------------------------------------------------------------------------

struct StartMotor {
  std::string drive;
  std::size_t channel;
  double rpm;
  ExpectedReply reply;
};
struct StopMotor {
  std::string drive;
  std::size_t channel;
  ExpectedReply reply;
};
struct SetParameters {
  std::string drive;
  std::vector<std::string> assignments;  // "1.IqStart=1200mA"
  ExpectedReply reply;
};
/// Reads once, or again and again until the value is right.
struct ReadParameter {
  std::string drive;
  std::string parameter;
  std::optional<Predicate> wanted;
  std::string unit;  // that of `wanted`; "" for the wire's own
  SimDuration within{};
  SimDuration every{};
  ExpectedReply reply;
};
struct CallCommand {
  std::string drive;
  std::string command;
  protocol::Values request;
  struct Field {
    std::string name;
    std::size_t index;  // in the reply's values
    double scale;
    std::string unit;
    std::optional<Predicate> wanted;
  };
  std::vector<Field> fields;  // all of the reply's
  ExpectedReply reply;
};
/// Bytes as they are.
struct SendRaw {
  struct Part {
    SimDuration pause;  // before it
    std::vector<std::uint8_t> bytes;
  };
  std::string drive;
  std::vector<Part> parts;
  bool judged = false;                             // `reply` was given
  std::vector<std::optional<std::uint8_t>> reply;  // none: any byte; empty: silence
  SimDuration within{};
};

struct WaitFor {
  SimDuration time;
};
struct WaitUntil {
  Condition condition;
  SimDuration within;
};
struct Expect {
  Condition condition;
  SimDuration within;  // 0: now
  SimDuration hold;    // without a break for so long
};
/// From this step on until another begins, or until the end.
struct Watch {
  Condition condition;
  bool never;
  std::optional<std::size_t> until;  // of the steps beside it
};

struct Apply {
  std::vector<NamedValue> inputs;
  std::optional<SimDuration> lasts;  // then what was before comes back
  std::string what = "apply";
};
struct Ramp {
  std::vector<NamedValue> targets;
  SimDuration over;
  bool background;
};
struct Profile {
  struct Point {
    SimDuration at;
    double value;
  };
  std::string input;
  std::vector<Point> points;
  bool linear;
  std::size_t repeat;
  bool background;
};
struct Inject {
  std::vector<NamedValue> faults;  // with their severity
  std::optional<SimDuration> lasts;
};
struct Clear {
  std::vector<std::string> faults;  // empty: all
};
struct Power {
  std::string drive;
  bool on;
  std::optional<SimDuration> lasts;
};
struct Reset {
  std::string drive;
};
struct Note {};

/// A program of the user's own, at the bench's pseudo-terminals.
struct RunHost {
  std::string command;  // of the shell; {port} and {port:LINE} are put in
  SimDuration timeout;
  double rate;
  int exit_code;
  std::string output;  // a text that must be in what it says; "" for none
};

struct Step;
struct Repeat {
  std::size_t count;
  std::vector<Step> steps;
};

using Action = std::variant<StartMotor, StopMotor, SetParameters, ReadParameter, CallCommand,
                            SendRaw, WaitFor, WaitUntil, Expect, Watch, Apply, Ramp, Profile,
                            Inject, Clear, Power, Reset, Note, RunHost, Repeat>;

// --- When it does it -----------------------------------------------------------------------------

/// A frame on the line, counted while the trigger's condition holds.
struct Milestone {
  std::string drive;
  enum class Kind { kRequest, kReply } kind;
  std::string frame;   // the command's name
  std::size_t number;  // the first is 1
};
struct Trigger {
  std::optional<Condition> when;
  std::optional<Milestone> at;
  SimDuration after{};  // the rest of it
};

struct Step {
  YamlPosition place;
  std::string verb;
  std::string text;   // as a reader wants it
  std::string label;  // "" for none
  Action action;
  std::optional<Trigger> trigger;  // none: when the steps before are done
};

// --- The whole -----------------------------------------------------------------------------------

struct Scenario {
  std::string file;  // as it was named
  std::string name;
  std::string about;
  std::string source;  // of what the drive has to do
  std::vector<std::string> tags;
  std::optional<std::uint64_t> seed;
  BenchOptions bench;
  std::vector<std::string> signals;  // to be plotted
  SimDuration interval{};            // between two samples
  std::vector<Step> steps;

  bool is_long() const;
};

/// "FILE:LINE:COLUMN"
std::string place_text(const Scenario& scenario, const Step& step);

}  // namespace virtdrive
