// Modbus RTU frames in recordings of a drive's line.
#pragma once

#include <memory>

#include "devices/protocol/framer.h"

namespace virtdrive::asd7_modbus {

std::unique_ptr<protocol::Framer> make_framer();

}  // namespace virtdrive::asd7_modbus
