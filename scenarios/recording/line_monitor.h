// Listens to a line, cuts what passes into packets, and tells its sinks of them and of what the
// host did.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/event_loop.h"
#include "devices/protocol/framer.h"
#include "pty/serial_line.h"
#include "scenarios/recording/wire_sink.h"

namespace virtdrive {

class LineMonitor {
 public:
  /// Bytes that are no frame make packets of their own, of at most so many bytes and without a gap
  /// of so long.
  static constexpr std::size_t kLongestNoise = 256;
  static constexpr SimDuration kNoiseGap = std::chrono::milliseconds(10);

  /// `line_number` is what the sinks are told; `protocol` is a table's name. Takes the line's taps.
  /// The sinks and the line must outlive the monitor.
  LineMonitor(EventLoop& loop, SerialLine& line, std::size_t line_number, std::string_view protocol,
              std::vector<WireSink*> sinks);
  ~LineMonitor();
  LineMonitor(const LineMonitor&) = delete;
  LineMonitor& operator=(const LineMonitor&) = delete;

  /// Tells of the frames that were under way, as cut short. To be called once, at the end.
  void finish();

 private:
  // One direction: bytes that no run has taken yet, and the noise before them.
  struct Lane {
    protocol::Direction direction;
    std::vector<WireByte> held;
    std::vector<WireByte> noise;
    std::string noise_text;  // of its first byte
  };

  void host_acted(std::span<const std::uint8_t> bytes, const HostSettings& settings);
  void hear(const WireByte& byte);
  void expire(Lane& lane);
  void take_runs(Lane& lane);
  void add_noise(Lane& lane, std::span<const WireByte> bytes, std::string_view text);
  void end_noise(Lane& lane);
  void tell(const WirePacket& packet);
  HostInstant instant() const;

  EventLoop& loop_;
  SerialLine& line_;
  std::size_t number_;
  std::unique_ptr<protocol::Framer> framer_;
  std::vector<WireSink*> sinks_;
  HostSettings settings_;  // as the sinks know them
  Lane from_host_{protocol::Direction::kRequest, {}, {}, {}};
  Lane to_host_{protocol::Direction::kReply, {}, {}, {}};
  std::vector<protocol::Run> runs_;
};

}  // namespace virtdrive
