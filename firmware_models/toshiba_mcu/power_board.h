// A power board: what lies between one channel's program and its motor. Three shunts, a DC link
// divider and a temperature sensor on the MCU's converter; the encoder's inputs; a connector with
// an emergency pin and signals for the speed; three half bridges on the MCU's PWM unit.
//
// It calls the program as the hardware does: a PWM interrupt each period while the PWM unit runs,
// the 1 kHz tick while the motor is not stopped, and the slow tasks each 100 ms and each second.
// The duty cycles that an interrupt computes are loaded at the start of the next period; gates go
// off at once. Without a program, before a board is made and after it is gone, the gates are off.
#pragma once

#include <array>
#include <functional>
#include <string_view>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/toshiba_mcu/motor_channel.h"
#include "plant/axis.h"
#include "plant/sensors.h"

namespace virtdrive::toshiba_mcu {

/// A board as it is built, whatever the parameters take it for.
struct BoardHardware {
  double current_v_per_a = 0.316;  // shunt and amplifier, before GainCurrentMeasure
  double bus_v_per_v = 0.091;      // divider
  double over_voltage_pin_v = 30;  // the driver block's comparator; assumed
  double zero_error_a = 0.008;     // assumed: about two counts
  double noise_a = 0.002;          // assumed: half a count
};

/// 24 V, the sensitivities of the maker's M37Sigma.
inline constexpr BoardHardware kLowVoltageBoard{};

/// What a bench may do to a board; stays as it is over the MCU's resets.
struct BoardInputs {
  double temperature_degc = 25;  // of the board, where its thermistor is
  NtcSensor::Fault thermistor = NtcSensor::Fault::kNone;
  bool emergency = false;               // the driver block's pin is pulled
  std::array<SensorFault, 3> shunts{};  // of phases U, V, W
  SensorFault bus_divider{};
  ShaftSensors shaft{};
  // The signals of ExternalSpeedControl.
  double speed_v = 0;          // 0..5 V at the analogue input
  double speed_pwm = 0;        // high share of the PWM signal, 0..1
  double speed_servo_us = 0;   // length of the servo pulse; 0: none comes
  bool speed_reverse = false;  // the direction pin
};

class PowerBoard {
 public:
  /// `name` names the noise's stream: "board0". `after_interrupt`, if any, is called after each PWM
  /// interrupt. The axis must outlive the board, which switches its gates off when it comes and
  /// when it goes.
  PowerBoard(EventLoop& loop, Axis& axis, const Seed& seed, std::string_view name,
             const BoardHardware& hardware = kLowVoltageBoard,
             std::function<void()> after_interrupt = nullptr);
  PowerBoard(const PowerBoard&) = delete;
  PowerBoard& operator=(const PowerBoard&) = delete;
  ~PowerBoard();

  const MotorChannel& channel() const { return channel_; }
  Outcome start();
  Outcome start_torque_control();
  Outcome stop();
  void set_speed_rpm(std::int32_t rpm);
  void set_torque_mnm(std::int32_t torque_mnm) { channel_.set_torque_mnm(torque_mnm); }
  void set_method(Method method) { channel_.set_method(method); }
  void set_settings(const ChannelSettings& settings);

  Outcome do_turn(std::int32_t turns, std::int32_t max_rpm);
  bool do_linear_motion(std::uint32_t position, std::int32_t max_rpm);
  void abort_linear_motion() { channel_.abort_linear_motion(); }
  /// With the inputs as they stand now.
  std::int32_t encoder_count();
  std::uint32_t absolute_position();
  std::int32_t turn_number();

  /// As the firmware measures them now: DC link in V, temperature in degC. The thermistor is the
  /// board's; where the motor's winding has a thermal model it has one too, and the hotter counts.
  double bus_v();
  double temperature_degc();

  const BoardInputs& inputs() const { return inputs_; }
  /// The emergency pin acts at once: gates off while a motor runs.
  void set_inputs(const BoardInputs& inputs);
  void set_temperature_degc(double degc) { inputs_.temperature_degc = degc; }

 private:
  Reading read_inputs();
  void read_encoder();
  std::int64_t counted_edges(bool heard = true);
  void load_registers();
  void pwm_interrupt();
  void millisecond();
  void slow_tasks();
  void follow();

  EventLoop& loop_;
  Axis& axis_;
  BoardHardware hardware_;
  std::function<void()> after_interrupt_;
  MotorChannel channel_;
  std::array<CurrentSensor, 3> current_sensors_;
  VoltageSensor bus_sensor_;
  NtcSensor thermistor_;
  RandomStream noise_;
  BoardInputs inputs_;
  EdgeCounter counter_;
  int polls_ = 0;  // since the last whole second
  Bridge loaded_ = Bridge::kOff;
  Wakeup pwm_;
  Wakeup tick_;
  Wakeup slow_;
};

}  // namespace virtdrive::toshiba_mcu
