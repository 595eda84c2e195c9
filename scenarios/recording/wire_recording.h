// A wire recording as it is read back. Any bytes may be given: what is no recording is a SetupError
// that names the offset; one that ends in the middle (its program was killed) is read up to there.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/protocol/framer.h"
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
  protocol::Verdict verdict = protocol::Verdict::kFrame;
  SimTime first_bit = kSimStart;
  std::vector<SimTime> last_bits = {};  // of each byte
  std::string comment = {};             // what it means, and its times
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

/// A file of at most 1 GiB; "-" is standard input.
WireRecording read_wire_recording(const std::string& path);

/// Called for each packet, as soon as it is read, with what is known of the bench by then.
using PacketListener = std::function<void(const WireRecording& so_far, const RecordedPacket&)>;

/// Reads a file, a pipe or standard input to its end, packet by packet: also one that is being
/// written. Why the recording is not whole, or "".
std::string follow_wire_recording(const std::string& path, const PacketListener& listener);

}  // namespace virtdrive
