// The protocol's framer: see devices/protocol/framer.h.
#pragma once

#include <memory>
#include <string_view>

#include "devices/protocol/framer.h"

namespace virtdrive::slcan {

inline constexpr std::string_view kName = "slcan";

std::unique_ptr<protocol::Framer> make_framer();

}  // namespace virtdrive::slcan
