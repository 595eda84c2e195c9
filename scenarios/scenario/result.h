// What came of a scenario: all that reports are made from. Simulated times only, so that equal runs
// have equal results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/sim_time.h"
#include "devices/wire_log.h"
#include "scenarios/scenario/history.h"

namespace virtdrive {

struct Failure {
  std::string place;  // "FILE:LINE:COLUMN"
  std::string step;   // its text
  std::string expected;
  std::string got;
  std::string off;  // how far; "" where no number says
  SimTime at = kSimStart;
};

struct StepResult {
  std::string text;
  std::string label;
  int line = 0;
  int depth = 0;  // of repetition
  SimTime begin = kSimStart;
  SimTime end = kSimStart;
  enum class Status { kDone, kFailed, kArmed } status = Status::kDone;
  std::string detail;  // what was read, what was answered
};

/// Something that happened to the bench: a fault came, a supply went.
struct BenchEvent {
  SimTime time;
  std::string text;
};

struct FrameRecord {
  SimTime time;
  std::string drive;
  WireEvent::Kind kind;
  std::string bytes;  // in hexadecimal
  std::string text;
};

/// The first and the last ones of many, with the number of those between.
template <class T>
class Ends {
 public:
  static constexpr std::size_t kMost = 500;  // at each end

  void add(T item) {
    if (first_.size() < kMost) {
      first_.push_back(std::move(item));
      return;
    }
    last_.push_back(std::move(item));
    if (last_.size() <= kMost) return;
    last_.pop_front();
    ++left_out_;
  }
  const std::vector<T>& first() const { return first_; }
  const std::deque<T>& last() const { return last_; }
  std::size_t left_out() const { return left_out_; }

 private:
  std::vector<T> first_;
  std::deque<T> last_;
  std::size_t left_out_ = 0;
};

struct ScenarioResult {
  std::string file;
  std::string name;
  std::string about;
  std::string source;
  std::vector<std::string> tags;
  std::uint64_t seed = 0;
  std::string bench;  // in a line
  SimDuration simulated{};
  std::optional<Failure> failure;
  Ends<StepResult> steps;
  Ends<BenchEvent> events;
  Ends<FrameRecord> frames;
  std::vector<std::string> notes;  // of the drive: parameters without effect
  History history;

  bool passed() const { return !failure; }
};

/// The file's path with dots, without its ending: "scenarios.library.toshiba-mcu.overvoltage".
std::string case_class(const ScenarioResult& result);

/// Of a failure: "expected drive1.stage is FOC, got drive1.stage Force (5)".
std::string one_line(const Failure& failure);
/// The same in several lines, with the place, the moment and the command that plays it again; "" if
/// it passed.
std::string explain(const ScenarioResult& result);
/// The command that plays a case again.
std::string again(const ScenarioResult& result);

}  // namespace virtdrive
