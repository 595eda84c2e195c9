// Test results as JUnit XML, the dialect that Jenkins, GitLab and GitHub actions read. Times are
// simulated ones and there is no date: equal runs give equal files.
#pragma once

#include <string>
#include <vector>

#include "core/sim_time.h"
#include "scenarios/scenario/result.h"

namespace virtdrive {

struct JunitCase {
  std::string name;
  std::string group;  // what readers fold: a file, a row of a table
  std::string file = {};
  SimDuration time{};
  std::string summary = {};  // of a failure, in one line; empty: passed
  std::string text = {};
};
std::string junit(const std::vector<JunitCase>& cases);

std::string junit(const std::vector<ScenarioResult>& results);

}  // namespace virtdrive
