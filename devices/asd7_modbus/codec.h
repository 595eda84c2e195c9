// Modbus RTU frames:  unit, function, data, CRC (low byte first).
//
// On the line silence ends a frame; within a recording, or for a host that waits for an answer, its
// length tells, where the function is a known one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/asd7_modbus/table.h"
#include "devices/protocol/payload.h"

namespace virtdrive::asd7_modbus {

struct Frame {
  std::uint8_t unit = 0;
  std::uint8_t function = 0;                    // as on the wire
  const CommandRow* row = nullptr;              // null: no such function
  std::optional<std::uint8_t> exception = {};   // of a reply
  std::optional<protocol::Values> values = {};  // nothing where the data have another length
};

enum class FrameError : std::uint8_t { kNone, kTooShort, kCrc };

/// The whole of what stood between two silences. `frame` counts only without an error.
FrameError decode(protocol::Direction direction, std::span<const std::uint8_t> bytes, Frame& frame);

/// Bytes of the frame that begins so; 0 while that cannot be told.
std::size_t expected_size(protocol::Direction direction, std::span<const std::uint8_t> bytes);

std::vector<std::uint8_t> encode_request(std::uint8_t unit, const CommandRow& row,
                                         const protocol::Values& values);
std::vector<std::uint8_t> encode_reply(std::uint8_t unit, const CommandRow& row,
                                       const protocol::Values& values);
std::vector<std::uint8_t> encode_exception(std::uint8_t unit, std::uint8_t function,
                                           Exception exception);

}  // namespace virtdrive::asd7_modbus
