// Scenario files (docs/scenarios.md) read and checked against the bench that they describe.
#pragma once

#include <string>
#include <string_view>

#include "scenarios/scenario/scenario.h"

namespace virtdrive {

/// SetupError "FILE:LINE:COLUMN: what is wrong, what was expected" for the first thing in the file
/// that is not right. Nothing is run.
Scenario load_scenario(const std::string& path);

/// The same from a text; `name` is what messages call it.
Scenario parse_scenario(const std::string& name, std::string_view text);

}  // namespace virtdrive
