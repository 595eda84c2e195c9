// Words of a protocol checked before anything runs: the drive's own client makes the request, on a
// line that leads nowhere. What it says of names, units and values it would say on the bench too.
#pragma once

#include <functional>

#include "scenarios/bench_drive.h"
#include "scenarios/scenario/yaml_words.h"

namespace virtdrive {

/// SetupError at `place` if the client refuses the words.
void check_words(const Place& place, const BenchDrive& drive,
                 const std::function<void(HostClient&)>& say);

}  // namespace virtdrive
