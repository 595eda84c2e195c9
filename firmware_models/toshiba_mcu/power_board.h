// A power board: what lies between one channel's program and its motor. Three shunts, a DC link
// divider and a temperature sensor on the MCU's converter; three half bridges on its PWM unit.
//
// It calls the program as the hardware does: a PWM interrupt each period while the PWM unit runs,
// the 1 kHz tick while the motor is not stopped, and the slow tasks each 100 ms and each second.
// The duty cycles that an interrupt computes are loaded at the start of the next period; gates go
// off at once.
#pragma once

#include <array>
#include <string_view>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/toshiba_mcu/motor_channel.h"
#include "plant/axis.h"
#include "plant/sensors.h"

namespace virtdrive::toshiba_mcu {

class PowerBoard {
 public:
  /// `name` names the noise's stream: "board0".
  PowerBoard(EventLoop& loop, Axis& axis, const Seed& seed, std::string_view name);
  PowerBoard(const PowerBoard&) = delete;
  PowerBoard& operator=(const PowerBoard&) = delete;

  const MotorChannel& channel() const { return channel_; }
  Outcome start();
  Outcome start_torque_control();
  Outcome stop();
  void set_speed_rpm(std::int32_t rpm);
  void set_torque_mnm(std::int32_t torque_mnm) { channel_.set_torque_mnm(torque_mnm); }
  void set_method(Method method) { channel_.set_method(method); }
  void set_settings(const ChannelSettings& settings);

  /// As the firmware measures them now: DC link in V, temperature in degC.
  double bus_v();
  double temperature_degc() const { return temperature_degc_; }
  void set_temperature_degc(double degc) { temperature_degc_ = degc; }

 private:
  AdcReading read_converters();
  void load_registers();
  void pwm_interrupt();
  void millisecond();
  void slow_tasks();
  void follow();

  EventLoop& loop_;
  Axis& axis_;
  MotorChannel channel_;
  std::array<CurrentSensor, 3> current_sensors_;
  VoltageSensor bus_sensor_;
  RandomStream noise_;
  double temperature_degc_ = 25;
  int polls_ = 0;  // since the last whole second
  Bridge loaded_ = Bridge::kOff;
  Wakeup pwm_;
  Wakeup tick_;
  Wakeup slow_;
};

}  // namespace virtdrive::toshiba_mcu
