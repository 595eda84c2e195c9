// What the drive's electronics make of the machine; a firmware model sees nothing else.
#pragma once

#include "plant/analog_sensors.h"
#include "plant/position_sensors.h"
