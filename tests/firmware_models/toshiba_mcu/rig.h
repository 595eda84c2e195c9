// A firmware on three motors, without a line: what the firmware's and the device's tests stand on.
#pragma once

#include <array>

#include "core/event_loop.h"
#include "firmware_models/toshiba_mcu/firmware.h"
#include "plant/motor_library.h"

namespace virtdrive::toshiba_mcu {

class Rig {
 public:
  explicit Rig(std::uint64_t seed = 1, const DcLinkParameters& supply = kSupply,
               const MachineEffects& effects = {})
      : axes_{axis(supply, effects), axis(supply, effects), axis(supply, effects)},
        firmware(loop, pointers_, Seed{seed}) {}

  PowerBoard& board(std::size_t channel = 1) { return firmware.board(channel); }
  const MotorChannel& channel(std::size_t number = 1) { return board(number).channel(); }
  Axis& axis_of(std::size_t channel = 1) { return axes_[channel]; }

  void run_for(SimDuration time) { loop.run_until(loop.now() + time); }
  /// Until the stage is reached; the time it took, or kNever if that is more than `patience`.
  SimDuration run_to(Stage stage, SimDuration patience = std::chrono::seconds(10)) {
    const SimTime from = loop.now();
    const bool reached =
        loop.run_until(from + patience, [&] { return channel().stage() == stage; });
    return reached ? loop.now() - from : SimDuration::max();
  }
  double speed_rpm() {
    axes_[1].advance_to(loop.now());
    return axes_[1].state().speed_radps * 9.549296585513721;
  }
  void set_brake(double torque_nm) {
    Load load = axes_[1].load();
    load.brake_torque_nm = torque_nm;
    axes_[1].advance_to(loop.now());
    axes_[1].set_load(load);
  }
  void change(UnitValue ChannelSettings::* setting, UnitValue value) {
    ChannelSettings settings = channel().settings();
    settings.*setting = value;
    board().set_settings(settings);
  }
  template <class T>
  void set_input(T BoardInputs::* input, T value) {
    BoardInputs inputs = board().inputs();
    inputs.*input = value;
    board().set_inputs(inputs);
  }
  void open_phases(std::array<bool, 3> open) {
    axes_[1].advance_to(loop.now());
    axes_[1].set_bridge_faults({.phase_open = open});
  }
  /// Starts channel 1 and runs until it has the speed.
  void run_up(std::int32_t rpm, SimDuration time = std::chrono::milliseconds(3500)) {
    board().set_speed_rpm(rpm);
    board().start();
    run_for(time);
  }

  EventLoop loop;

 private:
  static constexpr DcLinkParameters kSupply{
      .source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3};

  static Axis axis(const DcLinkParameters& supply, const MachineEffects& effects) {
    const Motor& motor = find_motor("db42s03");
    return Axis({.motor = motor.electrical,
                 .link = supply,
                 .mechanics = motor.mechanics,
                 .effects = effects},
                Integrator::kFast);
  }

  std::array<Axis, 3> axes_;
  std::array<Axis*, 3> pointers_{&axes_[0], &axes_[1], &axes_[2]};

 public:
  Firmware firmware;
};

}  // namespace virtdrive::toshiba_mcu
