// The program of one motor channel: stages, and what happens in each.
//
//   Stop -> Bootstrap -> ZeroCurrentMeasure -> Initposition -> Force <-> FOC
//    ^                                                           |
//    +--- Brake / gentle ramp / Emergency <----------------------+
//
// The board calls it as the MCU's hardware would: pwm_interrupt() each PWM period while
// pwm_active(), millisecond() each 1 kHz tick, poll() each 100 ms. It sees readings and sets gate
// states; it knows nothing of the plant. Currents, angle, encoder, motion and protections each have
// a file of their own; the channel puts them in order.
//
// Source: MCU Motor Studio protocol 3.10 for what a host sees; the maker's published firmware 1.x
// for transitions, durations and control laws.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware_models/toshiba_mcu/current_control.h"
#include "firmware_models/toshiba_mcu/encoder.h"
#include "firmware_models/toshiba_mcu/external_speed.h"
#include "firmware_models/toshiba_mcu/loop_state.h"
#include "firmware_models/toshiba_mcu/motion.h"
#include "firmware_models/toshiba_mcu/observer.h"
#include "firmware_models/toshiba_mcu/protections.h"
#include "firmware_models/toshiba_mcu/reading.h"
#include "firmware_models/toshiba_mcu/scaling.h"
#include "firmware_models/toshiba_mcu/settings.h"
#include "firmware_models/toshiba_mcu/stage.h"
#include "plant/inverter.h"

namespace virtdrive::toshiba_mcu {

class MotorChannel {
 public:
  explicit MotorChannel(const ChannelSettings& settings);

  const ChannelSettings& settings() const { return settings_; }
  /// New settings take effect at once for what is computed from them.
  void set_settings(const ChannelSettings& settings);

  // --- What the host asks for ---
  /// By speed, unless set_method() chose otherwise for this start.
  Outcome start();
  Outcome start_torque_control();
  Outcome stop();
  /// While running the method changes at once and without a bump; else it is that of the next
  /// start.
  void set_method(Method method);
  /// Clipped to the speed limit; against Direction: target 0 and a warning bit (5.1.66, bit 7).
  /// Ends a motion.
  void set_speed_rpm(std::int32_t rpm);
  /// For torque control, 0 ... torque_limit_mnm(); the sign is the set speed's.
  void set_torque_mnm(std::int32_t torque_mnm) { torque_mnm_ = torque_mnm; }
  std::int32_t torque_limit_mnm() const;

  // --- Motion (4.2.9, 4.2.14-4.2.16) ---
  /// So many turns on from the last target, or from where the motor is; starts it and stops it
  /// there. kRefused for max_rpm 0 and against Direction.
  Outcome do_turn(std::int32_t turns, std::int32_t max_rpm);
  /// To a position, which is then held; starts the motor if it is stopped. False for a position
  /// outside of EncoderMinPos ... EncoderMaxPos, max_rpm or EncoderLMApproach 0, a motion under
  /// way, a fault, against Direction.
  bool do_linear_motion(std::uint32_t position, std::int32_t max_rpm);
  /// The target speed becomes 0, the motor stays powered.
  void abort_linear_motion();
  /// In pulses at the gear's output, from EncoderStartPos on.
  std::uint32_t absolute_position() const;
  const EncoderCounter& encoder() const { return encoder_; }
  /// Whole turns of the motor since the reset, by the encoder or by the drive's own angle.
  std::int32_t turn_number() const;

  // --- What the hardware calls ---
  void pwm_interrupt(const Reading& reading);
  void millisecond(const Reading& reading);
  void poll(const SpeedSignals& signals);
  /// Once a second.
  void temperature_check(double degc);
  /// The encoder's inputs while no PWM interrupts come.
  void read_encoder(std::int64_t edges);

  /// True while PWM interrupts come: not in Stop, Brake and Emergency.
  bool pwm_active() const;
  /// The gates, as the registers stand now.
  const BridgeCommand& output() const { return output_; }

  // --- What the host can read; 0 in Stop, Brake and Emergency ---
  Stage stage() const { return stage_; }
  std::uint32_t errors() const { return errors_; }
  Method method() const { return pwm_active() ? method_ : Method::kIdle; }
  std::int32_t actual_rpm() const;
  std::int32_t target_rpm() const;
  std::uint32_t current_ma() const;
  std::uint32_t torque() const;  // 0.001 Ncm, labelled Ncm: TorqueFactor * Current / 10 (4.2.3)
  std::int32_t target_torque() const;  // 0.001 Ncm

  /// The loops' own numbers, for recordings.
  using Internals = LoopState;
  const Internals& internals() const { return now_; }
  const Scaling& scaling() const { return scaling_; }

 private:
  bool energised() const;  // a stage in which currents are controlled
  bool torque_controlled() const { return method_ == Method::kTorque && stage_ == Stage::kFoc; }
  bool is_set(Fault fault) const { return (errors_ & bit(fault)) != 0; }
  void enter(Stage stage);
  void trip(Fault fault);
  void halt();
  void forget_measurements();

  double target_hz() const;
  void set_target(std::int32_t rpm);
  bool allows(double direction) const;
  void ramp_command();
  void reduce_speed();
  void end_speed_reduction();

  double measured_hz() const;
  void set_current_reference();
  void hold_force_current();
  void control_speed();
  void control_torque();

  double turns_left() const;
  void step_motion();
  void follow_external_speed(const SpeedSignals& signals);
  void watch_stall();

  ChannelSettings settings_;
  Scaling scaling_;
  Stage stage_ = Stage::kStop;
  std::uint32_t errors_ = 0;
  BridgeCommand output_;
  LoopState now_;

  CurrentControl currents_;
  Observer observer_;
  EncoderCounter encoder_;
  Protections protections_;
  Motion motion_;

  Method method_ = Method::kSpeed;
  Method next_method_ = Method::kSpeed;
  std::int32_t torque_mnm_ = 0;
  std::int32_t set_rpm_ = 0;
  std::optional<std::int32_t> rpm_before_stop_;  // while a gentle stop is under way
  bool angle_known_ = false;                     // theta was kept by a gentle stop
  std::optional<double> reduced_target_hz_;      // while the load reduces the speed
  double motion_hz_ = 0;                         // the target while a motion is under way
  std::int64_t turn_target_ = 0;
  std::uint32_t position_target_ = 0;
  std::int64_t position_origin_ = 0;  // the count that EncoderStartPos stands for
  bool external_on_ = false;

  std::int32_t stage_ms_ = 0;  // 1 kHz ticks since the stage was entered
  std::int32_t position_delay_ms_ = 0;
  std::array<double, 5> speed_history_hz_{};
  std::size_t speed_index_ = 0;
  double encoder_offset_hz_ = 0;  // the encoder's speed less the estimator's, slowly
  int restart_in_polls_ = 0;      // after a stall, with RestartMode 1
};

}  // namespace virtdrive::toshiba_mcu
