// What a device and the wire it hangs on know of each other. Bytes only: baud rate, parity and
// character times are the line's business.
#pragma once

#include <cstdint>
#include <span>

#include "core/sim_time.h"

namespace virtdrive {

enum class Parity : std::uint8_t { kNone, kEven, kOdd };

/// A device's transmitter.
class SerialPort {
 public:
  virtual ~SerialPort() = default;
  /// Queues bytes behind those still leaving; returns when the last bit of the last one will be
  /// out.
  virtual SimTime send(std::span<const std::uint8_t> bytes) = 0;
  /// The device sets its UART to another baud rate; without effect where there is no wire.
  virtual void set_baud(int) {}
  /// Likewise to another parity.
  virtual void set_parity(Parity) {}
};

/// A device's receiver: called in Phase::kBytes, at the instant a byte's last bit has arrived.
class SerialReceiver {
 public:
  virtual ~SerialReceiver() = default;
  virtual void receive(std::uint8_t byte) = 0;
};

}  // namespace virtdrive
