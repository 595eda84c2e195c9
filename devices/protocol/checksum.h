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

/// Modbus over Serial Line V1.02, 6.2.2; goes low byte first.
constexpr std::uint16_t crc16_modbus(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace virtdrive::protocol
