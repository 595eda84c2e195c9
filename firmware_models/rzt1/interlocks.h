// The interlocks of chapter 7.1 in the order of its figure, once a millisecond.
//
// Each has a bit of EQUERY, which latches until ERESET; some have one of STA and a reaction of
// their own. At the end what ERRMASK names among the latched takes the power off. Bits of EQUERY
// are those of the successor's published example, or assumed where it has none (7, 18, 22, 23, 24).
#pragma once

#include <cstdint>

#include "firmware_models/rzt1/settings.h"

namespace virtdrive::rzt1 {

/// Bits of EQUERY and ERRMASK.
enum ErrorBit : std::uint32_t {
  kErrorEmpty = 1U << 7,
  kErrorPositionLow = 1U << 13,
  kErrorPositionHigh = 1U << 15,
  kErrorPosition = 1U << 17,
  kErrorInput = 1U << 18,
  kErrorSpeedDifference = 1U << 19,
  kErrorOverSpeed = 1U << 20,
  kErrorPreAlarm = 1U << 21,
  kErrorMotorHeat = 1U << 22,
  kErrorTemperature = 1U << 23,
  kErrorAmplifier = 1U << 24,
  kErrorOutputDisable = 1U << 25,
  kErrorOverCurrent = 1U << 26,
  kErrorOverVoltage = 1U << 27,
  kErrorUnderVoltage = 1U << 28,
};

/// ECP, ECV, EPO: as it was when the position error had lasted too long.
struct ErrorLatch {
  std::int32_t command_position = 0, command_velocity = 0, position = 0;
};

struct InterlockReading {
  std::int32_t total_current = 0;  // TC
  std::int32_t bus_counts = 0, temperature_counts = 0;
  bool amplifier_fault = false;
  std::uint8_t inputs = 0;
  bool watch_error = false;  // servo on and no search for the rotor under way
  bool moving = false;
  std::int32_t position = 0, position_error = 0, max_error = 0;
  std::int32_t velocity = 0;  // 16.16 counts per loop cycle
  std::int32_t command_position = 0, command_velocity = 0;
  std::int32_t loop_slots = 2;  // 50 us each
  std::int32_t empty_cycles = 0;
};

/// What the axis is to do.
struct InterlockOrder {
  bool stop = false;       // the motion, smoothly
  bool stop_off = false;   // and then the servo
  bool servo_off = false;  // at once
  bool power_off = false;
};

class Interlocks {
 public:
  /// `time_in_ms`: of ETIME and CTIME, else loop cycles.
  explicit Interlocks(bool time_in_ms = false) : time_in_ms_(time_in_ms) {}

  InterlockOrder check(const InterlockReading& reading, const Settings& settings);
  /// POE3 has put the outputs to high impedance; nothing waits for the millisecond.
  void output_disabled();

  /// What ON and ENABLE forget.
  void clear_status();
  void reset_errors() { errors_ = 0; }

  std::uint32_t errors() const { return errors_; }
  bool blocks(const Settings& settings) const {
    return (errors_ & static_cast<std::uint32_t>(settings.errmask)) != 0;
  }
  /// Bits 9, 10, 12, 13, 14 of STA.
  std::uint16_t status() const { return status_; }
  const ErrorLatch& latched() const { return latched_; }
  void set_latched(const ErrorLatch& latch) { latched_ = latch; }
  /// Of TC^2 - CLIMIT^2 over time, AD counts^2 ms.
  std::int32_t i2t() const;

 private:
  void set(std::uint16_t status, std::uint32_t error);
  void check_heat(const InterlockReading& reading, const Settings& settings);
  bool check_current(const InterlockReading& reading, const Settings& settings);
  bool check_error(const InterlockReading& reading, const Settings& settings);
  void check_inverter(const InterlockReading& reading, const Settings& settings);
  void check_motion(const InterlockReading& reading, const Settings& settings);
  std::int64_t limit_us(std::int32_t time, const InterlockReading& reading) const;

  bool time_in_ms_;
  std::uint16_t status_ = 0;
  std::uint32_t errors_ = 0;
  ErrorLatch latched_;
  std::int64_t i2t_ = 0;
  std::int64_t over_current_us_ = 0, over_error_us_ = 0;
  std::int32_t off_speed_ms_ = 0;
  bool error_tripped_ = false;
};

}  // namespace virtdrive::rzt1
