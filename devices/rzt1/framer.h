// The protocol's framer: see devices/protocol/framer.h.
#pragma once

#include <memory>

#include "devices/protocol/framer.h"

namespace virtdrive::rzt1 {

std::unique_ptr<protocol::Framer> make_framer();

}  // namespace virtdrive::rzt1
