// What a device tells of the frames it hears and says: for traces, statistics and recordings.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "core/event_loop.h"
#include "devices/protocol/table.h"

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

/// What every device does with all that: it counts, and tells who listens.
class WireLog {
 public:
  WireLog(const EventLoop& loop, WireListener listener, NoteListener notes)
      : loop_(loop), listener_(std::move(listener)), notes_(std::move(notes)) {}

  /// Somebody reads the texts: what serves them only need not be made otherwise.
  bool has_listener() const { return listener_ != nullptr; }
  void tell(WireEvent::Kind kind, std::span<const std::uint8_t> bytes, std::string_view text);
  void note(std::string_view text) const {
    if (notes_) notes_(text);
  }
  /// A host used the row of this name (which lives as long as the program): told once, if nothing
  /// acts on it.
  void note_use(std::string_view name, protocol::Support support);

  const WireCounters& counters() const { return counters_; }

 private:
  const EventLoop& loop_;
  WireListener listener_;
  NoteListener notes_;
  std::set<std::string_view> noted_;
  WireCounters counters_;
};

}  // namespace virtdrive
