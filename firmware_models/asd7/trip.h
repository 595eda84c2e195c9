// Why a drive has tripped: the codes of FC90 and FE10-FE13, and the alarms of FC91.
#pragma once

#include <cstdint>
#include <string_view>

namespace virtdrive::asd7 {

enum class Trip : std::uint8_t {
  kNone = 0x00,
  kOc1 = 0x01,   // over-current while accelerating
  kOc2 = 0x02,   // decelerating
  kOc3 = 0x03,   // at speed
  kOcl = 0x04,   // over-current of the load at the start
  kOca = 0x05,   // of the bridge's arms at the start
  kEphi = 0x08,  // phase of the supply lost
  kEpho = 0x09,  // phase of the motor lost
  kOp1 = 0x0a,   // over-voltage while accelerating
  kOp2 = 0x0b,   // decelerating
  kOp3 = 0x0c,   // else
  kOl1 = 0x0d,   // inverter overload
  kOl2 = 0x0e,   // motor overload
  kOlr = 0x0f,   // braking resistor overload
  kOh = 0x10,    // heat sink
  kE = 0x11,     // emergency stop
  kEep1 = 0x12,  // EEPROM: writing failed
  kEep2 = 0x13,  // reading failed
  kEep3 = 0x14,  // data damaged
  kErr2 = 0x15,  // RAM
  kErr3 = 0x16,  // ROM
  kErr4 = 0x17,  // CPU
  kErr5 = 0x18,  // communication time-out
  kErr7 = 0x1a,  // current detector
  kUc = 0x1d,    // current too low
  kUp1 = 0x1e,   // under-voltage of the link
  kOt = 0x20,    // over-torque
  kEf2 = 0x22,   // earth fault
  kOh2 = 0x2e,   // thermistor, by a terminal
};

/// As the panel shows it: "OC1"; "" for kNone.
std::string_view trip_name(Trip trip);

/// Bits of FC91.
enum AlarmBit : std::uint16_t {
  kAlarmOverCurrent = 1 << 0,
  kAlarmInverterOverload = 1 << 1,
  kAlarmMotorOverload = 1 << 2,
  kAlarmHeatSink = 1 << 3,
  kAlarmOverVoltage = 1 << 4,
  kAlarmUnderVoltage = 1 << 5,
  kAlarmLowCurrent = 1 << 7,
  kAlarmOverTorque = 1 << 8,
  kAlarmResistorOverload = 1 << 9,
  kAlarmRunHours = 1 << 10,
  kAlarmCommunication = 1 << 11,  // assumed: the time-out with F804 = 0
  kAlarmPowerLossStop = 1 << 14,
  kAlarmLowerLimitStop = 1 << 15,
};

/// Bits of FD01 and FE01.
enum StatusBit : std::uint16_t {
  kStatusFault = 1 << 0,    // FL
  kStatusTripped = 1 << 1,  // waiting for a retry included
  kStatusAlarm = 1 << 2,
  kStatusUnderVoltage = 1 << 3,
  kStatusSecondMotor = 1 << 4,
  kStatusPiOff = 1 << 5,
  kStatusSecondRamp = 1 << 6,
  kStatusDcBraking = 1 << 7,
  kStatusJog = 1 << 8,
  kStatusReverse = 1 << 9,
  kStatusRunning = 1 << 10,  // the output is on
  kStatusCoast = 1 << 11,    // ST is off
  kStatusEmergency = 1 << 12,
  kStatusRunRequested = 1 << 13,
  kStatusReady = 1 << 14,
};

/// Bits of the command word FA00 (FA04 alike).
enum CommandBit : std::uint16_t {
  kCommandPreset = 0xf,
  kCommandSecondMotor = 1 << 4,
  kCommandPiOff = 1 << 5,
  kCommandSecondRamp = 1 << 6,
  kCommandDcBrake = 1 << 7,
  kCommandJog = 1 << 8,
  kCommandReverse = 1 << 9,
  kCommandRun = 1 << 10,
  kCommandCoast = 1 << 11,
  kCommandEmergency = 1 << 12,
  kCommandReset = 1 << 13,
  kCommandFrequencyPriority = 1 << 14,
  kCommandPriority = 1 << 15,
};

}  // namespace virtdrive::asd7
