// Test results as JUnit XML, the dialect that Jenkins, GitLab and GitHub actions read. Times are
// simulated ones and there is no date: equal runs give equal files.
#pragma once

#include <string>
#include <vector>

#include "scenarios/scenario/result.h"

namespace virtdrive {

std::string junit(const std::vector<ScenarioResult>& results);

}  // namespace virtdrive
