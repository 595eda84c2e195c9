// A wire recording as it is read back. Any bytes may be given: what is no recording is a SetupError
// that names the offset; one that ends in the middle (its program was killed) is read up to there.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/recording/wire_file.h"

namespace virtdrive {

/// A thing that the host did: new settings, or bytes written.
struct HostAction {
  std::size_t line = 0;
  HostInstant when;
  std::optional<HostSettings> settings = {};
  std::vector<std::uint8_t> bytes = {};
};

struct RecordedPacket {
  std::size_t line = 0;
  protocol::Direction direction = protocol::Direction::kRequest;
  std::vector<std::uint8_t> bytes = {};
  std::vector<SimTime> last_bits = {};  // of each byte
  std::string comment = {};
};

struct WireRecording {
  std::string bench;  // its description
  std::vector<RecordedLine> lines = {};
  std::vector<RecordedFile> files = {};
  std::vector<HostAction> actions = {};
  std::vector<RecordedPacket> packets = {};
  SimTime end = kSimStart;
  /// Empty, or why the recording is not whole: then `end` is the last instant that it knows of.
  std::string cut_short = {};
};

/// `name` begins the error messages.
WireRecording parse_wire_recording(std::span<const std::uint8_t> bytes, std::string_view name);

/// A file of at most 1 GiB.
WireRecording read_wire_recording(const std::string& path);

}  // namespace virtdrive
