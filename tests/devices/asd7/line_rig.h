// A 7-Series drive with its motor and its device at the end of a wire that takes the time that
// characters take: for replays, conversations and the table walk.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/nvm.h"
#include "devices/asd7/device.h"
#include "devices/asd7_modbus/device.h"
#include "devices/host_transport.h"
#include "plant/motor_library.h"
#include "tests/devices/wire.h"

namespace virtdrive::asd7 {

using Bytes = std::vector<std::uint8_t>;

/// Of a drive whose mains and memory are the test's; Front is one of the two protocols' devices.
template <class Front>
class Rig final : public HostTransport {
 public:
  static constexpr SimDuration kCharacter{1'145'833};  // 11 bits at 9600 baud

  explicit Rig(Profile its_profile = {}, std::string_view size = "0.75",
               std::uint16_t number = kNumber)
      : model(find_model(size)),
        profile(its_profile),
        motor_(find_motor(model.motor)),
        axis({.motor = motor_.electrical,
              .link = mains_link(model),
              .mechanics = motor_.mechanics,
              .inverter = inverter_of(model),
              .effects = motor_.effects},
             Integrator::kFast),
        eeprom(memory, factory(model, number)),
        drive(loop, axis, model, eeprom.parameters().settings, eeprom.kept(), Seed{1}),
        wire_(loop, kCharacter),
        station(
            loop, wire_.port(), drive, eeprom, profile,
            [this](const WireEvent& event) { log += std::string(event.text) + "\n"; },
            [this](std::string_view note) { notes.emplace_back(note); }),
        front_(station) {
    wire_.attach(front_);
  }

  // --- A host ---
  void write(std::span<const std::uint8_t> bytes) override { wire_.write(bytes); }
  std::optional<std::uint8_t> read(SimDuration patience) override { return wire_.read(patience); }

  /// All that is said within a time after these bytes.
  Bytes ask(const Bytes& bytes, SimDuration time = std::chrono::milliseconds(100)) {
    write(bytes);
    return hear(time);
  }
  Bytes hear(SimDuration time) {
    Bytes heard;
    const SimTime until = loop.now() + time;
    while (const auto byte = read(std::max(until - loop.now(), SimDuration{}))) {
      heard.push_back(*byte);
    }
    return heard;
  }
  /// An ASCII frame without its CR, and the answer's likewise; "" is silence.
  std::string say(std::string_view text, SimDuration time = std::chrono::milliseconds(100)) {
    Bytes frame(text.begin(), text.end());
    frame.push_back('\r');
    const Bytes heard = ask(frame, time);
    if (heard.empty() || heard.back() != '\r') return {heard.begin(), heard.end()};
    return {heard.begin(), heard.end() - 1};
  }
  void run(SimDuration time) { loop.run_until(loop.now() + time); }
  void mains(bool on) {
    axis.advance_to(loop.now());
    MainsInput input = axis.bus().mains();
    input.connected.fill(on);
    axis.bus().set_mains(input);
  }

 private:
  static constexpr std::uint16_t kNumber =
      std::is_same_v<Front, Device> ? 0 : asd7_modbus::kFactoryUnit;

  static Parameters factory(const Model& model, std::uint16_t number) {
    Parameters parameters = factory_parameters(model);
    parameters.settings.number = number;
    return parameters;
  }

 public:
  EventLoop loop;
  const Model& model;
  Profile profile;
  MemoryInProcess memory;
  std::string log;
  std::vector<std::string> notes;

 private:
  Motor motor_;

 public:
  Axis axis;
  Eeprom eeprom;
  AcDrive drive;

 private:
  Wire wire_;

 public:
  Station station;

 private:
  Front front_;
};

using LineRig = Rig<Device>;
using ModbusRig = Rig<asd7_modbus::Device>;

}  // namespace virtdrive::asd7
