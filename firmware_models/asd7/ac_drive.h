// The program of an AC drive: from commands and set-points, by ramps and a V/f curve, to an output
// voltage; what stops it; what it reports.
//
//   AcDrive drive(loop, axis, find_model("0.75"), settings, memory, seed);
//   drive.set_frequency(6000);        // FA01, 60.00 Hz
//   drive.set_command(0xc400);        // FA00: command and frequency priority, run
//   drive.monitor().output_frequency  // FD00
//   drive.frozen().output_frequency   // FE00
//
// It lives as long as its bench, through power failures and resets: the CPU runs while alive().
// What a register holds is given in the register's unit, named by the function number.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/asd7/model.h"
#include "firmware_models/asd7/settings.h"
#include "firmware_models/asd7/trip.h"

namespace virtdrive::asd7 {

/// The terminals, and what else a person can touch. Analog inputs in 0.01 %.
struct Terminals {
  bool forward = false, reverse = false;
  bool standby = true;             // ST; off: coast
  bool reset = false;              // RES, on its edge
  std::array<bool, 4> preset{};    // S1..S4: preset speed, S1 the lowest bit
  bool thermistor = false;         // OH2
  bool local = false;              // takes command and frequency from the serial line
  std::uint16_t via = 0, vib = 0;  // 0..10000

  bool operator==(const Terminals&) const = default;
};

/// kStop twice within 1 s while the panel does not command: emergency stop.
enum class PanelKey : std::uint8_t { kRun, kStop, kReset };

/// What the drive keeps without power, besides the settings.
struct Memory {
  std::array<std::uint8_t, 4> past_trips{};  // FE10 (the latest) .. FE13
  std::uint8_t kept_trip = 0;                // F602
  std::uint64_t run_seconds = 0;             // FE14 counts hours
  double input_kwh = 0, output_kwh = 0;      // FE76, FE77
  std::uint32_t eeprom_writes = 0;           // wear: by parameters, trips and hours

  bool operator==(const Memory&) const = default;
};

/// FDxx and FExx, each in its register's unit.
struct Monitor {
  std::uint16_t output_frequency = 0;      // 00, 0.01 Hz, magnitude
  std::uint16_t status = 0;                // 01, StatusBit
  std::uint16_t frequency_command = 0;     // 02, 0.01 Hz, magnitude
  bool reverse = false;                    // sign of 00 and 02
  std::uint16_t output_current = 0;        // 03, 0.01 % of FE70
  std::uint16_t input_voltage = 0;         // 04, 0.01 %: link / (sqrt 2 * class)
  std::uint16_t output_voltage = 0;        // 05, 0.01 % of the class, line to line, rms
  std::uint16_t input_terminals = 0;       // 06: bit 0 F, 1 R, 2 RES, 3.. S1..S4, 7 ST
  std::uint16_t output_terminals = 0;      // 07: bit 0 RY (low-speed signal), 1 RCH (reached), 2 FL
  std::int16_t compensated_frequency = 0;  // 15, 0.01 Hz: with slip compensation, signed
  std::int16_t estimated_speed = 0;        // 16, 0.01 Hz, signed
  std::int16_t filtered_speed = 0;         // 17, 0.01 Hz, 1 s
  std::int16_t torque = 0;                 // 18, 0.01 % of the motor's rated torque, signed
  std::int16_t torque_command = 0;         // 19, 0.01 %: 0, there is no torque control
  std::int16_t torque_current = 0;         // 20, 0.01 % of FE70, signed
  std::int16_t exciting_current = 0;       // 21, 0.01 % of FE70
  std::int16_t pi_feedback = 0;            // 22, 0.01 Hz
  std::uint16_t motor_overload = 0;        // 23, 0.01 %
  std::uint16_t inverter_overload = 0;     // 24, 0.01 %
  std::uint16_t resistor_overload = 0;     // 25, 1 %
  std::uint16_t motor_load = 0;            // 26, 1 %: current of the motor's rated
  std::uint16_t inverter_load = 0;         // 27, 1 %: current of FE70
  std::uint16_t input_power = 0;           // 29, 0.01 kW
  std::uint16_t output_power = 0;          // 30, 0.01 kW
  std::uint16_t via = 0, vib = 0;          // 35, 36, 0.01 %
  std::uint16_t command_source = 0;        // 45, CommandSource
  std::uint16_t frequency_source = 0;      // 46: FrequencySource; 10 preset speed, 11 jog
  std::uint16_t operating_speed = 0;       // 58, 0.01 Hz, magnitude
  std::int16_t heat_sink = 0;              // degC
};

class AcDrive {
 public:
  /// `axis` hangs on a link made by mains_link(). Throws nothing; the CPU starts 1 s after the link
  /// has its voltage.
  AcDrive(EventLoop& loop, Axis& axis, const Model& model, const Settings& settings,
          const Memory& memory, const Seed& seed);
  ~AcDrive();
  AcDrive(const AcDrive&) = delete;
  AcDrive& operator=(const AcDrive&) = delete;

  const Model& model() const;

  // --- Life ---
  /// The CPU runs: has a supply and is not in a reset's dead time. Dead, it hears and says nothing.
  bool alive() const;
  /// Called when the CPU starts, at power-up and after a reset: the parameters are to be loaded
  /// from the EEPROM (set_settings) and all FAxx are 0.
  void set_on_start(std::function<void()> on_start);
  /// Called when it dies.
  void set_on_stop(std::function<void()> on_stop);

  // --- Settings and what is kept ---
  const Settings& settings() const;
  /// Acts with the next turn of the program. Range checks are the caller's.
  void set_settings(const Settings& settings);
  /// The output is on, or a run command waits: parameters that are locked while running are.
  bool running() const;
  const Memory& memory() const;
  /// A parameter went to the EEPROM.
  void count_eeprom_write();

  // --- Serial line ---
  enum class CommandResult : std::uint8_t {
    kTaken,
    kRestarts,  // bit 13 while tripped: no reply, the CPU is dead for 2 s
    kIgnored,   // bit 13 without a trip, or too early after an overload: no reply
  };
  /// FA00, FA04. Run bits act while bit 15 stands or CMOD is serial; bits 12 and 13 always.
  CommandResult set_command(std::uint16_t word);
  std::uint16_t command() const;
  /// FA20: bit 1 clears the energies (on its edge), 7 stops as fast as it can, 8-9 ramp 1 or 2.
  void set_command2(std::uint16_t word);
  std::uint16_t command2() const;
  /// FA01, FA05, 0.01 Hz, 0..FH (the caller's check).
  void set_frequency(std::uint16_t frequency);
  std::uint16_t frequency() const;
  /// F803 ran out: acts by F804.
  void communication_lost();
  /// The alarm of F804 = 0 ends with the next frame.
  void communication_found();

  // --- Panel and terminals ---
  void press(PanelKey key);
  /// FA03, 0.01 Hz.
  void set_panel_frequency(std::uint16_t frequency);
  std::uint16_t panel_frequency() const;
  void set_terminals(const Terminals& terminals);
  const Terminals& terminals() const;

  // --- Bench ---
  void set_ambient_degc(double degc);
  double ambient_degc() const;
  /// A cause that lasts until it is taken away: EF2 and OCA trip while the output is on or starts,
  /// the others (Err2, Err3, Err4, Err7) at once; kNone: none.
  void inject(Trip cause);
  /// EEP1, EEP2, EEP3, by the device that keeps the settings.
  void eeprom_failed(Trip how);

  // --- What is reported ---
  Trip trip() const;                // FC90
  std::uint16_t alarms() const;     // FC91, AlarmBit
  bool tripped() const;             // also while waiting for a retry
  Monitor monitor() const;          // FDxx
  Monitor frozen() const;           // FExx: at the trip, else the present
  bool fault_relay() const;         // FL
  std::uint16_t run_hours() const;  // FE14
  double bus_v() const;             // as measured
  double heat_sink_degc() const;
  double output_hz() const;             // signed
  double process_frequency_hz() const;  // the command after PI, before the ramp, signed
  std::uint64_t ticks() const;          // turns of the modulator so far: equal for equal runs

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace virtdrive::asd7
