// The parameters of an AC drive, each as the register holds it: the number of its unit, named by
// the function number that the 7-Series displays. Defaults are those of the smallest size; what
// depends on the size is in default_settings() (model.h).
//
// Numbers that the documents at hand do not confirm are named as later drives of the family have
// them; which those are is the parameter table's to say, not this file's.
#pragma once

#include <array>
#include <cstdint>

namespace virtdrive::asd7 {

inline constexpr std::size_t kPresetSpeeds = 15;
inline constexpr std::size_t kJumps = 3;

/// 0003: who gives the run command.
enum class CommandSource : std::uint8_t { kTerminals, kPanel, kSerial };
/// 0004, 0207: who gives the frequency.
enum class FrequencySource : std::uint8_t { kPanel, kVia, kVib, kViaAndVib, kSerial };
/// 0015
enum class VoltsPerHertz : std::uint8_t {
  kConstantTorque,
  kVariableTorque,
  kAutomaticBoost,         // the stator's drop is added, by the current measured
  kAutomaticBoostAndSlip,  // and the slip, by the torque estimated
};
/// 0017: which of the two guards of the motor work. Also a motor with a fan of its own.
enum class MotorGuard : std::uint8_t {
  kTripAndStall,
  kTrip,
  kStall,
  kNone,
  kForcedTripAndStall,
  kForcedTrip,
  kForcedStall,
  kForcedNone,
};
/// F302
enum class RideThrough : std::uint8_t { kOff, kRegenerate, kDecelerate };
/// F502, F503
enum class RampShape : std::uint8_t { kLinear, kS1, kS2 };
/// F603
enum class EmergencyStop : std::uint8_t { kCoast, kRamp, kDcBrake };

struct SpeedJump {
  std::uint16_t frequency = 0;  // 0.01 Hz
  std::uint16_t width = 0;      // 0.01 Hz, whole, around it; 0: none
};

struct Settings {
  // --- Basic ---
  std::uint16_t auto_acceleration = 0;     // 0000: kept, without effect
  std::uint16_t command_source = 0;        // 0003
  std::uint16_t frequency_source = 0;      // 0004
  std::uint16_t panel_reverse = 0;         // 0008: 0 forward, 1 reverse
  std::uint16_t acceleration1 = 100;       // 0009, 0.1 s from 0 to FH; 0: 0.01 s
  std::uint16_t deceleration1 = 100;       // 0010
  std::uint16_t maximum_frequency = 8000;  // 0011 FH, 0.01 Hz
  std::uint16_t upper_limit = 8000;        // 0012 UL, 0.01 Hz
  std::uint16_t lower_limit = 0;           // 0013 LL, 0.01 Hz
  std::uint16_t base_frequency1 = 6000;    // 0014 vL, 0.01 Hz
  std::uint16_t volts_per_hertz = 0;       // 0015 Pt
  std::uint16_t torque_boost1 = 60;        // 0016 vb, 0.1 % of the motor's voltage
  std::uint16_t motor_guard = 0;           // 0017 OLM
  std::array<std::uint16_t, kPresetSpeeds> preset_speeds{};  // 0018-0024, F287-F294, 0.01 Hz

  // --- Second motor, second sources ---
  std::uint16_t base_frequency2 = 6000;   // F170, 0.01 Hz
  std::uint16_t torque_boost2 = 60;       // F172, 0.1 %
  std::uint16_t motor_protection2 = 100;  // F173, % of the motor's rated current
  std::uint16_t stall_level2 = 150;       // F185, % of FE70; 200: off
  std::uint16_t frequency_source2 = 1;    // F207
  std::uint16_t source_switch = 0;        // F200: 1 frequency_source below 1 Hz gives way to F207

  // --- Terminals: the analog inputs' two points, 0.01 % to 0.01 Hz ---
  std::uint16_t via_point1 = 0, via_frequency1 = 0;         // F201, F202
  std::uint16_t via_point2 = 10000, via_frequency2 = 6000;  // F203, F204
  std::uint16_t vib_point1 = 0, vib_frequency1 = 0;         // F210, F211
  std::uint16_t vib_point2 = 10000, vib_frequency2 = 6000;  // F212, F213

  // --- Frequency ---
  std::uint16_t start_frequency = 50;     // F240, 0.01 Hz
  std::uint16_t dc_brake_frequency = 0;   // F250, 0.01 Hz; 0: off
  std::uint16_t dc_brake_current = 50;    // F251, % of FE70
  std::uint16_t dc_brake_time = 10;       // F252, 0.1 s
  std::uint16_t lower_limit_stop = 0;     // F256, 0.1 s at LL until it stops; 0: off
  std::uint16_t jog_frequency = 500;      // F260, 0.01 Hz
  std::array<SpeedJump, kJumps> jumps{};  // F270-F275

  // --- Protection of operation ---
  std::uint16_t carrier = 120;          // F300, 0.1 kHz
  std::uint16_t flying_start = 0;       // F301: 1 after an interruption, 2 always
  std::uint16_t ride_through = 0;       // F302
  std::uint16_t retries = 0;            // F303: 0 off, 1..10
  std::uint16_t braking_resistor = 0;   // F304: 0 off, 1 on, 2 on with its overload guard
  std::uint16_t overvoltage_limit = 0;  // F305: 0 on, 1 off
  std::uint16_t supply_correction = 2;  // F307: 0..1 output follows the link, 2..3 it does not
  std::uint16_t resistor_ohm = 2000;    // F308, 0.1 Ohm
  std::uint16_t resistor_power = 12;    // F309, 0.01 kW

  // --- PI control ---
  std::uint16_t pi_control = 0;        // F360: 1 on
  std::uint16_t pi_feedback = 1;       // F360's input: 1 VIA, 2 VIB (FrequencySource)
  std::uint16_t pi_filter = 1;         // F361, 0.1 s
  std::uint16_t pi_proportional = 30;  // F362, 0.01
  std::uint16_t pi_integral = 20;      // F363, 0.01 / s

  // --- Motor ---
  std::uint16_t slip_gain = 70;  // F401, %
  std::uint16_t boost_gain =
      49;  // F402, 0.1 % of the motor's voltage per rated current: 0.7 of the stator's drop
  std::uint16_t rated_current = 30;    // F415, 0.1 A
  std::uint16_t no_load_current = 65;  // F416, % of rated_current
  std::uint16_t rated_rpm = 1722;      // F417

  // --- Second ramp, shapes ---
  std::uint16_t acceleration2 = 100;  // F500, 0.1 s
  std::uint16_t deceleration2 = 100;  // F501, 0.1 s
  std::uint16_t ramp_shape1 = 0;      // F502
  std::uint16_t ramp_shape2 = 0;      // F503
  std::uint16_t ramp_switch = 0;      // F505, 0.01 Hz: ramp 1 below, 2 above; 0: off
  std::uint16_t s_lower = 10;         // F506, % of the ramp's span that is round at its start
  std::uint16_t s_upper = 10;         // F507, % at its end

  // --- Protections ---
  std::uint16_t motor_protection1 = 100;    // 0600 tHr, % of the motor's rated current
  std::uint16_t stall_level1 = 150;         // F601, % of FE70; 200: off
  std::uint16_t keep_trip = 0;              // F602: 1 a trip outlives power-off
  std::uint16_t emergency_stop = 0;         // F603
  std::uint16_t emergency_brake_time = 10;  // F604, 0.1 s, of EmergencyStop::kDcBrake
  std::uint16_t output_phase_guard = 0;     // F605: 1 on
  std::uint16_t derating_frequency =
      3000;  // F606, 0.01 Hz: below, a motor with its own fan cools less
  std::uint16_t motor_overload_time = 300;  // F607, s at 150 %
  std::uint16_t input_phase_guard = 1;      // F608: 1 on
  std::uint16_t low_current_trip = 0;       // F610: 0 alarm, 1 trip
  std::uint16_t low_current = 0;            // F611, % of FE70
  std::uint16_t low_current_time = 0;       // F612, s; 0: off
  std::uint16_t over_torque_trip = 0;       // F615: 0 alarm, 1 trip
  std::uint16_t over_torque = 130;          // F616, % of the motor's rated torque; 0: off
  std::uint16_t over_torque_time = 5;       // F618, 0.1 s
  std::uint16_t undervoltage_trip = 0;      // F627: 0 coast and go on, 1 trip
  std::uint16_t run_hours_alarm = 0;        // F621, 100 h: run hours that raise the alarm; 0: off

  // --- Communication: acted upon by the device, kept with the rest ---
  std::uint16_t baud = 3;             // F800
  std::uint16_t parity = 1;           // F801
  std::uint16_t number = 0;           // F802
  std::uint16_t time_out = 0;         // F803, s; 0: off
  std::uint16_t time_out_action = 1;  // F804: 0 alarm, 1 trip and coast, 2 ramp stop and trip
  std::uint16_t wait_time = 0;        // F805, 0.01 s
  std::uint16_t inter_drive = 0;      // F806
  std::uint16_t point1 = 0, point1_frequency = 0;       // F811 %, F812 0.01 Hz
  std::uint16_t point2 = 100, point2_frequency = 6000;  // F813 %, F814 0.01 Hz
  std::uint16_t note = 0;                               // F880

  // --- Locks ---
  std::uint16_t command_lock = 0;  // F736: 1 CMOD and FMOD cannot be changed while it runs
};

}  // namespace virtdrive::asd7
