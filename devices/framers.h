// The framers of the protocols that there are.
#pragma once

#include <memory>
#include <string_view>

#include "devices/protocol/framer.h"

namespace virtdrive {

/// In the place of a protocol's name: a line of bytes without frames.
inline constexpr std::string_view kNoProtocol = "bytes";

/// Of a protocol by its table's name, e.g. "toshiba-mcu". There is one for each protocol that has a
/// codec; VIRTDRIVE_CHECK for any other name.
std::unique_ptr<protocol::Framer> make_framer(std::string_view protocol);

}  // namespace virtdrive
