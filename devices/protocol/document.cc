#include "devices/protocol/document.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace virtdrive::protocol {
namespace {

std::string_view word(WireType type) {
  constexpr std::string_view kWords[] = {"u8", "i8", "u16", "i16", "u32", "i32", "char", "value"};
  return kWords[static_cast<std::size_t>(type)];
}

bool has_weaker_evidence(const ProtocolTable& table) {
  const auto weaker = [](const auto& row) { return row.evidence > Evidence::kAssumed; };
  return std::ranges::any_of(table.parameters, weaker) ||
         std::ranges::any_of(table.commands, weaker);
}

// A table cell must not end the cell.
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string layout(std::span<const Field> fields) {
  std::string text;
  for (const Field& field : fields) {
    if (!text.empty()) text += ", ";
    if (field.members.empty())
      text += fmt::format("{} {}", word(field.type), field.name);
    else
      text += fmt::format("{{{}}}", layout(field.members));
    if (field.count > 1) text += fmt::format("[{}]", field.count);
    if (!field.unit.empty()) text += fmt::format(" {}", field.unit);
  }
  return text.empty() ? "-" : text;
}

using Out = std::back_insert_iterator<std::string>;

void write_framing(Out out, const Framing& framing) {
  const auto hex = [](std::string_view bytes) {
    std::string text;
    for (const char c : bytes) text += fmt::format("{:02X} ", static_cast<unsigned char>(c));
    return text.empty() ? std::string("none ") : text;
  };
  constexpr std::string_view kChecksums[] = {"none",
                                             "CRC-8, polynomial 0x07",
                                             "8-bit sum",
                                             "negated 8-bit sum",
                                             "8-bit sum as two hex digits",
                                             "CRC-16 of Modbus"};
  fmt::format_to(
      out, "## Framing\n\nStart {}| end {}| checksum {} over {} | {} | longest frame {} bytes\n\n",
      hex(framing.start), hex(framing.end), kChecksums[static_cast<std::size_t>(framing.checksum)],
      framing.checksum_span.empty() ? "the frame" : framing.checksum_span,
      framing.order == ByteOrder::kLittleEndian ? "little-endian" : "big-endian", framing.longest);
}

void write_commands(Out out, std::string_view title, std::span<const CommandRow> rows) {
  if (rows.empty()) return;
  fmt::format_to(out,
                 "## {}\n\n| code | name | request | reply | support | evidence | section | |\n"
                 "|---|---|---|---|---|---|---|---|\n",
                 title);
  for (const CommandRow& row : rows) {
    fmt::format_to(out, "| {:02X} | {} | {} | {} | {} | {} | {} | {} |\n", row.code, row.name,
                   cell(layout(row.request)), cell(layout(row.reply)), word(row.support),
                   word(row.evidence), row.source, cell(row.doc));
  }
  fmt::format_to(out, "\n");
}

void write_parameters(Out out, std::span<const ParameterRow> rows) {
  if (rows.empty()) return;
  fmt::format_to(
      out,
      "## Parameters\n\n| id | name | access | range | unit | factory | support | evidence | "
      "section | |\n|---|---|---|---|---|---|---|---|---|---|\n");
  const int digits = rows.back().id > 0xFF ? 4 : 2;
  for (const ParameterRow& row : rows) {
    fmt::format_to(out, "| {:0{}X} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.id,
                   digits, row.name, word(row.access), range(row), cell(units(row)), factory(row),
                   word(row.support), word(row.evidence), row.source, cell(row.doc));
  }
  fmt::format_to(out, "\n");
}

void write_codes(Out out, std::string_view title, std::span<const CodeRow> rows) {
  if (rows.empty()) return;
  fmt::format_to(out, "## {}\n\n| code | name | evidence | |\n|---|---|---|---|\n", title);
  for (const CodeRow& row : rows) {
    fmt::format_to(out, "| {} | {} | {} | {} |\n", row.code, row.name, word(row.evidence),
                   cell(row.doc));
  }
  fmt::format_to(out, "\n");
}

}  // namespace

std::string_view word(Support support) {
  constexpr std::string_view kWords[] = {"implemented", "stored", "rejected"};
  return kWords[static_cast<std::size_t>(support)];
}

std::string_view word(Evidence evidence) {
  constexpr std::string_view kWords[] = {"documented", "observed", "assumed", "family", "recalled"};
  return kWords[static_cast<std::size_t>(evidence)];
}

std::string_view word(Access access) {
  constexpr std::string_view kWords[] = {"R/W", "R", "W"};
  return kWords[static_cast<std::size_t>(access)];
}

std::string units(const ParameterRow& row) {
  std::string text;
  for (const UnitCode& unit : row.units) {
    text += fmt::format("{}{}", text.empty() ? "" : "|", unit.label);
  }
  if (!row.units.empty()) return text;
  return row.scale == 1 ? std::string(row.unit) : fmt::format("{} {}", row.scale, row.unit);
}

std::string range(const ParameterRow& row) {
  if (row.type == WireType::kText) return fmt::format("text, {} bytes", row.count);
  return fmt::format("{} ... {}", row.range.minimum, row.range.maximum);
}

std::string factory(const ParameterRow& row) {
  if (row.type == WireType::kText || row.access != Access::kReadWrite) return "";
  for (const UnitCode& unit : row.units) {
    if (unit.code == row.factory.unit) return fmt::format("{} {}", row.factory.value, unit.label);
  }
  return fmt::format("{}", row.factory.value);
}

std::string document(const ProtocolTable& table) {
  std::string text;
  const Out out(text);
  fmt::format_to(out, "# {}\n\n", table.title);
  fmt::format_to(
      out,
      "Made from the tables of `{}` by `./dev docs`; do not edit. Sections are those of: {}.\n\n"
      "Support: *implemented* acts; *stored* is accepted and read back without effect; "
      "*rejected* is refused. Evidence: *documented* by the maker; *observed* on real "
      "devices or in the maker's published firmware; *assumed* here because every source "
      "is silent.{}\n\n",
      table.name, table.document,
      has_weaker_evidence(table)
          ? " *family*: documented for a relative that speaks the same protocol, the section "
            "names it; *recalled*: from memory of the family, no text seen."
          : "");
  write_framing(out, table.framing);
  write_commands(out, "Commands", table.commands);
  write_commands(out, "Functions", table.functions);
  write_parameters(out, table.parameters);
  write_codes(out, "Error codes", table.errors);
  const bool bits = table.faults.empty() || table.faults.back().code < 32;
  write_codes(out, bits ? "Fault bits" : "Fault codes", table.faults);
  text.pop_back();
  return text;
}

}  // namespace virtdrive::protocol
