// Many scenarios at once: found in files and folders, chosen, played on all cores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/scenario/player.h"
#include "scenarios/scenario/scenario.h"

namespace virtdrive {

struct SuiteOptions {
  std::vector<std::string> paths;     // files, and folders in which all *.yaml are scenarios
  std::string pattern;                // part of a name, a path or a tag; empty: all
  bool with_long = false;             // those tagged 'long' too
  std::optional<std::uint64_t> seed;  // instead of each scenario's own
  std::size_t repeat = 1;             // with the seeds that follow
  std::size_t shard = 1;              // of `shards`: every so many-th case
  std::size_t shards = 1;
  std::size_t jobs = 0;  // threads; 0: one a core
};

/// One run of one scenario.
struct Case {
  std::shared_ptr<const Scenario> scenario;
  std::uint64_t seed;
};

/// The scenarios in the order of their paths, all of them read and checked. SetupError for a path
/// that is not there, a folder without scenarios, or the first file that is not right.
std::vector<std::shared_ptr<const Scenario>> find_scenarios(const std::vector<std::string>& paths);

/// What of them is to be played, in order.
std::vector<Case> choose_cases(const std::vector<std::shared_ptr<const Scenario>>& scenarios,
                               const SuiteOptions& options);

/// Told in the order of the cases, by one thread at a time. Afterwards frames and history of the
/// result are dropped: many runs must not fill the memory.
using CaseListener = std::function<void(std::size_t index, const ScenarioResult&)>;

/// Plays them all; the results in the order of the cases, the same whatever the number of jobs.
std::vector<ScenarioResult> play_all(const std::vector<Case>& cases, std::size_t jobs,
                                     const CaseListener& listener);

struct Totals {
  std::size_t passed = 0;
  std::size_t failed = 0;
  double simulated_s = 0;
};
Totals totals(const std::vector<ScenarioResult>& results);

}  // namespace virtdrive
