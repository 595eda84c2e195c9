#include <fmt/format.h>

#include "scenarios/cli/commands.h"
#include "scenarios/scenario/schema.h"

namespace virtdrive {

int print_schema() {
  fmt::print("{}", scenario_schema());
  return kExitOk;
}

}  // namespace virtdrive
