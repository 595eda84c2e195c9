// MD series communication on RS-485, V4.4: framing, every PID and every command number.
//
// Source column: page of "Communication protocol on RS485, BLDC driver", V4.4, 2019-07-16; "header"
// is its C header (p. 32-35), "later" what newer versions add and hosts of today send at start-up.
// A PID numbers a command or a parameter; both travel in the same frame, in both directions. These
// are the rows of all models: model_table.h says what one model makes of them.
#pragma once

#include <algorithm>
#include <iterator>

#include "devices/protocol/table.h"

namespace virtdrive::md485 {

using protocol::Access;
using protocol::CodeRow;
using protocol::CommandRow;
using protocol::Evidence;
using protocol::Field;
using protocol::Names;
using protocol::ParameterRow;
using protocol::ProtocolTable;
using protocol::Range;
using protocol::Support;
using protocol::WireType;

// --- Framing (2.1) -------------------------------------------------------------------------------

/// Machine ids: who receives (RMID) and who transmits (TMID).
inline constexpr std::uint8_t kController = 183;
/// A host may call itself anything and hears its own number back; 184 and 128 are in use, too.
inline constexpr std::uint8_t kHost = 172;
/// The ID that every controller takes as its own.
inline constexpr std::uint8_t kAllControllers = 254;
/// What has to stand before the value in a write of the rows in kChecked (2.4).
inline constexpr std::uint8_t kWriteCheck = 0xAA;
inline constexpr std::uint8_t kDefaultCheck = 0x55;
/// A CAN frame holds a PID and up to so many bytes of its data (2.3).
inline constexpr std::size_t kMostCanData = 7;

// --- Fields --------------------------------------------------------------------------------------

inline constexpr Field kPid[] = {{.name = "pid"}};
inline constexpr Field kPidWithIndex[] = {{.name = "pid"}, {.name = "index"}};
inline constexpr Field kDoNotCare[] = {{.name = "x", .optional = true}};
inline constexpr Field kCheck[] = {{.name = "check"}};
inline constexpr Field kNumber[] = {{.name = "number"}};
inline constexpr Field kState[] = {{.name = "state"}};
inline constexpr Field kFunctionOn[] = {{.name = "on"}, {.name = "x", .optional = true}};
inline constexpr Field kSpeed[] = {{.name = "speed", .type = WireType::kI16, .unit = "rpm"}};
inline constexpr Field kOutput[] = {{.name = "output", .type = WireType::kI16}};
inline constexpr Field kTorque[] = {{.name = "torque", .type = WireType::kI16}};
inline constexpr Field kPosition[] = {
    {.name = "position", .type = WireType::kI32, .unit = "counts"}};
inline constexpr Field kPositionAndSpeed[] = {
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "max_speed", .type = WireType::kI16, .unit = "rpm"}};
inline constexpr Field kEnableTwo[] = {
    {.name = "motor1"}, {.name = "motor2"}, {.name = "return_type", .optional = true}};
inline constexpr Field kTwoSpeeds[] = {{.name = "enable1"},
                                       {.name = "speed1", .type = WireType::kI16, .unit = "rpm"},
                                       {.name = "enable2"},
                                       {.name = "speed2", .type = WireType::kI16, .unit = "rpm"},
                                       {.name = "return_type", .optional = true}};
inline constexpr Field kTwoOutputs[] = {{.name = "enable1"},
                                        {.name = "output1", .type = WireType::kI16},
                                        {.name = "enable2"},
                                        {.name = "output2", .type = WireType::kI16},
                                        {.name = "return_type", .optional = true}};
inline constexpr Field kTwoTorques[] = {{.name = "enable1"},
                                        {.name = "torque1", .type = WireType::kI16},
                                        {.name = "enable2"},
                                        {.name = "torque2", .type = WireType::kI16},
                                        {.name = "return_type", .optional = true}};
inline constexpr Field kTwoPositions[] = {
    {.name = "enable1"},
    {.name = "position1", .type = WireType::kI32, .unit = "counts"},
    {.name = "enable2"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts"},
    {.name = "return_type", .optional = true}};
inline constexpr Field kTwoPositionsAndSpeeds[] = {
    {.name = "enable1"},
    {.name = "position1", .type = WireType::kI32, .unit = "counts"},
    {.name = "max_speed1", .type = WireType::kI16, .unit = "rpm"},
    {.name = "enable2"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts"},
    {.name = "max_speed2", .type = WireType::kI16, .unit = "rpm"},
    {.name = "return_type", .optional = true}};

inline constexpr Field kMainData[] = {
    {.name = "speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "current", .type = WireType::kU16, .unit = "A", .scale = 0.1},
    {.name = "control_type"},
    {.name = "reference_speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "output", .type = WireType::kI16},
    {.name = "status"},
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "brake_duty"},
    {.name = "temperature", .unit = "degC"},
    {.name = "status2", .optional = true},
};
inline constexpr Field kIoMonitor[] = {
    {.name = "speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "current", .type = WireType::kU16, .unit = "A", .scale = 0.1},
    {.name = "status"},
    {.name = "inputs"},
    {.name = "speed_input", .type = WireType::kU16},
    {.name = "dip_switch"},
    {.name = "hall"},
    {.name = "status2"},
    {.name = "switch_input"},
    {.name = "supply", .type = WireType::kU16, .unit = "V", .scale = 0.1},
    {.name = "slow_start_volume"},
    {.name = "slow_down_volume"},
    {.name = "internal_volume"},
};
inline constexpr Field kMonitor[] = {
    {.name = "speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "current", .type = WireType::kU16, .unit = "A", .scale = 0.1},
    {.name = "output", .type = WireType::kU16},
    {.name = "status"},
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "inputs"},
};
inline constexpr Field kPositions[] = {
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts", .optional = true}};
inline constexpr Field kPntMainData[] = {
    {.name = "speed1", .type = WireType::kI16, .unit = "rpm"},
    {.name = "current1", .type = WireType::kU16, .unit = "A", .scale = 0.1},
    {.name = "status1"},
    {.name = "position1", .type = WireType::kI32, .unit = "counts"},
    {.name = "speed2", .type = WireType::kI16, .unit = "rpm"},
    {.name = "current2", .type = WireType::kU16, .unit = "A", .scale = 0.1},
    {.name = "status2"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts"}};
inline constexpr Field kPntMonitor[] = {
    {.name = "speed1", .type = WireType::kI16, .unit = "rpm"},
    {.name = "status1"},
    {.name = "position1", .type = WireType::kI32, .unit = "counts"},
    {.name = "speed2", .type = WireType::kI16, .unit = "rpm"},
    {.name = "status2"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts"}};
inline constexpr Field kPntIoMonitor[] = {
    {.name = "inputs1"},
    {.name = "inputs2"},
    {.name = "hall1"},
    {.name = "hall2"},
    {.name = "speed_input1", .type = WireType::kU16},
    {.name = "speed_input2", .type = WireType::kU16},
    {.name = "supply", .type = WireType::kU16, .unit = "V", .scale = 0.1},
    {.name = "slow_start_volume"},
    {.name = "internal_volume"},
    {.name = "dip_switch"}};
inline constexpr Field kGains[] = {{.name = "position_p", .type = WireType::kI16},
                                   {.name = "speed_p", .type = WireType::kI16},
                                   {.name = "speed_i", .type = WireType::kI16}};
inline constexpr Field kTorqueGains[] = {{.name = "p", .type = WireType::kI16},
                                         {.name = "i", .type = WireType::kI16}};
inline constexpr Field kLimits[] = {{.name = "low", .type = WireType::kI16},
                                    {.name = "high", .type = WireType::kI16}};
inline constexpr Field kStep[] = {{.name = "number"},
                                  {.name = "speed", .type = WireType::kI16, .unit = "rpm"}};
inline constexpr Field kCurvePoint[] = {{.name = "number"},
                                        {.name = "x", .type = WireType::kI16},
                                        {.name = "y", .type = WireType::kI16}};
inline constexpr Field kPreset[] = {
    {.name = "number"},
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "position2", .type = WireType::kI32, .unit = "counts", .optional = true}};
inline constexpr Field kFunctionType[] = {{.name = "type"}, {.name = "x", .optional = true}};
inline constexpr Field kFunctionSpeed[] = {
    {.name = "speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "delay", .type = WireType::kI16, .unit = "s", .scale = 0.1}};
inline constexpr Field kFunctionPosition[] = {
    {.name = "speed", .type = WireType::kI16, .unit = "rpm"},
    {.name = "increment", .type = WireType::kI16, .unit = "counts"}};
inline constexpr Field kFirstWord[] = {{.name = "value", .type = WireType::kU16}};
inline constexpr Field kCanFrame[] = {
    {.name = "can_id", .type = WireType::kU32}, {.name = "data1", .optional = true},
    {.name = "data2", .optional = true},        {.name = "data3", .optional = true},
    {.name = "data4", .optional = true},        {.name = "data5", .optional = true},
    {.name = "data6", .optional = true},        {.name = "data7", .optional = true},
    {.name = "data8", .optional = true}};

// --- Commands (2.4) ------------------------------------------------------------------------------

// clang-format off
inline constexpr CommandRow kCommands[] = {
    {.code = 3, .name = "PID_DEFAULT_SET", .request = kCheck, .replies = false, .source = "p. 6",
     .doc = "With 0x55: all settings to the model's defaults except ID, baud rate and CAN bit rate; output off."},
    {.code = 4, .name = "PID_REQ_PID_DATA", .request = kPid, .names = Names::kParameter, .source = "p. 6",
     .doc = "Asks for a PID's data; the answer is that PID's own frame. Silence for commands and unknown PIDs."},
    {.code = 5, .name = "PID_TQ_OFF", .request = kDoNotCare, .replies = false, .source = "p. 6",
     .doc = "All motors free at once."},
    {.code = 6, .name = "PID_BRAKE", .request = kDoNotCare, .replies = false, .source = "p. 6",
     .doc = "All motors shorted at once."},
    {.code = 10, .name = "PID_COMMAND", .request = kNumber, .names = Names::kFunction, .replies = false, .source = "p. 6",
     .doc = "One of the command numbers below."},
    {.code = 12, .name = "PID_ALARM_RESET", .request = kDoNotCare, .replies = false, .source = "p. 7",
     .doc = "Clears the alarms whose cause is gone."},
    {.code = 13, .name = "PID_POSI_RESET", .request = kDoNotCare, .replies = false, .source = "p. 7",
     .doc = "Sets the position of all motors to 0; hosts send it with and without its byte."},
    {.code = 14, .name = "PID_MAIN_BC_STATE", .request = kState, .replies = false, .source = "p. 7",
     .doc = "1: PID 193 each 100 ms to this host; 0: no more."},
    {.code = 15, .name = "PID_MONITOR_BC_STATE", .request = kState, .replies = false, .source = "p. 7",
     .doc = "1: PID 196 each 100 ms to this host; 0: no more."},
    {.code = 30, .name = "PID_PRESET_SAVE", .request = kNumber, .replies = false, .source = "p. 10",
     .doc = "Keeps the present position (both motors) as preset 1..20. The frame printed beside it says 31."},
    {.code = 31, .name = "PID_PRESET_RECALL", .request = kNumber, .replies = false, .source = "p. 10",
     .doc = "Moves to preset 1..20; one that was never saved is 0. The frame printed beside it says 32."},
    {.code = 100, .name = "PID_START_STOP", .request = kState, .replies = false, .source = "p. 11",
     .doc = "0 stop, 1 run counter-clockwise, 2 clockwise at COM_TAR_SPEED (180); ignored while that is 0."},
    {.code = 130, .name = "PID_VEL_CMD", .request = kSpeed, .replies = false, .source = "p. 12",
     .doc = "Speed reference of motor 1, positive is counter-clockwise."},
    {.code = 131, .name = "PID_VEL_CMD2", .request = kSpeed, .replies = false, .source = "p. 12",
     .doc = "Speed reference in steps of 10 rpm; on dual models, as real ones do, that of motor 2 in rpm."},
    {.code = 134, .name = "PID_OPEN_VEL_CMD", .request = kOutput, .replies = false, .source = "p. 12",
     .doc = "Open loop, -1023..1023 for full duty."},
    {.code = 140, .name = "PID_TQ_CMD", .request = kTorque, .replies = false, .source = "p. 13",
     .doc = "Torque, -1023..1023 for MAX_LOAD. The frame printed has its two machine ids swapped."},
    {.code = 164, .name = "PID_REQ_PID_DATA2", .request = kPidWithIndex, .names = Names::kParameter, .source = "p. 15",
     .doc = "Asks for one of the rows of PID 225, 226 or 227."},
    {.code = 174, .name = "PID_PNT_TQ_OFF", .request = kEnableTwo, .replies = false, .source = "p. 16",
     .doc = "Frees the motors whose byte is not 0."},
    {.code = 175, .name = "PID_PNT_BRAKE", .request = kEnableTwo, .replies = false, .source = "p. 16",
     .doc = "Shorts the motors whose byte is not 0."},
    {.code = 184, .name = "PID_FUNC_CMD", .request = kFunctionOn, .replies = false, .source = "p. 18",
     .doc = "START/STOP by frame for the special function of PID 183."},
    {.code = 206, .name = "PID_PNT_POSI_CMD", .request = kTwoPositionsAndSpeeds, .replies = false, .source = "p. 21",
     .doc = "Moves to two positions; a motor whose byte is 0 keeps what it does."},
    {.code = 207, .name = "PID_PNT_VEL_CMD", .request = kTwoSpeeds, .replies = false, .source = "p. 21",
     .doc = "Two speeds; a motor whose byte is 0 keeps what it does."},
    {.code = 208, .name = "PID_PNT_OPEN_VEL_CMD", .request = kTwoOutputs, .replies = false, .source = "p. 21",
     .doc = "Open loop for two motors."},
    {.code = 209, .name = "PID_PNT_TQ_CMD", .request = kTwoTorques, .replies = false, .source = "p. 22",
     .doc = "Torque for two motors."},
    {.code = 215, .name = "PID_PNT_INC_POSI_CMD", .request = kTwoPositions, .replies = false, .source = "p. 24",
     .doc = "Moves two motors by increments."},
    {.code = 217, .name = "PID_POSI_SET", .request = kPosition, .replies = false, .source = "p. 24",
     .doc = "Gives the present position of motor 1 another number."},
    {.code = 218, .name = "PID_POSI_SET2", .request = kPosition, .replies = false, .source = "p. 24",
     .doc = "The same for motor 2."},
    {.code = 219, .name = "PID_POSI_VEL_CMD", .request = kPositionAndSpeed, .replies = false, .source = "p. 24",
     .doc = "Moves motor 1 to a position; speed 0 is half of MAX_RPM."},
    {.code = 220, .name = "PID_INC_POSI_VEL_CMD", .request = kPositionAndSpeed, .replies = false, .source = "p. 24",
     .doc = "Moves motor 1 by an increment. The frame printed says 219."},
    {.code = 242, .name = "PID_PNT_INC_POSI_VEL_CMD", .request = kTwoPositionsAndSpeeds, .replies = false, .source = "p. 27",
     .doc = "Moves two motors by increments, each with its speed."},
    {.code = 243, .name = "PID_POSI_CMD", .request = kPosition, .replies = false, .source = "p. 27",
     .doc = "Moves motor 1 to a position at TAR_POSI_VEL. Typed R/W; never answered."},
    {.code = 244, .name = "PID_INC_POSI_CMD", .request = kPosition, .replies = false, .source = "p. 27",
     .doc = "Moves motor 1 by an increment at TAR_POSI_VEL. Typed R/W; never answered."},
    {.code = 246, .name = "PID_PNT_POSI_CMD (246)", .request = kTwoPositions, .replies = false, .source = "p. 28",
     .doc = "Moves two motors at TAR_POSI_VEL. The last byte is the return type on dual models, on single ones the ID that shall answer with PID 196."},
    {.code = 251, .name = "PID_INC_POSI_CMD2", .request = kPosition, .replies = false, .source = "p. 28",
     .doc = "Moves motor 2 by an increment at TAR_POSI_VEL. Typed R/W; never answered."},
};

/// The numbers of PID_COMMAND (10).
inline constexpr CommandRow kCommandNumbers[] = {
    {.code = 2, .name = "CMD_TQ_OFF", .replies = false, .source = "p. 6",
     .doc = "All motors free."},
    {.code = 4, .name = "CMD_BRAKE", .replies = false, .source = "p. 6",
     .doc = "All motors shorted."},
    {.code = 5, .name = "CMD_MAIN_DATA_BC_ON", .replies = false, .source = "p. 6",
     .doc = "PID 193 each 100 ms to this host."},
    {.code = 6, .name = "CMD_MAIN_DATA_BC_OFF", .replies = false, .source = "p. 6",
     .doc = "No more."},
    {.code = 8, .name = "CMD_ALARM_RESET", .replies = false, .source = "p. 6",
     .doc = "As PID 12."},
    {.code = 10, .name = "CMD_POSI_RESET", .replies = false, .source = "p. 6",
     .doc = "As PID 13."},
    {.code = 11, .name = "CMD_MONITOR_BC_ON", .replies = false, .source = "p. 6",
     .doc = "PID 196 each 100 ms to this host."},
    {.code = 12, .name = "CMD_MONITOR_BC_OFF", .replies = false, .source = "p. 6",
     .doc = "No more."},
    {.code = 13, .name = "CMD_IO_MONITOR_BC_ON", .replies = false, .source = "p. 6",
     .doc = "PID 194 each 100 ms to this host."},
    {.code = 14, .name = "CMD_IO_MONITOR_BC_OFF", .replies = false, .source = "p. 6",
     .doc = "No more."},
    {.code = 15, .name = "CMD_FAN_ON", .replies = false, .source = "p. 6",
     .doc = "Fan on."},
    {.code = 16, .name = "CMD_FAN_OFF", .replies = false, .source = "p. 7",
     .doc = "Fan off, but for what the heat sink asks for."},
    {.code = 17, .name = "CMD_CLUTCH_ON", .replies = false, .source = "p. 7",
     .doc = "Mechanical brake engaged (models with that output)."},
    {.code = 18, .name = "CMD_CLUTCH_OFF", .replies = false, .source = "p. 7",
     .doc = "Mechanical brake released."},
    {.code = 20, .name = "CMD_TAR_VEL_OFF", .replies = false, .source = "p. 7",
     .doc = "TAR_VEL (155) to 0."},
    {.code = 21, .name = "CMD_SLOW_START_OFF", .replies = false, .source = "p. 7",
     .doc = "SLOW_START (153) to 0."},
    {.code = 22, .name = "CMD_SLOW_DOWN_OFF", .replies = false, .source = "p. 7",
     .doc = "SLOW_DOWN (154) to 0."},
    {.code = 23, .name = "CMD_CAN_RESEND_ON", .replies = false, .source = "p. 7",
     .doc = "What is heard on CAN goes out on RS-485 as PID 238, to this host (models with CAN)."},
    {.code = 24, .name = "CMD_CAN_RESEND_OFF", .replies = false, .source = "p. 7",
     .doc = "No more."},
    {.code = 25, .name = "CMD_MAX_LOAD_OFF", .replies = false, .source = "p. 7",
     .doc = "MAX_LOAD (211) to the model's."},
    {.code = 26, .name = "CMD_ENC_PPR_OFF", .replies = false, .source = "p. 7",
     .doc = "ENC_PPR (156) to 0."},
    {.code = 27, .name = "CMD_LOW_SPEED_LIMIT_OFF", .replies = false, .source = "p. 7",
     .doc = "LOW_SPEED_LIMIT (157) to 0."},
    {.code = 28, .name = "CMD_HIGH_SPEED_LIMIT_OFF", .replies = false, .source = "p. 7",
     .doc = "HIGH_SPEED_LIMIT (158) to 0, not set."},
    {.code = 29, .name = "CMD_SPEED_LIMIT_OFF", .replies = false, .source = "p. 7",
     .doc = "Both limits to 0."},
    {.code = 31, .name = "CMD_CURVE_PT_OFF", .replies = false, .source = "p. 7",
     .doc = "All curve points to 0, not set."},
    {.code = 32, .name = "CMD_STEP_INPUT_OFF", .replies = false, .source = "p. 7",
     .doc = "INPUT_TYPE (25) to 0."},
    {.code = 44, .name = "CMD_UICOM_OFF", .replies = false, .source = "p. 7",
     .doc = "The terminals drive again."},
    {.code = 45, .name = "CMD_UICOM_ON", .replies = false, .source = "p. 7",
     .doc = "Frames drive; the terminals are limits."},
    {.code = 46, .name = "CMD_MAX_RPM_OFF", .replies = false, .source = "p. 7",
     .doc = "MAX_RPM (221) to the model's."},
    {.code = 47, .name = "CMD_HALL_TYPE_OFF", .replies = false, .source = "p. 7",
     .doc = "HALL_TYPE (21) to the model's."},
    {.code = 48, .name = "CMD_LOW_POT_OFF", .replies = false, .source = "p. 7",
     .doc = "Low half of PID 224 to 0."},
    {.code = 49, .name = "CMD_HIGH_POT_OFF", .replies = false, .source = "p. 7",
     .doc = "High half of PID 224 to 0."},
    {.code = 50, .name = "CMD_MAIN_DATA_BC_ON2", .replies = false, .source = "p. 7",
     .doc = "PID 200 each 100 ms (dual models)."},
    {.code = 51, .name = "CMD_MAIN_DATA_BC_OFF2", .replies = false, .source = "p. 7",
     .doc = "No more."},
    {.code = 52, .name = "CMD_MONITOR_BC_ON2", .replies = false, .source = "p. 7",
     .doc = "PID 201 each 100 ms (dual models)."},
    {.code = 53, .name = "CMD_MONITOR_BC_OFF2", .replies = false, .source = "p. 7",
     .doc = "No more."},
    {.code = 54, .name = "CMD_IO_MONITOR_BC_ON2", .replies = false, .source = "p. 7",
     .doc = "PID 202 each 100 ms (dual models)."},
    {.code = 55, .name = "CMD_IO_MONITOR_BC_OFF2", .replies = false, .source = "p. 7",
     .doc = "No more."},
    {.code = 61, .name = "CMD_PNT_MAIN_DATA_BC_ON", .replies = false, .evidence = Evidence::kObserved, .source = "later",
     .doc = "PID 210 each 100 ms (dual models)."},
    {.code = 62, .name = "CMD_PNT_MAIN_DATA_BC_OFF", .replies = false, .evidence = Evidence::kObserved, .source = "later",
     .doc = "No more."},
};

// --- Parameters (2.4) ----------------------------------------------------------------------------

inline constexpr Range kByte = {0, 255};
inline constexpr Range kFlag = {0, 1};
inline constexpr Range kTenBits = {0, 1023};
inline constexpr Range kPositive = {0, 32767};
inline constexpr Range kAnyI16 = {-32768, 32767};
inline constexpr Range kAnyI32 = {INT32_MIN, INT32_MAX};

inline constexpr ParameterRow kParameters[] = {
    {.id = 1, .name = "PID_VERSION", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .factory = {44}, .source = "p. 6",
     .doc = "44 is V4.4."},
    {.id = 7, .name = "PID_ACK", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .support = Support::kRejected, .source = "p. 6",
     .doc = "The PID that was received; sent by RETURN_TYPE 2, never asked for: a request for it is not answered."},
    {.id = 16, .name = "PID_INV_SIGN_CMD", .type = WireType::kU8, .range = kFlag, .source = "p. 8",
     .doc = "1 turns the sign of commands to motor 1 and of what it reports."},
    {.id = 17, .name = "PID_USE_LIMIT_SW", .type = WireType::kU8, .range = kFlag, .factory = {1}, .source = "p. 8",
     .doc = "1: while frames drive, pin 6 (DIR) permits CW and pin 8 (START/STOP) CCW. The remark prints 6, 7."},
    {.id = 18, .name = "PID_INV_SIGN_CMD2", .type = WireType::kU8, .range = kFlag, .source = "p. 8",
     .doc = "As 16 for motor 2; stored on single models."},
    {.id = 19, .name = "PID_INV_ALARM", .type = WireType::kU8, .range = kFlag, .source = "p. 8",
     .doc = "Turns the sense of the ALARM output."},
    {.id = 21, .name = "PID_HALL_TYPE", .type = WireType::kU8, .range = kByte, .factory = {2}, .source = "p. 8",
     .doc = "Poles: 0..5 for 4, 8, 10, 12, 2, 6; from 6 on twice the value."},
    {.id = 22, .name = "PID_INV_SIGN_OUT", .type = WireType::kU8, .range = kFlag, .evidence = Evidence::kObserved, .source = "later",
     .doc = "1 turns the sign of what motor 1 reports."},
    {.id = 23, .name = "PID_INV_SIGN_OUT2", .type = WireType::kU8, .range = kFlag, .evidence = Evidence::kObserved, .source = "later",
     .doc = "The same for motor 2."},
    {.id = 24, .name = "PID_ZERO_VEL_CTRL", .type = WireType::kU8, .range = {0, 5}, .evidence = Evidence::kObserved, .source = "p. 8",
     .doc = "At speed 0: 0 free, 1 held, 2 shorted; 3 free as soon as 0 is commanded; 4 and 5 as 0. V4.4 has 0 and 1."},
    {.id = 25, .name = "PID_INPUT_TYPE", .type = WireType::kU8, .range = {0, 5}, .source = "p. 8",
     .doc = "Speed input: 0 analog or PWM, 1 joystick, 2 pulse, 3 RC, 5 step. 4 is refused."},
    {.id = 26, .name = "PID_LATER_26", .type = WireType::kU8, .range = kByte, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Written by hosts at start-up."},
    {.id = 28, .name = "PID_STOP_STATUS2", .type = WireType::kU8, .range = {0, 5}, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "As 24 for motor 2; 24 serves both."},
    {.id = 29, .name = "PID_USE_LIMIT_SW2", .type = WireType::kU8, .range = kFlag, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "As 17 for motor 2; 17 serves both."},
    {.id = 34, .name = "PID_CTRL_STATUS", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .source = "p. 10",
     .doc = "Status bits of motor 1. The answer printed begins 184, 183."},
    {.id = 36, .name = "PID_START_INV_SIGN", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "1 inverts START/STOP, as limit too."},
    {.id = 37, .name = "PID_RUN_INV_SIGN", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "1 inverts RUN/BRAKE."},
    {.id = 38, .name = "PID_REGENERATION", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "1: the motor is also braked to hold the speed; 0: only driven."},
    {.id = 39, .name = "PID_CTRL_STATUS2", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Status bits of motor 2."},
    {.id = 40, .name = "PID_LIMIT_STOP_COND", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "At a limit: 1 short, 0 free."},
    {.id = 41, .name = "PID_TQ_LIMIT_SW", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "1: more than 90 % of MAX_LOAD for 100 ms stops like a limit switch."},
    {.id = 44, .name = "PID_TQ_CTRL", .type = WireType::kU8, .range = kFlag, .source = "p. 11",
     .doc = "1: the terminals' reference is torque."},
    {.id = 45, .name = "PID_BLUETOOTH", .type = WireType::kU8, .range = kFlag, .support = Support::kStored, .source = "p. 11",
     .doc = "There is no Bluetooth. The frame printed says 44."},
    {.id = 46, .name = "PID_USE_EPOSI", .type = WireType::kU8, .range = kFlag, .evidence = Evidence::kObserved, .source = "later",
     .doc = "1: position in encoder counts (4 x ENC_PPR), its sign turned."},
    {.id = 48, .name = "PID_DI", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Inputs: bit 0 INT_SPEED, 1 ALARM_RESET, 2 DIR, 3 RUN/BRAKE, 4 START/STOP, 5 ENC_B, 6 ENC_A."},
    {.id = 49, .name = "PID_IN_POSITION_OK", .type = WireType::kU8, .access = Access::kReadOnly, .range = {0, 3}, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Bit 0: motor 1 in position, bit 1: motor 2."},
    {.id = 57, .name = "PID_MAX_SS_TIME", .type = WireType::kU8, .range = kByte, .factory = {15}, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Seconds that 1023 of SLOW_START, SLOW_DOWN, POSI_SS and POSI_SD stands for."},
    {.id = 60, .name = "PID_LAST_ALARM", .type = WireType::kU8, .access = Access::kReadOnly, .range = kByte, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Status bits of the last alarm."},
    {.id = 78, .name = "PID_UI_COM", .type = WireType::kU8, .range = kFlag, .evidence = Evidence::kObserved, .source = "later",
     .doc = "1: frames drive from power-up on, 0: the terminals do, until the first motion command; a change acts as CMD 45 or 44."},
    {.id = 81, .name = "PID_LATER_81", .type = WireType::kU8, .range = kByte, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Written by hosts at start-up."},
    {.id = 82, .name = "PID_SYNC_TYPE", .type = WireType::kU8, .range = kByte, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Written by hosts at start-up."},
    {.id = 84, .name = "PID_NO_MODBUS", .type = WireType::kU8, .range = kByte, .factory = {1}, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Modbus RTU is not spoken."},
    {.id = 92, .name = "PID_LATER_92", .type = WireType::kU8, .range = kByte, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Written by hosts at start-up."},
    {.id = 126, .name = "PID_LATER_126", .type = WireType::kU8, .range = kByte, .support = Support::kStored, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Written by hosts at start-up."},
    {.id = 133, .name = "PID_ID", .type = WireType::kU8, .range = {1, 253}, .factory = {1}, .source = "p. 12",
     .doc = "Own ID, at once. Written behind 0xAA."},
    {.id = 135, .name = "PID_BAUDRATE", .type = WireType::kU8, .range = {1, 5}, .factory = {2}, .source = "p. 12",
     .doc = "9600, 19200, 38400, 57600, 115200; from the next power-up on. Written behind 0xAA."},
    {.id = 137, .name = "PID_ECAN_BITRATE", .type = WireType::kU8, .range = {1, 5}, .factory = {1}, .source = "p. 12",
     .doc = "50, 100, 250, 500 kbit/s, 1 Mbit/s; from the next power-up on. Stored on models without CAN. Written behind 0xAA."},
    {.id = 138, .name = "PID_INT_RPM_DATA", .type = WireType::kI16, .access = Access::kReadOnly, .range = kAnyI16, .unit = "rpm", .source = "p. 12",
     .doc = "Speed of motor 1."},
    {.id = 139, .name = "PID_TQ_DATA", .type = WireType::kU16, .access = Access::kReadOnly, .range = {0, 32767}, .unit = "A", .scale = 0.1, .source = "p. 12",
     .doc = "Current of motor 1."},
    {.id = 143, .name = "PID_VOLT_IN", .type = WireType::kU16, .access = Access::kReadOnly, .range = {0, 32767}, .unit = "V", .scale = 0.1, .source = "p. 13",
     .doc = "Supply: 0.1 V, on AC models 1 V of the DC link."},
    {.id = 146, .name = "PID_CCW_PHASE_OFFSET", .type = WireType::kU8, .range = {0, 30}, .unit = "deg", .source = "p. 13",
     .doc = "Commutation this much earlier, CCW. Written behind 0xAA."},
    {.id = 147, .name = "PID_CW_PHASE_OFFSET", .type = WireType::kU8, .range = {0, 30}, .unit = "deg", .source = "p. 13",
     .doc = "Commutation this much earlier, CW. Written behind 0xAA."},
    {.id = 149, .name = "PID_RETURN_TYPE", .type = WireType::kU8, .range = {0, 3}, .source = "p. 13",
     .doc = "What a command or write is answered with: 0 nothing, 1 PID 196, 2 PID 7, 3 PID 194. Written behind 0xAA."},
    {.id = 150, .name = "PID_TQ_PO", .type = WireType::kI16, .range = kAnyI16, .support = Support::kStored, .source = "header",
     .doc = "Nothing tells what it is."},
    {.id = 152, .name = "PID_OVER_MODULATION", .type = WireType::kU8, .range = kFlag, .evidence = Evidence::kAssumed, .source = "p. 13",
     .doc = "1: each leg conducts for 150 degrees instead of 120, more output with more ripple. Written behind 0xAA."},
    {.id = 153, .name = "PID_SLOW_START", .type = WireType::kI16, .range = kTenBits, .source = "p. 13",
     .doc = "1023: 15 s from 0 to MAX_RPM, linear."},
    {.id = 154, .name = "PID_SLOW_DOWN", .type = WireType::kI16, .range = kTenBits, .source = "p. 13",
     .doc = "1023: 15 s from MAX_RPM to 0, linear."},
    {.id = 155, .name = "PID_TAR_VEL", .type = WireType::kI16, .range = {0, 32767}, .unit = "rpm", .source = "p. 14",
     .doc = "In place of the internal volume while above 0; clamped to MAX_RPM."},
    {.id = 156, .name = "PID_ENC_PPR", .type = WireType::kI16, .range = {0, 32767}, .source = "p. 14",
     .doc = "Above 0: speed from an encoder with so many lines."},
    {.id = 157, .name = "PID_LOW_SPEED_LIMIT", .type = WireType::kI16, .range = {0, 512}, .source = "p. 14",
     .doc = "Analog input below it is 0. The frame printed says 154."},
    {.id = 158, .name = "PID_HIGH_SPEED_LIMIT", .type = WireType::kI16, .range = kTenBits, .source = "p. 14",
     .doc = "Analog input above it is full; 0 is not set, 1..511 is taken as 512."},
    {.id = 159, .name = "PID_SLOW_START_DOWN", .type = WireType::kI16, .range = kTenBits, .evidence = Evidence::kAssumed, .source = "header",
     .doc = "Writes 153 and 154; reads 153."},
    {.id = 160, .name = "PID_PWM_OUT", .type = WireType::kI16, .range = kTenBits, .support = Support::kStored, .source = "p. 15",
     .doc = "For DC-motor controllers (DMD)."},
    {.id = 162, .name = "PID_DEAD_ZONE", .type = WireType::kI16, .range = kTenBits, .factory = {100}, .evidence = Evidence::kAssumed, .source = "p. 15",
     .doc = "Joystick and RC within +-it of the centre are 0."},
    {.id = 166, .name = "PID_REF_RPM", .type = WireType::kI16, .access = Access::kReadOnly, .range = kAnyI16, .unit = "rpm", .source = "p. 16",
     .doc = "Ramped reference of motor 1."},
    {.id = 167, .name = "PID_PV_GAIN", .type = WireType::kI16, .range = kPositive, .factory = {20}, .evidence = Evidence::kAssumed, .source = "p. 16",
     .doc = "Position loop: speed per error, 0.1/s."},
    {.id = 168, .name = "PID_P_GAIN", .type = WireType::kI16, .range = kPositive, .factory = {50}, .evidence = Evidence::kAssumed, .source = "p. 16",
     .doc = "Speed loop, proportional; GAIN_FACTOR 16384."},
    {.id = 169, .name = "PID_I_GAIN", .type = WireType::kI16, .range = kPositive, .factory = {1800}, .evidence = Evidence::kAssumed, .source = "p. 16",
     .doc = "Speed loop, integral."},
    {.id = 170, .name = "PID_TQ_P_GAIN", .type = WireType::kI16, .range = kPositive, .factory = {10}, .evidence = Evidence::kAssumed, .source = "p. 16",
     .doc = "Torque loop, proportional; GAIN_FACTOR 128."},
    {.id = 171, .name = "PID_IN_POSITION", .type = WireType::kI16, .range = kPositive, .source = "p. 16",
     .doc = "A move ends within this many counts; 0: it is held. The frame printed says 167."},
    {.id = 176, .name = "PID_TAR_POSI_VEL", .type = WireType::kI16, .range = kPositive, .factory = {2000}, .unit = "rpm", .evidence = Evidence::kObserved, .source = "p. 17",
     .doc = "Speed of moves that name none."},
    {.id = 177, .name = "PID_TQ_I_GAIN", .type = WireType::kI16, .range = kPositive, .factory = {20}, .evidence = Evidence::kAssumed, .source = "p. 17",
     .doc = "Torque loop, integral."},
    {.id = 178, .name = "PID_POSI_SS", .type = WireType::kI16, .range = kTenBits, .factory = {100}, .evidence = Evidence::kObserved, .source = "p. 17",
     .doc = "Acceleration of moves, as SLOW_START; 0 is no limit."},
    {.id = 179, .name = "PID_POSI_SD", .type = WireType::kI16, .range = kTenBits, .factory = {100}, .evidence = Evidence::kObserved, .source = "p. 17",
     .doc = "Deceleration of moves, as SLOW_DOWN; 0 is no limit."},
    {.id = 180, .name = "PID_COM_TAR_SPEED", .type = WireType::kI16, .range = kAnyI16, .unit = "rpm", .source = "p. 18",
     .doc = "Speed of START_STOP (100); forgotten at power-off."},
    {.id = 183, .name = "PID_FUNC_CMD_TYPE", .range = {0, 4}, .fields = kFunctionType, .source = "p. 18",
     .doc = "Special function: 1 SPEED, 2 POSITION, 3 MOMENTARY, 4 ADD."},
    {.id = 185, .name = "PID_COM_WATCH_DELAY", .range = {0, 65535}, .fields = kFirstWord, .evidence = Evidence::kObserved, .source = "later",
     .doc = "0.1 s without a good frame: reference 0 to motors that frames drive; 0 is off. A second word is left alone."},
    {.id = 193, .name = "PID_MAIN_DATA", .access = Access::kReadOnly, .fields = kMainData, .evidence = Evidence::kObserved, .source = "p. 18",
     .doc = "Monitor block of motor 1. V4.4 prints 16 bytes; real controllers send status2 as a 17th."},
    {.id = 194, .name = "PID_IO_MONITOR", .access = Access::kReadOnly, .fields = kIoMonitor, .evidence = Evidence::kObserved, .source = "header",
     .doc = "Inputs of motor 1."},
    {.id = 196, .name = "PID_MONITOR", .access = Access::kReadOnly, .fields = kMonitor, .source = "p. 20",
     .doc = "Short monitor of motor 1; prints 11 bytes and counts 12: the last are the inputs."},
    {.id = 197, .name = "PID_POSI_DATA", .access = Access::kReadOnly, .fields = kPositions, .evidence = Evidence::kObserved, .source = "p. 20",
     .doc = "Position; dual controllers send both."},
    {.id = 198, .name = "PID_RPM_DATA", .type = WireType::kI32, .access = Access::kReadOnly, .range = kAnyI32, .unit = "rpm", .source = "p. 20",
     .doc = "Speed of motor 1."},
    {.id = 200, .name = "PID_MAIN_DATA2", .access = Access::kReadOnly, .fields = kMainData, .evidence = Evidence::kObserved, .source = "p. 20",
     .doc = "193 of motor 2."},
    {.id = 201, .name = "PID_MONITOR2", .access = Access::kReadOnly, .fields = kMonitor, .source = "p. 20",
     .doc = "196 of motor 2; the row is named PID_IO_MONITOR."},
    {.id = 202, .name = "PID_IO_MONITOR2", .access = Access::kReadOnly, .fields = kIoMonitor, .evidence = Evidence::kObserved, .source = "p. 20",
     .doc = "194 of motor 2; the row is named PID_IO_IO_MONITOR."},
    {.id = 203, .name = "PID_GAIN", .fields = kGains, .source = "p. 20",
     .doc = "PIDs 167, 168 and 169 in one."},
    {.id = 205, .name = "PID_TYPE", .type = WireType::kText, .count = 20, .access = Access::kReadOnly, .source = "p. 20",
     .doc = "The model and V4.4, without terminator."},
    {.id = 210, .name = "PID_PNT_MAIN_DATA", .access = Access::kReadOnly, .fields = kPntMainData, .source = "p. 22",
     .doc = "Both motors in one; a single controller's other half is 0."},
    {.id = 211, .name = "PID_MAX_LOAD", .type = WireType::kI16, .range = {0, 1500}, .factory = {200}, .unit = "A", .scale = 0.1, .source = "p. 24",
     .doc = "Highest current; 0 is the model's. Up to 150 % of the model's current."},
    {.id = 212, .name = "PID_LIMIT_TQ", .type = WireType::kI16, .range = kAnyI16, .support = Support::kStored, .source = "header",
     .doc = "Nothing tells what it is."},
    {.id = 216, .name = "PID_PNT_MONITOR", .access = Access::kReadOnly, .fields = kPntMonitor, .evidence = Evidence::kObserved, .source = "p. 16",
     .doc = "Both motors, short: return type 1 of the two-motor commands, which V4.4 does not number."},
    {.id = 221, .name = "PID_MAX_RPM", .type = WireType::kI16, .range = {1, 32767}, .factory = {3000}, .unit = "rpm", .evidence = Evidence::kAssumed, .source = "p. 24",
     .doc = "Full scale of all speeds."},
    {.id = 222, .name = "PID_SPEED_LIMIT", .fields = kLimits, .source = "p. 25",
     .doc = "PIDs 157 and 158 in one."},
    {.id = 223, .name = "PID_MIN_RPM", .type = WireType::kI16, .range = {0, 32767}, .factory = {1}, .unit = "rpm", .evidence = Evidence::kObserved, .source = "header",
     .doc = "References below are 0."},
    {.id = 224, .name = "PID_SPEED_LIMIT2", .fields = kLimits, .evidence = Evidence::kAssumed, .source = "header",
     .doc = "As 222 for the internal volume."},
    {.id = 225, .name = "PID_STEP_INPUT", .fields = kStep, .source = "p. 25",
     .doc = "Speed of step 1..7; never set: MAX_RPM x n / 7."},
    {.id = 226, .name = "PID_CURVE_PT", .fields = kCurvePoint, .source = "p. 25",
     .doc = "Curve points 1, 2 (positive) and 3, 4 (negative); x 0 is not set."},
    {.id = 227, .name = "PID_PRESET_DATA", .access = Access::kReadOnly, .fields = kPreset, .evidence = Evidence::kObserved, .source = "p. 26",
     .doc = "Preset 1..20; dual controllers send both positions."},
    {.id = 230, .name = "PID_REF_POSI", .type = WireType::kI32, .access = Access::kReadOnly, .range = kAnyI32, .unit = "counts", .source = "p. 26",
     .doc = "Target position of motor 1."},
    {.id = 231, .name = "PID_POSI_MIN_LIMIT", .type = WireType::kI32, .range = kAnyI32, .factory = {-1023}, .unit = "counts", .evidence = Evidence::kObserved, .source = "p. 26",
     .doc = "Position at the lowest input, where the terminals drive a position."},
    {.id = 232, .name = "PID_POSI_CEN", .type = WireType::kI32, .range = kAnyI32, .unit = "counts", .source = "p. 26",
     .doc = "Position at input 0."},
    {.id = 233, .name = "PID_POSI_MAX_LIMIT", .type = WireType::kI32, .range = kAnyI32, .factory = {1023}, .unit = "counts", .evidence = Evidence::kObserved, .source = "p. 26",
     .doc = "Position at the highest input."},
    {.id = 234, .name = "PID_TIME", .type = WireType::kI32, .access = Access::kReadOnly, .range = {0, INT32_MAX}, .unit = "s", .evidence = Evidence::kAssumed, .source = "header",
     .doc = "Seconds since power-up."},
    {.id = 235, .name = "PID_TQ_GAIN", .fields = kTorqueGains, .evidence = Evidence::kObserved, .source = "later",
     .doc = "PIDs 170 and 177 in one."},
    {.id = 238, .name = "PID_CAN_RESEND", .access = Access::kReadOnly, .fields = kCanFrame, .support = Support::kRejected, .source = "p. 27",
     .doc = "A frame that was heard on CAN; sent by CMD 23 (p. 7), never asked for: a request for it is not answered."},
    {.id = 239, .name = "PID_FUNC_SPEED", .fields = kFunctionSpeed, .source = "p. 27",
     .doc = "Speed and run time of functions SPEED, MOMENTARY and ADD."},
    {.id = 241, .name = "PID_PNT_IO_MONITOR", .access = Access::kReadOnly, .fields = kPntIoMonitor, .evidence = Evidence::kObserved, .source = "later",
     .doc = "Inputs of both motors. V4.4's header has the older PHASE_OFFSET here."},
    {.id = 250, .name = "PID_FUNC_POSI", .fields = kFunctionPosition, .source = "p. 28",
     .doc = "Speed and increment of function POSITION."},
};
// clang-format on

/// Written as {kWriteCheck, value}; read without the check.
inline constexpr std::uint16_t kChecked[] = {133, 135, 137, 146, 147, 149, 152};
constexpr bool is_checked(std::uint16_t pid) {
  return std::ranges::find(kChecked, pid) != std::end(kChecked);
}

inline constexpr CodeRow kFaults[] = {
    {.code = 0, .name = "ALARM", .doc = "An alarm is pending; stands beside every other bit."},
    {.code = 1,
     .name = "CTRL_FAIL",
     .doc = "Speed off by more than 30 % of the reference for 15 s."},
    {.code = 2, .name = "OVER_VOLT", .doc = "DC link above the model's limit for 10 ms."},
    {.code = 3,
     .name = "OVER_TEMP",
     .doc = "Above 65 degC; the current limit falls from 55 degC on."},
    {.code = 4, .name = "OVER_LOAD", .doc = "Above MAX_LOAD for 4 s, or above 150 % of it."},
    {.code = 5, .name = "HALL_FAIL", .doc = "Hall code 0 or 7 for 10 ms."},
    {.code = 6, .name = "INV_VEL", .doc = "The speed's sign is not the output's, for 1 s."},
    {.code = 7, .name = "STALL", .doc = "Output, but no speed, for 2 s."},
};

inline constexpr ProtocolTable kTable = {
    .name = "md485",
    .title = "MD series on RS-485, V4.4",
    .document = "Communication protocol on RS485, BLDC driver, V4.4, 2019-07-16",
    .framing = {.start = "\xB7",
                .length_at = 4,
                .overhead = 6,
                .checksum = protocol::Checksum::kNegatedSum8,
                .checksum_span = "all bytes before it",
                .longest = 6 + 255,
                .silence = std::chrono::milliseconds(10)},
    .commands = kCommands,
    .functions = kCommandNumbers,
    .parameters = kParameters,
    .errors = {},
    .faults = kFaults,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::md485
