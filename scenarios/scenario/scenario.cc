#include "scenarios/scenario/scenario.h"

#include <algorithm>
#include <fmt/format.h>

namespace virtdrive {

bool Scenario::is_long() const {
  return std::ranges::find(tags, "long") != tags.end();
}

std::string place_text(const Scenario& scenario, const Step& step) {
  return fmt::format("{}:{}:{}", scenario.file, step.place.line, step.place.column);
}

}  // namespace virtdrive
