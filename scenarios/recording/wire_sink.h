// What passes on a bench's lines, as it is told to those who write it down or compare it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/sim_time.h"
#include "devices/protocol/framer.h"
#include "pty/serial_line.h"

namespace virtdrive {

/// A frame, or bytes that are none, as it passed on a line.
struct WirePacket {
  protocol::Direction direction = protocol::Direction::kRequest;  // kRequest: from the host
  std::span<const WireByte> bytes;                                // at least one
  protocol::Verdict verdict = protocol::Verdict::kFrame;
  std::string_view text;  // decoded, or what is wrong
};

/// Where a host's action stands in the simulation.
struct HostInstant {
  SimTime time;
  /// The loop's events of that instant were still to come. If not, they were over, or there were
  /// none.
  bool before_events = false;

  friend bool operator==(const HostInstant&, const HostInstant&) = default;
};

class WireSink {
 public:
  virtual ~WireSink() = default;

  virtual void host_settings(std::size_t line, HostInstant when, const HostSettings& settings) = 0;
  virtual void host_write(std::size_t line, HostInstant when,
                          std::span<const std::uint8_t> bytes) = 0;
  virtual void packet(std::size_t line, const WirePacket& packet) = 0;
};

}  // namespace virtdrive
