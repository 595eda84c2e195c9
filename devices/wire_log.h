// What a device tells of the frames it hears and says: for traces, statistics and recordings.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/sim_time.h"

namespace virtdrive {

struct WireEvent {
  enum class Kind : std::uint8_t {
    kRequest,   // a good frame from the host
    kReply,     // what the device sends
    kBadFrame,  // a frame that the device cannot take: checksum, end, unknown command
    kLost,      // bytes that came while the device could not listen
  };
  Kind kind;
  SimTime time;
  std::span<const std::uint8_t> bytes;
  std::string_view text;  // decoded, or the reason
};

using WireListener = std::function<void(const WireEvent&)>;

/// Something that a user should know although nothing is wrong, told once: a parameter that is
/// stored without effect was written.
using NoteListener = std::function<void(std::string_view)>;

/// Counted by every device.
struct WireCounters {
  std::uint64_t requests = 0;
  std::uint64_t replies = 0;
  std::uint64_t bad_frames = 0;
  std::uint64_t bytes_lost = 0;  // while busy

  friend WireCounters operator+(const WireCounters& a, const WireCounters& b) {
    return {a.requests + b.requests, a.replies + b.replies, a.bad_frames + b.bad_frames,
            a.bytes_lost + b.bytes_lost};
  }
};

}  // namespace virtdrive
