// The stages of a motor channel, as MMS_MotorStage tells them (5.1.68), and its error bits
// (5.1.66).
#pragma once

#include <cstdint>
#include <string_view>

namespace virtdrive::toshiba_mcu {

enum class Stage : std::uint8_t {
  kStop = 0,
  kBootstrap = 1,
  kBrake = 2,
  kZeroCurrentMeasure = 3,
  kInitPosition = 4,
  kForce = 5,
  kFoc = 6,
  kEmergency = 7,
};

constexpr std::string_view name(Stage stage) {
  constexpr std::string_view kNames[] = {"Stop",         "Bootstrap", "Brake", "ZeroCurrentMeasure",
                                         "Initposition", "Force",     "FOC",   "Emergency"};
  return kNames[static_cast<std::size_t>(stage)];
}

/// Bit numbers of MMS_ErrorState.
enum class Fault : std::uint8_t {
  kOverTemperature = 0,
  kEmergency = 1,
  kOverVoltage = 2,
  kNoMotor = 3,
  kSoftwareUnderVoltage = 4,
  kSoftwareOverVoltage = 5,
  kSoftwareOverCurrent = 6,
  kWrongDirection = 7,
  kSpeedReduction = 8,
  kStall = 9,
};

constexpr std::uint32_t bit(Fault fault) {
  return 1U << static_cast<unsigned>(fault);
}

/// What a running motor is controlled by: bits of 0x11, 0x12 and 0x23; 0 while idle (4.2.18).
enum class Method : std::uint8_t { kIdle = 0, kSpeed = 1, kTorque = 2 };

/// What a request to a channel came to; the device turns it into a telegram.
enum class Outcome : std::uint8_t {
  kDone,
  kRefused,   // -1
  kNotReady,  // -2
};

}  // namespace virtdrive::toshiba_mcu
