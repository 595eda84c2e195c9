// MCU Motor Studio serial protocol, firmware 3.10: every command and parameter.
//
// Source column: section of "Serial Communication - Protocol Specification", Rev 1.1.0, 2022-10-21.
// Where that document contradicts itself the row's doc says which reading was taken.
#pragma once

#include "devices/protocol/table.h"
#include "firmware_models/toshiba_mcu/settings.h"

namespace virtdrive::toshiba_mcu {

using protocol::Access;
using protocol::CodeRow;
using protocol::CommandRow;
using protocol::Evidence;
using protocol::FactoryValue;
using protocol::Field;
using protocol::ParameterRow;
using protocol::ProtocolTable;
using protocol::Range;
using protocol::Support;
using protocol::UnitCode;
using protocol::WireType;

// --- Framing -------------------------------------------------------------------------------------

inline constexpr std::uint8_t kBot = 0x11;
inline constexpr std::uint8_t kEot = 0x13;
inline constexpr std::uint8_t kErrorTelegram = 0xEE;
inline constexpr std::uint8_t kAllMotors = 0xFF;  // -1: the system, not a channel

/// Motor numbers 0-2, bits of the Channels parameter.
inline constexpr std::size_t kChannels = 3;

// --- Payload fields ------------------------------------------------------------------------------

inline constexpr Field kMotorNr[] = {{.name = "motor_nr"}};
inline constexpr Field kDummy[] = {{.name = "dummy"}};
inline constexpr Field kError[] = {{.name = "error"}};
inline constexpr Field kGetEntry[] = {{.name = "id"}, {.name = "offset"}};
inline constexpr Field kValueEntry[] = {{.name = "value", .type = WireType::kI32},
                                        {.name = "unit", .type = WireType::kI8}};
inline constexpr Field kSetEntry[] = {{.name = "id"},
                                      {.name = "unit", .type = WireType::kI8},
                                      {.name = "value", .type = WireType::kI32}};

inline constexpr std::size_t kTransferCount = kIdentity.transfer_count;

inline constexpr Field kMotorState[] = {
    {.name = "actual_speed", .type = WireType::kI32, .unit = "rpm"},
    {.name = "target_speed", .type = WireType::kI32, .unit = "rpm"},
    {.name = "current", .type = WireType::kU32, .unit = "mA"},
    {.name = "torque", .type = WireType::kU32, .unit = "Ncm", .scale = 0.001},
    {.name = "timestamp", .type = WireType::kU32, .unit = "ms"}};
inline constexpr Field kExtendedMotorState[] = {
    {.name = "actual", .type = WireType::kI32},
    {.name = "target", .type = WireType::kI32},
    {.name = "current", .type = WireType::kU32, .unit = "mA"},
    {.name = "non_controlled", .type = WireType::kU32},
    {.name = "timestamp", .type = WireType::kU32, .unit = "ms"},
    {.name = "method"}};
inline constexpr Field kDsoRequest[] = {{.name = "motor_nr"},
                                        {.name = "selected", .type = WireType::kU32},
                                        {.name = "trigger_on", .type = WireType::kU32},
                                        {.name = "mode"},
                                        {.name = "level", .type = WireType::kU16},
                                        {.name = "spread"}};
inline constexpr Field kDsoSteps[] = {{.name = "logsteps", .type = WireType::kU16}};
inline constexpr Field kDsoData[] = {{.name = "value", .type = WireType::kI16, .count = 16}};
inline constexpr Field kHsDsoRequest[] = {{.name = "motor_nr"},
                                          {.name = "enable"},
                                          {.name = "selected", .type = WireType::kU32},
                                          {.name = "spread"}};
inline constexpr Field kTurnRequest[] = {
    {.name = "motor_nr"},
    {.name = "turns", .type = WireType::kI16},
    {.name = "max_speed", .type = WireType::kU16, .unit = "rpm"}};
inline constexpr Field kGetOneRequest[] = {
    {.name = "motor_nr"}, {.name = "id"}, {.name = "offset"}};
inline constexpr Field kSetOneRequest[] = {{.name = "motor_nr"},
                                           {.name = "id"},
                                           {.name = "unit", .type = WireType::kI8},
                                           {.name = "value", .type = WireType::kI32}};
inline constexpr Field kGetManyRequest[] = {
    {.name = "motor_nr"},
    {.name = "entries"},
    {.name = "entry", .count = kTransferCount, .members = kGetEntry}};
inline constexpr Field kGetManyReply[] = {
    {.name = "error"},
    {.name = "offset"},
    {.name = "entry", .count = kTransferCount, .members = kValueEntry}};
inline constexpr Field kSetManyRequest[] = {
    {.name = "motor_nr"},
    {.name = "entries"},
    {.name = "entry", .count = kTransferCount, .members = kSetEntry}};
inline constexpr Field kSetManyReply[] = {{.name = "error"}, {.name = "offset"}};
inline constexpr Field kLinearRequest[] = {
    {.name = "motor_nr"},
    {.name = "position", .type = WireType::kU32, .unit = "pulses"},
    {.name = "max_speed", .type = WireType::kU16, .unit = "rpm"}};
inline constexpr Field kPosition[] = {
    {.name = "position", .type = WireType::kU32, .unit = "pulses"}};
inline constexpr Field kMethod[] = {{.name = "method"}};
inline constexpr Field kSetMethodRequest[] = {{.name = "motor_nr"}, {.name = "method"}};
inline constexpr Field kEncoderNr[] = {{.name = "encoder_nr"}};
inline constexpr Field kCounter[] = {{.name = "counter", .type = WireType::kI32}};
inline constexpr Field kVersion[] = {{.name = "major"}, {.name = "minor"}};
inline constexpr Field kState[] = {{.name = "state"}};
inline constexpr Field kErrorCode[] = {{.name = "code", .type = WireType::kI8}};

// --- Commands (4.1, 4.2) -------------------------------------------------------------------------

// clang-format off
inline constexpr CommandRow kCommands[] = {
    {.code = 0x00, .name = "StartMotor", .request = kMotorNr, .reply = kDummy, .source = "4.2.1",
     .doc = "Spins the motor up to the set speed and keeps it there."},
    {.code = 0x01, .name = "StopMotor", .request = kMotorNr, .reply = kDummy, .source = "4.2.2",
     .doc = "Stops by ShutdownMode; leaves the Emergency stage. The heading prints 0x00, the "
            "frames 0x01."},
    {.code = 0x02, .name = "GetMotorState", .request = kMotorNr, .reply = kMotorState,
     .source = "4.2.3",
     .doc = "Speed, current, torque and tick; zeros but for the tick while stopped. The torque "
            "counts "
            "0.001 Ncm though labelled Ncm."},
    {.code = 0x03, .name = "StoreParameters", .request = kMotorNr, .reply = kDummy,
     .source = "4.2.4", .doc = "Keeps a channel's parameters over a reset."},
    {.code = 0x04, .name = "ClearParameters", .request = kDummy, .reply = kDummy,
     .source = "4.2.5",
     .doc = "Forgets what was stored; the parameters in RAM stay until a reset."},
    {.code = 0x05, .name = "ConfigDSOLog", .request = kDsoRequest, .reply = kDsoSteps,
     .source = "4.2.6",
     .doc = "Arms the oscilloscope; answers how many times 0x06 has to be asked. No signal or more "
            "than 16: 0, and nothing armed."},
    {.code = 0x06, .name = "GetDSOLogData", .request = kDummy, .reply = kDsoData,
     .source = "4.2.7",
     .doc = "The next 16 values. Not ready (-2) while it waits or samples, refused (-1) when all is "
            "fetched."},
    {.code = 0x07, .name = "ConfigureHsDSO", .request = kHsDsoRequest, .reply = kDummy,
     .source = "4.2.8",
     .doc = "Streams the signals on the second serial line, 5 Mbit/s: 11, CRC8 of what follows, "
            "missed frames, u16 PWM periods, values."},
    {.code = 0x08, .name = "DoTurn", .request = kTurnRequest, .reply = kDummy,
     .source = "4.2.9",
     .doc = "So many turns on, then stops; the last turn at 10 rpm. Starts the motor; StopMotor and a "
            "speed end it."},
    {.code = 0x09, .name = "GetOneMotorParameter", .request = kGetOneRequest, .reply = kValueEntry,
     .source = "4.2.10", .doc = "Reads one parameter; of a name, four bytes from the offset."},
    {.code = 0x0A, .name = "SetOneMotorParameter", .request = kSetOneRequest, .reply = kDummy,
     .source = "4.2.11", .doc = "Writes one parameter in RAM."},
    {.code = 0x0B, .name = "GetMotorParameters", .request = kGetManyRequest, .reply = kGetManyReply,
     .source = "4.2.12", .doc = "Reads up to eight parameters; eight slots on the wire, always."},
    {.code = 0x0C, .name = "SetMotorParameters", .request = kSetManyRequest, .reply = kSetManyReply,
     .source = "4.2.13",
     .doc = "Writes up to eight parameters; stops at the first that is refused."},
    {.code = 0x0D, .name = "DoLinearMotion", .request = kLinearRequest, .reply = kError,
     .source = "4.2.14",
     .doc = "Goes to a position and holds it; the last 5 % at EncoderLMApproach. Error 1: out of "
            "Min..MaxPos, busy, a fault, no speed."},
    {.code = 0x0E, .name = "GetAbsolutePosition", .request = kMotorNr, .reply = kPosition,
     .source = "4.2.15",
     .doc = "Position in pulses at the gear's output, from EncoderStartPos on."},
    {.code = 0x0F, .name = "AbortLinearMotion", .request = kMotorNr, .reply = kError,
     .source = "4.2.16",
     .doc = "Ends a linear motion: target speed 0, the motor stays powered."},
    {.code = 0x10, .name = "StartMotorTorqueCtrl", .request = kMotorNr, .reply = kDummy,
     .source = "4.2.17",
     .doc = "Starts with torque control; Speed is the highest speed and gives the direction."},
    {.code = 0x11, .name = "GetMotorControlMethod", .request = kMotorNr, .reply = kMethod,
     .source = "4.2.18", .doc = "1 speed, 2 torque, 0 while idle."},
    {.code = 0x12, .name = "SetMotorControlMethod", .request = kSetMethodRequest, .reply = kError,
     .source = "4.2.19",
     .doc = "1 speed, 2 torque, error 1 for anything else; while idle, for the next start."},
    {.code = 0x13, .name = "GetEncoderCounter", .request = kEncoderNr, .reply = kCounter,
     .source = "4.2.20",
     .doc = "Edges counted, 32 bits without wrap per turn. Table 4-1 gives it 0x12, its frames "
            "0x13."},
    {.code = 0x14, .name = "GetFWVersion", .request = kDummy, .reply = kVersion, .source = "4.2.21",
     .doc = "Major and minor version, for hosts of the 1.x firmware."},
    {.code = 0x21, .name = "SetDemoState", .request = kState, .reply = kError,
     .support = Support::kStored, .source = "4.2.22",
     .doc = "Keeps the number; this image has no demo application that would act on it."},
    {.code = 0x22, .name = "GetDemoState", .request = kDummy, .reply = kState,
     .support = Support::kStored, .source = "4.2.23", .doc = "The number that was set, 0 at first."},
    {.code = 0x23, .name = "GetExtendedMotorState", .request = kMotorNr,
     .reply = kExtendedMotorState, .source = "4.2.24",
     .doc = "As 0x02, with the control method. The example prints big-endian fields; its CRC fits "
            "little-endian ones."},
};
// clang-format on

/// The reply that takes the place of any other: 11 EE code CRC 13.
inline constexpr CommandRow kErrorReply = {
    .code = kErrorTelegram,
    .name = "Error",
    .request = {},
    .reply = kErrorCode,
    .evidence = Evidence::kObserved,
    .source = "3",
    .doc = "Instead of an answer: the telegram could not be taken or the request was refused."};

// clang-format off
inline constexpr CodeRow kErrors[] = {
    {.code = 1, .name = "crc", .evidence = Evidence::kObserved,
     .doc = "The request's CRC does not fit."},
    {.code = -1, .name = "refused", .evidence = Evidence::kObserved,
     .doc = "Unknown channel or id, read-only, out of range, or switched off."},
    {.code = -2, .name = "not_ready", .evidence = Evidence::kObserved,
     .doc = "Not now: an error is pending, or data are not complete."},
};
// clang-format on

// clang-format off
inline constexpr CodeRow kFaults[] = {
    {.code = 0, .name = "OverTemperature",
     .doc = "Over temperature; keeps the motor from starting."},
    {.code = 1, .name = "Emergency", .doc = "Emergency input of the motor driver block."},
    {.code = 2, .name = "OverVoltage", .doc = "Over-voltage input of the motor driver block."},
    {.code = 3, .name = "NoMotor", .doc = "No current flows in Force: the motor is disconnected."},
    {.code = 4, .name = "SwUnderVoltage", .doc = "DC link below SwUndervoltage."},
    {.code = 5, .name = "SwOverVoltage", .doc = "DC link above SwOvervoltage."},
    {.code = 6, .name = "SwOverCurrent", .doc = "Current above SwOvercurrent."},
    {.code = 7, .name = "WrongDirection",
     .doc = "A speed against Direction was asked for (warning)."},
    {.code = 8, .name = "SpeedReduction", .doc = "The load reduces the target speed (warning)."},
    {.code = 9, .name = "StallDetected", .doc = "The field stalled."},
};
// clang-format on

// --- Units (5.1) ---------------------------------------------------------------------------------

inline constexpr UnitCode kAccelerationUnits[] = {
    {0, "rad/s2"}, {1, "Hz/s"}, {2, "rpm/s"}, {3, "rpm/min"}};
inline constexpr UnitCode kTorqueFactorUnits[] = {{-3, "mNm/A"}, {0, "Nm/A"}};
inline constexpr UnitCode kResistanceUnits[] = {{0, "Ohm"}, {-3, "mOhm"}, {-6, "uOhm"}};
inline constexpr UnitCode kInductanceUnits[] = {{-3, "mH"}, {-6, "uH"}, {-9, "nH"}};
inline constexpr UnitCode kSpeedUnits[] = {{0, "Hz"}, {1, "rpm"}};
inline constexpr UnitCode kCurrentUnits[] = {{0, "A"}, {-3, "mA"}};
inline constexpr UnitCode kCurrentSensitivityUnits[] = {{-3, "mV/A"}, {-6, "uV/A"}};
inline constexpr UnitCode kVoltageSensitivityUnits[] = {{-3, "mV/V"}};

// --- Parameters (5.1) ----------------------------------------------------------------------------

/// FirmwareVersion as the parameter tells it (5.1.62).
inline constexpr std::int32_t kVersionWord = kIdentity.version_major << 8 | kIdentity.version_minor;

constexpr FactoryValue factory(UnitValue v) {
  return {v.value, v.unit};
}

inline constexpr Range kAnyI32{INT32_MIN, INT32_MAX};
inline constexpr Range kU16Range{0, 65535};
inline constexpr Range kFlag{0, 1};
inline constexpr const ChannelSettings& kF = kFactorySettings;

// SpeedChange goes up to SpeedLimit + 1, which the device checks in Hz (5.1.8).
inline constexpr Range kSpeedRange{1, 200000};
inline constexpr Range kSpeedChangeRange{1, 200001};

// clang-format off
inline constexpr ParameterRow kParameters[] = {
    {.id = 0x10, .name = "PolePairs", .range = {1, 100}, .factory = factory(kF.pole_pairs),
     .source = "5.1.1", .doc = "Pole pairs of the motor."},
    {.id = 0x11, .name = "Direction", .range = {0, 2}, .factory = factory(kF.direction),
     .source = "5.1.2", .doc = "0 clockwise only, 1 counter-clockwise only, 2 both."},
    {.id = 0x12, .name = "MaxAngAcc", .range = {1, 10000},
     .factory = factory(kF.max_angular_acceleration), .units = kAccelerationUnits,
     .source = "5.1.3",
     .doc = "Limit of the acceleration, of the electrical angle in rad/s2 and Hz/s."},
    {.id = 0x13, .name = "TorqueFactor", .range = {0, 10000}, .factory = factory(kF.torque_factor),
     .units = kTorqueFactorUnits, .source = "5.1.4",
     .doc = "Torque per ampere, for the torque that the state telegrams tell."},
    {.id = 0x14, .name = "Resistance", .range = {0, 10000}, .factory = factory(kF.resistance),
     .units = kResistanceUnits, .source = "5.1.5", .doc = "Resistance of one phase."},
    {.id = 0x15, .name = "Inductance", .range = {0, 10000}, .factory = factory(kF.inductance),
     .units = kInductanceUnits, .source = "5.1.6", .doc = "Inductance of one phase."},
    {.id = 0x16, .name = "SpeedLimit", .range = kSpeedRange, .factory = factory(kF.speed_limit),
     .units = kSpeedUnits, .source = "5.1.7",
     .doc = "Highest speed, in Hz electrical or rpm mechanical."},
    {.id = 0x17, .name = "SpeedChange", .range = kSpeedChangeRange,
     .factory = factory(kF.speed_change), .units = kSpeedUnits, .source = "5.1.8",
     .doc = "Speed at which Force becomes FOC; SpeedLimit + 1 keeps the motor in Force."},
    {.id = 0x18, .name = "PositionDelay", .range = {0, 10000}, .factory = factory(kF.position_delay),
     .unit = "ms", .source = "5.1.9", .doc = "Time in Initposition, while Iq ramps up to IqStart."},
    {.id = 0x19, .name = "IqStart", .range = {1, 10000}, .factory = factory(kF.iq_start),
     .units = kCurrentUnits, .source = "5.1.10",
     .doc = "Current in Initposition and Force; IqLimit limits it."},
    {.id = 0x1A, .name = "IdStart", .range = {1, 10000}, .factory = factory(kF.id_start),
     .units = kCurrentUnits, .source = "5.1.11",
     .doc = "Part of the threshold below which the motor counts as disconnected."},
    {.id = 0x1B, .name = "IqLimit", .range = {1, 10000}, .factory = factory(kF.iq_limit),
     .units = kCurrentUnits, .source = "5.1.12", .doc = "Highest Iq in FOC."},
    {.id = 0x1C, .name = "IdLimit", .range = {1, 10000}, .factory = factory(kF.id_limit),
     .units = kCurrentUnits, .source = "5.1.13", .doc = "Limits IdStart."},
    {.id = 0x1D, .name = "MotorId", .type = WireType::kText, .count = 20, .source = "5.1.14",
     .doc = "Name of the motor; read and written four bytes at an offset. A write's offset stands "
            "in "
            "the unit field, the only free one (assumed)."},
    {.id = 0x30, .name = "Encoder", .range = {0, 6}, .factory = factory(kF.encoder),
     .source = "5.1.15",
     .doc = "0 none, 1 Hall UVW, 2 Hall UV, 3 ABZ, 4 AB, 5 single pulse, 6 AS5145H: all wired on the "
            "bench. Without, 6 counts per electrical turn are emulated."},
    {.id = 0x31, .name = "EncoderUsage", .range = {0, 2}, .factory = factory(kF.encoder_usage),
     .source = "5.1.16",
     .doc = "1: the encoder's speed is reported, corrects the speed controller and finds stalls; the "
            "angle stays the estimator's (assumed). 0 and 2: it counts."},
    {.id = 0x32, .name = "EncoderResolution", .range = {0, 20000},
     .factory = factory(kF.encoder_resolution), .source = "5.1.17",
     .doc = "Counts per revolution of ABZ, AB and single pulse; the bench's encoder has 500 lines, "
            "four counts each."},
    {.id = 0x33, .name = "EncoderMinPos", .range = kAnyI32,
     .factory = factory(kF.encoder_min_position), .unit = "pulses",
     .source = "5.1.18",
     .doc = "Lowest position of linear motion; unsigned 32 bits in the i32 field."},
    {.id = 0x34, .name = "EncoderStartPos", .range = kAnyI32,
     .factory = factory(kF.encoder_start_position), .unit = "pulses",
     .source = "5.1.19", .doc = "Position that the present encoder value stands for."},
    {.id = 0x35, .name = "EncoderMaxPos", .range = kAnyI32,
     .factory = factory(kF.encoder_max_position), .unit = "pulses",
     .source = "5.1.20", .doc = "Highest position of linear motion."},
    {.id = 0x36, .name = "EncoderLMApproach", .range = kU16Range,
     .factory = factory(kF.encoder_approach), .unit = "rpm", .source = "5.1.21", .doc = "Speed of the approach to the final position."},
    {.id = 0x37, .name = "EncoderGearFactor", .range = kU16Range,
     .factory = factory(kF.encoder_gear_factor), .source = "5.1.22",
     .doc = "Gear ratio 1:x: so many counts of the motor's encoder are one pulse of the position "
            "(assumed); 0 is 1."},
    {.id = 0x40, .name = "PiIdKi", .range = kU16Range, .factory = factory(kF.pi_id_ki),
     .source = "5.1.23",
     .doc = "Integral gain of Id: a Q15 register of v_max per a_max and PWM period, whatever its "
            "label."},
    {.id = 0x41, .name = "PiIdKp", .range = kU16Range, .factory = factory(kF.pi_id_kp),
     .source = "5.1.24", .doc = "Proportional gain of Id: a Q15 register of v_max per a_max."},
    {.id = 0x42, .name = "PiIqKi", .range = kU16Range, .factory = factory(kF.pi_iq_ki),
     .source = "5.1.25", .doc = "Integral gain of Iq, as PiIdKi."},
    {.id = 0x43, .name = "PiIqKp", .range = kU16Range, .factory = factory(kF.pi_iq_kp),
     .source = "5.1.26", .doc = "Proportional gain of Iq, as PiIdKp."},
    {.id = 0x44, .name = "PositionKi", .range = kU16Range, .factory = factory(kF.position_ki),
     .unit = "Hz/Vs", .source = "5.1.27", .doc = "Integral gain of the position estimator."},
    {.id = 0x45, .name = "PositionKp", .range = kU16Range, .factory = factory(kF.position_kp),
     .unit = "Hz/V", .source = "5.1.28", .doc = "Proportional gain of the position estimator."},
    {.id = 0x46, .name = "SpeedKi", .range = kU16Range, .factory = factory(kF.speed_ki),
     .unit = "mA/Hz*s", .source = "5.1.29", .doc = "Integral gain of the speed controller."},
    {.id = 0x47, .name = "SpeedKp", .range = kU16Range, .factory = factory(kF.speed_kp),
     .unit = "mA/Hz", .source = "5.1.30", .doc = "Proportional gain of the speed controller."},
    {.id = 0x50, .name = "PwmFrequency", .range = {0, 50000}, .factory = factory(kF.pwm_frequency),
     .unit = "Hz", .source = "5.1.31",
     .doc = "PWM and current loop frequency; with 0 a start is refused (assumed)."},
    {.id = 0x51, .name = "ShutdownMode", .range = {0, 2}, .factory = factory(kF.shutdown_mode),
     .source = "5.1.32", .doc = "0 outputs off, 1 short brake, 2 ramp down to 0."},
    {.id = 0x52, .name = "Braketime", .range = {0, 10000}, .factory = factory(kF.brake_time),
     .unit = "ms", .source = "5.1.33", .doc = "Time in the Brake stage."},
    {.id = 0x53, .name = "Brakepercentage", .range = {0, 100},
     .factory = factory(kF.brake_percentage), .unit = "%", .source = "5.1.34",
     .doc = "Share of each PWM period with the windings shorted; open for the rest."},
    {.id = 0x54, .name = "RestartMode", .range = kFlag, .factory = factory(kF.restart_mode),
     .source = "5.1.35", .doc = "After a stall: 0 off, 1 restart."},
    {.id = 0x55, .name = "StalldetectValue", .range = {0, 4095},
     .factory = factory(kF.stall_detect_value), .source = "5.1.36",
     .doc = "Least integral part of Vq in FOC, Q15 of v_max as in the maker's firmware; 0 is off."},
    {.id = 0x56, .name = "Overtemperature", .range = {-40, 150},
     .factory = factory(kF.over_temperature), .unit = "degC", .source = "5.1.37",
     .doc = "Temperature at which the motor is switched off; released 5 degC below."},
    {.id = 0x57, .name = "CanId", .range = {0, 15}, .factory = factory(kF.can_id),
     .support = Support::kStored, .source = "5.1.38", .doc = "CAN id; this image has no CAN."},
    {.id = 0x58, .name = "ExternalSpeedControl", .range = {0, 4},
     .factory = factory(kF.external_speed_control), .source = "5.1.39",
     .doc = "0 none, 1 ADC, 2 PWM, 3 servo -max..max, 4 servo 0..max: a signal at the board starts, "
            "stops and sets the speed, read each 100 ms."},
    {.id = 0x59, .name = "SwOvervoltage", .range = kU16Range, .factory = factory(kF.over_voltage),
     .unit = "V", .source = "5.1.40",
     .doc = "DC link voltage above which the motor is switched off; 0 is off."},
    {.id = 0x5A, .name = "SwUndervoltage", .range = kU16Range, .factory = factory(kF.under_voltage),
     .unit = "V", .source = "5.1.41",
     .doc = "DC link voltage below which the motor is switched off; 0 is off."},
    {.id = 0x5B, .name = "SwOvercurrent", .range = kU16Range, .factory = factory(kF.over_current),
     .unit = "mA", .source = "5.1.42",
     .doc = "|Iq| above which the motor is switched off; 0 is off (assumed)."},
    {.id = 0x5C, .name = "SpeedReduction", .range = {0, 100}, .factory = factory(kF.speed_reduction),
     .unit = "%", .source = "5.1.43",
     .doc = "Share of IqLimit above which the target follows the actual speed; 0 is off "
            "(assumed)."},
    {.id = 0x70, .name = "Deadtime", .range = {0, 5000}, .factory = factory(kF.dead_time),
     .unit = "ns", .source = "5.1.44", .doc = "Dead time of the half bridges, rounded to 100 ns."},
    {.id = 0x71, .name = "BootstrapDelay", .range = {0, 1000},
     .factory = factory(kF.bootstrap_delay), .unit = "ms", .source = "5.1.45",
     .doc = "Time in Bootstrap, with all low sides on."},
    {.id = 0x72, .name = "SensitivityCurrentMeasure", .range = {0, 10000},
     .factory = factory(kF.current_sensitivity), .units = kCurrentSensitivityUnits,
     .source = "5.1.46", .doc = "What the firmware takes the current amplifiers for."},
    {.id = 0x73, .name = "SensitivityVoltageMeasure", .range = {0, 10000},
     .factory = factory(kF.voltage_sensitivity), .units = kVoltageSensitivityUnits,
     .source = "5.1.47", .doc = "What the firmware takes the DC link divider for."},
    {.id = 0x74, .name = "GainCurrentMeasure", .range = {0, 7}, .factory = factory(kF.current_gain),
     .source = "5.1.48",
     .doc = "Gain of the MCU's current amplifiers: 1, 2, 4, 5, 8, 10, 16, 32, the first board's "
            "list; lowers a_max."},
    {.id = 0x75, .name = "MeasurementType", .range = {1, 3}, .factory = factory(kF.measurement_type),
     .source = "5.1.49",
     .doc = "1 one shunt: the phase of the middle duty follows from the others; 2 two sensors: phase "
            "c does; 3 three shunts."},
    {.id = 0x76, .name = "SensorDirection", .range = kFlag, .factory = factory(kF.sensor_direction),
     .source = "5.1.50", .doc = "1 takes the currents with the opposite sign."},
    {.id = 0x77, .name = "PolL", .range = kFlag, .factory = factory(kF.low_side_polarity),
     .support = Support::kStored, .source = "5.1.51",
     .doc = "Polarity of the low sides; the bridge follows whatever is set."},
    {.id = 0x78, .name = "PolH", .range = kFlag, .factory = factory(kF.high_side_polarity),
     .support = Support::kStored, .source = "5.1.52",
     .doc = "Polarity of the high sides; the bridge follows whatever is set."},
    {.id = 0x90, .name = "FirmwareFeatures", .access = Access::kReadOnly, .range = kAnyI32,
     .factory = {kIdentity.feature_bits}, .source = "5.1.53",
     .doc = "Compiled-in features, a bit each."},
    {.id = 0x91, .name = "BoardRevision", .access = Access::kReadOnly, .range = {0, 255},
     .factory = {kIdentity.board_revision}, .source = "5.1.54", .doc = "Revision of the board."},
    {.id = 0x92, .name = "Channels", .access = Access::kReadOnly, .range = {0, 7},
     .factory = {kIdentity.channels}, .source = "5.1.55",
     .doc = "Channels that are there, a bit each."},
    {.id = 0x93, .name = "DsoSize", .access = Access::kReadOnly, .range = kU16Range,
     .factory = {kIdentity.dso_size}, .source = "5.1.56",
     .doc = "16-bit values that the oscilloscope holds."},
    {.id = 0x94, .name = "ParameterTransferCount", .access = Access::kReadOnly, .range = {1, 255},
     .factory = {kIdentity.transfer_count}, .source = "5.1.57",
     .doc = "Slots of 0x0B and 0x0C. Section 4.2.12 calls it PAR (84)."},
    {.id = 0x95, .name = "BoardName", .type = WireType::kText, .count = 20,
     .access = Access::kReadOnly, .source = "5.1.58", .doc = "Name of the CPU board."},
    {.id = 0x96, .name = "BoardNamePWR0", .type = WireType::kText, .count = 20,
     .access = Access::kReadOnly, .source = "5.1.59", .doc = "Name of channel 0's power board."},
    {.id = 0x97, .name = "BoardNamePWR1", .type = WireType::kText, .count = 20,
     .access = Access::kReadOnly, .source = "5.1.60", .doc = "Name of channel 1's power board."},
    {.id = 0x98, .name = "BoardNamePWR2", .type = WireType::kText, .count = 20,
     .access = Access::kReadOnly, .source = "5.1.61", .doc = "Name of channel 2's power board."},
    {.id = 0xB0, .name = "FirmwareVersion", .access = Access::kReadOnly, .range = kAnyI32,
     .factory = {kVersionWord}, .source = "5.1.62",
     .doc = "Byte 1 major, byte 0 minor: the reverse of command 0x14."},
    {.id = 0xB1, .name = "ResetStatus", .access = Access::kReadOnly, .range = kFlag, .factory = {1},
     .source = "5.1.63", .doc = "1 at the first read after a reset, then 0."},
    {.id = 0xB2, .name = "SystemLoad", .access = Access::kReadOnly, .range = {0, 100},
     .factory = {5}, .unit = "%", .evidence = Evidence::kAssumed, .source = "5.1.64",
     .doc = "Load of the MCU: 5 % and 8 us for each PWM interrupt; the simulation has no CPU."},
    {.id = 0xE0, .name = "Temperature", .access = Access::kReadOnly, .range = {-40, 150},
     .factory = {25}, .unit = "degC", .source = "5.1.65",
     .doc = "Temperature of the board's sensor."},
    {.id = 0xE1, .name = "ErrorState", .access = Access::kReadOnly, .range = {0, 1023},
     .source = "5.1.66", .doc = "Error bits; the faults table names them."},
    {.id = 0xE2, .name = "DcLinkVoltage", .access = Access::kReadOnly, .range = kU16Range,
     .unit = "V", .scale = 0.1, .source = "5.1.67", .doc = "Measured DC link voltage."},
    {.id = 0xE3, .name = "MotorStage", .access = Access::kReadOnly, .range = {0, 7},
     .source = "5.1.68",
     .doc = "0 Stop, 1 Bootstrap, 2 Brake, 3 ZeroCurrentMeasure, 4 Initposition, 5 Force, 6 FOC, "
            "7 Emergency."},
    {.id = 0xE4, .name = "TurnNumber", .access = Access::kReadOnly, .range = kAnyI32,
     .source = "5.1.69",
     .doc = "Whole turns of the motor, by the encoder or the drive's own angle."},
    {.id = 0xE5, .name = "Speed", .access = Access::kWriteOnly, .range = kAnyI32, .unit = "rpm",
     .source = "5.1.70",
     .doc = "Target speed, clipped to SpeedLimit; negative is counter-clockwise."},
    {.id = 0xE6, .name = "Torque", .access = Access::kWriteOnly, .range = {0, INT32_MAX},
     .unit = "mNm", .source = "5.1.71",
     .doc = "Torque asked for in torque control, up to IqLimit * TorqueFactor (assumed)."},
};
// clang-format on

inline constexpr ProtocolTable kTable = {
    .name = "toshiba-mcu",
    .title = "Toshiba MCU Motor Studio, firmware 3.10",
    .document = "Serial Communication - Protocol Specification, Rev 1.1.0, 2022-10-21",
    .framing = {.start = "\x11",
                .end = "\x13",
                .checksum = protocol::Checksum::kCrc8FromCommand,
                .checksum_span = "payload; the command is the start value",
                .longest = 54},
    .commands = kCommands,
    .parameters = kParameters,
    .errors = kErrors,
    .faults = kFaults,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::toshiba_mcu
