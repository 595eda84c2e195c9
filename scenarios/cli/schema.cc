#include "scenarios/scenario/schema.h"

#include <fmt/format.h>

#include "scenarios/cli/commands.h"

namespace virtdrive {

int print_schema() {
  fmt::print("{}", scenario_schema());
  return kExitOk;
}

}  // namespace virtdrive
