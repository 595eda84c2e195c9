// What a device and the CAN bus it hangs on know of each other. Whole frames only: arbitration, bit
// times and errors are the bus's business.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace virtdrive {

/// A CAN 2.0 frame. The bytes of `data` beyond `length` are 0, all of them in a remote frame.
struct CanFrame {
  std::uint32_t id = 0;  // 11 bits, or 29 where extended
  bool extended = false;
  bool remote = false;      // asks for a frame: a length without data
  std::uint8_t length = 0;  // 0..8
  std::array<std::uint8_t, 8> data{};

  std::span<const std::uint8_t> bytes() const { return std::span(data).first(remote ? 0 : length); }
  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

/// `bytes` holds at most 8.
inline CanFrame extended_frame(std::uint32_t id, std::span<const std::uint8_t> bytes) {
  CanFrame frame{.id = id, .extended = true, .length = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

/// What a CAN controller tells of itself.
struct CanState {
  int transmit_errors = 0;  // TEC; above 127 error passive, above 255 bus off
  int receive_errors = 0;   // REC
  bool bus_off = false;

  bool passive() const { return transmit_errors > 127 || receive_errors > 127; }
  bool warning() const { return transmit_errors > 96 || receive_errors > 96; }
};

/// A device's CAN controller.
class CanPort {
 public:
  virtual ~CanPort() = default;
  /// On the bus from now on, at this bit rate, counters at 0. `listen_only`: says nothing at all.
  virtual void open(int bit_rate, bool listen_only) = 0;
  /// Off the bus; what waited to leave is gone.
  virtual void close() = 0;
  /// Queues a frame behind those still waiting. False, and nothing is sent, if the queue is full or
  /// the controller is not on the bus, listens only, or is bus off.
  virtual bool send(const CanFrame& frame) = 0;
  virtual CanState state() const = 0;
};

/// A device's receiver: called in Phase::kBytes, when a frame's last bit has passed, for all that
/// others say.
class CanReceiver {
 public:
  virtual ~CanReceiver() = default;
  virtual void receive(const CanFrame& frame) = 0;
};

}  // namespace virtdrive
