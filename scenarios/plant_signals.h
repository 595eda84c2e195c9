// The names of what is physical on a bench: motors, loads, supplies, and what can break in them.
#pragma once

#include <cstddef>
#include <string>

#include "core/event_loop.h"
#include "core/signals.h"
#include "plant/axis.h"

namespace virtdrive {

/// "motor1.speed", "bus1.voltage", "load1.brake_torque", "bridge1.upper_a_stuck" ... The plant is
/// as far as its last control step; whoever looks at it brings it to the present. The axis must
/// outlive the registry.
void register_axis(Registry& registry, const EventLoop& loop, std::size_t channel, Axis& axis);

/// "NAME.voltage" and "NAME.off"; of mains also "NAME.phase_r_lost" ... What a supply gives is read
/// at the axes: "bus1.current".
void register_supply(Registry& registry, const EventLoop& loop, const std::string& name,
                     const DcBus& bus);

}  // namespace virtdrive
