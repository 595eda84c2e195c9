#include "firmware_models/toshiba_mcu/scaling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kQ15 = 32768;

// Unit codes that are decimal exponents: 0, -3, -6, -9.
double decimal(UnitValue v) {
  return v.value * std::pow(10.0, v.unit);
}

// Unit codes of MaxAngAcc (5.1.3): 0 rad/s2, 1 Hz/s, both electrical; 2 rpm/s, 3 rpm/min,
// mechanical.
double acceleration_hz_per_s(UnitValue v, double pole_pairs) {
  switch (v.unit) {
    case 1:
      return v.value;
    case 2:
      return v.value * pole_pairs / 60;
    case 3:
      return v.value * pole_pairs / 3600;
    default:
      return v.value / (2 * std::numbers::pi);
  }
}

}  // namespace

double electrical_hz(UnitValue speed, double pole_pairs) {
  return speed.unit == 1 ? speed.value * pole_pairs / 60.0 : speed.value;
}

Scaling scale(const ChannelSettings& s) {
  Scaling c;
  c.pole_pairs = s.pole_pairs.value;
  c.gear_factor = std::max(1, s.encoder_gear_factor.value);
  c.acceleration_hz_per_s = acceleration_hz_per_s(s.max_angular_acceleration, c.pole_pairs);
  c.torque_nm_per_a = decimal(s.torque_factor);
  c.resistance_ohm = decimal(s.resistance);
  c.inductance_h = decimal(s.inductance);
  c.speed_limit_hz = electrical_hz(s.speed_limit, c.pole_pairs);
  c.speed_change_hz = electrical_hz(s.speed_change, c.pole_pairs);
  const double whole_limit = std::max(1.0, std::floor(c.speed_limit_hz));
  c.full_scale_hz = whole_limit + std::floor(whole_limit / 5);
  c.iq_limit_a = decimal(s.iq_limit);
  c.iq_start_a = std::min(decimal(s.iq_start), c.iq_limit_a);
  c.id_start_a = std::min(decimal(s.id_start), decimal(s.id_limit));

  // The sense amplifiers rest at 2.5 V of 5 V for currents, at 0 V for the bus. Sensitivity 0 would
  // divide by zero: then nothing is measured.
  const double gain = kCurrentGains[static_cast<std::size_t>(s.current_gain.value)];
  const double current_sensitivity = decimal(s.current_sensitivity) * gain;  // V/A
  const double voltage_sensitivity = decimal(s.voltage_sensitivity);         // V/V
  c.full_scale_a = current_sensitivity > 0 ? 2.5 / current_sensitivity : 0;
  c.full_scale_v =
      voltage_sensitivity > 0 ? std::floor(5.0 / voltage_sensitivity) : 0;  // an integer
  c.bus_v_per_count = voltage_sensitivity > 0 ? kAdcVoltsPerCount / voltage_sensitivity : 0;
  c.current_a_per_count = current_sensitivity > 0 ? kAdcVoltsPerCount / current_sensitivity : 0;

  // Gains are register values of the vector engine: Q15 of full scale volts per full scale amperes.
  const double register_v_per_a = c.full_scale_a > 0 ? c.full_scale_v / c.full_scale_a / kQ15 : 0;
  c.id_kp = s.pi_id_kp.value * register_v_per_a;
  c.id_ki = s.pi_id_ki.value * register_v_per_a;
  c.iq_kp = s.pi_iq_kp.value * register_v_per_a;
  c.iq_ki = s.pi_iq_ki.value * register_v_per_a;

  const double frequency = s.pwm_frequency.value;
  const double period = frequency > 0 ? 1 / frequency : 0;
  c.pwm_period = from_seconds(period);
  c.position_kp_hz_per_v = s.position_kp.value + s.position_ki.value * period;
  c.speed_kp_a_per_hz = s.speed_kp.value * 1e-3;
  c.speed_ki_a_per_hz = s.speed_ki.value * 1e-3 * period;
  c.stall_voltage_v = s.stall_detect_value.value / kQ15 * c.full_scale_v;
  c.over_current_a = s.over_current.value * 1e-3;
  c.speed_reduction_a = c.iq_limit_a * s.speed_reduction.value / 100.0;
  return c;
}

}  // namespace virtdrive::toshiba_mcu
