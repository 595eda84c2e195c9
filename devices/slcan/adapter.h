// A CAN adapter: a serial port on one side, a CAN controller on the other.
//
//   host  S5 CR  ->  CR          the bit rate is set
//         O CR   ->  CR          on the bus
//         T00B7AC012041C CR ->  Z CR
//                    <-  T00ACB7012012C CR   what others say comes by itself
//
// The answer to a frame says that it is queued, not that somebody took it. What is not understood,
// or not in this state of the channel, is answered with BELL.
#pragma once

#include <string_view>

#include "core/event_loop.h"
#include "devices/can_port.h"
#include "devices/serial_port.h"
#include "devices/slcan/codec.h"

namespace virtdrive::slcan {

class Adapter final : public SerialReceiver, public CanReceiver {
 public:
  Adapter(EventLoop& loop, SerialPort& port, CanPort& can) : loop_(loop), port_(port), can_(can) {}

  void receive(std::uint8_t byte) override;
  void receive(const CanFrame& frame) override;

 private:
  void act(const Line& line);
  void open(bool listen_only);
  void transmit(const CanFrame& frame);
  bool takes(When when) const;
  void answer(std::string_view text, std::uint8_t end = kOk);
  std::uint8_t flags() const;

  EventLoop& loop_;
  SerialPort& port_;
  CanPort& can_;
  Decoder decoder_;
  AcceptanceFilter filter_;
  int bit_rate_ = 0;  // 0: not set yet
  bool open_ = false;
  bool listens_only_ = false;
  bool stamps_ = false;
};

}  // namespace virtdrive::slcan
