// Positions wrap as 32-bit registers do.
#pragma once

#include <algorithm>
#include <cstdint>

namespace virtdrive::rzt1 {

constexpr std::int32_t sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

constexpr std::int32_t difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

/// A parameter that is 16 bits wide on the wire and no less than 0.
constexpr std::int64_t word(std::int32_t parameter) {
  return std::clamp(parameter, 0, 0xFFFF);
}

/// 0 .. modulus - 1; modulus > 0.
constexpr std::int32_t within(std::int32_t counts, std::int32_t modulus) {
  const std::int32_t rest = counts % modulus;
  return rest < 0 ? rest + modulus : rest;
}

}  // namespace virtdrive::rzt1
