// A drive of the 7-Series with its motor on the mains, in virtual time.
#pragma once

#include <memory>

#include "core/event_loop.h"
#include "firmware_models/asd7/ac_drive.h"
#include "plant/motor_library.h"

namespace virtdrive::asd7 {

using namespace std::chrono_literals;

/// FA00: command and frequency priority, run.
inline constexpr std::uint16_t kRunByLine = 0xc400;

struct BenchOptions {
  Load load{};
  Integrator integrator = Integrator::kFast;
  Memory memory{};
  int phases = 3;
};

class DriveBench {
 public:
  explicit DriveBench(std::string_view size, const BenchOptions& options = {})
      : model(find_model(size)),
        motor(find_motor(model.motor)),
        settings(default_settings(model)),
        axis({.motor = motor.electrical,
              .link = mains_link(model, options.phases, model.supply_v, model.supply_hz),
              .mechanics = motor.mechanics,
              .inverter = inverter_of(model),
              .effects = motor.effects},
             options.integrator, options.load),
        drive(loop, axis, model, settings, options.memory, Seed(1)) {}

  void run(SimDuration duration) { loop.run_until(loop.now() + duration); }
  /// Changes the settings by a function.
  template <typename Change>
  void set(Change change) {
    change(settings);
    drive.set_settings(settings);
  }
  void start(double hz) {
    drive.set_frequency(static_cast<std::uint16_t>(hz * 100 + 0.5));
    drive.set_command(kRunByLine);
  }
  void stop() { drive.set_command(0xc000); }
  void load(const Load& load) {
    axis.advance_to(loop.now());
    axis.set_load(load);
  }
  void mains(const std::array<double, 3>& level) {
    axis.advance_to(loop.now());
    MainsInput input = axis.bus().mains();
    input.level = level;
    axis.bus().set_mains(input);
  }
  void mains(bool on) { mains(on ? std::array<double, 3>{1, 1, 1} : std::array<double, 3>{}); }
  double hz() const { return drive.monitor().output_frequency / 100.0; }
  double rpm() const { return axis.state().speed_radps * 30 / 3.14159265358979; }
  std::uint16_t status() const { return drive.monitor().status; }
  double current_percent() const { return drive.monitor().output_current / 100.0; }
  /// Runs until it trips or the time has passed; what has passed.
  double until_trip(SimDuration limit) {
    const SimTime begin = loop.now();
    loop.run_until(begin + limit, [this] { return drive.tripped(); });
    return seconds(loop.now() - begin);
  }
  /// From standstill to 60 Hz by the default ramp, and a second.
  SimDuration run_up() const { return from_seconds(settings.acceleration1 * 0.1 * 60 / 80) + 1s; }
  double rated_nm() const { return motor.rating.torque_nm; }
  double rated_radps() const { return motor.rating.speed_rpm * 3.14159265358979 / 30; }
  /// k w^2 that asks for a share of the rated torque at the rated speed.
  Load fan(double share = 1, double inertia_factor = 5) const {
    return {.inertia_kgm2 = inertia_factor * motor.mechanics.inertia_kgm2,
            .quadratic_nm_per_radps2 = share * rated_nm() / (rated_radps() * rated_radps())};
  }

  EventLoop loop;
  const Model& model;
  Motor motor;
  Settings settings;
  Axis axis;
  AcDrive drive;
};

}  // namespace virtdrive::asd7
