// The 7-Series drives on a bench: three sizes, each with its own protocol or with Modbus RTU, on
// the mains.
#pragma once

#include <vector>

#include "scenarios/drive.h"

namespace virtdrive {

std::vector<DriveKind> asd7_kinds();

}  // namespace virtdrive
