// Payload bytes <-> numbers, by the fields of a table's row.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/check.h"
#include "devices/protocol/table.h"

namespace virtdrive::protocol {

/// A payload's numbers in wire order, groups counted out. At most kMaximum: the longest payload of
/// the four protocols holds 50.
class Values {
 public:
  static constexpr std::size_t kMaximum = 64;

  Values() = default;
  Values(std::initializer_list<std::int64_t> list) {
    for (const std::int64_t v : list) push(v);
  }

  std::size_t size() const { return size_; }
  std::int64_t operator[](std::size_t i) const {
    VIRTDRIVE_CHECK(i < size_, "value {} of {}", i, size_);
    return data_[i];
  }
  void push(std::int64_t v) {
    VIRTDRIVE_CHECK(size_ < kMaximum, "more than {} values", kMaximum);
    data_[size_++] = v;
  }
  /// Fills up with zeros to what the fields hold: dummies and unused slots are zero.
  void pad(std::span<const Field> fields) {
    while (size_ < values(fields)) push(0);
  }

  friend bool operator==(const Values& a, const Values& b) {
    return std::equal(a.data_.begin(), a.data_.begin() + a.size_, b.data_.begin(),
                      b.data_.begin() + b.size_);
  }

 private:
  std::array<std::int64_t, kMaximum> data_{};
  std::size_t size_ = 0;
};

/// One number to or from the wire. `bytes` holds exactly width(type).
void store(std::span<std::uint8_t> bytes, WireType type, ByteOrder order, std::int64_t value);
std::int64_t load(std::span<const std::uint8_t> bytes, WireType type, ByteOrder order);

/// Appends the values as the fields lay them out. Values beyond a field's width lose their upper
/// bits, as in the drive's own structures.
void pack(std::span<const Field> fields, ByteOrder order, const Values& values,
          std::vector<std::uint8_t>& out);

/// `bytes` holds exactly width(fields).
Values unpack(std::span<const Field> fields, ByteOrder order, std::span<const std::uint8_t> bytes);

/// As unpack, but `bytes` may hold more (left alone) or lack optional fields (zero); nothing if it
/// lacks others.
std::optional<Values> unpack_some(std::span<const Field> fields, ByteOrder order,
                                  std::span<const std::uint8_t> bytes);

/// The fields of a parameter's value.
std::vector<Field> value_fields(const ParameterRow& row);
/// `fields` with `value` in the place of kParameter.
std::vector<Field> with_value(std::span<const Field> fields, std::span<const Field> value);
/// The fields whose bits are set, the first field's being bit 0. Bits without a field do not count.
std::vector<Field> masked(std::span<const Field> fields, std::int64_t mask);

/// "motor_nr=1 id=0xE5 ..." for traces: numbers in the fields' units. Fields behind the last value,
/// which a sender left out, are not told.
std::string describe(std::span<const Field> fields, const Values& values);

}  // namespace virtdrive::protocol
