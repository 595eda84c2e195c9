// The names of what passes on a line, and of what can be wrong with it.
#pragma once

#include <string>

#include "core/signals.h"
#include "pty/can_bus.h"
#include "pty/serial_line.h"

namespace virtdrive {

/// "NAME.collisions", "NAME.to_host_lost", "NAME.to_drives_cut" ... The line must outlive the
/// registry.
void register_line(Registry& registry, const std::string& name, SerialLine& line);
/// "NAME.frames", "NAME.errors", "NAME.bus_cut" of the bus behind a CAN adapter.
void register_can(Registry& registry, const std::string& name, CanBus& bus);

}  // namespace virtdrive
