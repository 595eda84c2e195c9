// What a controller keeps in its flash: one set for the whole board, also where it drives two
// motors. Numbers are as they lie on the wire; page numbers are of the protocol document, V4.4.
#pragma once

#include <array>
#include <cstdint>

namespace virtdrive::md {

inline constexpr std::size_t kMostMotors = 2;
inline constexpr std::size_t kSteps = 7;
inline constexpr std::size_t kCurvePoints = 4;  // two for positive references, two for negative
inline constexpr std::size_t kPresets = 20;

/// A step that was never set follows MAX_RPM.
inline constexpr std::int32_t kStepNotSet = INT32_MIN;

struct CurvePoint {
  std::int32_t x = 0;  // 0: not set
  std::int32_t y = 0;
};

struct Settings {
  std::int32_t id = 1;
  std::int32_t baud_code = 2;  // 1 .. 5: 9600 .. 115200
  std::int32_t can_bitrate = 1;
  std::int32_t return_type = 0;

  // Signs and inputs
  std::int32_t inv_sign = 0, inv_sign2 = 0;          // of commands and feedback
  std::int32_t inv_sign_out = 0, inv_sign_out2 = 0;  // of feedback only
  std::int32_t use_limit_sw = 1;
  std::int32_t inv_alarm = 0;
  std::int32_t start_inv_sign = 0;
  std::int32_t run_inv_sign = 0;
  std::int32_t limit_stop_cond = 0;  // 1: short
  std::int32_t tq_limit_sw = 0;
  std::int32_t input_type = 0;
  std::int32_t low_speed_limit = 0, high_speed_limit = 0;    // high 0: not set
  std::int32_t low_volume_limit = 0, high_volume_limit = 0;  // of the internal volume
  std::int32_t dead_zone = 100;
  std::array<std::int32_t, kSteps> steps = {kStepNotSet, kStepNotSet, kStepNotSet, kStepNotSet,
                                            kStepNotSet, kStepNotSet, kStepNotSet};
  std::array<CurvePoint, kCurvePoints> curve{};

  // The motor
  std::int32_t hall_type = 2;
  std::int32_t enc_ppr = 0;
  std::int32_t use_eposi = 0;
  std::int32_t max_rpm = 3000;
  std::int32_t min_rpm = 1;
  std::int32_t max_load = 200;                             // 0.1 A; 0: the model's
  std::int32_t ccw_phase_offset = 0, cw_phase_offset = 0;  // degrees

  // Control
  std::int32_t zero_vel_ctrl = 0;
  std::int32_t regeneration = 0;
  std::int32_t tq_ctrl = 0;
  std::int32_t slow_start = 0, slow_down = 0;  // 1023: 15 s
  std::int32_t tar_vel = 0;
  std::int32_t pv_gain = 20, p_gain = 50, i_gain = 1800;
  std::int32_t tq_p_gain = 10, tq_i_gain = 20;
  std::int32_t in_position = 0;
  std::int32_t tar_posi_vel = 2000;
  std::int32_t posi_ss = 100, posi_sd = 100;
  std::int32_t posi_min = -1023, posi_cen = 0, posi_max = 1023;
  std::array<std::array<std::int32_t, kMostMotors>, kPresets> presets{};
  std::int32_t func_type = 0;
  std::int32_t func_speed = 1000, func_delay = 10;  // rpm, 0.1 s
  std::int32_t func_posi_speed = 1500, func_posi_increment = 240;
  std::int32_t watch_delay = 0;   // 0.1 s
  std::int32_t max_ss_time = 15;  // s that a slow start of 1023 takes
  std::int32_t ui_com = 0;        // 1: frames drive from power-up on
  std::int32_t over_modulation = 0;

  // Kept and read back, without effect
  std::int32_t later_26 = 0, stop_status2 = 0, use_limit_sw2 = 0, bluetooth = 0;
  std::int32_t later_81 = 0, sync_type = 0, no_modbus = 1, later_92 = 0, later_126 = 0;
  std::int32_t tq_po = 0, pwm_out = 0, limit_tq = 0;
};

/// Poles of HALL_TYPE (p. 8): a table up to 5, then twice the value.
constexpr int poles(std::int32_t hall_type) {
  constexpr std::array kPoles = {4, 8, 10, 12, 2, 6};
  return hall_type < 6 ? kPoles[static_cast<std::size_t>(hall_type)] : 2 * hall_type;
}

/// Hall edges in one turn of the motor: three a pole (p. 28).
constexpr int hall_counts_per_turn(std::int32_t hall_type) {
  return 3 * poles(hall_type);
}

constexpr int kBauds[] = {9600, 19200, 38400, 57600, 115200};
constexpr int baud(std::int32_t code) {
  return kBauds[code - 1];
}

/// bit/s of PID 137's codes 1..5 (p. 12).
constexpr int kCanBitRates[] = {50'000, 100'000, 250'000, 500'000, 1'000'000};
constexpr int can_bit_rate(std::int32_t code) {
  return kCanBitRates[code - 1];
}

/// The speed of step 1..7 in rpm.
constexpr std::int32_t step_rpm(const Settings& settings, std::size_t number) {
  const std::int32_t set = settings.steps[number - 1];
  return set != kStepNotSet ? set
                            : settings.max_rpm * static_cast<std::int32_t>(number) /
                                  static_cast<std::int32_t>(kSteps);
}

}  // namespace virtdrive::md
