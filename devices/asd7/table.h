// Toshiba 7-Series ASD: framing, commands, and every communication number with its parameter.
//
// Of the 7-Series' own manual four pages are at hand: "excerpt" is the 7-Series Serial
// Communications User Manual, 53840-001, pages 22-25. The rest is what its relatives document,
// which speak the same protocol: VF-S11 (E6581222), VF-AS1 (E6581315), VF-S15 (E6581913), P9; "G7"
// is an option board's manual for the 7-Series G7 (ICC-10389-003), "ETH" a gateway's (ICC ETH-100).
// What rests on memory alone is Evidence::kRecalled. A parameter's number is its digits read as
// hexadecimal: F803 is 0803.
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
using protocol::Range;
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

/// A frame that is cut short is given up: VF-AS1 says 0.5 s, for block frames 1 s.
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

// clang-format off
inline constexpr CommandRow kCommands[] = {
    {.code = 'G', .name = "G", .request = kNumberAndData, .reply = kNumberAndData, .names = Names::kParameter,
     .evidence = Evidence::kFamily, .source = "VF-S11, VF-S15",
     .doc = "Binary only: reads, with dummy data, so that request and reply are equally long on two wires. The excerpt has its name."},
    {.code = 'P', .name = "P", .request = kNumberAndData, .reply = kNumberAndData, .names = Names::kParameter,
     .source = "excerpt, p. 23", .doc = "Writes into RAM, until power-off; the answer repeats it."},
    {.code = 'R', .name = "R", .request = kNumberField, .reply = kNumberAndData, .names = Names::kParameter,
     .source = "excerpt, p. 23", .doc = "Reads."},
    {.code = 'S', .name = "S", .request = kNumberAndData, .names = Names::kParameter, .replies = false,
     .evidence = Evidence::kFamily, .source = "VF-AS1, VF-S15",
     .doc = "Binary only, from drive to drives: FA01 in 0.01 % of the points F811-F814. Never answered."},
    {.code = 'W', .name = "W", .request = kNumberAndData, .reply = kNumberAndData, .names = Names::kParameter,
     .source = "excerpt, p. 23", .doc = "Writes, also into the EEPROM where the number has a place there; the answer repeats it."},
    {.code = 's', .name = "s", .request = kNumberAndData, .names = Names::kParameter, .replies = false,
     .evidence = Evidence::kFamily, .source = "VF-AS1, VF-S15",
     .doc = "As S, of a master that is tripped: the drive does as F806 says."},
};
// clang-format on

constexpr bool is_binary_only(const CommandRow& row) {
  return row.code == 'G' || row.code == 'S' || row.code == 's';
}
/// Changes something; the only commands that a broadcast may carry (excerpt, p. 25).
constexpr bool writes(const CommandRow& row) {
  return row.code == 'P' || row.code == 'W';
}

/// The answer that takes the place of any other.
inline constexpr CommandRow kErrorReply = {.code = 'N',
                                           .name = "N",
                                           .reply = kErrorCode,
                                           .evidence = Evidence::kFamily,
                                           .source = "VF-S15",
                                           .doc = "Error code instead of an answer."};

// --- Communication numbers -----------------------------------------------------------------------

/// Where a row stands written.
struct Grounds {
  Evidence evidence;
  std::string_view source;
};
inline constexpr Grounds kExcerpt{Evidence::kDocumented, "excerpt, p. 24"};
inline constexpr Grounds kG7{Evidence::kObserved, "G7"};
inline constexpr Grounds kEth{Evidence::kObserved, "ETH"};
inline constexpr Grounds kS15{Evidence::kFamily, "VF-S15"};
inline constexpr Grounds kAs1{Evidence::kFamily, "VF-AS1"};
inline constexpr Grounds kAs1S15{Evidence::kFamily, "VF-AS1, VF-S15"};
inline constexpr Grounds kS11S15{Evidence::kFamily, "VF-S11, VF-S15"};
inline constexpr Grounds kAllRelatives{Evidence::kFamily, "VF-S11, VF-AS1, VF-S15"};
inline constexpr Grounds kP9{Evidence::kFamily, "P9"};
inline constexpr Grounds kRecall{Evidence::kRecalled, "VF-A7, VF-S9"};
inline constexpr Grounds kDecided{Evidence::kAssumed, "-"};

struct Measure {
  std::string_view unit = "";
  double scale = 1;
};
inline constexpr Measure kPlain{};
inline constexpr Measure kHertz{"Hz", 0.01};
inline constexpr Measure kCentiPercent{"%", 0.01};
inline constexpr Measure kDeciPercent{"%", 0.1};
inline constexpr Measure kPercent{"%", 1};
inline constexpr Measure kSeconds{"s", 1};
inline constexpr Measure kDeciSeconds{"s", 0.1};
inline constexpr Measure kCentiSeconds{"s", 0.01};
inline constexpr Measure kKilowatts{"kW", 0.01};
inline constexpr Measure kHours{"h", 1};

constexpr ParameterRow setting(std::uint16_t id, std::string_view name, Range range,
                               std::int64_t factory, Measure measure, Grounds grounds,
                               std::string_view doc, Support support = Support::kImplemented) {
  return {.id = id,
          .name = name,
          .type = WireType::kU32,
          .range = range,
          .factory = {factory},
          .unit = measure.unit,
          .scale = measure.scale,
          .support = support,
          .evidence = grounds.evidence,
          .source = grounds.source,
          .doc = doc};
}
constexpr ParameterRow monitor(std::uint16_t id, std::string_view name, Measure measure,
                               Grounds grounds, std::string_view doc,
                               WireType type = WireType::kU32) {
  const bool sign = type == WireType::kI32;
  return {.id = id,
          .name = name,
          .type = type,
          .access = Access::kReadOnly,
          .range = sign ? Range{-32768, 32767} : Range{0, 65535},
          .unit = measure.unit,
          .scale = measure.scale,
          .evidence = grounds.evidence,
          .source = grounds.source,
          .doc = doc};
}
constexpr ParameterRow signed_monitor(std::uint16_t id, std::string_view name, Measure measure,
                                      Grounds grounds, std::string_view doc) {
  return monitor(id, name, measure, grounds, doc, WireType::kI32);
}
constexpr ParameterRow unknown_here(std::uint16_t id, std::string_view name, Grounds grounds,
                                    std::string_view doc) {
  return setting(id, name, {0, 0xFFFF}, 0, kPlain, grounds, doc, Support::kRejected);
}

inline constexpr Range kSwitch{0, 1};
inline constexpr Range kFrequencies{0, 50000};
inline constexpr Range kRampTimes{0, 36000};

// Values are 32 bits wide in the drive; 16-bit frames carry the lower half, sign included (excerpt,
// p. 24). Factory values are those of the 0.75 kW size.
// clang-format off
inline constexpr ParameterRow kParameters[] = {
    // Basic parameters
    setting(0x0000, "AU1", {0, 1}, 0, kPlain, kS15, "Automatic acceleration and deceleration: 1 on.", Support::kStored),
    setting(0x0001, "AU2", {0, 3}, 0, kPlain, kRecall, "Automatic torque boost macro.", Support::kStored),
    setting(0x0003, "CMOD", {0, 2}, 0, kPlain, kS11S15, "Who gives the run command: 0 terminals, 1 panel, 2 serial line. 0 and 1 are VF-S11's, 2 VF-S15's."),
    setting(0x0004, "FMOD", {0, 4}, 0, kPlain, kS11S15, "Who gives the frequency: 0 panel, 1 VIA, 2 VIB, 3 both, 4 serial line. 1 to 3 are recalled."),
    setting(0x0005, "FMSL", {0, 20}, 0, kPlain, kS15, "What the meter terminal FM shows.", Support::kStored),
    setting(0x0006, "FM", {0, 1280}, 100, kPlain, kRecall, "Gain of the meter terminal.", Support::kStored),
    setting(0x0007, "tYP", {0, 3}, 0, kPlain, kRecall, "1 or 3: all parameters to their factory values, within 1 s; reads 0. Locked while running."),
    setting(0x0008, "Fr", {0, 1}, 0, kPlain, kS11S15, "Direction of the panel's run command: 0 forward, 1 reverse."),
    setting(0x0009, "ACC", kRampTimes, 100, kDeciSeconds, kS15, "Acceleration time 1, from 0 to FH."),
    setting(0x0010, "DEC", kRampTimes, 100, kDeciSeconds, kAllRelatives, "Deceleration time 1, from FH to 0."),
    setting(0x0011, "FH", {3000, 50000}, 8000, kHertz, kAllRelatives, "Maximum frequency. Locked while running. The number is recalled."),
    setting(0x0012, "UL", {50, 50000}, 8000, kHertz, {Evidence::kFamily, "VF-S11"}, "Upper limit of the frequency, up to FH."),
    setting(0x0013, "LL", kFrequencies, 0, kHertz, kRecall, "Lower limit of the frequency, up to UL."),
    setting(0x0014, "vL", {2500, 50000}, 6000, kHertz, kRecall, "Base frequency 1. Locked while running."),
    setting(0x0015, "Pt", {0, 3}, 0, kPlain, kRecall, "V/f: 0 constant torque, 1 variable torque, 2 automatic boost, 3 boost and slip compensation. Locked while running."),
    setting(0x0016, "vb", {0, 300}, 60, kDeciPercent, kRecall, "Torque boost 1."),
    setting(0x0017, "OLM", {0, 7}, 0, kPlain, kRecall, "Guards of the motor: 0 trip and stall, 1 trip, 2 stall, 3 none; 4 to 7 the same for a motor with a fan of its own."),
    setting(0x0018, "Sr1", kFrequencies, 0, kHertz, kRecall, "Preset speed 1, LL to UL."),
    setting(0x0019, "Sr2", kFrequencies, 0, kHertz, kRecall, "Preset speed 2."),
    setting(0x0020, "Sr3", kFrequencies, 0, kHertz, kRecall, "Preset speed 3."),
    setting(0x0021, "Sr4", kFrequencies, 0, kHertz, kRecall, "Preset speed 4."),
    setting(0x0022, "Sr5", kFrequencies, 0, kHertz, kRecall, "Preset speed 5."),
    setting(0x0023, "Sr6", kFrequencies, 0, kHertz, kRecall, "Preset speed 6."),
    setting(0x0024, "Sr7", kFrequencies, 0, kHertz, kRecall, "Preset speed 7."),
    // Second motor, second sources, analog inputs
    setting(0x0170, "F170", {2500, 50000}, 6000, kHertz, kS15, "Base frequency 2. Locked while running."),
    setting(0x0172, "F172", {0, 300}, 60, kDeciPercent, kRecall, "Torque boost 2."),
    setting(0x0173, "F173", {10, 100}, 100, kPercent, kRecall, "Motor protection level 2, of the motor's rated current."),
    setting(0x0185, "F185", {10, 200}, 150, kPercent, kRecall, "Stall prevention level 2, of the rated output current; 200 is off."),
    setting(0x0200, "F200", kSwitch, 0, kPlain, kRecall, "1: FMOD gives way to F207 below 1 Hz."),
    setting(0x0201, "F201", {0, 10000}, 0, kCentiPercent, kRecall, "VIA, point 1."),
    setting(0x0202, "F202", kFrequencies, 0, kHertz, kRecall, "VIA, frequency at point 1."),
    setting(0x0203, "F203", {0, 10000}, 10000, kCentiPercent, kRecall, "VIA, point 2."),
    setting(0x0204, "F204", kFrequencies, 6000, kHertz, kRecall, "VIA, frequency at point 2."),
    setting(0x0207, "F207", {0, 4}, 1, kPlain, kS15, "FMOD2, coded as FMOD."),
    setting(0x0210, "F210", {0, 10000}, 0, kCentiPercent, kRecall, "VIB, point 1."),
    setting(0x0211, "F211", kFrequencies, 0, kHertz, kRecall, "VIB, frequency at point 1."),
    setting(0x0212, "F212", {0, 10000}, 10000, kCentiPercent, kRecall, "VIB, point 2."),
    setting(0x0213, "F213", kFrequencies, 6000, kHertz, kRecall, "VIB, frequency at point 2."),
    setting(0x0240, "F240", {50, 1000}, 50, kHertz, kRecall, "Start frequency; the output ends below it, too."),
    setting(0x0250, "F250", {0, 12000}, 0, kHertz, kRecall, "DC braking starts at this frequency; 0 is off."),
    setting(0x0251, "F251", {0, 100}, 50, kPercent, kRecall, "DC braking current, of the rated output current."),
    setting(0x0252, "F252", {0, 250}, 10, kDeciSeconds, kRecall, "DC braking time."),
    setting(0x0256, "F256", {0, 6000}, 0, kDeciSeconds, kRecall, "Stops after so long at LL; 0 is off."),
    setting(0x0260, "F260", {50, 2000}, 500, kHertz, kRecall, "Jog frequency."),
    setting(0x0270, "F270", kFrequencies, 0, kHertz, kRecall, "Jump frequency 1."),
    setting(0x0271, "F271", {0, 3000}, 0, kHertz, kRecall, "Its width; 0 is none."),
    setting(0x0272, "F272", kFrequencies, 0, kHertz, kRecall, "Jump frequency 2."),
    setting(0x0273, "F273", {0, 3000}, 0, kHertz, kRecall, "Its width."),
    setting(0x0274, "F274", kFrequencies, 0, kHertz, kRecall, "Jump frequency 3."),
    setting(0x0275, "F275", {0, 3000}, 0, kHertz, kRecall, "Its width."),
    setting(0x0287, "Sr8", kFrequencies, 0, kHertz, kRecall, "Preset speed 8 (F287)."),
    setting(0x0288, "Sr9", kFrequencies, 0, kHertz, kRecall, "Preset speed 9."),
    setting(0x0289, "Sr10", kFrequencies, 0, kHertz, kRecall, "Preset speed 10."),
    setting(0x0290, "Sr11", kFrequencies, 0, kHertz, kRecall, "Preset speed 11."),
    setting(0x0291, "Sr12", kFrequencies, 0, kHertz, kRecall, "Preset speed 12."),
    setting(0x0292, "Sr13", kFrequencies, 0, kHertz, kRecall, "Preset speed 13."),
    setting(0x0293, "Sr14", kFrequencies, 0, kHertz, kRecall, "Preset speed 14."),
    setting(0x0294, "Sr15", kFrequencies, 0, kHertz, kRecall, "Preset speed 15 (F294)."),
    // How it runs
    setting(0x0300, "F300", {20, 160}, 120, {"kHz", 0.1}, kRecall, "Carrier frequency."),
    setting(0x0301, "F301", {0, 2}, 0, kPlain, kRecall, "Flying start: 1 after an interruption, 2 always."),
    setting(0x0302, "F302", {0, 2}, 0, kPlain, kRecall, "Mains dip: 1 rides through on the load's energy, 2 decelerates and stops."),
    setting(0x0303, "F303", {0, 10}, 0, kPlain, kRecall, "Retries after a trip; 0 is off."),
    setting(0x0304, "F304", {0, 2}, 0, kPlain, kRecall, "Braking resistor: 1 on, 2 on with its overload guard."),
    setting(0x0305, "F305", kSwitch, 0, kPlain, kRecall, "Overvoltage limit: 0 on, 1 off."),
    setting(0x0307, "F307", {0, 3}, 2, kPlain, kRecall, "Output voltage: 0 and 1 follow the link's voltage, 2 and 3 are corrected."),
    setting(0x0308, "F308", {10, 10000}, 2000, {"Ohm", 0.1}, kRecall, "Braking resistor."),
    setting(0x0309, "F309", {1, 3000}, 12, kKilowatts, kRecall, "Its power."),
    setting(0x0360, "F360", kSwitch, 0, kPlain, kRecall, "PI control: 1 on, feedback at VIA or VIB."),
    setting(0x0361, "F361", {0, 255}, 1, kDeciSeconds, kRecall, "Filter of the PI feedback."),
    setting(0x0362, "F362", {1, 10000}, 30, {"", 0.01}, kRecall, "PI proportional gain."),
    setting(0x0363, "F363", {1, 10000}, 20, {"1/s", 0.01}, kRecall, "PI integral gain."),
    setting(0x0401, "F401", {0, 150}, 70, kPercent, kRecall, "Slip compensation."),
    setting(0x0402, "F402", {0, 300}, 49, kDeciPercent, kRecall, "Automatic torque boost."),
    setting(0x0415, "F415", {1, 20000}, 30, {"A", 0.1}, kRecall, "The motor's rated current."),
    setting(0x0416, "F416", {10, 100}, 65, kPercent, kRecall, "Its no-load current, of that."),
    setting(0x0417, "F417", {100, 64000}, 1722, {"rpm", 1}, kS15, "Its rated speed."),
    setting(0x0500, "F500", kRampTimes, 100, kDeciSeconds, kS15, "Acceleration time 2."),
    setting(0x0501, "F501", kRampTimes, 100, kDeciSeconds, kS15, "Deceleration time 2."),
    setting(0x0502, "F502", {0, 2}, 0, kPlain, kRecall, "Shape of ramp 1: 0 straight, 1 and 2 S."),
    setting(0x0503, "F503", {0, 2}, 0, kPlain, kRecall, "Shape of ramp 2."),
    setting(0x0505, "F505", kFrequencies, 0, kHertz, kRecall, "Ramp 1 below it, ramp 2 above; 0 is off."),
    setting(0x0506, "F506", {0, 50}, 10, kPercent, kRecall, "Share of an S that is round at its start."),
    setting(0x0507, "F507", {0, 50}, 10, kPercent, kRecall, "At its end."),
    // Protections
    setting(0x0600, "tHr", {10, 100}, 100, kPercent, kRecall, "Motor protection level 1, of the motor's rated current."),
    setting(0x0601, "F601", {10, 200}, 150, kPercent, kRecall, "Stall prevention level 1, of the rated output current; 200 is off."),
    setting(0x0602, "F602", kSwitch, 0, kPlain, kRecall, "1: a trip outlives power-off."),
    setting(0x0603, "F603", {0, 2}, 0, kPlain, kRecall, "Emergency stop: 0 coast, 1 ramp, 2 DC braking; then trip E."),
    setting(0x0604, "F604", {0, 200}, 10, kDeciSeconds, kRecall, "Its DC braking time."),
    setting(0x0605, "F605", kSwitch, 0, kPlain, kRecall, "Guard against a lost motor phase: 1 on."),
    setting(0x0606, "F606", {0, 6000}, 3000, kHertz, kRecall, "Below it a motor with its own fan is guarded more closely."),
    setting(0x0607, "F607", {10, 2400}, 300, kSeconds, kRecall, "Motor overload time at 150 %."),
    setting(0x0608, "F608", kSwitch, 1, kPlain, kRecall, "Guard against a lost supply phase: 1 on."),
    setting(0x0610, "F610", kSwitch, 0, kPlain, kRecall, "Low current: 0 alarm, 1 trip."),
    setting(0x0611, "F611", {0, 100}, 0, kPercent, kRecall, "Low current level, of the rated output current."),
    setting(0x0612, "F612", {0, 255}, 0, kSeconds, kRecall, "Low current time; 0 is off."),
    setting(0x0615, "F615", kSwitch, 0, kPlain, kRecall, "Over-torque: 0 alarm, 1 trip."),
    setting(0x0616, "F616", {0, 250}, 130, kPercent, kRecall, "Over-torque level, of the motor's rated torque; 0 is off."),
    setting(0x0618, "F618", {0, 100}, 5, kDeciSeconds, kRecall, "Over-torque time."),
    setting(0x0621, "F621", {0, 999}, 0, {"h", 100}, kRecall, "Run hours that raise an alarm; 0 is off."),
    setting(0x0627, "F627", kSwitch, 0, kPlain, kRecall, "Undervoltage while running: 0 coasts and goes on, 1 trips."),
    setting(0x0736, "F736", kSwitch, 0, kPlain, kS15, "1: CMOD and FMOD cannot be changed while it runs."),
    // Communication
    setting(0x0800, "F800", {0, 3}, 3, kPlain, kRecall, "Baud rate, from the next reset on: 0 to 3 are 1200, 2400, 4800, 9600."),
    setting(0x0801, "F801", {0, 2}, 1, kPlain, kS15, "Parity, from the next reset on: 0 none, 1 even, 2 odd."),
    setting(0x0802, "F802", {0, 247}, 0, kPlain, kG7, "ASD number; ASCII frames reach 0 to 99, binary ones 0 to 63. Counts at once; the write itself is answered with the old one."),
    setting(0x0803, "F803", {0, 100}, 0, kSeconds, kP9, "Communication time-out; 0 is off. `timeout_unit` makes it 0.1 s, as VF-S15's."),
    setting(0x0804, "F804", {0, 8}, 1, kPlain, kS15, "What the time-out does: 0 alarm, 1 trip, 2 ramp and trip; the factory value is decided here. `timeout_actions=p9` takes P9's 0 to 8."),
    setting(0x0805, "F805", {0, 200}, 0, kCentiSeconds, kS15, "An answer waits at least so long. The excerpt has its name, transmission waittime."),
    setting(0x0806, "F806", {0, 4}, 0, kPlain, kS15, "Inter-drive communication: 0 to 2 slave that stops, goes on, or trips when the master does; 3 master that sends its command, 4 its output frequency."),
    setting(0x0811, "F811", {0, 100}, 0, kPercent, kS15, "Point 1 of S."),
    setting(0x0812, "F812", kFrequencies, 0, kHertz, kS15, "Frequency at point 1."),
    setting(0x0813, "F813", {0, 100}, 100, kPercent, kS15, "Point 2 of S."),
    setting(0x0814, "F814", kFrequencies, 6000, kHertz, kS15, "Frequency at point 2."),
    setting(0x0880, "F880", {0, 65535}, 0, kPlain, kS15, "Free note."),
    monitor(0x0999, "time_unit", kPlain, kS15, "Unit of the ramp times: 1 is 0.01 s, 2 is 0.1 s."),
    // Commands and set-points: RAM only
    setting(0xFA00, "command", {0, 0xFFFF}, 0, kPlain, kAllRelatives, "Bits 0-3 preset speed, 4 motor 2, 5 PI off, 6 ramp 2, 7 DC braking, 8 jog, 9 reverse, 10 run, 11 coast, 12 emergency stop, 13 reset, 14 frequency priority, 15 command priority."),
    setting(0xFA01, "frequency", kFrequencies, 0, kHertz, kEth, "Frequency command, up to FH."),
    setting(0xFA03, "panel_frequency", kFrequencies, 0, kHertz, kS15, "Frequency command of the panel, up to UL."),
    setting(0xFA04, "command_rs485", {0, 0xFFFF}, 0, kPlain, kRecall, "The same word as FA00: the last write counts."),
    setting(0xFA05, "frequency_rs485", kFrequencies, 0, kHertz, kRecall, "The same as FA01."),
    unknown_here(0xFA06, "command_option", kG7, "Command word of an option board, laid out otherwise than FA00; there is no such board."),
    unknown_here(0xFA07, "frequency_option", kRecall, "Frequency command of an option board."),
    setting(0xFA20, "command2", {0, 0xFFFF}, 0, kPlain, kS15, "Bit 1 clears the energies, 7 stops as fast as it can, 8-9 ramp 1 or 2; the other bits do nothing."),
    unknown_here(0xFA23, "command2_option", kG7, "Second command word of an option board."),
    unknown_here(0xFA26, "output_hold", kS15, "Later drives' hold of outputs."),
    unknown_here(0xFA50, "terminal_outputs", kS15, "Later drives' outputs by the line."),
    unknown_here(0xFA51, "meter_output", kS15, "Later drives' meter output by the line."),
    monitor(0xFB05, "capacity_code", kPlain, kS15, "Size; the codes are decided here."),
    monitor(0xFC90, "trip", kPlain, kS15, "Code of the present trip, 0 is none; the codes are below."),
    monitor(0xFC91, "alarms", kPlain, kS11S15, "Bits 0 current, 1 inverter overload, 2 motor overload, 3 heat sink, 4 over-voltage, 5 under-voltage, 7 low current, 8 over-torque, 9 braking resistor, 10 run hours, 11 time-out (assumed), 14 power-loss stop, 15 LL stop."),
    // Monitors: FD as it is now, FE as it was at the trip
    monitor(0xFD00, "output_frequency", kHertz, kAllRelatives, "Output frequency. `signed_frequency` makes it negative in reverse, as the excerpt's example has it."),
    monitor(0xFD01, "status", kPlain, kS11S15, "Bits 0 FL, 1 tripped, 2 alarm, 3 undervoltage, 4 motor 2, 5 PI off, 6 ramp 2, 7 DC braking, 8 jog, 9 reverse, 10 running, 11 coast, 12 emergency stop, 13 run requested, 14 ready (`status_bit14`)."),
    monitor(0xFD02, "frequency_command", kHertz, kAs1S15, "Frequency command in force."),
    monitor(0xFD03, "output_current", kCentiPercent, kAllRelatives, "Of the rated output current."),
    monitor(0xFD04, "dc_voltage", kCentiPercent, kAllRelatives, "Link voltage over sqrt 2, of 200 or 400 V; that base is recalled."),
    monitor(0xFD05, "output_voltage", kCentiPercent, kAllRelatives, "Of 200 or 400 V; that base is recalled."),
    monitor(0xFD06, "input_terminals", kPlain, kS15, "Bits 0 F, 1 R, 2 RES, 3-6 S1-S4, 7 ST."),
    monitor(0xFD07, "output_terminals", kPlain, kS15, "Bits 0 RY, 1 RCH, 2 FL."),
    signed_monitor(0xFD15, "compensated_frequency", kHertz, kAs1S15, "With slip compensation."),
    signed_monitor(0xFD16, "estimated_speed", kHertz, kAs1S15, "Estimated speed."),
    signed_monitor(0xFD17, "filtered_speed", kHertz, kAs1S15, "The same, filtered for 1 s."),
    signed_monitor(0xFD18, "torque", kCentiPercent, kAs1, "Of the motor's rated torque."),
    signed_monitor(0xFD19, "torque_command", kCentiPercent, kAs1, "0: there is no torque control."),
    signed_monitor(0xFD20, "torque_current", kCentiPercent, kAs1, "Of the rated output current."),
    signed_monitor(0xFD21, "exciting_current", kCentiPercent, kAs1, "Of the rated output current."),
    signed_monitor(0xFD22, "pi_feedback", kHertz, kAs1S15, "Feedback of the PI control."),
    monitor(0xFD23, "motor_overload", kCentiPercent, kAs1S15, "How far the motor's overload guard is: 100 trips."),
    monitor(0xFD24, "inverter_overload", kCentiPercent, kAs1S15, "The same of the inverter."),
    monitor(0xFD25, "resistor_overload", kPercent, kAs1S15, "The same of the braking resistor."),
    monitor(0xFD26, "motor_load", kPercent, kS15, "Current, of the motor's rated one."),
    monitor(0xFD27, "inverter_load", kPercent, kS11S15, "Current, of the rated output current."),
    monitor(0xFD29, "input_power", kKilowatts, kS15, "Input power."),
    monitor(0xFD30, "output_power", kKilowatts, kS15, "Output power."),
    monitor(0xFD45, "command_source_now", kPlain, kS15, "Who gives the run command, coded as CMOD."),
    monitor(0xFD46, "frequency_source_now", kPlain, kS15, "Who gives the frequency, coded as FMOD; 10 preset speed, 11 jog."),
    monitor(0xFE00, "output_frequency_held", kHertz, kAllRelatives, "As FD00, held at a trip; so are all FE00 to FE30."),
    monitor(0xFE01, "status_held", kPlain, kS11S15, "As FD01."),
    monitor(0xFE02, "frequency_command_held", kHertz, kAs1S15, "As FD02."),
    monitor(0xFE03, "output_current_held", kCentiPercent, kAllRelatives, "As FD03."),
    monitor(0xFE04, "dc_voltage_held", kCentiPercent, kAllRelatives, "As FD04."),
    monitor(0xFE05, "output_voltage_held", kCentiPercent, kAllRelatives, "As FD05."),
    monitor(0xFE06, "input_terminals_held", kPlain, kS15, "As FD06."),
    monitor(0xFE07, "output_terminals_held", kPlain, kS15, "As FD07."),
    monitor(0xFE08, "cpu_version", kPlain, kS15, "Program version; the number is decided here."),
    monitor(0xFE10, "past_trip1", kPlain, kS15, "Code of the latest trip, kept without power."),
    monitor(0xFE11, "past_trip2", kPlain, kS15, "The one before."),
    monitor(0xFE12, "past_trip3", kPlain, kS15, "And before."),
    monitor(0xFE13, "past_trip4", kPlain, kS15, "And before."),
    monitor(0xFE14, "run_hours", kHours, kS15, "Cumulative run time, kept without power."),
    signed_monitor(0xFE15, "compensated_frequency_held", kHertz, kAs1S15, "As FD15."),
    signed_monitor(0xFE16, "estimated_speed_held", kHertz, kAs1S15, "As FD16."),
    signed_monitor(0xFE17, "filtered_speed_held", kHertz, kAs1S15, "As FD17."),
    signed_monitor(0xFE18, "torque_held", kCentiPercent, kAs1, "As FD18."),
    signed_monitor(0xFE19, "torque_command_held", kCentiPercent, kAs1, "As FD19."),
    signed_monitor(0xFE20, "torque_current_held", kCentiPercent, kAs1, "As FD20."),
    signed_monitor(0xFE21, "exciting_current_held", kCentiPercent, kAs1, "As FD21."),
    signed_monitor(0xFE22, "pi_feedback_held", kHertz, kAs1S15, "As FD22."),
    monitor(0xFE23, "motor_overload_held", kCentiPercent, kAs1S15, "As FD23."),
    monitor(0xFE24, "inverter_overload_held", kCentiPercent, kAs1S15, "As FD24."),
    monitor(0xFE25, "resistor_overload_held", kPercent, kAs1S15, "As FD25."),
    monitor(0xFE26, "motor_load_held", kPercent, kS15, "As FD26."),
    monitor(0xFE27, "inverter_load_held", kPercent, kS11S15, "As FD27."),
    monitor(0xFE29, "input_power_held", kKilowatts, kS15, "As FD29."),
    monitor(0xFE30, "output_power_held", kKilowatts, kS15, "As FD30."),
    monitor(0xFE35, "via", kCentiPercent, kS15, "Analog input VIA."),
    monitor(0xFE36, "vib", kCentiPercent, kS15, "Analog input VIB."),
    unknown_here(0xFE37, "vic", kS15, "Later drives' third analog input."),
    monitor(0xFE58, "operating_speed", kHertz, kG7, "Operating speed."),
    monitor(0xFE70, "rated_current", {"A", 0.1}, kS11S15, "Rated output current."),
    monitor(0xFE71, "rated_voltage", {"V", 0.1}, kS11S15, "Rated voltage."),
    monitor(0xFE73, "cpu_version2", kPlain, kS15, "Version of the second CPU; decided here."),
    monitor(0xFE76, "input_energy", {"kWh", 1}, kS15, "Energy taken from the mains."),
    monitor(0xFE77, "output_energy", {"kWh", 1}, kS15, "Energy given to the motor."),
};
// clang-format on

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
    {.code = 0,
     .name = "cannot_execute",
     .evidence = Evidence::kFamily,
     .doc = "Not now, not while running, read-only, or (assumed) not in this format."},
    {.code = 1,
     .name = "range",
     .evidence = Evidence::kFamily,
     .doc = "Data out of range, or more than four digits."},
    {.code = 2,
     .name = "number",
     .evidence = Evidence::kFamily,
     .doc = "No such communication number."},
    {.code = 3,
     .name = "command",
     .evidence = Evidence::kFamily,
     .doc = "No such command; ASCII only, binary frames are dropped."},
    {.code = 4, .name = "sum", .evidence = Evidence::kFamily, .doc = "The checksum does not fit."},
};

// Codes of FC90 and FE10 to FE13.
// clang-format off
inline constexpr CodeRow kTrips[] = {
    {.code = 0x01, .name = "OC1", .evidence = Evidence::kFamily, .doc = "Over-current while accelerating."},
    {.code = 0x02, .name = "OC2", .evidence = Evidence::kFamily, .doc = "Over-current while decelerating."},
    {.code = 0x03, .name = "OC3", .evidence = Evidence::kFamily, .doc = "Over-current at speed."},
    {.code = 0x04, .name = "OCL", .evidence = Evidence::kFamily, .doc = "Over-current of the load at the start."},
    {.code = 0x05, .name = "OCA", .evidence = Evidence::kFamily, .doc = "Over-current of the bridge at the start: injected."},
    {.code = 0x08, .name = "EPHI", .evidence = Evidence::kFamily, .doc = "A phase of the supply is lost."},
    {.code = 0x09, .name = "EPHO", .evidence = Evidence::kFamily, .doc = "A phase of the motor is lost."},
    {.code = 0x0A, .name = "OP1", .evidence = Evidence::kFamily, .doc = "Over-voltage while accelerating."},
    {.code = 0x0B, .name = "OP2", .evidence = Evidence::kFamily, .doc = "Over-voltage while decelerating."},
    {.code = 0x0C, .name = "OP3", .evidence = Evidence::kFamily, .doc = "Over-voltage else."},
    {.code = 0x0D, .name = "OL1", .evidence = Evidence::kFamily, .doc = "Inverter overload."},
    {.code = 0x0E, .name = "OL2", .evidence = Evidence::kFamily, .doc = "Motor overload."},
    {.code = 0x0F, .name = "OLr", .evidence = Evidence::kFamily, .doc = "Braking resistor overload."},
    {.code = 0x10, .name = "OH", .evidence = Evidence::kFamily, .doc = "Heat sink too hot."},
    {.code = 0x11, .name = "E", .evidence = Evidence::kFamily, .doc = "Emergency stop."},
    {.code = 0x12, .name = "EEP1", .evidence = Evidence::kFamily, .doc = "EEPROM: writing failed."},
    {.code = 0x13, .name = "EEP2", .evidence = Evidence::kFamily, .doc = "EEPROM: reading failed."},
    {.code = 0x14, .name = "EEP3", .evidence = Evidence::kFamily, .doc = "EEPROM: data damaged."},
    {.code = 0x15, .name = "Err2", .evidence = Evidence::kFamily, .doc = "RAM: injected."},
    {.code = 0x16, .name = "Err3", .evidence = Evidence::kFamily, .doc = "ROM: injected."},
    {.code = 0x17, .name = "Err4", .evidence = Evidence::kFamily, .doc = "CPU: injected."},
    {.code = 0x18, .name = "Err5", .evidence = Evidence::kFamily, .doc = "Communication time-out."},
    {.code = 0x1A, .name = "Err7", .evidence = Evidence::kFamily, .doc = "Current detector: injected."},
    {.code = 0x1D, .name = "UC", .evidence = Evidence::kFamily, .doc = "Current too low."},
    {.code = 0x1E, .name = "UP1", .evidence = Evidence::kFamily, .doc = "Under-voltage of the link."},
    {.code = 0x20, .name = "Ot", .evidence = Evidence::kFamily, .doc = "Over-torque."},
    {.code = 0x22, .name = "EF2", .evidence = Evidence::kFamily, .doc = "Earth fault: injected."},
    {.code = 0x2E, .name = "OH2", .evidence = Evidence::kFamily, .doc = "Thermistor."},
};
// clang-format on

inline constexpr ProtocolTable kTable = {
    .name = "asd7",
    .title = "Toshiba 7-Series ASD",
    .document =
        "7-Series Serial Communications User Manual, 53840-001, August 2003 (excerpt, p. "
        "22-25), and the relatives named in each row",
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
    .faults = kTrips,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::asd7
