// A controller with its motors and its device at the end of a wire that takes the time that
// characters take: for replays, conversations and the table walk.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/nvm.h"
#include "devices/host_transport.h"
#include "devices/md485/device.h"
#include "tests/devices/wire.h"
#include "tests/firmware_models/md/rig.h"

namespace virtdrive::md485 {

using Bytes = std::vector<std::uint8_t>;

class LineRig final : public HostTransport {
 public:
  static constexpr SimDuration kCharacter{520'833};  // 10 bits at 19200 baud

  explicit LineRig(std::string_view model = "md400", Profile profile = Profile::kToday)
      : rig(model),
        table(rig.model, profile),
        device(
            rig.loop, wire_.port(), *rig.controller, table, memory, {},
            [this](const WireEvent& event) { log += std::string(event.text) + "\n"; },
            [this](std::string_view note) { notes.emplace_back(note); }) {
    wire_.attach(device);
  }

  // --- A host ---
  void write(std::span<const std::uint8_t> bytes) override { wire_.write(bytes); }
  std::optional<std::uint8_t> read(SimDuration patience) override { return wire_.read(patience); }

  /// All that is said within a time after these bytes.
  Bytes ask(const Bytes& bytes, SimDuration time = std::chrono::milliseconds(60)) {
    write(bytes);
    Bytes heard;
    const SimTime until = rig.loop.now() + time;
    while (const auto byte = read(std::max(until - rig.loop.now(), SimDuration{}))) {
      heard.push_back(*byte);
    }
    return heard;
  }
  /// A whole frame: header, sum and all.
  static Bytes frame(std::uint8_t pid, const Bytes& data, std::uint8_t id = 1,
                     std::uint8_t host = kHost) {
    Bytes bytes = {kController, host, id, pid, static_cast<std::uint8_t>(data.size())};
    bytes.insert(bytes.end(), data.begin(), data.end());
    std::uint8_t sum = 0;
    for (const std::uint8_t byte : bytes) sum = static_cast<std::uint8_t>(sum + byte);
    bytes.push_back(static_cast<std::uint8_t>(-sum));
    return bytes;
  }
  Bytes send(std::uint8_t pid, const Bytes& data, std::uint8_t id = 1) {
    return ask(frame(pid, data, id));
  }
  /// The data bytes that a request for a PID is answered with; nothing if it is not.
  std::optional<Bytes> data(std::uint8_t pid, std::uint8_t id = 1) {
    const Bytes reply = send(4, {pid}, id);
    if (reply.size() < 6) return std::nullopt;
    return Bytes(reply.begin() + 5, reply.end() - 1);
  }

 public:
  md::Rig rig;
  ModelTable table;
  MemoryInProcess memory;
  std::string log;
  std::vector<std::string> notes;

 private:
  Wire wire_{rig.loop, kCharacter};

 public:
  Device device;
};

}  // namespace virtdrive::md485
