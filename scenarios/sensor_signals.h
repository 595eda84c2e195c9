// The names of what can break in a drive's sensors: Hall sensors, encoders, shunts and dividers. A
// drive that has them keeps the sensor as plain data, names it here, and hands it to its program
// when told of a change.
#pragma once

#include <functional>
#include <string>

#include "core/signals.h"
#include "plant/sensors.h"

namespace virtdrive {

/// Called after each write.
using SensorChanged = std::function<void()>;

/// "NAME.a_stuck" (1 low, 2 high), "NAME.a_misplaced" (electrical degrees) ... and the whole cable:
/// "NAME.code_0", "NAME.code_7". The sensor must outlive the registry, here and below.
void name_sensor(Registry& registry, const std::string& name, HallSensors& sensors,
                 SensorChanged changed);

/// "NAME.slip" (mechanical degrees), "NAME.missed" (counts), "NAME.index_dead",
/// "NAME.cable_broken".
void name_sensor(Registry& registry, const std::string& name, Encoder& encoder,
                 SensorChanged changed);

/// "NAME.crc", "NAME.battery" (1 low, 2 lost).
void name_sensor(Registry& registry, const std::string& name, AbsoluteEncoder& encoder,
                 SensorChanged changed);

/// "NAMEoffset" (in `unit`, up to `most` either way), "NAMEgain" (0.1: reads 10 % too much; -1:
/// nothing), "NAMEstuck" (1 reads the lowest count, 2 the highest). `name` ends in '.' or '_';
/// `what` goes into the doc: "Shunt of phase a".
void name_sensor(Registry& registry, const std::string& name, const std::string& what,
                 const std::string& unit, double most, SensorFault& fault, SensorChanged changed);

}  // namespace virtdrive
