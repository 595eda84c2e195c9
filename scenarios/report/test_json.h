// Test results as one JSON document, for programs. Simulated times only: equal runs give equal
// files.
#pragma once

#include <string>
#include <vector>

#include "scenarios/scenario/result.h"

namespace virtdrive {

std::string test_json(const std::vector<ScenarioResult>& results);

}  // namespace virtdrive
