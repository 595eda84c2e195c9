// A controller with its motors and its device at the end of a wire that takes the time that
// characters take: for replays, conversations and the table walk.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/nvm.h"
#include "devices/host_transport.h"
#include "devices/md485/device.h"
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
            rig.loop, port_, *rig.controller, table, memory, {},
            [this](const WireEvent& event) { log += std::string(event.text) + "\n"; },
            [this](std::string_view note) { notes.emplace_back(note); }) {}

  // --- A host ---
  void write(std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) {
      rig.run_for(kCharacter);
      device.receive(byte);
    }
  }
  std::optional<std::uint8_t> read(SimDuration patience) override {
    const SimTime until = rig.loop.now() + patience;
    rig.loop.run_until(until, [&] { return !port_.said.empty(); });
    if (port_.said.empty() || port_.said.front().first > until) {
      rig.loop.run_until(until);
      return std::nullopt;
    }
    const auto [time, byte] = port_.said.front();
    rig.loop.run_until(std::max(time, rig.loop.now()));
    port_.said.pop_front();
    return byte;
  }

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

 private:
  class Port final : public SerialPort {
   public:
    explicit Port(EventLoop& loop) : loop_(loop) {}
    SimTime send(std::span<const std::uint8_t> bytes) override {
      for (const std::uint8_t byte : bytes) {
        free_ = std::max(free_, loop_.now()) + kCharacter;
        said.emplace_back(free_, byte);
      }
      return free_;
    }
    std::deque<std::pair<SimTime, std::uint8_t>> said;

   private:
    EventLoop& loop_;
    SimTime free_ = kSimStart;
  };

 public:
  md::Rig rig;
  ModelTable table;
  MemoryInProcess memory;
  std::string log;
  std::vector<std::string> notes;

 private:
  Port port_{rig.loop};

 public:
  Device device;
};

}  // namespace virtdrive::md485
