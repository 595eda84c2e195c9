// The MD controllers on a bench: seventeen models, one or two motors on one supply.
#pragma once

#include <vector>

#include "scenarios/drive.h"

namespace virtdrive {

std::vector<DriveKind> md_kinds();

}  // namespace virtdrive
