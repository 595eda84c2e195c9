// The kit's servo firmware over its board: two axes, the electronic gear between them, the 50 us
// task on the event loop, inputs, outputs, DIP switches, the recorder.
//
//   Hardware hardware;                                        // the bench's
//   ServoDrive drive(loop, axes, {factory_settings(1), factory_settings(2)}, hardware, seed);
//   drive.axis(0).on();
//
// It lives as long as the board has power; restart() is a reset of the MCU. An axis that is off and
// at rest is looked at once a millisecond only.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/rzt1/hardware.h"
#include "firmware_models/rzt1/recorder.h"
#include "firmware_models/rzt1/servo_axis.h"
#include "plant/axis.h"

namespace virtdrive::rzt1 {

class ServoDrive {
 public:
  static constexpr std::size_t kAxes = 2;

  /// Two plant axes; they and `hardware` must outlive the drive, which switches the gates off when
  /// it comes and when it goes.
  ServoDrive(EventLoop& loop, std::span<Axis* const> axes,
             const std::array<Settings, kAxes>& settings, Hardware& hardware, const Seed& seed,
             const FirmwareOptions& options = {});
  ServoDrive(const ServoDrive&) = delete;
  ServoDrive& operator=(const ServoDrive&) = delete;
  ~ServoDrive();

  /// A reset: gates off, everything as after power-up with these settings. Absolute encoders answer
  /// 150 ms later. References to the axes stay good.
  void restart(const std::array<Settings, kAxes>& settings);

  ServoAxis& axis(std::size_t number) { return units_[number].axis(); }
  const ServoAxis& axis(std::size_t number) const { return units_[number].axis(); }
  Recorder& recorder() { return recorder_; }
  const Recorder& recorder() const { return recorder_; }
  /// TRACE, with the task kept awake for it.
  Result set_trigger(int trigger);

  /// The pins or sensors have changed.
  void hardware_changed();
  const Hardware& hardware() const { return hardware_; }
  /// INP: Halls, inputs of both axes (7.3).
  std::uint16_t inputs() const;
  /// OUT1, OUT2.
  bool output(std::size_t number) const { return outputs_[number]; }
  void set_output(std::size_t number, bool on) { outputs_[number] = on; }
  /// TIMER: the PWM timer as the task ended, 0..7499 of 50 us.
  std::int32_t timer() const { return timer_; }

  /// 50 us tasks run so far, of both axes.
  std::uint64_t slots() const { return slots_; }

 private:
  // An axis with its inverter and sensors.
  struct Unit {
    Axis* plant = nullptr;
    std::optional<ServoAxis> servo;  // made anew in its place by a reset
    bool awake = true;
    SlotOutput::Mode loaded = SlotOutput::Mode::kOff;
    double seen_rad = 0;  // the shaft's angle at the last slot
    double pole_pairs = 1;
    double warmth_k = 0;  // of the inverter above its surroundings

    ServoAxis& axis() { return *servo; }
    const ServoAxis& axis() const { return *servo; }
  };

  void start(const std::array<Settings, kAxes>& settings);
  void task();
  void slot(std::size_t number);
  void millisecond(Unit& unit);
  void wake(std::size_t number);
  void schedule();
  bool at_rest(const Unit& unit) const;
  SlotReading sample(std::size_t number);
  ShaftReading read_shaft(Unit& unit, const AxisHardware& hardware, double angle_rad) const;
  std::uint8_t hall_pins(std::size_t number, double angle_rad) const;
  void load(Unit& unit, const AxisHardware& hardware);
  std::int32_t inverter_counts(Unit& unit);
  void switch_off(Unit& unit);
  std::int32_t measure_timing() const;

  EventLoop& loop_;
  Hardware& hardware_;
  FirmwareOptions options_;
  std::array<Unit, kAxes> units_;
  CurrentSensor current_sensor_;
  VoltageSensor bus_sensor_;
  RandomStream noise_;
  Recorder recorder_;
  std::array<bool, 2> outputs_{};
  std::int32_t timer_ = 0;
  std::uint64_t slots_ = 0;
  SimTime encoders_answer_at_;
  Wakeup task_;
};

}  // namespace virtdrive::rzt1
