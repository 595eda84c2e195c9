// The protocol's framer: see devices/protocol/framer.h.
#pragma once

#include <memory>

#include "devices/protocol/framer.h"

namespace virtdrive::toshiba_mcu {

std::unique_ptr<protocol::Framer> make_framer();

}  // namespace virtdrive::toshiba_mcu
