// The CTRL connector, and what the program makes of its inputs (p. 8 .. 10, 14, 15, 25).
#pragma once

#include <cstdint>

#include "firmware_models/md/settings.h"

namespace virtdrive::md {

/// The pins of one motor's connector. A switch that is on is connected to ground. As a bench starts
/// them nothing moves: the speed input is at 0 V.
struct Terminals {
  bool int_speed = false;    // 2: the internal volume gives the speed
  bool alarm_reset = false;  // 5
  bool cw = true;            // 6, DIR: on is CW
  bool run = true;           // 7, RUN/BRAKE
  bool start = true;         // 8, START/STOP
  double speed_v = 0;        // 10: 0 .. 5 V
  double pwm_duty = 0;       // 10 as PWM above 5 kHz, 0 .. 1; 0: the voltage counts
  double pulse_hz = 0;       // PULSE_IN as pulses
  double rc_ms = 0;          // PULSE_IN as RC servo pulse; 0: no pulses come
  double volume = 0;         // internal volumes, 0 .. 1
  double slow_start_volume = 0;
  double slow_down_volume = 0;
};

/// How the speed input is read (PID 25).
enum class InputType : std::uint8_t { kAnalog, kJoystick, kPulse, kRcServo, kStep = 5 };

/// START/STOP and RUN/BRAKE behind their inversions (PID 36, 37).
bool started(const Terminals& pins, const Settings& settings);
bool running(const Terminals& pins, const Settings& settings);

/// The pins as PID 48 shows them: encoder inputs open.
std::uint8_t input_byte(const Terminals& pins);

/// Pin 10 as the converter sees it, 0..1023.
std::int32_t analog_counts(const Terminals& pins);

/// The speed input, -1023..1023, behind limits, dead zone and curve. Not for InputType::kStep.
double speed_input(const Terminals& pins, const Settings& settings);
/// The internal volume behind its limits, 0..1023.
double volume_input(const Terminals& pins, const Settings& settings);
/// Step 0..7: INT_SPEED + 2 RUN + 4 START.
std::size_t step_number(const Terminals& pins);

/// A raw value between two limits, 0..1023: below `low` 0, above `high` (0: not set) full.
double between_limits(double raw, std::int32_t low, std::int32_t high);
/// Within the dead zone 0, the rest stretched to the full scale.
double without_dead_zone(double raw, std::int32_t dead_zone);
/// Through the points that are set.
double curve(double raw, const Settings& settings);
/// Position that an input stands for: MIN, CEN, MAX at -1023, 0, 1023.
double position_input(double raw, const Settings& settings);

}  // namespace virtdrive::md
