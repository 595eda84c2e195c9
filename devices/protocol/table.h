// How a protocol is declared: once, as constexpr data, one table per kind of thing.
//
//   constexpr CommandRow kCommands[] = {{.code = 0x00, .name = "StartMotor", ...}, ...};
//   constexpr ParameterRow kParameters[] = {{.id = 0x10, .name = "PolePairs", ...}, ...};
//   constexpr ProtocolTable kTable = {.name = "...", .commands = kCommands, ...};
//   static_assert(well_formed(kTable));
//
// The emulator's look-up and refusals, the host-side client, the trace, the fuzzer's seeds and the
// documents are derived from these rows; nothing about a protocol is typed a second time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/sim_time.h"

namespace virtdrive::protocol {

/// What stands behind a row.
enum class Support : std::uint8_t {
  kImplemented,  // acts, or tells of the simulation
  kStored,       // accepted and read back, without effect: the simulation has nothing behind it
  kRejected,     // refused, as a drive refuses what it lacks
};

/// How sure a row is.
enum class Evidence : std::uint8_t {
  kDocumented,  // the maker's document says so
  kObserved,    // seen on real devices or in the maker's published firmware
  kAssumed,     // open in every source; decided here, the reason in the row's doc
  kFamily,      // documented for a relative that speaks the same protocol; the source names it
  kRecalled,    // from memory, no text seen: the weakest
};

enum class Access : std::uint8_t { kReadWrite, kReadOnly, kWriteOnly };

enum class ByteOrder : std::uint8_t { kLittleEndian, kBigEndian };

/// What a receiver listens for.
enum class Direction : std::uint8_t { kRequest, kReply };

/// A number as it lies on the wire. kText is one byte of a string. kParameter stands for the value
/// of the parameter that the payload names: with_value() puts that parameter's own fields in its
/// place.
enum class WireType : std::uint8_t { kU8, kI8, kU16, kI16, kU32, kI32, kText, kParameter };

constexpr std::size_t width(WireType type) {
  switch (type) {
    case WireType::kU8:
    case WireType::kI8:
    case WireType::kText:
      return 1;
    case WireType::kU16:
    case WireType::kI16:
      return 2;
    case WireType::kU32:
    case WireType::kI32:
      return 4;
    case WireType::kParameter:
      break;
  }
  return 0;
}

constexpr bool is_signed(WireType type) {
  return type == WireType::kI8 || type == WireType::kI16 || type == WireType::kI32;
}

/// One value of a payload, or a group of them, `count` times in a row.
struct Field {
  std::string_view name;
  WireType type = WireType::kU8;
  std::size_t count = 1;
  std::string_view unit = {};  // as printed; the wire value times `scale` is in this unit
  double scale = 1;
  std::span<const Field> members = {};  // a group: `type` does not count
  bool optional = false;  // a sender may end before it: then it and all behind it read as zero
};

/// Bytes that fields take on the wire.
constexpr std::size_t width(std::span<const Field> fields) {
  std::size_t bytes = 0;
  for (const Field& field : fields) {
    bytes += field.count * (field.members.empty() ? width(field.type) : width(field.members));
  }
  return bytes;
}

/// Numbers that fields hold, groups and repetitions counted out.
constexpr std::size_t values(std::span<const Field> fields) {
  std::size_t count = 0;
  for (const Field& field : fields) {
    count += field.count * (field.members.empty() ? 1 : values(field.members));
  }
  return count;
}

/// What the first number of a request names.
enum class Names : std::uint8_t { kNothing, kParameter, kFunction };

struct CommandRow {
  std::uint16_t code = 0;
  std::string_view name;
  std::span<const Field> request = {};
  std::span<const Field> reply = {};
  Names names = Names::kNothing;
  bool replies = true;
  bool reply_by_mask = false;  // the request's number is a mask: bit i set, the reply holds field i
  Support support = Support::kImplemented;
  Evidence evidence = Evidence::kDocumented;
  std::string_view source;  // section of the document
  std::string_view doc;     // one line
};

struct Range {
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;
  constexpr bool contains(std::int64_t v) const { return v >= minimum && v <= maximum; }
};

/// One of the units that a parameter may be written in, with the code that names it on the wire.
struct UnitCode {
  std::int8_t code;
  std::string_view label;
};

struct FactoryValue {
  std::int64_t value = 0;
  std::int8_t unit = 0;
};

struct ParameterRow {
  std::uint16_t id = 0;
  std::string_view name;
  WireType type = WireType::kI32;
  std::size_t count = 1;  // > 1: a text's length, or words in a row
  Access access = Access::kReadWrite;
  Range range = {};
  FactoryValue factory = {};
  std::string_view unit = {};  // as printed, where the protocol knows one unit only
  double scale = 1;            // the wire value times `scale` is in `unit`
  std::size_t hex_digits = 0;  // where values go as text: digits in hexadecimal; 0: decimal
  std::span<const UnitCode> units = {};  // where the wire tells the unit
  std::span<const Field> fields = {};    // where a parameter is a structure (a monitor block)
  Support support = Support::kImplemented;
  Evidence evidence = Evidence::kDocumented;
  std::string_view source;
  std::string_view doc;
};

/// An error code, or a bit of a fault word.
struct CodeRow {
  std::int32_t code;
  std::string_view name;
  Evidence evidence = Evidence::kDocumented;
  std::string_view doc;
};

enum class Checksum : std::uint8_t {
  kNone,
  kCrc8FromCommand,  // polynomial 0x07, the command as start value, over the payload
  kSum8,             // low byte of the sum
  kNegatedSum8,      // what makes the sum zero
  kAsciiSum8,        // low byte of the sum, as two upper-case hex digits
  kCrc16Modbus,      // polynomial 0x8005 reflected, start value 0xFFFF, low byte first
};

struct Framing {
  std::string_view name = {};   // where a drive knows several
  std::string_view start = {};  // first bytes of a request
  std::string_view end = {};    // last bytes of a request; empty where a length rules
  std::size_t length_at = 0;    // place of the byte that counts the payload; 0: the row tells
  std::size_t overhead = 0;     // bytes of a frame besides those that this byte counts
  Checksum checksum = Checksum::kNone;
  std::string_view checksum_span = {};  // in words, for the documents
  ByteOrder order = ByteOrder::kLittleEndian;
  std::size_t longest = 0;   // bytes of the longest frame, both directions
  SimDuration silence = {};  // a frame is given up after so long without a byte; 0: never
};

struct ProtocolTable {
  std::string_view name;  // "toshiba-mcu"
  std::string_view title;
  std::string_view document;  // the maker's document, with its number and date
  Framing framing;
  std::span<const Framing> other_framings =
      {};  // further ways to say the same, told by the first byte
  std::span<const CommandRow> commands;
  std::span<const CommandRow> functions = {};  // what one of the commands calls by number or name
  std::span<const ParameterRow> parameters;
  std::span<const CodeRow> errors;
  std::span<const CodeRow> faults;
};

/// The row of an id in a table sorted by it; null if there is none.
constexpr const ParameterRow* find(std::span<const ParameterRow> rows, std::uint16_t id) {
  std::size_t low = 0;
  for (std::size_t high = rows.size(); low < high;) {
    const std::size_t middle = low + (high - low) / 2;
    if (rows[middle].id < id)
      low = middle + 1;
    else
      high = middle;
  }
  return low < rows.size() && rows[low].id == id ? &rows[low] : nullptr;
}

constexpr const CommandRow* find(std::span<const CommandRow> rows, std::uint16_t code) {
  for (const CommandRow& row : rows) {
    if (row.code == code) return &row;
  }
  return nullptr;
}

constexpr bool has_unit(const ParameterRow& row, std::int8_t code) {
  for (const UnitCode& unit : row.units) {
    if (unit.code == code) return true;
  }
  return row.units.empty();
}

constexpr bool well_formed(const ParameterRow& row) {
  const bool range = row.type == WireType::kText || row.range.minimum <= row.range.maximum;
  const bool factory = row.access == Access::kWriteOnly || row.type == WireType::kText ||
                       !row.fields.empty() ||
                       (row.range.contains(row.factory.value) && has_unit(row, row.factory.unit));
  return !row.name.empty() && !row.source.empty() && !row.doc.empty() && row.count > 0 && range &&
         factory;
}

constexpr bool well_formed(std::span<const CommandRow> rows, std::size_t longest) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const CommandRow& row = rows[i];
    if (row.name.empty() || row.source.empty() || row.doc.empty()) return false;
    if (i > 0 && rows[i - 1].code >= row.code) return false;
    if (width(row.request) > longest || width(row.reply) > longest) return false;
  }
  return true;
}

/// Rows sorted by id, none twice, each with a name, a source, a range that holds its factory value.
/// Linear: a quadratic check meets g++'s limit of constexpr operations at some 600 rows.
constexpr bool well_formed(const ProtocolTable& table) {
  for (std::size_t i = 0; i < table.parameters.size(); ++i) {
    if (!well_formed(table.parameters[i])) return false;
    if (i > 0 && table.parameters[i - 1].id >= table.parameters[i].id) return false;
  }
  for (const Framing& other : table.other_framings) {
    if (other.name.empty() || other.longest == 0) return false;
  }
  return !table.name.empty() && table.framing.longest > 0 &&
         well_formed(table.commands, table.framing.longest) &&
         well_formed(table.functions, table.framing.longest);
}

}  // namespace virtdrive::protocol
