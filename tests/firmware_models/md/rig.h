// A controller with its motors on a bench without a line: what the firmware's and the device's
// tests stand on.
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include "core/check.h"
#include "core/event_loop.h"
#include "firmware_models/md/controller.h"
#include "plant/motor_library.h"

namespace virtdrive::md {

inline const Model& model_named(std::string_view name) {
  for (const Model& model : models()) {
    if (model.name == name) return model;
  }
  throw SetupError("no such model");
}

/// The model's default motor on a supply that takes what it is given back.
inline AxisParameters test_axis(const Model& model) {
  const Motor motor = find_motor(model.motor);
  return {
      .motor = motor.electrical,
      .link = {.source_v = model.bus_v, .resistance_ohm = 0, .capacitance_f = model.capacitance_f},
      .mechanics = motor.mechanics};
}

class Rig {
 public:
  explicit Rig(std::string_view name = "md400", std::uint64_t seed = 1,
               const BrakeChopper& chopper = {})
      : model(model_named(name)), settings_(default_settings(model)) {
    AxisParameters parameters = test_axis(model);
    if (chopper.on_v > 0) {
      parameters.link.chopper = chopper;
      parameters.link.resistance_ohm = 1;  // a rectifier: takes nothing back
    }
    const DcBus bus(parameters.link, Integrator::kFast);
    for (std::size_t i = 0; i < model.motors; ++i) axes_.emplace_back(parameters, bus);
    for (Axis& axis : axes_) pointers_.push_back(&axis);
    controller = std::make_unique<Controller>(loop, pointers_, model, settings_, Seed{seed});
  }

  Axis& axis(std::size_t number = 0) {
    axes_[number].advance_to(loop.now());
    return axes_[number];
  }
  const MotorChannel& motor(std::size_t number = 0) const { return controller->motor(number); }
  MotorChannel& order(std::size_t number = 0) { return *controller->by_frame(number); }
  Terminals& pins(std::size_t number = 0) { return controller->terminals(number); }

  void run_for(SimDuration time) { loop.run_until(loop.now() + time); }
  /// How long it took; SimDuration::max() if it never was.
  template <class Condition>
  SimDuration run_to(Condition&& condition, SimDuration patience = std::chrono::seconds(10)) {
    const SimTime from = loop.now();
    return loop.run_until(from + patience, condition) ? loop.now() - from : SimDuration::max();
  }
  SimDuration run_to_status(int bits, SimDuration patience = std::chrono::seconds(20)) {
    return run_to([&] { return (motor().status() & bits) == bits; }, patience);
  }

  void change(std::int32_t Settings::* member, std::int32_t value) {
    Settings settings = controller->settings();
    settings.*member = value;
    controller->set_settings(settings);
  }
  void load(double Load::* quantity, double value, std::size_t number = 0) {
    Load load = axis(number).load();
    load.*quantity = value;
    axes_[number].set_load(load);
  }
  double speed_rpm(std::size_t number = 0) {
    return axis(number).state().speed_radps * 30 / std::numbers::pi;
  }

  EventLoop loop;
  const Model& model;

 private:
  Settings settings_;
  std::vector<Axis> axes_;
  std::vector<Axis*> pointers_;

 public:
  std::unique_ptr<Controller> controller;
};

}  // namespace virtdrive::md
