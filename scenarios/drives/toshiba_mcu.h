// The Toshiba MCU Motor Studio drive on a bench: three channels, a motor and a supply each.
#pragma once

#include "scenarios/drive.h"

namespace virtdrive {

DriveKind toshiba_mcu_kind();

}  // namespace virtdrive
