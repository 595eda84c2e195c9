// Frames of the MD series: RMID TMID ID PID NUM data[NUM] CHK, CHK making the sum zero.
//
// Both directions look the same. A controller takes any TMID and answers with it as RMID.
#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/md485/table.h"
#include "devices/protocol/frame_buffer.h"
#include "devices/protocol/payload.h"

namespace virtdrive::md485 {

/// Between which host and which controller a frame goes.
struct Route {
  std::uint8_t host = kHost;
  std::uint8_t id = 1;
  friend bool operator==(const Route&, const Route&) = default;
};

struct Frame {
  Route route = {};
  std::uint8_t pid = 0;
  const CommandRow* command = nullptr;      // a PID is one or the other;
  const ParameterRow* parameter = nullptr;  // unknown PIDs are neither
  protocol::Values values = {};
};

/// A command, or a value written to a parameter.
std::vector<std::uint8_t> encode_request(Route route, const CommandRow& row,
                                         const protocol::Values& values);
std::vector<std::uint8_t> encode_request(Route route, const ParameterRow& row,
                                         const protocol::Values& values);
/// A parameter's value, asked for with PID_REQ_PID_DATA or broadcast.
std::vector<std::uint8_t> encode_reply(Route route, const ParameterRow& row,
                                       const protocol::Values& values);

/// What a frame's data bytes are read as.
enum class DataVerdict : std::uint8_t { kGood, kUnknownPid, kTooShort };
/// Fills `frame`, whose route and PID are set, from its data bytes.
DataVerdict read_data(protocol::Direction direction, std::span<const std::uint8_t> data,
                      Frame& frame);

/// A receiver that trusts NUM until the sum says otherwise, then looks for a frame from the next
/// byte on. One byte, or the end of a false frame, can so bring several frames:
///
///   for (auto e = decoder.push(byte); e != Event::kNone; e = decoder.next()) ...
class Decoder {
 public:
  enum class Event : std::uint8_t {
    kNone,        // in the middle of a frame
    kNoise,       // a byte, or several, outside of a frame
    kFrame,       // complete: see frame()
    kUnknownPid,  // complete, but no row has its PID
    kTooShort,    // complete, but without all of its row's data
    kBadSum,
  };

  /// A controller's receiver takes RMID 183, and lets pass (as kNoise) what other controllers on
  /// the line answer: their TMID, 183, would else begin a false frame. A host's takes its own
  /// number, from TMID 183.
  explicit Decoder(protocol::Direction direction, std::uint8_t host = kHost)
      : direction_(direction), host_(host) {}

  Event push(std::uint8_t byte);
  /// What else the bytes hold that were taken already.
  Event next();
  /// The line was silent for kTable.framing.silence: gives up the frame that was cut short and
  /// looks for another one behind its first byte. To be repeated, as next(), until kNone.
  Event expire();

  /// The last frame; of kUnknownPid and kTooShort its route and PID.
  const Frame& frame() const { return frame_; }
  /// The bytes of the frame that push() or next() just told of, or else of the one under way.
  std::span<const std::uint8_t> bytes() const;
  bool idle() const { return pending() == 0; }
  /// Bytes taken that no event was about yet.
  std::size_t pending() const { return buffer_.size() - ended_; }
  void reset();

 private:
  static std::bitset<256> usual_hosts() { return std::bitset<256>().set(kHost).set(184).set(128); }
  bool can_start() const;
  Event read(std::span<const std::uint8_t> bytes);

  protocol::Direction direction_;
  std::uint8_t host_;
  std::bitset<256> hosts_ = usual_hosts();  // numbers that hosts on this line go by
  protocol::FrameBuffer<kTable.framing.longest> buffer_;
  std::size_t ended_ = 0;  // bytes at the buffer's front that are done with
  std::size_t shown_ = 0;  // of them, what bytes() still shows
  Frame frame_;
};

}  // namespace virtdrive::md485
