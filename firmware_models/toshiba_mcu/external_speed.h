// Speed asked for by a signal at the board instead of a telegram (ExternalSpeedControl, 5.1.39).
//
// As in the maker's published firmware: read each 100 ms; a value above nothing starts the motor,
// nothing stops it; the direction pin gives the sign. A servo pulse, which that firmware does not
// know yet, is 1000 to 2000 us (assumed), 0 when there is no pulse.
#pragma once

#include <cstdint>

namespace virtdrive::toshiba_mcu {

enum class ExternalSpeed : std::uint8_t { kNone, kAdc, kPwm, kServoBothWays, kServoOneWay };

/// The signals at the board's connector.
struct SpeedSignals {
  int adc_counts = 0;   // 12 bits
  double pwm_high = 0;  // share of the period, 0..1
  double servo_us = 0;  // length of the pulse; 0: none comes
  bool reverse = false;
};

/// Share of SpeedLimit, -1..1. PWM below 5 % is nothing and above 95 % everything; so are the outer
/// 5 % of a servo's half travel, and its middle.
double wanted_share(ExternalSpeed method, const SpeedSignals& signals);

}  // namespace virtdrive::toshiba_mcu
