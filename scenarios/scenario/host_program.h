// A person's own program as a step of a scenario: started by the shell, at the bench's
// pseudo-terminals, paced by the clock. The one thing in a scenario that is not repeatable to the
// bit.
#pragma once

#include <string>

#include "scenarios/bench.h"
#include "scenarios/scenario/scenario.h"

namespace virtdrive {

struct HostOutcome {
  std::string summary;   // "exit code 0 after 1.2 s; its output, ..."
  std::string expected;  // what was not so
  std::string wrong;     // "" if all was well
};

/// Runs the program to its end, or to the time-out; simulated time passes. It finds the terminals
/// in its command ({port}, {port:LINE}) and its environment: VIRTDRIVE_PORT, and
/// VIRTDRIVE_PORT_LINE for each line, in capitals. Its standard output and error are kept, up to 64
/// KiB.
HostOutcome run_host_program(Bench& bench, const RunHost& host);

}  // namespace virtdrive
