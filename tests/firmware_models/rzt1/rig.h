// The kit with two motors on a bench without a line.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "core/event_loop.h"
#include "firmware_models/rzt1/servo_drive.h"
#include "plant/motor_library.h"

namespace virtdrive::rzt1 {

inline constexpr double kTurnRad = 2 * std::numbers::pi;
inline constexpr std::int32_t kTurn = 131072;  // counts

/// The bench that the factory settings were chosen for: a 400-W motor on 280 V.
inline AxisParameters bench_axis() {
  const Motor motor = find_motor("servo-400w");
  return {.motor = motor.electrical,
          .link = {.source_v = 280, .resistance_ohm = 0, .capacitance_f = 470e-6},
          .mechanics = motor.mechanics};
}

class Rig {
 public:
  explicit Rig(const AxisParameters& parameters = bench_axis(), const FirmwareOptions& options = {},
               const Hardware& board = {}, Settings settings = {})
      : hardware(board) {
    const DcBus bus(parameters.link, Integrator::kFast);
    axes_.reserve(2);
    for (int i = 0; i < 2; ++i) axes_.emplace_back(parameters, bus);
    for (Axis& axis : axes_) pointers_.push_back(&axis);
    std::array<Settings, 2> both{settings, settings};
    both[1].address = 2;
    drive = std::make_unique<ServoDrive>(loop, pointers_, both, hardware, Seed{1}, options);
  }

  ServoAxis& axis(std::size_t number = 0) { return drive->axis(number); }
  Axis& plant(std::size_t number = 0) {
    axes_[number].advance_to(loop.now());
    return axes_[number];
  }
  double angle_rad(std::size_t number = 0) { return plant(number).state().angle_rad; }

  void run_for(SimDuration time) { loop.run_until(loop.now() + time); }
  /// How long it took; below 0 if it never was.
  template <class Condition>
  double run_to(Condition&& condition, double patience_s = 10) {
    const SimTime from = loop.now();
    if (!loop.run_until(from + from_seconds(patience_s), condition)) return -1;
    return seconds(loop.now() - from);
  }
  double run_to_end_of_motion(std::size_t number = 0, double patience_s = 20) {
    return run_to([&] { return !axis(number).moving() && !axis(number).busy(); }, patience_s);
  }

  /// Servo on, phased and at rest.
  Result ready(std::size_t number = 0) {
    const Result result = axis(number).on();
    if (result != Result::kOk) return result;
    run_to([&] { return !axis(number).busy(); });
    run_for(std::chrono::milliseconds(50));
    return Result::kOk;
  }
  void set(std::int32_t Settings::* parameter, std::int32_t value, std::size_t number = 0) {
    if (axis(number).set(parameter, value) != Result::kOk) throw SetupError("refused");
  }
  double move_to(std::int32_t position, std::size_t number = 0) {
    axis(number).set_target(position);
    if (axis(number).go() != Result::kOk) return -1;
    return run_to_end_of_motion(number);
  }
  void turn_to(double angle, std::size_t number = 0) {
    plant(number).set_motion(angle, 0);
    drive->hardware_changed();
    run_for(std::chrono::milliseconds(2));
  }
  void change_load(const Load& load, std::size_t number = 0) { plant(number).set_load(load); }

  EventLoop loop;
  Hardware hardware;

 private:
  std::vector<Axis> axes_;
  std::vector<Axis*> pointers_;

 public:
  std::unique_ptr<ServoDrive> drive;
};

}  // namespace virtdrive::rzt1
