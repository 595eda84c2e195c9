// The protocol's framer: see devices/protocol/framer.h.
#pragma once

#include <memory>

#include "devices/protocol/framer.h"

namespace virtdrive::asd7 {

std::unique_ptr<protocol::Framer> make_framer();

}  // namespace virtdrive::asd7
