// MD series communication on RS-485, V4.4: framing and the first rows.
//
// Source column: section of "Communication protocol on RS485, BLDC driver", V4.4, 2019-07-16.
// A PID numbers a command or a parameter; both travel in the same frame, in both directions.
#pragma once

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
using protocol::Support;
using protocol::WireType;

// --- Framing (2.1) -------------------------------------------------------------------------------

/// Machine ids: who receives (RMID) and who transmits (TMID).
inline constexpr std::uint8_t kController = 183;
/// A host may call itself anything and hears its own number back; 184 and 128 are in use, too.
inline constexpr std::uint8_t kHost = 172;
/// The ID that every controller takes as its own.
inline constexpr std::uint8_t kAllControllers = 254;

// --- Fields --------------------------------------------------------------------------------------

inline constexpr Field kPid[] = {{.name = "pid"}};
inline constexpr Field kDoNotCare[] = {{.name = "x", .optional = true}};
inline constexpr Field kSpeed[] = {{.name = "speed", .type = WireType::kI16, .unit = "rpm"}};
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

// --- Commands and parameters (2.4) ---------------------------------------------------------------

inline constexpr CommandRow kCommands[] = {
    {.code = 4,
     .name = "PID_REQ_PID_DATA",
     .request = kPid,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "2.4",
     .doc = "Asks for a PID's data; the answer is that PID's own frame. No MD drive is there yet."},
    {.code = 13,
     .name = "PID_POSI_RESET",
     .request = kDoNotCare,
     .replies = false,
     .support = Support::kRejected,
     .source = "2.4",
     .doc = "Sets the position to zero; hosts send it with and without its byte. No MD drive is "
            "there yet."},
    {.code = 130,
     .name = "PID_VEL_CMD",
     .request = kSpeed,
     .replies = false,
     .support = Support::kRejected,
     .source = "2.4",
     .doc = "Speed reference, positive is counter-clockwise. No MD drive is there yet."},
};

inline constexpr ParameterRow kParameters[] = {
    {.id = 193,
     .name = "PID_MAIN_DATA",
     .access = Access::kReadOnly,
     .fields = kMainData,
     .support = Support::kRejected,
     .evidence = Evidence::kObserved,
     .source = "2.4",
     .doc = "Monitor block. V4.4 prints 16 bytes; real controllers send status2 as a 17th. No MD "
            "drive is there yet."},
};

inline constexpr CodeRow kFaults[] = {
    {.code = 0, .name = "ALARM", .doc = "An alarm is pending."},
    {.code = 1,
     .name = "CTRL_FAIL",
     .doc = "Speed off by more than 30 % of the reference for 15 s."},
    {.code = 2, .name = "OVER_VOLT", .doc = "Supply voltage above its limit."},
    {.code = 3,
     .name = "OVER_TEMP",
     .doc = "Above 65 degC; the output is reduced from 55 degC on."},
    {.code = 4, .name = "OVER_LOAD", .doc = "Above the set current for 4 s, or 150 % of it."},
    {.code = 5, .name = "HALL_FAIL", .doc = "Hall code 0 or 7, or an encoder failure."},
    {.code = 6, .name = "INV_VEL", .doc = "The speed's sign is not the output's."},
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
    .parameters = kParameters,
    .errors = {},
    .faults = kFaults,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::md485
