// The protocol in CAN frames (2.3): the same PIDs, extended frames only.
//
//   request  identifier  0 | RMID 183 | TMID | ID      data  PID, up to seven bytes
//   answer               0 | TMID     | 183  | ID            the same
//
// The document says "extended mode only" and no more; the layout is assumed. A PID of more than
// seven bytes does not fit and is not answered.
#pragma once

#include <optional>
#include <vector>

#include "devices/can_port.h"
#include "devices/md485/codec.h"

namespace virtdrive::md485 {

/// VIRTDRIVE_CHECK: a command or a value of more than seven bytes.
CanFrame can_request(Route route, const CommandRow& row, const protocol::Values& values);
CanFrame can_request(Route route, const ParameterRow& row, const protocol::Values& values);
/// Nothing for a PID of more than seven bytes.
std::optional<CanFrame> can_reply(Route route, const ParameterRow& row,
                                  const protocol::Values& values);

/// Route and PID of a frame to controllers (request) or to `host` (reply); nothing for others.
std::optional<Frame> can_route(protocol::Direction direction, const CanFrame& frame,
                               std::uint8_t host = kHost);
/// The data behind the PID.
std::span<const std::uint8_t> can_data(const CanFrame& frame);

/// PID 238 on RS-485: identifier and data of a frame that was heard.
std::vector<std::uint8_t> encode_can_resend(Route route, const CanFrame& heard);

}  // namespace virtdrive::md485
