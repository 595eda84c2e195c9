// A motor's curves on one page: torque, power and current over speed at the rated and the peak
// current, and the map of efficiency. One SVG that needs nothing else; how the curves are computed:
// plant/motor_curves.h. Of an induction machine: torque, current, efficiency and power factor over
// speed on its rated supply (plant/induction_curves.h).
#pragma once

#include <string>

#include "plant/motor_library.h"

namespace virtdrive {

std::string motor_svg(const Motor& motor);

}  // namespace virtdrive
