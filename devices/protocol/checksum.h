// Sums that more than one protocol ends its frames with.
#pragma once

#include <cstdint>
#include <span>

namespace virtdrive::protocol {

/// Low byte of the sum.
constexpr std::uint8_t sum8(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return static_cast<std::uint8_t>(sum);
}

/// The byte that makes the sum zero.
constexpr std::uint8_t negated_sum8(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint8_t>(0U - sum8(bytes));
}

}  // namespace virtdrive::protocol
