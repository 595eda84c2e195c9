// A page of the scenarios that there are: what each shows, and the file itself.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/scenario/scenario.h"

namespace virtdrive {

/// Markdown, a section a drive; paths from "scenarios/" on.
std::string gallery(const std::vector<std::shared_ptr<const Scenario>>& scenarios);

}  // namespace virtdrive
