// Settings in the units that the control loops work with. Recomputed when a setting is written;
// takes effect at the next PWM interrupt.
#pragma once

#include "core/sim_time.h"
#include "firmware_models/toshiba_mcu/settings.h"

namespace virtdrive::toshiba_mcu {

/// The MCU's converter: 12 bits over 5 V; current amplifiers rest at 2.5 V.
inline constexpr int kAdcMaximum = 4095;
inline constexpr int kAdcMiddle = 2048;
inline constexpr double kAdcVoltsPerCount = 5.0 / 4096;

/// Gains that GainCurrentMeasure chooses between: the amplifiers of the M374 board (5.1.48).
inline constexpr double kCurrentGains[] = {1, 2, 4, 5, 8, 10, 16, 32};

/// Frequencies are electrical, in Hz; currents peak phase currents.
struct Scaling {
  double pole_pairs = 1;
  double gear_factor = 1;
  double acceleration_hz_per_s = 0;
  double torque_nm_per_a = 0;
  double resistance_ohm = 0;
  double inductance_h = 0;
  double speed_limit_hz = 0;
  double speed_change_hz = 0;
  double full_scale_hz = 0;  // HzMax: the Q15 full scale of omega, 1.2 times the limit
  double iq_start_a = 0;     // the smaller of IqStart and IqLimit
  double id_start_a = 0;
  double iq_limit_a = 0;
  double full_scale_a = 0;  // a_max: the current at which the ADC ends
  double full_scale_v = 0;  // v_max, whole volts: the Q15 full scale of the voltage registers
  double bus_v_per_count = 0;
  double current_a_per_count = 0;

  // Current controllers: V per A, and V per A per PWM period.
  double id_kp = 0, id_ki = 0, iq_kp = 0, iq_ki = 0;
  double position_kp_hz_per_v = 0;  // Kp + Ki / PWM frequency: Ki is not accumulated
  double speed_kp_a_per_hz = 0;
  double speed_ki_a_per_hz = 0;  // per PWM period
  double stall_voltage_v = 0;
  double over_current_a = 0;     // 0: off
  double speed_reduction_a = 0;  // |Iq_ref| above which the target follows the actual speed

  SimDuration pwm_period{};  // 0: PwmFrequency 0, the motor cannot be started
};

Scaling scale(const ChannelSettings& settings);

/// Electrical Hz of a speed setting: unit 0 Hz (electrical), 1 rpm (mechanical).
double electrical_hz(UnitValue speed, double pole_pairs);

}  // namespace virtdrive::toshiba_mcu
