// The RZ/T1 motion-control kit on a bench: two servo axes on one bus of 280 V, three consoles.
#pragma once

#include "scenarios/drive.h"

namespace virtdrive {

DriveKind rzt1_kind();

}  // namespace virtdrive
