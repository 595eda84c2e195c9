// What joins a table's rows to what stands behind them, checked at compile time: a row that claims
// support and has nothing behind it does not compile, nor does a binding without a row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "devices/protocol/table.h"

namespace virtdrive::protocol {

template <class Target>
struct Binding {
  std::uint16_t id;
  Target target;
};

constexpr std::uint16_t id_of(const CommandRow& row) {
  return row.code;
}
constexpr std::uint16_t id_of(const ParameterRow& row) {
  return row.id;
}

/// True if the bindings, sorted by id, are exactly the rows that are not rejected. One pass.
template <class Row, class Target, std::size_t N>
consteval bool covers(std::span<const Row> rows, const std::array<Binding<Target>, N>& bindings) {
  std::size_t b = 0;
  for (const Row& row : rows) {
    if (row.support == Support::kRejected) continue;
    if (b == N || bindings[b].id != id_of(row)) return false;
    ++b;
  }
  return b == N;
}

/// The binding of an id; null if there is none.
template <class Target, std::size_t N>
constexpr const Target* find(const std::array<Binding<Target>, N>& bindings, std::uint16_t id) {
  for (const Binding<Target>& binding : bindings) {
    if (binding.id == id) return &binding.target;
  }
  return nullptr;
}

/// Why a drive refuses to read or write a parameter; each protocol maps these to its own error
/// codes.
enum class Refusal : std::uint8_t {
  kNone,
  kUnknown,  // no such row, or a rejected one
  kReadOnly,
  kWriteOnly,
  kOutOfRange,
  kUnit,  // a unit code that the row does not list
};

constexpr Refusal check_read(const ParameterRow* row) {
  if (row == nullptr || row->support == Support::kRejected) return Refusal::kUnknown;
  return row->access == Access::kWriteOnly ? Refusal::kWriteOnly : Refusal::kNone;
}

constexpr Refusal check_write(const ParameterRow* row, std::int64_t value, std::int8_t unit = 0) {
  if (row == nullptr || row->support == Support::kRejected) return Refusal::kUnknown;
  if (row->access == Access::kReadOnly) return Refusal::kReadOnly;
  if (!has_unit(*row, unit)) return Refusal::kUnit;
  if (row->type != WireType::kText && !row->range.contains(value)) return Refusal::kOutOfRange;
  return Refusal::kNone;
}

}  // namespace virtdrive::protocol
