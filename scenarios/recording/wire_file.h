// Writes a wire recording: what Wireshark shows, and what a replay needs (docs/recordings.md).
//
//   packets            a frame each, or bytes that are none, with the instant of each byte
//   host writes        as the host's program made them, which is not as they left on the line
//   bench, memory      to build the same again
//
// Each block is handed to the system when it is whole: a recording whose program was killed can be
// read up to its last block. No date, no path, no name of a machine: equal runs give equal files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/output_file.h"
#include "scenarios/recording/wire_sink.h"

namespace virtdrive {

struct RecordedLine {
  std::string name;      // "line0"
  std::string protocol;  // a table's name
  int baud = 0;          // of the drive, at the start

  friend bool operator==(const RecordedLine&, const RecordedLine&) = default;
};

/// What a file that a drive was made from held at the start.
struct RecordedFile {
  static constexpr std::size_t kMemory = 0;  // its non-volatile memory
  static constexpr std::size_t kMotor = 1;   // the first of its motors, and so on

  std::size_t drive = 0;  // of the bench's drives
  std::size_t role = kMemory;
  std::vector<std::uint8_t> content = {};
};

class WireFile final : public WireSink {
 public:
  /// Opens `path` anew. `bench` describes it (bench_description.h). SetupError if the file cannot
  /// be written.
  WireFile(const std::string& path, std::string_view bench, const std::vector<RecordedLine>& lines,
           const std::vector<RecordedFile>& files);

  void host_settings(std::size_t line, HostInstant when, const HostSettings& settings) override;
  void host_write(std::size_t line, HostInstant when, std::span<const std::uint8_t> bytes) override;
  void packet(std::size_t line, const WirePacket& packet) override;

  /// Marks how far the recording goes. SetupError if not all of it could be written (disk full).
  void close(SimTime end);

 private:
  void write(std::string_view block);

  OutputFile file_;
};

}  // namespace virtdrive
