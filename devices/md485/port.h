// A controller's ways to the world: RS-485, TTL232 and CAN. Each hears frames and sends answers;
// what the frames do is the device's.
#pragma once

#include <deque>
#include <functional>
#include <span>

#include "core/event_loop.h"
#include "devices/can_port.h"
#include "devices/md485/can_codec.h"
#include "devices/md485/codec.h"
#include "devices/serial_port.h"
#include "devices/wire_log.h"

namespace virtdrive::md485 {

class Port {
 public:
  /// A good frame, whoever it is for, with its bytes.
  using Taker = std::function<void(Port& from, const Frame&, std::span<const std::uint8_t>)>;

  virtual ~Port() = default;
  /// Sends a PID's frame, if it has room for it; returns when its last bit will be out.
  virtual SimTime send(Route route, const ParameterRow& row, const protocol::Values& values) = 0;
  /// Nobody is talking: what nobody asked for may be sent.
  virtual bool is_free() const = 0;
};

class UartPort final : public Port, public SerialReceiver {
 public:
  UartPort(EventLoop& loop, SerialPort& port, WireLog& log, Taker taker);

  void receive(std::uint8_t byte) override;
  SimTime send(Route route, const ParameterRow& row, const protocol::Values& values) override;
  bool is_free() const override;
  /// PID 238.
  SimTime send_heard(Route route, const CanFrame& frame);

 private:
  void handle(Decoder::Event event);

  EventLoop& loop_;
  SerialPort& port_;
  WireLog& log_;
  Taker taker_;
  Decoder decoder_{protocol::Direction::kRequest};
  SimTime heard_ = kSimStart;
  Wakeup silence_;
};

class CanBusPort final : public Port, public CanReceiver {
 public:
  /// All that passes on the bus, before it is looked at.
  using Tap = std::function<void(const CanFrame&)>;

  CanBusPort(EventLoop& loop, CanPort& port, WireLog& log, Taker taker, Tap tap);

  void receive(const CanFrame& frame) override;
  SimTime send(Route route, const ParameterRow& row, const protocol::Values& values) override;
  bool is_free() const override { return true; }

 private:
  EventLoop& loop_;
  CanPort& port_;
  WireLog& log_;
  Taker taker_;
  Tap tap_;
};

}  // namespace virtdrive::md485
