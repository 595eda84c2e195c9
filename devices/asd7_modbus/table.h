// The same registers over Modbus RTU, as later drives of the family offer it: VF-S11 (E6581222,
// p. 32) and VF-S15 (E6581913, p. 25-41). No 7-Series drive spoke it; hosts of this family do.
//
// A register's address is its communication number; one word at a time.
#pragma once

#include <array>

#include "devices/asd7/table.h"

namespace virtdrive::asd7_modbus {

using asd7::ParameterRow;
using protocol::CodeRow;
using protocol::CommandRow;
using protocol::Evidence;
using protocol::Field;
using protocol::Names;
using protocol::ProtocolTable;
using protocol::WireType;

inline constexpr std::uint8_t kAllDrives = 0;  // unit of a broadcast
inline constexpr std::uint8_t kExceptionBit = 0x80;
/// Of silence: it ends a frame (E6581913, p. 25).
inline constexpr double kSilentCharacters = 3.5;

inline constexpr Field kNumberAndQuantity[] = {{.name = "number", .type = WireType::kU16},
                                               {.name = "quantity", .type = WireType::kU16}};
inline constexpr Field kNumberAndData[] = {{.name = "number", .type = WireType::kU16},
                                           {.name = "data", .type = WireType::kU16}};
inline constexpr Field kBytesAndData[] = {{.name = "bytes"},
                                          {.name = "data", .type = WireType::kU16}};
inline constexpr Field kWriteMultiple[] = {{.name = "number", .type = WireType::kU16},
                                           {.name = "quantity", .type = WireType::kU16},
                                           {.name = "bytes"},
                                           {.name = "data", .type = WireType::kU16}};

inline constexpr std::uint16_t kRead = 0x03, kWrite = 0x06, kWriteSome = 0x10;

// clang-format off
inline constexpr CommandRow kFunctions[] = {
    {.code = kRead, .name = "read", .request = kNumberAndQuantity, .reply = kBytesAndData, .names = Names::kParameter,
     .evidence = Evidence::kFamily, .source = "VF-S11, VF-S15 p. 26",
     .doc = "Reads one word: another quantity than 1 is exception 3."},
    {.code = kWrite, .name = "write", .request = kNumberAndData, .reply = kNumberAndData, .names = Names::kParameter,
     .evidence = Evidence::kFamily, .source = "VF-S11, VF-S15 p. 31",
     .doc = "Writes, also into the EEPROM; the answer repeats it."},
    {.code = kWriteSome, .name = "write_multiple", .request = kWriteMultiple, .reply = kNumberAndQuantity, .names = Names::kParameter,
     .evidence = Evidence::kFamily, .source = "VF-S15 p. 25",
     .doc = "The same, of one word: another quantity is exception 3."},
};
// clang-format on

/// A host that asks for unit 1 is to find the drive.
inline constexpr std::uint16_t kFactoryUnit = 1;

// As asd7's, but for the number: 0 would never be answered.
inline constexpr auto kParameters = [] {
  auto rows = std::to_array(asd7::kParameters);
  for (ParameterRow& row : rows) {
    if (row.id != 0x0802) continue;
    row.factory.value = kFactoryUnit;
    row.evidence = Evidence::kAssumed;
    row.source = "-";
    row.doc = "Unit number; 0 is never answered. The factory value is decided here.";
  }
  return rows;
}();

enum class Exception : std::uint8_t {
  kFunction = 1,
  kAddress = 2,
  kValue = 3,
  kFailure = 4,
};

inline constexpr CodeRow kExceptions[] = {
    {.code = 1, .name = "function", .evidence = Evidence::kFamily, .doc = "No such function."},
    {.code = 2,
     .name = "address",
     .evidence = Evidence::kFamily,
     .doc = "No such communication number."},
    {.code = 3,
     .name = "value",
     .evidence = Evidence::kFamily,
     .doc = "Data, or quantity, out of range."},
    {.code = 4,
     .name = "failure",
     .evidence = Evidence::kFamily,
     .doc = "Not now, not while running, read-only."},
};

inline constexpr std::size_t kLongestFrame = 256;

inline constexpr ProtocolTable kTable = {
    .name = "asd7-modbus",
    .title = "Toshiba 7-Series ASD over Modbus RTU, as later drives of the family offer it",
    .document =
        "VF-S15 RS485 Communication Manual, E6581913, and VF-S11's, E6581222; the registers "
        "are those of the 7-Series' own protocol",
    .framing = {.checksum = protocol::Checksum::kCrc16Modbus,
                .checksum_span = "unit number to data; 3.5 characters of silence end a frame",
                .order = protocol::ByteOrder::kBigEndian,
                .longest = kLongestFrame},
    .commands = kFunctions,
    .parameters = kParameters,
    .errors = kExceptions,
    .faults = asd7::kTrips,
};
static_assert(well_formed(kTable));

}  // namespace virtdrive::asd7_modbus
