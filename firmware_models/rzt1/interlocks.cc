#include "firmware_models/rzt1/interlocks.h"

#include <algorithm>
#include <cstdlib>

#include "firmware_models/rzt1/counts.h"
#include "firmware_models/rzt1/status.h"

namespace virtdrive::rzt1 {
namespace {

constexpr std::int64_t kPollUs = 1000;
constexpr std::int64_t kSlotUs = 50;
constexpr std::int32_t kOffSpeedMs = 5000;
constexpr std::int32_t kEmptyCheckSlots = 2;  // 100 us

constexpr std::int64_t square(std::int64_t x) {
  return x * x;
}

}  // namespace

void Interlocks::set(std::uint16_t status, std::uint32_t error) {
  status_ |= status;
  errors_ |= error;
}

std::int64_t Interlocks::limit_us(std::int32_t time, const InterlockReading& reading) const {
  return word(time) * (time_in_ms_ ? kPollUs : kSlotUs * reading.loop_slots);
}

InterlockOrder Interlocks::check(const InterlockReading& reading, const Settings& settings) {
  InterlockOrder order;
  check_heat(reading, settings);
  order.servo_off = check_current(reading, settings);
  if (reading.amplifier_fault) {
    set(kAmplifierFault, kErrorAmplifier);
    order.servo_off = true;
  }
  if (check_error(reading, settings)) {
    order.stop = true;
    order.stop_off = settings.astop == 1;
  }
  if ((reading.inputs & settings.emask) != 0) {
    set(kInputInhibit, kErrorInput);
    order.servo_off = order.power_off = true;
  }
  check_inverter(reading, settings);
  check_motion(reading, settings);
  if (blocks(settings)) order.power_off = true;
  return order;
}

// Heat above what CLIMIT would leave, as (current^2 - nominal^2) over time.
void Interlocks::check_heat(const InterlockReading& reading, const Settings& settings) {
  status_ &= static_cast<std::uint16_t>(~kMotorOverheat);
  if (settings.plimit <= 0 || settings.ptime <= 0) {
    i2t_ = 0;
    return;
  }
  const std::int64_t nominal = square(word(settings.climit));
  i2t_ = std::max<std::int64_t>(0, i2t_ + square(reading.total_current) - nominal);
  if (i2t_ > (square(word(settings.plimit)) - nominal) * word(settings.ptime)) {
    set(kMotorOverheat, kErrorMotorHeat);
  }
}

bool Interlocks::check_current(const InterlockReading& reading, const Settings& settings) {
  if (settings.ctime == 0 || reading.total_current <= settings.climit) {
    over_current_us_ = 0;
    return false;
  }
  over_current_us_ += kPollUs;
  if (over_current_us_ < limit_us(settings.ctime, reading)) return false;
  set(kOverCurrent, kErrorOverCurrent);
  return true;
}

bool Interlocks::check_error(const InterlockReading& reading, const Settings& settings) {
  const bool over = reading.watch_error && reading.max_error > 0 &&
                    std::abs(reading.position_error) > reading.max_error;
  if (!over) {
    over_error_us_ = 0;
    error_tripped_ = false;
    return false;
  }
  over_error_us_ += kPollUs;
  if (error_tripped_ || over_error_us_ < limit_us(settings.etime, reading)) return false;
  error_tripped_ = true;
  set(kPositionErrorBit, kErrorPosition);
  latched_ = {reading.command_position, reading.command_velocity, reading.position};
  return true;
}

void Interlocks::check_inverter(const InterlockReading& reading, const Settings& settings) {
  if (reading.bus_counts < settings.elvolt) set(0, kErrorUnderVoltage);
  if (reading.bus_counts > settings.ehvolt) set(0, kErrorOverVoltage);
  if (reading.total_current >= settings.eovc) set(0, kErrorPreAlarm);
  if (reading.temperature_counts > settings.eovtemp) set(0, kErrorTemperature);
}

void Interlocks::check_motion(const InterlockReading& reading, const Settings& settings) {
  // EOVS and EWOVS count per 100 us.
  const auto per_100us = [&](std::int64_t velocity) {
    return std::abs(velocity) * 2 / reading.loop_slots;
  };
  if (reading.moving && per_100us(reading.velocity) >= settings.eovs) set(0, kErrorOverSpeed);
  const std::int64_t off = static_cast<std::int64_t>(reading.command_velocity) - reading.velocity;
  const bool off_speed = reading.watch_error && per_100us(off) >= settings.ewovs;
  off_speed_ms_ = off_speed ? off_speed_ms_ + 1 : 0;
  if (off_speed_ms_ >= kOffSpeedMs) set(0, kErrorSpeedDifference);
  if (settings.ewposmax != INT32_MAX && reading.position >= settings.ewposmax) {
    set(0, kErrorPositionHigh);
  }
  if (settings.ewposmin != INT32_MIN && reading.position <= settings.ewposmin) {
    set(0, kErrorPositionLow);
  }
  const std::int64_t empty =
      static_cast<std::int64_t>(reading.empty_cycles) * reading.loop_slots / kEmptyCheckSlots;
  if (empty > settings.eemp) set(0, kErrorEmpty);
}

void Interlocks::output_disabled() {
  set(kAmplifierFault, kErrorOutputDisable);
}

void Interlocks::clear_status() {
  status_ = 0;
  over_current_us_ = over_error_us_ = 0;
  off_speed_ms_ = 0;
  error_tripped_ = false;
}

std::int32_t Interlocks::i2t() const {
  return static_cast<std::int32_t>(std::min<std::int64_t>(i2t_, INT32_MAX));
}

}  // namespace virtdrive::rzt1
