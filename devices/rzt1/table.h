// RZ/T1 motion-control firmware: packets, functions and variables.
//
// Source column: section, or page of Appendix A, of R11AN0086JJ0102, Rev.1.02, 2019-07-31.
// Variables (parameters) and functions share one numbering, 0..144: lines of text name them,
// packets number them. The document prints no factory values but those of SIM and TBSIZE, and
// ranges for few: where a row is observed or assumed, that may be all that is.
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
using protocol::Range;
using protocol::Support;
using protocol::WireType;

// --- Framing (8.1, 8.2) --------------------------------------------------------------------------

inline constexpr std::uint8_t kStart = 0xAA;
inline constexpr std::uint8_t kAllModules = 0xFF;
inline constexpr char kAcceptedPrompt = '>';
inline constexpr char kRefusedPrompt = '?';
/// Said on console 2 when the firmware is ready (5.3).
inline constexpr char kReady = 'R';
/// Motors of the board: axis 1 and axis 2 of a line.
inline constexpr std::uint32_t kAxes = 2;
inline constexpr std::size_t kConsoles = 3;
inline constexpr int kBootBaud = 115200;
/// VER in a line, and the four bytes of GetModuleData: those of a related public firmware.
inline constexpr std::string_view kVersionText = "RZ/T1 Motor Solution Kit 4.0";
inline constexpr std::int64_t kVersionNumbers[] = {3, 0x20, 0, 4};

inline constexpr Framing kLines[] = {{.name = "ASCII", .end = "\r", .longest = 512}};

// --- Packets (8.2, Appendix B) -------------------------------------------------------------------

/// Points of one StreamPVT: what a length byte leaves room for.
inline constexpr std::size_t kMostPoints = 31;
/// Samples of one channel of the recorder (TBSIZE).
inline constexpr std::size_t kTraceSize = 512;

inline constexpr Field kVersion[] = {
    {.name = "protocol"}, {.name = "module"}, {.name = "minor"}, {.name = "major"}};
inline constexpr Field kMask[] = {{.name = "mask", .type = WireType::kU16}};
inline constexpr Field kReport[] = {
    {.name = "position", .type = WireType::kI32},
    {.name = "status", .type = WireType::kU16},
    {.name = "position_error", .type = WireType::kI16},
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
inline constexpr Field kAnyWord[] = {{.name = "value", .type = WireType::kU16}};
inline constexpr Field kSlice[] = {{.name = "time_slice"}, {.name = "watermark", .optional = true}};
inline constexpr Field kPoint[] = {{.name = "position", .type = WireType::kI32},
                                   {.name = "velocity", .type = WireType::kI32}};
inline constexpr Field kPoints[] = {
    {.name = "count", .optional = true},
    {.name = "points", .count = kMostPoints, .members = kPoint, .optional = true}};
inline constexpr Field kBuffer[] = {{.name = "buffer"}};
inline constexpr Field kTrace[] = {{.name = "count", .type = WireType::kU16},
                                   {.name = "size"},
                                   {.name = "samples", .count = kTraceSize, .optional = true}};
inline constexpr Field kBaudCode[] = {{.name = "code"}};

// clang-format off
inline constexpr CommandRow kPackets[] = {
    {.code = 0, .name = "GetModuleData", .reply = kVersion, .evidence = Evidence::kObserved, .source = "B.1",
     .doc = "Versions of protocol, module and firmware; the numbers are those of a related public firmware."},
    {.code = 1, .name = "StatusReport", .request = kMask, .reply = kReport, .reply_by_mask = true, .source = "B.2",
     .doc = "What the mask asks for, in the order of its bits; bits 8-15 are ignored."},
    {.code = 2, .name = "FunctionCall", .request = kId, .names = Names::kFunction, .source = "B.3",
     .doc = "Calls a function by its number."},
    {.code = 3, .name = "InitPVT", .request = kSlice, .evidence = Evidence::kObserved, .source = "B.4",
     .doc = "Empties the PVT FIFO and sets the loop cycles between two points, and WMARK if a second byte is there. 0 is out of range; not while moving."},
    {.code = 4, .name = "StreamPVT", .request = kPoints, .source = "B.5",
     .doc = "Up to 31 points, with their count in front as drawn or without it as the table of sizes has it; all or none."},
    {.code = 5, .name = "SetParameter", .request = kIdValue, .names = Names::kParameter, .source = "B.6",
     .doc = "Writes a variable, two or four bytes by its size."},
    {.code = 6, .name = "GetParameter", .request = kId, .reply = kValue, .names = Names::kParameter, .source = "B.7",
     .doc = "Reads a variable, two or four bytes by its size."},
    {.code = 7, .name = "GetTrace", .request = kBuffer, .reply = kTrace, .evidence = Evidence::kAssumed, .source = "B.8",
     .doc = "A recorder buffer, 0-3 in the low bits; bit 7: samples of four bytes. Count and size go before the samples, so that a host can tell where they end (trace_layout=raw: as drawn)."},
    {.code = 15, .name = "SetBaudRate", .request = kBaudCode, .source = "B.9",
     .doc = "0 to 8: 115.2, 230.4, 250, 460.8, 500, 921.6, 1000, 1250, 1500 kbit/s, from the answer's end on; lost at a reset."},
};

/// Bit rates by their code (B.9).
inline constexpr int kBauds[] = {115200, 230400, 250000, 460800, 500000, 921600, 1000000, 1250000, 1500000};

// --- Functions (Appendix A: Cmd) -----------------------------------------------------------------

inline constexpr CommandRow kFunctions[] = {
    {.code = 85, .name = "GO", .source = "A, p. 88",
     .doc = "Latches what is buffered and starts the motion, or changes the one under way; GO 2000 in a line sets ABS first. With the servo off only the gains are latched."},
    {.code = 86, .name = "FWD", .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "Jogs forward at VEL."},
    {.code = 87, .name = "REV", .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "Jogs backward at VEL."},
    {.code = 88, .name = "RESET", .source = "A, p. 88",
     .doc = "The firmware starts anew when its answer is out, with what was saved; R on console 2 tells that it is ready."},
    {.code = 89, .name = "ON", .source = "A, p. 88",
     .doc = "Servo on: amplifier, phasing where it is due, then position control. Refused while an interlock holds."},
    {.code = 90, .name = "OFF", .source = "A, p. 88",
     .doc = "Servo off; the amplifier stays on."},
    {.code = 91, .name = "ENABLE", .source = "A, p. 88",
     .doc = "PWM on."},
    {.code = 92, .name = "DISABLE", .source = "A, p. 88",
     .doc = "Servo and PWM off."},
    {.code = 93, .name = "STOP", .source = "A, p. 88",
     .doc = "Stops with DEC."},
    {.code = 94, .name = "ABORT", .source = "A, p. 88",
     .doc = "Stops with 32 times DEC."},
    {.code = 95, .name = "HOME", .source = "A, p. 88",
     .doc = "Finds the home as HMASK says; the servo has to be on and at rest."},
    {.code = 96, .name = "ALIGN", .source = "A, p. 88",
     .doc = "Phasing as PIMODE says."},
    {.code = 108, .name = "PLAY", .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "Prints the recorder's samples, a line each: CH1,CH2,CH3,CH4. Typed R/W; in a packet it is no variable, and calling it prints nothing."},
    {.code = 113, .name = "SETUP", .request = kAnyWord, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Finds PMAP and HINVERT; the servo has to be off. Typed R/W: a write of any word starts it as well."},
    {.code = 115, .name = "SAVE", .source = "A, p. 89",
     .doc = "Keeps the axis' persistent parameters."},
    {.code = 116, .name = "RESTORE", .source = "A, p. 89",
     .doc = "Takes the axis' persistent parameters from the flash, the factory's if it is damaged; the servo has to be off."},
    {.code = 142, .name = "ERESET", .source = "A, p. 90",
     .doc = "Clears EQUERY."},
};

// --- Variables (Appendix A) ----------------------------------------------------------------------

inline constexpr Range kShort = {INT16_MIN, INT16_MAX};
inline constexpr Range kUnsignedShort = {0, UINT16_MAX};
inline constexpr Range kPositive = {0, INT16_MAX};
inline constexpr Range kAny = {INT32_MIN, INT32_MAX};
inline constexpr Range kUnsigned = {0, UINT32_MAX};

inline constexpr ParameterRow kParameters[] = {
    {.id = 0, .name = "STA", .type = WireType::kU32, .access = Access::kReadOnly, .range = {0, 0xFFFF}, .factory = {1}, .hex_digits = 4, .source = "A, p. 85",
     .doc = "Status word: 0 motion complete, 1 servo on, 2 amplifier on, 3 index captured, 4 encoder fault, 5 encoder warning, 6 PVT FIFO at or below WMARK, 7 phased, 8 busy, 9 over-current, 10 input inhibit, 11 PVT starved, 12 overheat, 13 amplifier fault, 14 position error, 15 wrapped. Two bytes in a status report; bit 8 is printed as reserved."},
    {.id = 1, .name = "ERR", .type = WireType::kI16, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 85",
     .doc = "Position error, command minus actual, counts; cut off at 32767."},
    {.id = 2, .name = "ADC1", .type = WireType::kI16, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 85",
     .doc = "Current of channel 1, AD counts: 2048 is 20 A here."},
    {.id = 3, .name = "ADC2", .type = WireType::kI16, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 85",
     .doc = "Current of channel 2, AD counts."},
    {.id = 4, .name = "TC", .type = WireType::kI16, .access = Access::kReadOnly, .range = {0, 32767}, .source = "A, p. 85",
     .doc = "Sum of the magnitudes of ADC1 and ADC2."},
    {.id = 5, .name = "CV", .type = WireType::kI16, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 85",
     .doc = "Actual velocity, counts per loop cycle."},
    {.id = 6, .name = "PVT", .type = WireType::kU16, .access = Access::kReadOnly, .range = {0, 100}, .source = "A, p. 85",
     .doc = "Points in the PVT FIFO."},
    {.id = 7, .name = "ITIME", .type = WireType::kU16, .range = {1, 65535}, .factory = {200}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Loop cycles between two PVT points."},
    {.id = 8, .name = "VEL", .type = WireType::kI32, .range = {0, INT32_MAX}, .factory = {7158282}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Target velocity, counts per loop cycle times 65536."},
    {.id = 9, .name = "ACC", .type = WireType::kI32, .range = {1, INT32_MAX}, .factory = {14317}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Acceleration, counts per loop cycle squared times 65536; its size is not printed: 4."},
    {.id = 10, .name = "DEC", .type = WireType::kI32, .range = {0, INT32_MAX}, .factory = {14317}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Deceleration, as ACC; 0: as ACC."},
    {.id = 11, .name = "AJERK", .type = WireType::kI32, .range = {0, 1000}, .source = "A, p. 85",
     .doc = "Rate of change of the acceleration, Bezier profile only."},
    {.id = 12, .name = "DJERK", .type = WireType::kI32, .range = {0, 1000}, .source = "A, p. 85",
     .doc = "Rate of change of the deceleration, Bezier profile only."},
    {.id = 13, .name = "PRO", .type = WireType::kU16, .range = {0, 3}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Velocity profile: 0 trapezoid, 1 spline, 2 Bezier, 3 PVT."},
    {.id = 14, .name = "KP", .type = WireType::kU16, .range = kPositive, .factory = {2000}, .evidence = Evidence::kAssumed, .source = "A, p. 85",
     .doc = "Position loop, proportional gain; counts from the next GO, STOP, ABORT or ON. The factory value is chosen for the bench motor."},
    {.id = 15, .name = "KI", .type = WireType::kU16, .range = kPositive, .evidence = Evidence::kAssumed, .source = "A, p. 85",
     .doc = "Position loop, integral gain; likewise."},
    {.id = 16, .name = "KD", .type = WireType::kU16, .range = kPositive, .source = "A, p. 85",
     .doc = "Position loop, derivative gain; likewise."},
    {.id = 17, .name = "IL", .type = WireType::kU16, .range = kPositive, .factory = {32767}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Position loop, limit of the integral; likewise."},
    {.id = 18, .name = "VFF", .type = WireType::kU16, .range = kPositive, .factory = {32767}, .evidence = Evidence::kAssumed, .source = "A, p. 85",
     .doc = "Velocity feed-forward, 32767 is 100 %; likewise. The factory value is chosen for the bench motor."},
    {.id = 19, .name = "AFF", .type = WireType::kU16, .range = kPositive, .source = "A, p. 85",
     .doc = "Acceleration feed-forward; likewise."},
    {.id = 20, .name = "MAX", .type = WireType::kU16, .range = kPositive, .factory = {5000}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Largest position error, counts; 0: not watched. Latched likewise."},
    {.id = 21, .name = "ETIME", .type = WireType::kU16, .range = kUnsignedShort, .factory = {500}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "How long the error may be larger, loop cycles (error_time=ms: milliseconds)."},
    {.id = 22, .name = "DS", .type = WireType::kU16, .range = {1, 32767}, .factory = {2}, .evidence = Evidence::kObserved, .source = "A, p. 85",
     .doc = "Loop cycle of position and velocity loop in 50 us."},
    {.id = 23, .name = "MLIMIT", .type = WireType::kU16, .range = kPositive, .factory = {32767}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Limit of the position loop's output, 32 counts per cycle each 1024: in the cascade a limit of the speed. At once."},
    {.id = 24, .name = "BIAS", .type = WireType::kI32, .range = kAny, .source = "A, p. 86",
     .doc = "Added to the position loop's output. At once."},
    {.id = 25, .name = "ASTOP", .type = WireType::kU16, .range = {0, 1}, .source = "A, p. 86",
     .doc = "After too large an error: 0 stops the motion, 1 then switches the servo off."},
    {.id = 26, .name = "PIMODE", .type = WireType::kU16, .range = {0, 2}, .source = "A, p. 86",
     .doc = "Phasing: 0 forced, 1 by the Halls, 2 dither."},
    {.id = 27, .name = "PITIME", .type = WireType::kU16, .range = kUnsignedShort, .factory = {5000}, .evidence = Evidence::kObserved, .source = "A, p. 86",
     .doc = "Duration of phasing, loop cycles."},
    {.id = 28, .name = "PIOUT", .type = WireType::kU16, .range = kPositive, .factory = {1966}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Output while phasing, 32767 is a third of the bus voltage. The factory value is chosen for the bench motor."},
    {.id = 29, .name = "PMAP", .type = WireType::kU16, .range = {0, 5}, .source = "A, p. 86",
     .doc = "Phases on the outputs U, V, W: 0 UVW, 1 UWV, 2 VWU, 3 VUW, 4 WUV, 5 WVU."},
    {.id = 30, .name = "PORIGIN", .type = WireType::kI32, .range = kAny, .source = "A, p. 86",
     .doc = "Encoder position where the flux angle is 0."},
    {.id = 31, .name = "PCMODE", .type = WireType::kU16, .range = {0, 3}, .factory = {1}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Commutation: 0 voltage by space vectors, 1 field-oriented current, 2 Halls, 3 by the host."},
    {.id = 32, .name = "PVECTOR", .type = WireType::kI32, .range = {0, 5}, .source = "A, p. 86",
     .doc = "Direction of the vector in PCMODE 3, times 60 degrees."},
    {.id = 33, .name = "PPAIRS", .type = WireType::kU16, .range = {1, 65535}, .factory = {5}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Pole pairs."},
    {.id = 34, .name = "PCOUNTS", .type = WireType::kI32, .range = {1, INT32_MAX}, .factory = {26214}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Counts per electrical turn, ECPR / PPAIRS."},
    {.id = 35, .name = "ECPR", .type = WireType::kI32, .range = {1, INT32_MAX}, .factory = {131072}, .evidence = Evidence::kObserved, .source = "A, p. 86",
     .doc = "Encoder counts per turn."},
    {.id = 36, .name = "PIOFFS", .type = WireType::kI32, .range = kAny, .source = "A, p. 86",
     .doc = "Offset added when phasing ends."},
    {.id = 37, .name = "PANGLE", .type = WireType::kI32, .access = Access::kReadOnly, .range = kAny, .factory = {-1}, .source = "A, p. 86",
     .doc = "Flux angle in counts; -1 while it is not known."},
    {.id = 38, .name = "PADV", .type = WireType::kI32, .range = kAny, .support = Support::kStored, .source = "A, p. 86",
     .doc = "Unused, says the document."},
    {.id = 39, .name = "VCOMP", .type = WireType::kI32, .range = kAny, .factory = {10}, .support = Support::kStored, .source = "A, p. 86",
     .doc = "Unused, says the document."},
    {.id = 40, .name = "CLIMIT", .type = WireType::kI16, .range = kPositive, .factory = {1500}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Limit of TC, AD counts."},
    {.id = 41, .name = "CTIME", .type = WireType::kU16, .range = kUnsignedShort, .factory = {5000}, .evidence = Evidence::kObserved, .source = "A, p. 86",
     .doc = "How long TC may be above CLIMIT, loop cycles; 0: not watched."},
    {.id = 42, .name = "IDM", .type = WireType::kI32, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 86",
     .doc = "Direct current, AD counts."},
    {.id = 43, .name = "IQM", .type = WireType::kI32, .access = Access::kReadOnly, .range = kShort, .source = "A, p. 86",
     .doc = "Quadrature current, AD counts."},
    {.id = 44, .name = "IQERR", .type = WireType::kI32, .access = Access::kReadOnly, .range = {-65536, 65535}, .source = "A, p. 86",
     .doc = "Quadrature current's error, AD counts."},
    {.id = 45, .name = "QKP", .type = WireType::kU16, .range = kPositive, .factory = {60}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Current loop, proportional gain, at once. The range is that of other gains."},
    {.id = 46, .name = "QKI", .type = WireType::kU16, .range = kPositive, .factory = {4}, .evidence = Evidence::kAssumed, .source = "A, p. 86",
     .doc = "Current loop, integral gain, at once."},
    {.id = 47, .name = "PCT", .type = WireType::kU16, .range = kUnsignedShort, .hex_digits = 4, .support = Support::kStored, .source = "A, p. 86",
     .doc = "Position capture mode: the index is all that is captured."},
    {.id = 48, .name = "HMASK", .type = WireType::kU16, .range = kUnsignedShort, .hex_digits = 4, .source = "A, p. 86",
     .doc = "Homing: 0 index, 3 hard stop, else the inputs that are home switches."},
    {.id = 49, .name = "INVERT", .type = WireType::kU16, .range = kUnsignedShort, .hex_digits = 4, .source = "A, p. 87",
     .doc = "Home switches that are active low."},
    {.id = 50, .name = "HINVERT", .type = WireType::kI32, .range = {0, 1}, .evidence = Evidence::kAssumed, .source = "A, p. 87",
     .doc = "1: Hall signals are inverted. The range is the document's; related public firmware numbers remappings here."},
    {.id = 51, .name = "HSHIFT", .type = WireType::kI32, .range = kAny, .factory = {-1}, .support = Support::kStored, .source = "A, p. 87",
     .doc = "Unused, says the document."},
    {.id = 52, .name = "HPOS", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "Position where the Halls changed last."},
    {.id = 53, .name = "EMASK", .type = WireType::kU16, .range = kUnsignedShort, .hex_digits = 4, .source = "A, p. 87",
     .doc = "Inputs that are interlocks: bits 0-3 the axis' inputs, 4-6 its Halls."},
    {.id = 54, .name = "ECP", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "Command position when the error was too large."},
    {.id = 55, .name = "ECV", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "Command velocity when the error was too large."},
    {.id = 56, .name = "EPO", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "Actual position when the error was too large."},
    {.id = 57, .name = "U", .type = WireType::kI32, .range = kPositive, .factory = {32767}, .source = "A, p. 87",
     .doc = "Output U, 32767 is 100 %; a write drives it in PCMODE 3."},
    {.id = 58, .name = "V", .type = WireType::kI32, .range = kPositive, .factory = {32767}, .source = "A, p. 87",
     .doc = "Output V; likewise."},
    {.id = 59, .name = "W", .type = WireType::kI32, .range = kPositive, .factory = {32767}, .source = "A, p. 87",
     .doc = "Output W; likewise."},
    {.id = 60, .name = "TYPE", .type = WireType::kU16, .range = {1, 3}, .factory = {3}, .source = "A, p. 87",
     .doc = "Module: 1 one channel, 2 this axis leads the electronic gear, 3 two axes by themselves."},
    {.id = 61, .name = "HTYPE", .type = WireType::kU16, .range = {0, 0}, .source = "A, p. 87",
     .doc = "Hall sensors: parallel is all there is."},
    {.id = 62, .name = "HOFFS", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "Position of the home: where the sensor is found the position is minus this."},
    {.id = 63, .name = "DATA0", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 64, .name = "DATA1", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 65, .name = "DATA2", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 66, .name = "DATA3", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 67, .name = "DATA4", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 68, .name = "DATA5", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 69, .name = "DATA6", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 70, .name = "DATA7", .type = WireType::kI32, .range = kAny, .source = "A, p. 87",
     .doc = "The user's own."},
    {.id = 71, .name = "PHASES", .type = WireType::kU16, .range = {2, 3}, .factory = {3}, .source = "A, p. 87",
     .doc = "Motor: 2 brushed or voice coil, 3 three-phase."},
    {.id = 72, .name = "BRAKE", .type = WireType::kU16, .range = kUnsignedShort, .support = Support::kStored, .source = "A, p. 87",
     .doc = "Unused, says the document."},
    {.id = 73, .name = "TMODE", .type = WireType::kU16, .range = {0, 3}, .source = "A, p. 87",
     .doc = "Recorder: 0 idle, 1 armed, 2 until full, 3 ring until the event. 0 stops it; others are taken and change nothing: TRACE starts."},
    {.id = 74, .name = "TRATE", .type = WireType::kU16, .range = kUnsignedShort, .factory = {1}, .evidence = Evidence::kAssumed, .source = "A, p. 87",
     .doc = "A sample each so many 50 us; 0 counts as 1."},
    {.id = 75, .name = "TLEVEL", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Trigger level of CH1, or mask of inputs."},
    {.id = 76, .name = "SIM", .type = WireType::kU16, .range = {0, 1}, .source = "A, p. 88",
     .doc = "1: the encoder is simulated, the actual position is the command, the PWM is not driven."},
    {.id = 77, .name = "TIMER", .type = WireType::kU16, .range = kUnsignedShort, .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "PWM timer when the real-time task ended; a write is taken and overwritten."},
    {.id = 78, .name = "ADDP", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Position of the next PVT point."},
    {.id = 79, .name = "ADDV", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Velocity of the next PVT point, as VEL; puts it into the FIFO."},
    {.id = 80, .name = "ABS", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Target position."},
    {.id = 81, .name = "REL", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Distance from the actual position at GO; 0: none."},
    {.id = 82, .name = "POS", .type = WireType::kI32, .range = kAny, .source = "A, p. 88",
     .doc = "Actual position, counts; a write moves the origin."},
    {.id = 83, .name = "INP", .type = WireType::kU16, .access = Access::kReadOnly, .range = kUnsignedShort, .hex_digits = 4, .source = "A, p. 88",
     .doc = "Inputs of both axes: 0-2 Halls U V W of axis 1, 4-6 of axis 2, 8-11 INP1-4, 12-15 INP5-8."},
    {.id = 84, .name = "IND", .type = WireType::kI32, .access = Access::kReadOnly, .range = kAny, .source = "A, p. 88",
     .doc = "Position where the index was captured; reading it clears STA bit 3."},
    {.id = 97, .name = "VER", .type = WireType::kU32, .access = Access::kReadOnly, .range = kUnsigned, .factory = {0x04002003}, .evidence = Evidence::kObserved, .source = "A, p. 88",
     .doc = "Version: a text in a line, the four bytes of GetModuleData in a packet. The numbers are those of a related public firmware."},
    {.id = 98, .name = "OUT1", .type = WireType::kI16, .range = {0, 1}, .source = "A, p. 88",
     .doc = "Output P4-2, for a brake."},
    {.id = 99, .name = "OUT2", .type = WireType::kI16, .range = {0, 1}, .source = "A, p. 88",
     .doc = "Output P4-3, for a brake."},
    {.id = 100, .name = "PWM", .type = WireType::kI16, .range = {-32767, 32767}, .source = "A, p. 88",
     .doc = "Output while the servo is off, 32767 is 100 %: voltage or current, as PCMODE says."},
    {.id = 101, .name = "IQPKT", .type = WireType::kI16, .range = {-32767, 32767}, .source = "A, p. 88",
     .doc = "Quadrature output, the same number as PWM; IQCMD is taken too."},
    {.id = 102, .name = "IDPKT", .type = WireType::kI16, .range = {-32767, 32767}, .source = "A, p. 88",
     .doc = "Direct output; IDCMD is taken too."},
    {.id = 103, .name = "CH1", .type = WireType::kI16, .range = {0, 21}, .source = "A, p. 88",
     .doc = "What the recorder's channel 1 holds; 4-7 are refused. A source below 8 takes buffer 4 for its high words."},
    {.id = 104, .name = "CH2", .type = WireType::kI16, .range = {0, 21}, .source = "A, p. 88",
     .doc = "Channel 2; of 32-bit sources the low word."},
    {.id = 105, .name = "CH3", .type = WireType::kI16, .range = {0, 21}, .source = "A, p. 88",
     .doc = "Channel 3; likewise."},
    {.id = 106, .name = "CH4", .type = WireType::kI16, .range = {0, 21}, .source = "A, p. 88",
     .doc = "Channel 4; likewise."},
    {.id = 107, .name = "TRACE", .type = WireType::kI16, .range = {0, 10}, .source = "A, p. 88",
     .doc = "Trigger; a write starts the recorder, or arms it."},
    {.id = 109, .name = "PLIMIT", .type = WireType::kI16, .range = kPositive, .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "I2t: peak current, AD counts of TC; 0: not watched."},
    {.id = 110, .name = "PTIME", .type = WireType::kI16, .range = kPositive, .evidence = Evidence::kAssumed, .source = "A, p. 88",
     .doc = "I2t: how long the peak current may last, ms; 0: not watched."},
    {.id = 111, .name = "GEARIN", .type = WireType::kI16, .range = {1, 32767}, .factory = {1}, .source = "A, p. 89",
     .doc = "Electronic gear, numerator."},
    {.id = 112, .name = "GEAROUT", .type = WireType::kI16, .range = {1, 32767}, .factory = {1}, .source = "A, p. 89",
     .doc = "Electronic gear, denominator."},
    {.id = 114, .name = "PINVERT", .type = WireType::kI16, .range = {0, 1}, .source = "A, p. 89",
     .doc = "1: position feedback is inverted."},
    {.id = 117, .name = "ETYPE", .type = WireType::kI16, .range = {0, 5}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Encoder: 0 incremental, 1 EnDat, 2 BiSS, 3 FA-CODER, 4 A-format, 5 HIPERFACE DSL. Absolute ones on axis 2 only; the interface starts once."},
    {.id = 118, .name = "EID", .type = WireType::kU32, .range = kUnsigned, .hex_digits = 4, .source = "A, p. 89",
     .doc = "Encoder's identification; a write is taken and overwritten."},
    {.id = 119, .name = "EADDR", .type = WireType::kI16, .range = {0, 255}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Address in the encoder's EEPROM."},
    {.id = 120, .name = "EDATA", .type = WireType::kI16, .range = kShort, .source = "A, p. 89",
     .doc = "Word at EADDR in the encoder's EEPROM; out of range with an incremental one."},
    {.id = 121, .name = "EBAUDRATE", .type = WireType::kI16, .range = {1, 32767}, .factory = {2500}, .support = Support::kStored, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Bit rate of the encoder, kbit/s."},
    {.id = 122, .name = "ESTATUS", .type = WireType::kU16, .access = Access::kReadOnly, .range = kUnsignedShort, .hex_digits = 4, .evidence = Evidence::kObserved, .source = "A, p. 89",
     .doc = "Status of the absolute encoder. Typed R/W; writes are refused."},
    {.id = 123, .name = "ADDR", .type = WireType::kU16, .range = {1, 127}, .factory = {1}, .source = "A, p. 89",
     .doc = "Address in packets; written in lines only. Axis 2 has 2."},
    {.id = 124, .name = "GROUP", .type = WireType::kU16, .range = {0, 254}, .evidence = Evidence::kObserved, .source = "A, p. 89",
     .doc = "Group address in packets; 0: none."},
    {.id = 125, .name = "TBSIZE", .type = WireType::kU16, .access = Access::kReadOnly, .range = {512, 512}, .factory = {512}, .source = "A, p. 89",
     .doc = "Samples of a channel that the recorder holds."},
    {.id = 126, .name = "WMARK", .type = WireType::kU16, .range = {0, 100}, .factory = {10}, .evidence = Evidence::kObserved, .source = "A, p. 89",
     .doc = "PVT FIFO: STA bit 6 tells when there are no more points."},
    {.id = 127, .name = "QKD", .type = WireType::kU16, .range = kPositive, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Current loop, derivative gain, at once. Printed as proportional."},
    {.id = 128, .name = "VKP", .type = WireType::kU16, .range = kPositive, .factory = {12}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Velocity loop, proportional gain, latched like KP. The factory value is chosen for the bench motor."},
    {.id = 129, .name = "VKI", .type = WireType::kU16, .range = kPositive, .factory = {2}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Velocity loop, integral gain; likewise."},
    {.id = 130, .name = "VKD", .type = WireType::kU16, .range = kPositive, .source = "A, p. 89",
     .doc = "Velocity loop, derivative gain; likewise."},
    {.id = 131, .name = "ELVOLT", .type = WireType::kI32, .range = {0, 4095}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Lowest bus voltage, AD counts: 8 a volt here."},
    {.id = 132, .name = "EHVOLT", .type = WireType::kI32, .range = {0, 4095}, .factory = {4095}, .evidence = Evidence::kAssumed, .source = "A, p. 89",
     .doc = "Highest bus voltage, AD counts."},
    {.id = 133, .name = "EWPOSMIN", .type = WireType::kI32, .range = kAny, .factory = {INT32_MIN}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Lowest position."},
    {.id = 134, .name = "EWPOSMAX", .type = WireType::kI32, .range = kAny, .factory = {INT32_MAX}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Highest position."},
    {.id = 135, .name = "EOVS", .type = WireType::kI32, .range = {0, INT32_MAX}, .factory = {INT32_MAX}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Highest speed, counts per 100 us times 65536 (printed 65535)."},
    {.id = 136, .name = "EWOVS", .type = WireType::kI32, .range = {0, INT32_MAX}, .factory = {INT32_MAX}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Largest difference between commanded and actual speed for 5 s; likewise."},
    {.id = 137, .name = "EEMP", .type = WireType::kI32, .range = {0, INT32_MAX}, .factory = {30}, .evidence = Evidence::kObserved, .source = "A, p. 90",
     .doc = "How often the FIFO may be read empty."},
    {.id = 138, .name = "EOVTEMP", .type = WireType::kI32, .range = {0, 4095}, .factory = {2000}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Highest temperature, AD counts: 20 a degree here."},
    {.id = 139, .name = "ERRMASK", .type = WireType::kU32, .range = kUnsigned, .factory = {0x1E380000}, .hex_digits = 8, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Bits of EQUERY that stop the motor."},
    {.id = 140, .name = "EVOLT", .type = WireType::kI32, .access = Access::kReadOnly, .range = {0, 4095}, .source = "A, p. 90",
     .doc = "Bus voltage, AD counts."},
    {.id = 141, .name = "EQUERY", .type = WireType::kU32, .access = Access::kReadOnly, .range = kUnsigned, .hex_digits = 8, .evidence = Evidence::kObserved, .source = "A, p. 90",
     .doc = "Errors seen since ERESET: 7 FIFO empty, 13 and 15 position, 17 position error, 18 input, 19 speed difference, 20 over-speed, 21 over-load, 22 I2t, 23 temperature, 24 amplifier fault, 25 PWM off (POE3), 26 over-current, 27 over-voltage, 28 under-voltage. The numbers are those of a related public firmware."},
    {.id = 143, .name = "EOVC", .type = WireType::kI32, .range = {0, 4095}, .factory = {4095}, .evidence = Evidence::kAssumed, .source = "A, p. 90",
     .doc = "Over-load: TC, AD counts. To be set below CLIMIT with its bit in ERRMASK clear."},
    {.id = 144, .name = "ETEMP", .type = WireType::kI32, .access = Access::kReadOnly, .range = {0, 4095}, .source = "A, p. 90",
     .doc = "Temperature, AD counts."},
};
// clang-format on

/// Further names that lines may use: those of a related public firmware.
struct Alias {
  std::string_view name;
  std::uint16_t id;
};
inline constexpr Alias kAliases[] = {{"IQCMD", 101}, {"IDCMD", 102}};

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

/// Bits of STA (B.2).
inline constexpr CodeRow kStatusBits[] = {
    {.code = 0, .name = "complete", .doc = "The motion is complete."},
    {.code = 1, .name = "servo_on", .doc = "Servo control is on."},
    {.code = 2, .name = "amplifier_on", .doc = "The PWM amplifier is on."},
    {.code = 3, .name = "index", .doc = "The index was captured."},
    {.code = 4, .name = "encoder_fault", .doc = "The absolute encoder has failed."},
    {.code = 5, .name = "encoder_warning", .doc = "The absolute encoder warns."},
    {.code = 6, .name = "pvt_low", .doc = "The PVT FIFO is at or below WMARK."},
    {.code = 7, .name = "phased", .doc = "The rotor's angle is known."},
    {.code = 8,
     .name = "busy",
     .evidence = Evidence::kObserved,
     .doc = "Homing, phasing or SETUP is under way; printed as reserved."},
    {.code = 9, .name = "over_current", .doc = "Current over-load."},
    {.code = 10, .name = "inhibit", .doc = "An input has stopped the axis."},
    {.code = 11, .name = "starved", .doc = "The PVT FIFO ran empty."},
    {.code = 12, .name = "overheat", .doc = "I2t."},
    {.code = 13, .name = "amplifier_fault", .doc = "Inverter fault."},
    {.code = 14, .name = "position_error", .doc = "The position error was too large."},
    {.code = 15, .name = "wrapped", .doc = "The position counter has wrapped."},
};

/// Bits of EQUERY and ERRMASK: not in the document.
inline constexpr CodeRow kFaults[] = {
    {.code = 7, .name = "pvt_empty", .evidence = Evidence::kObserved, .doc = "EEMP."},
    {.code = 13, .name = "position_low", .evidence = Evidence::kObserved, .doc = "EWPOSMIN."},
    {.code = 15, .name = "position_high", .evidence = Evidence::kObserved, .doc = "EWPOSMAX."},
    {.code = 17, .name = "position_error", .evidence = Evidence::kObserved, .doc = "MAX, ETIME."},
    {.code = 18, .name = "input", .evidence = Evidence::kAssumed, .doc = "EMASK."},
    {.code = 19, .name = "speed_difference", .evidence = Evidence::kObserved, .doc = "EWOVS."},
    {.code = 20, .name = "over_speed", .evidence = Evidence::kObserved, .doc = "EOVS."},
    {.code = 21, .name = "over_load", .evidence = Evidence::kObserved, .doc = "EOVC."},
    {.code = 22, .name = "i2t", .evidence = Evidence::kAssumed, .doc = "PLIMIT, PTIME, CLIMIT."},
    {.code = 23, .name = "temperature", .evidence = Evidence::kAssumed, .doc = "EOVTEMP."},
    {.code = 24, .name = "amplifier_fault", .evidence = Evidence::kAssumed, .doc = "The input."},
    {.code = 25, .name = "pwm_off", .evidence = Evidence::kObserved, .doc = "POE3."},
    {.code = 26, .name = "over_current", .evidence = Evidence::kObserved, .doc = "CLIMIT, CTIME."},
    {.code = 27, .name = "over_voltage", .evidence = Evidence::kObserved, .doc = "EHVOLT."},
    {.code = 28, .name = "under_voltage", .evidence = Evidence::kObserved, .doc = "ELVOLT."},
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
                .longest = 1 + 3 + 4 * kTraceSize + 1},
    .other_framings = kLines,
    .commands = kPackets,
    .functions = kFunctions,
    .parameters = kParameters,
    .errors = kErrors,
    .faults = kFaults,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::rzt1
