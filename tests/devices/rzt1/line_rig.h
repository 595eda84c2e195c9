// The kit with two motors and a wire at each of its three consoles: for replays, conversations and
// the table walk.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/nvm.h"
#include "devices/rzt1/client.h"
#include "devices/rzt1/device.h"
#include "tests/devices/wire.h"
#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {

using Bytes = std::vector<std::uint8_t>;

class LineRig {
 public:
  static constexpr SimDuration kCharacter{86'806};  // 10 bits at 115200 baud

  explicit LineRig(DeviceOptions options = {}, const FirmwareOptions& firmware = {})
      : rig(bench_axis(), firmware),
        device(
            rig.loop, ports(), *rig.drive, memory, options, {},
            [this](const WireEvent& event) { log += std::string(event.text) + "\n"; },
            [this](std::string_view note) { notes.emplace_back(note); }) {
    for (std::size_t i = 0; i < kConsoles; ++i) wires_[i].attach(device.console(i));
  }

  Wire& wire(std::size_t console = 0) { return wires_[console]; }
  ServoAxis& axis(std::size_t number = 0) { return rig.axis(number); }
  void run_for(SimDuration time) { rig.run_for(time); }

  /// All that is said within a time after these bytes.
  Bytes ask(const Bytes& bytes, std::size_t console = 0,
            SimDuration time = std::chrono::milliseconds(5)) {
    wire(console).write(bytes);
    return heard(console, time);
  }
  Bytes heard(std::size_t console = 0, SimDuration time = std::chrono::milliseconds(5)) {
    Bytes bytes;
    const SimTime until = rig.loop.now() + time;
    while (const auto byte = wire(console).read(std::max(until - rig.loop.now(), SimDuration{}))) {
      bytes.push_back(*byte);
    }
    return bytes;
  }
  /// A line without its CR; all that comes back.
  std::string type(std::string_view text, std::size_t console = 0) {
    Bytes bytes(text.begin(), text.end());
    bytes.push_back('\r');
    const Bytes reply = ask(bytes, console);
    return {reply.begin(), reply.end()};
  }

 private:
  std::array<SerialPort*, kConsoles> ports() {
    return {&wires_[0].port(), &wires_[1].port(), &wires_[2].port()};
  }

 public:
  Rig rig;
  MemoryInProcess memory;
  std::string log;
  std::vector<std::string> notes;

 private:
  std::array<Wire, kConsoles> wires_{Wire(rig.loop, kCharacter), Wire(rig.loop, kCharacter),
                                     Wire(rig.loop, kCharacter)};

 public:
  Device device;
};

}  // namespace virtdrive::rzt1
