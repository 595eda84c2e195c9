// Plays a wire recording's host against a bench of the recording's making, and holds what the
// drives say against what they said: each byte, and the instant of its last bit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sim_time.h"
#include "devices/wire_log.h"
#include "scenarios/recording/wire_recording.h"
#include "scenarios/signal_comparison.h"

namespace virtdrive {

/// What is to be other than recorded; of each drive.
struct ReplayOptions {
  std::vector<std::string> motors = {};
  std::string load = {};  // empty: as recorded
  std::optional<std::uint64_t> seed = {};
  std::vector<std::string> set = {};  // written after the recorded ones
  /// By how much a byte may come earlier or later than recorded; a recording of real hardware has
  /// its adapter's delays in it.
  SimDuration tolerance{};
  std::string signals = {};     // CSV file that was recorded beside; empty: bytes only
  double signal_tolerance = 0;  // of a signal's largest size
  std::string wire = {};        // file of a new recording; empty: none
  NoteListener notes = {};
};

/// A drive's byte, and the packet that it is in.
struct DriveByte {
  std::uint8_t byte = 0;
  SimTime last_bit;
  std::vector<std::uint8_t> packet = {};
  std::string text = {};
};

/// The first byte that is not as it was. One of the two may be missing, not both.
struct Divergence {
  std::string line = {};
  std::uint64_t index = 0;  // from 0, of what the drives said on that line
  std::optional<DriveByte> recorded = {};
  std::optional<DriveByte> replayed = {};
};

struct ReplayResult {
  std::uint64_t host_bytes = 0;   // written by the hosts
  std::uint64_t drive_bytes = 0;  // that were as recorded
  SimTime end = kSimStart;
  std::optional<Divergence> divergence = {};  // none: identical
  std::uint64_t rows = 0;                     // of signals that were compared
  std::optional<SignalDivergence> signal_divergence = {};
};

/// `name` is the recording's, for messages. SetupError if its bench cannot be built. Ends soon
/// after the first divergence, unless a new recording was asked for.
ReplayResult replay(const WireRecording& recording, const std::string& name,
                    const ReplayOptions& options = {});

}  // namespace virtdrive
