// Toshiba 7-Series ASD: the commands, and the first communication numbers.
//
// Source column: "excerpt" is the 7-Series Serial Communications User Manual, 53840-001, pages
// 22-25; "VF-S15" its sibling's RS485 manual, E6581913, for what those pages do not hold.
#pragma once

#include <cstdint>

#include "devices/protocol/table.h"

namespace virtdrive::asd7 {

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

// --- Framing -------------------------------------------------------------------------------------

inline constexpr char kAsciiStart = '(';
inline constexpr char kAsciiEnd = '\r';
inline constexpr char kAsciiSum = '&';    // before the sum's two digits
inline constexpr char kAsciiClose = ')';  // may be left out, as the sum may
inline constexpr char kAnyDigit = '*';
inline constexpr char kBinaryStart = '/';
inline constexpr char kWide = 'L';  // marks 32-bit access
inline constexpr std::uint8_t kHighestBinaryNumber = 0x3F;
inline constexpr std::uint8_t kAllBinary = 0xFF;

/// The later manuals give a frame that is cut short half a second; S15's ask for no gap.
inline constexpr SimDuration kSilence = std::chrono::milliseconds(500);

inline constexpr Framing kBinaryFramings[] = {
    {.name = "16-bit binary",
     .start = "/",
     .checksum = protocol::Checksum::kSum8,
     .checksum_span = "all bytes before it",
     .order = protocol::ByteOrder::kBigEndian,
     .longest = 8,
     .silence = kSilence},
    {.name = "32-bit binary",
     .start = "/",
     .checksum = protocol::Checksum::kSum8,
     .checksum_span = "all bytes before it",
     .order = protocol::ByteOrder::kBigEndian,
     .longest = 11,
     .silence = kSilence},
};

// --- Commands ------------------------------------------------------------------------------------

inline constexpr Field kNumberField[] = {{.name = "number", .type = WireType::kU16}};
inline constexpr Field kNumberAndData[] = {{.name = "number", .type = WireType::kU16},
                                           {.name = "data", .type = WireType::kParameter}};
inline constexpr Field kErrorCode[] = {{.name = "code", .type = WireType::kU16}};

inline constexpr CommandRow kCommands[] = {
    {.code = 'P',
     .name = "P",
     .request = kNumberAndData,
     .reply = kNumberAndData,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "excerpt, p. 23",
     .doc = "Writes, until power-off; the answer repeats it. No 7-Series drive is there yet."},
    {.code = 'R',
     .name = "R",
     .request = kNumberField,
     .reply = kNumberAndData,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "excerpt, p. 23",
     .doc = "Reads. No 7-Series drive is there yet."},
    {.code = 'W',
     .name = "W",
     .request = kNumberAndData,
     .reply = kNumberAndData,
     .names = Names::kParameter,
     .support = Support::kRejected,
     .source = "excerpt, p. 23",
     .doc =
         "Writes, also into non-volatile memory; the answer repeats it. No 7-Series drive is there "
         "yet."},
};

/// The answer that takes the place of any other.
inline constexpr CommandRow kErrorReply = {.code = 'N',
                                           .name = "N",
                                           .reply = kErrorCode,
                                           .support = Support::kRejected,
                                           .evidence = Evidence::kAssumed,
                                           .source = "VF-S15",
                                           .doc =
                                               "Error code instead of an answer, as its "
                                               "siblings have it."};

// --- Communication numbers -----------------------------------------------------------------------

// Values are 32 bits wide in the drive; 16-bit frames carry the lower half, sign included.
inline constexpr ParameterRow kParameters[] = {
    {.id = 0xFA00,
     .name = "command",
     .type = WireType::kU32,
     .range = {0, 0xFFFF},
     .support = Support::kRejected,
     .evidence = Evidence::kObserved,
     .source = "VF-S15",
     .doc = "Command word: 10 run, 9 reverse, 13 reset, 14 frequency and 15 command priority. No "
            "7-Series drive is there yet."},
    {.id = 0xFA01,
     .name = "frequency_command",
     .type = WireType::kU32,
     .range = {0, 50000},
     .unit = "Hz",
     .scale = 0.01,
     .support = Support::kRejected,
     .evidence = Evidence::kObserved,
     .source = "VF-S15",
     .doc = "Frequency command, up to the maximum frequency set. No 7-Series drive is there yet."},
    {.id = 0xFD00,
     .name = "output_frequency",
     .type = WireType::kI32,
     .access = Access::kReadOnly,
     .range = {-50000, 50000},
     .unit = "Hz",
     .scale = 0.01,
     .support = Support::kRejected,
     .evidence = Evidence::kAssumed,
     .source = "excerpt, p. 24",
     .doc = "Output frequency; the number is its siblings', the sign the excerpt's example. No "
            "7-Series drive is there yet."},
    {.id = 0xFE03,
     .name = "output_current",
     .type = WireType::kU32,
     .access = Access::kReadOnly,
     .range = {0, 0xFFFF},
     .unit = "%",
     .scale = 0.01,
     .support = Support::kRejected,
     .evidence = Evidence::kAssumed,
     .source = "VF-S15",
     .doc = "Output current, frozen at a trip; the number is its siblings'. No 7-Series drive is "
            "there yet."},
};

/// Codes of the error reply.
enum class Error : std::uint8_t {
  kCannotExecute = 0,
  kRange = 1,
  kNumber = 2,
  kCommand = 3,  // ASCII only: binary frames with an unknown command are dropped
  kSum = 4,
};

/// The excerpt's "mode error", of values too wide for a 16-bit frame: its code is in no source.
inline constexpr Error kModeError = Error::kCannotExecute;

inline constexpr CodeRow kErrors[] = {
    {.code = 0, .name = "cannot_execute", .doc = "Not now, or not in this format."},
    {.code = 1, .name = "range", .doc = "Data out of range, or more than four digits."},
    {.code = 2, .name = "number", .doc = "No such communication number."},
    {.code = 3, .name = "command", .doc = "No such command."},
    {.code = 4, .name = "sum", .doc = "The checksum does not fit."},
};

inline constexpr ProtocolTable kTable = {
    .name = "asd7",
    .title = "Toshiba 7-Series ASD",
    .document = "7-Series Serial Communications User Manual, 53840-001, August 2003 (excerpt)",
    .framing = {.name = "16-bit ASCII",
                .start = "(",
                .end = "\r",
                .checksum = protocol::Checksum::kAsciiSum8,
                .checksum_span = "from ( to &",
                .order = protocol::ByteOrder::kBigEndian,
                .longest = 32,
                .silence = kSilence},
    .other_framings = kBinaryFramings,
    .commands = kCommands,
    .parameters = kParameters,
    .errors = kErrors,
    .faults = {},
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::asd7
