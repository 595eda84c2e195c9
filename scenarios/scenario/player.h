// Plays a scenario on a bench of its own, as fast as the machine can.
#pragma once

#include <cstdint>

#include "scenarios/scenario/result.h"
#include "scenarios/scenario/scenario.h"

namespace virtdrive {

/// Never throws for what the drive or the host does: that is the result. Touches nothing that
/// another thread's play() could touch.
ScenarioResult play(const Scenario& scenario, std::uint64_t seed);

}  // namespace virtdrive
