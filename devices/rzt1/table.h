// RZ/T1 motion-control firmware: the packets, and the first functions and variables.
//
// Source column: section of R11AN0086JJ0102, Rev.1.02, 2019-07-31. Variables (parameters) and
// functions share one numbering; lines of text name them, packets number them.
#pragma once

#include <cstdint>

#include "devices/protocol/table.h"

namespace virtdrive::rzt1 {

using protocol::Access;
using protocol::CodeRow;
using protocol::CommandRow;
using protocol::Evidence;
using protocol::Field;
using protocol::Framing;
using protocol::Names;
using protocol::ParameterRow;
using protocol::ProtocolTable;
using protocol::Support;
using protocol::WireType;

// --- Framing (8.1, 8.2) --------------------------------------------------------------------------

inline constexpr std::uint8_t kStart = 0xAA;
inline constexpr std::uint8_t kAllModules = 0xFF;
inline constexpr char kAcceptedPrompt = '>';
inline constexpr char kRefusedPrompt = '?';
/// Motors of the board: axis 1 and axis 2 of a line.
inline constexpr std::uint32_t kAxes = 2;

inline constexpr Framing kLines[] = {{.name = "ASCII", .end = "\r", .longest = 512}};

// --- Packets (8.2, Appendix B) -------------------------------------------------------------------

inline constexpr Field kVersion[] = {
    {.name = "protocol"}, {.name = "module"}, {.name = "minor"}, {.name = "major"}};
inline constexpr Field kMask[] = {{.name = "mask", .type = WireType::kU16}};
inline constexpr Field kReport[] = {
    {.name = "position", .type = WireType::kI32, .unit = "counts"},
    {.name = "status", .type = WireType::kU16},
    {.name = "position_error", .type = WireType::kI16, .unit = "counts"},
    {.name = "current", .type = WireType::kU16},
    {.name = "halls"},
    {.name = "inputs"},
    {.name = "pvt_fifo"},
    {.name = "scan_fifo"},
};
inline constexpr Field kId[] = {{.name = "id"}};
inline constexpr Field kIdValue[] = {{.name = "id"},
                                     {.name = "value", .type = WireType::kParameter}};
inline constexpr Field kValue[] = {{.name = "value", .type = WireType::kParameter}};

inline constexpr CommandRow kPackets[] = {
    {.code = 0,
     .name = "GetModuleData",
     .reply = kVersion,
     .support = Support::kRejected,
     .source = "B.1",
     .doc = "Versions of protocol, module and firmware. No RZ/T1 drive is there yet."},
    {.code = 1,
     .name = "StatusReport",
     .request = kMask,
     .reply = kReport,
     .reply_by_mask = true,
     .support = Support::kRejected,
     .source = "B.2",
     .doc =
         "What the mask asks for, in the order of its bits; bits 8-15 are ignored. No RZ/T1 drive "
         "is there yet."},
    {.code = 2,
     .name = "FunctionCall",
     .request = kId,
     .names = Names::kFunction,
     .support = Support::kRejected,
     .source = "B.3",
     .doc = "Calls a function by its number. No RZ/T1 drive is there yet."},
    {.code = 5,
     .name = "SetParameter",
     .request = kIdValue,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "8.2.3",
     .doc = "Writes a variable, two or four bytes by its size. No RZ/T1 drive is there yet."},
    {.code = 6,
     .name = "GetParameter",
     .request = kId,
     .reply = kValue,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "8.2.3",
     .doc = "Reads a variable, two or four bytes by its size. No RZ/T1 drive is there yet."},
};

// --- Functions and variables (Appendix A) --------------------------------------------------------

inline constexpr CommandRow kFunctions[] = {
    {.code = 85,
     .name = "GO",
     .support = Support::kRejected,
     .source = "A",
     .doc = "Starts the motion to the target position. No RZ/T1 drive is there yet."},
};

inline constexpr ParameterRow kParameters[] = {
    {.id = 0,
     .name = "STA",
     .type = WireType::kU32,
     .access = Access::kReadOnly,
     .range = {0, 0xFFFF},
     .factory = {1},
     .hex_digits = 4,
     .support = Support::kRejected,
     .source = "A",
     .doc = "Status word: four bytes here, two in a status report. No RZ/T1 drive is there yet."},
    {.id = 8,
     .name = "VEL",
     .type = WireType::kI32,
     .range = {0, INT32_MAX},
     .factory = {7158282},
     .unit = "counts/cycle",
     .scale = 1.0 / 65536,
     .support = Support::kRejected,
     .evidence = Evidence::kObserved,
     .source = "A",
     .doc =
         "Target velocity; the factory value is that of a related public firmware. No RZ/T1 drive "
         "is there yet."},
    {.id = 14,
     .name = "KP",
     .type = WireType::kU16,
     .range = {0, 32767},
     .factory = {2000},
     .support = Support::kRejected,
     .evidence = Evidence::kAssumed,
     .source = "A",
     .doc =
         "Position loop gain; the factory value is chosen for the motor, none is printed. No RZ/T1 "
         "drive is there yet."},
    {.id = 80,
     .name = "ABS",
     .type = WireType::kI32,
     .range = {INT32_MIN, INT32_MAX},
     .unit = "counts",
     .support = Support::kRejected,
     .source = "A",
     .doc = "Absolute target position. No RZ/T1 drive is there yet."},
    {.id = 82,
     .name = "POS",
     .type = WireType::kI32,
     .range = {INT32_MIN, INT32_MAX},
     .unit = "counts",
     .support = Support::kRejected,
     .source = "A",
     .doc = "Actual position; a write moves the origin. No RZ/T1 drive is there yet."},
};

inline constexpr CodeRow kErrors[] = {
    {.code = 0, .name = "ok", .doc = "Accepted."},
    {.code = 1, .name = "bad_code", .doc = "No such packet."},
    {.code = 2, .name = "bad_index", .doc = "No such variable or function."},
    {.code = 3, .name = "bad_size", .doc = "The data are too short or too long."},
    {.code = 4, .name = "out_of_range", .doc = "The value is out of the variable's range."},
    {.code = 5, .name = "read_only", .doc = "The variable cannot be written."},
    {.code = 6, .name = "interlock", .doc = "An interlock is active."},
    {.code = 7, .name = "fault", .doc = "The controller has a fault."},
    {.code = 8, .name = "invalid_state", .doc = "Not in this state."},
    {.code = 9, .name = "overflow", .doc = "The buffer is full."},
    {.code = 10, .name = "execution", .doc = "It was tried and failed."},
    {.code = 255, .name = "bad_sum", .doc = "The request's checksum does not fit."},
};

inline constexpr ProtocolTable kTable = {
    .name = "rzt1",
    .title = "RZ/T1 motion-control firmware, Rev.1.02",
    .document = "R11AN0086JJ0102, Rev.1.02, 2019-07-31",
    .framing = {.name = "packet",
                .start = "\xAA",
                .length_at = 2,
                .overhead = 5,
                .checksum = protocol::Checksum::kSum8,
                .checksum_span =
                    "all bytes between the first and itself; of a reply, all before it",
                .longest = 5 + 255},
    .other_framings = kLines,
    .commands = kPackets,
    .functions = kFunctions,
    .parameters = kParameters,
    .errors = kErrors,
    .faults = {},
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::rzt1
