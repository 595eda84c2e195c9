// A wire between a device and a host in this process: each byte takes the time of its character.
// Without settings, collisions and faults; those are the serial line's.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <span>
#include <utility>

#include "core/event_loop.h"
#include "devices/host_transport.h"
#include "devices/serial_port.h"

namespace virtdrive {

/// The host's end; its patience is simulated time.
class Wire final : public HostTransport {
 public:
  Wire(EventLoop& loop, SimDuration character) : loop_(loop), port_(loop, character) {}

  /// The device's transmitter.
  SerialPort& port() { return port_; }
  void attach(SerialReceiver& device) { device_ = &device; }

  void write(std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) {
      loop_.run_until(loop_.now() + port_.character);
      device_->receive(byte);
    }
  }
  std::optional<std::uint8_t> read(SimDuration patience) override {
    const SimTime until = loop_.now() + patience;
    loop_.run_until(until, [&] { return !port_.said.empty(); });
    if (port_.said.empty() || port_.said.front().first > until) {
      loop_.run_until(until);
      return std::nullopt;
    }
    const auto [time, byte] = port_.said.front();
    loop_.run_until(std::max(time, loop_.now()));
    port_.said.pop_front();
    return byte;
  }

 private:
  struct Port final : SerialPort {
    Port(EventLoop& its_loop, SimDuration its_character)
        : loop(its_loop), character(its_character) {}
    SimTime send(std::span<const std::uint8_t> bytes) override {
      for (const std::uint8_t byte : bytes) {
        free = std::max(free, loop.now()) + character;
        said.emplace_back(free, byte);
      }
      return free;
    }
    EventLoop& loop;
    SimDuration character;
    std::deque<std::pair<SimTime, std::uint8_t>> said;  // with the instant of the last bit
    SimTime free = kSimStart;
  };

  EventLoop& loop_;
  Port port_;
  SerialReceiver* device_ = nullptr;
};

}  // namespace virtdrive
