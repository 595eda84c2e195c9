// Cuts the bytes of a line, both directions, into packets: frames, and bytes that are none. Each
// byte of a direction ends up in exactly one packet, in order.
//
//   FrameCutter cutter("toshiba-mcu", [](const WirePacket& packet) { ... });
//   cutter.hear(Direction::kRequest, byte);
//   cutter.finish();
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "devices/protocol/framer.h"
#include "pty/serial_line.h"
#include "scenarios/recording/wire_sink.h"

namespace virtdrive {

class FrameCutter {
 public:
  /// Bytes that are no frame make packets of their own, of at most so many bytes and without a gap
  /// of so long.
  static constexpr std::size_t kLongestNoise = 256;
  static constexpr SimDuration kNoiseGap = std::chrono::milliseconds(10);

  using Listener = std::function<void(const WirePacket&)>;

  /// `protocol` is a table's name.
  FrameCutter(std::string_view protocol, Listener listener);

  void hear(protocol::Direction direction, const WireByte& byte);
  /// Tells of the frames that were under way, as cut short. To be called once, at the end.
  void finish();

 private:
  // One direction: bytes that no run has taken yet, and the noise before them.
  struct Lane {
    protocol::Direction direction;
    std::vector<WireByte> held = {};
    std::vector<WireByte> noise = {};
    std::string noise_text = {};  // of its first byte
  };

  void pass_silence(Lane& lane, SimTime until);
  void expire(Lane& lane);
  void take_runs(Lane& lane);
  void add_noise(Lane& lane, std::span<const WireByte> bytes, std::string_view text);
  void end_noise(Lane& lane);

  std::unique_ptr<protocol::Framer> framer_;
  Listener listener_;
  Lane from_host_{protocol::Direction::kRequest};
  Lane to_host_{protocol::Direction::kReply};
  std::vector<protocol::Run> runs_;
};

}  // namespace virtdrive
