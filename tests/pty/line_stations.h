// Several devices on one line, and all that is heard.
#pragma once

#include <deque>
#include <numeric>
#include <vector>

#include "pty/serial_line.h"

namespace virtdrive {

using Bytes = std::vector<std::uint8_t>;

struct Heard {
  std::uint8_t byte;
  SimTime time;

  friend bool operator==(const Heard&, const Heard&) = default;
};

inline Bytes bytes_of(const std::vector<Heard>& heard) {
  Bytes result;
  for (const Heard& one : heard) result.push_back(one.byte);
  return result;
}

/// 0, 1, 2 ...
inline Bytes counting(std::size_t count) {
  Bytes bytes(count);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

struct Stations {
  class Device final : public SerialReceiver {
   public:
    explicit Device(EventLoop& loop) : loop_(loop) {}
    void receive(std::uint8_t byte) override { heard.push_back({byte, loop_.now()}); }
    Bytes bytes() const { return bytes_of(heard); }

    std::vector<Heard> heard;

   private:
    EventLoop& loop_;
  };

  Stations(std::size_t count, const LineSettings& settings, LineOptions options)
      : line(loop, settings, std::move(options)) {
    for (std::size_t i = 0; i < count; ++i) {
      line.add_device().attach(devices.emplace_back(loop));
    }
    line.on_host_byte([this](std::uint8_t byte, SimTime time) { host.push_back({byte, time}); });
  }

  void run_for(SimDuration duration) { loop.run_until(loop.now() + duration); }
  void record() {
    line.on_wire([this](const WireByte& byte) { wire.push_back(byte); });
  }

  EventLoop loop;
  SerialLine line;
  std::deque<Device> devices;
  std::vector<Heard> host;
  std::vector<WireByte> wire;
};

}  // namespace virtdrive
