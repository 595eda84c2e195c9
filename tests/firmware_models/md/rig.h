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

namespace virtdrive::md {

inline const Model& model_named(std::string_view name) {
  for (const Model& model : models()) {
    if (model.name == name) return model;
  }
  throw SetupError("no such model");
}

/// Motors like those that the models are made for: R, L and Kt between two lines, a flat trapezoid
/// of which the bench's sine is the fundamental.
inline AxisParameters test_axis(const Model& model) {
  struct Data {
    int pole_pairs;
    double line_ohm, line_h, kt, inertia, coulomb, viscous;
  };
  const bool wheel = model.name == "md200t";
  const Data d = wheel      ? Data{10, 0.6, 1e-3, 0.5, 1.5e-2, 0.15, 3e-3}
                 : model.ac ? Data{4, 5.5, 9.5e-3, 0.78, 1.2e-4, 0.03, 3e-5}
                            : Data{5, 0.22, 0.4e-3, 0.12, 1.2e-4, 0.03, 3e-5};
  constexpr double kFundamental = 1.2158;  // of a trapezoid with a flat top of 120 degrees
  return {
      .motor = {.pole_pairs = d.pole_pairs,
                .resistance_ohm = d.line_ohm / 2,
                .inductance_d_h = d.line_h / 2,
                .inductance_q_h = d.line_h / 2,
                .flux_wb = kFundamental * d.kt / 2 / d.pole_pairs,
                .rated_current_a = model.current_a},
      .link = {.source_v = model.bus_v, .resistance_ohm = 0, .capacitance_f = model.capacitance_f},
      .mechanics = {
          .inertia_kgm2 = d.inertia, .viscous_nm_per_radps = d.viscous, .coulomb_nm = d.coulomb}};
}

class Rig {
 public:
  explicit Rig(std::string_view name = "md400", std::uint64_t seed = 1)
      : model(model_named(name)), settings_(default_settings(model)) {
    const AxisParameters parameters = test_axis(model);
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
