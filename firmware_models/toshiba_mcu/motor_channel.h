// The program of one motor channel: stages, field-oriented control without a sensor, protections.
//
//   Stop -> Bootstrap -> ZeroCurrentMeasure -> Initposition -> Force <-> FOC
//    ^                                                           |
//    +--- Brake / gentle ramp / Emergency <----------------------+
//
// The board calls it as the MCU's hardware would: pwm_interrupt() each PWM period while
// pwm_active(), millisecond() each 1 kHz tick, poll() each 100 ms. It sees ADC counts and sets gate
// states; it knows nothing of the plant.
//
// Source: MCU Motor Studio protocol 3.10 for what a host sees; the maker's published firmware 1.x
// for transitions, durations and control laws.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware_models/toshiba_mcu/scaling.h"
#include "firmware_models/toshiba_mcu/settings.h"
#include "firmware_models/toshiba_mcu/stage.h"
#include "plant/inverter.h"

namespace virtdrive::toshiba_mcu {

/// What the MCU's converters read at the start of a PWM period.
struct AdcReading {
  std::array<int, 3> current_counts{kAdcMiddle, kAdcMiddle, kAdcMiddle};
  int bus_counts = 0;
};

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
  void set_speed_rpm(std::int32_t rpm);
  /// For torque control, 0 ... torque_limit_mnm(); the sign is the set speed's.
  void set_torque_mnm(std::int32_t torque_mnm) { torque_mnm_ = torque_mnm; }
  std::int32_t torque_limit_mnm() const;

  // --- What the hardware calls ---
  void pwm_interrupt(const AdcReading& reading);
  void millisecond(const AdcReading& reading);
  void poll();
  /// Once a second: over-temperature is 6 readings at the limit in a row, released 5 degC below.
  void temperature_check(double degc);

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
  struct Internals {
    double id_a = 0, iq_a = 0, id_ref_a = 0, iq_ref_a = 0;
    double vd_v = 0, vq_v = 0;
    double theta_turns = 0;  // electrical, 0..1
    double omega_hz = 0;     // estimated
    double command_hz = 0;   // ramped
    double bus_v = 0;
  };
  const Internals& internals() const { return now_; }
  const Scaling& scaling() const { return scaling_; }

 private:
  bool energised() const;  // a stage in which currents are controlled
  double target_hz() const;
  bool torque_controlled() const { return method_ == Method::kTorque && stage_ == Stage::kFoc; }
  void enter(Stage stage);
  void trip(Fault fault);
  void halt();
  void forget_measurements();
  void set_target(std::int32_t rpm);

  void measure_zero_current(const AdcReading& reading);
  void measure(const AdcReading& reading);
  bool protect(const AdcReading& reading);
  void advance_angle();
  void set_current_reference();
  void control_speed();
  void control_torque();
  void control_currents();
  void modulate(double v_alpha, double v_beta);
  void ramp_command();
  void reduce_speed();
  void end_speed_reduction();
  void watch_bus(const AdcReading& reading);
  void watch_stall();

  ChannelSettings settings_;
  Scaling scaling_;
  Stage stage_ = Stage::kStop;
  std::uint32_t errors_ = 0;
  BridgeCommand output_;
  Internals now_;

  Method method_ = Method::kSpeed;
  Method next_method_ = Method::kSpeed;
  std::int32_t torque_mnm_ = 0;
  std::int32_t set_rpm_ = 0;
  std::optional<std::int32_t> rpm_before_stop_;  // while a gentle stop is under way
  bool angle_known_ = false;                     // theta was kept by a gentle stop
  std::optional<double> reduced_target_hz_;      // while the load reduces the speed

  std::int32_t stage_ms_ = 0;  // 1 kHz ticks since the stage was entered
  std::int32_t position_delay_ms_ = 0;
  int zero_periods_ = 0;
  std::array<int, 3> zero_sum_{};
  std::array<double, 3> zero_counts_{};
  double sine_ = 0, cosine_ = 1;
  double d_integral_v_ = 0, q_integral_v_ = 0;
  double iq_integral_a_ = 0;
  std::array<double, 5> omega_history_hz_{};
  std::size_t omega_index_ = 0;

  int disconnected_periods_ = 0;
  int hot_checks_ = 0;
  int bad_stall_checks_ = 0;
  double good_emf_per_hz_ = 0;
  int restart_in_polls_ = 0;  // after a stall, with RestartMode 1
};

}  // namespace virtdrive::toshiba_mcu
