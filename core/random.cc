#include "core/random.h"

#include <numbers>

namespace virtdrive {

double RandomStream::uniform() {
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double RandomStream::bell() {
  const std::uint64_t four = bits();
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += static_cast<double>(four >> (16 * i) & 0xFFFF);
  // Four numbers 0 ... 65535: mean 2 * 65535, variance 4 * (65536^2 - 1) / 12.
  constexpr double kMean = 2 * 65535.0;
  constexpr double kInverseDeviation = std::numbers::sqrt3 / 65536;
  return (sum - kMean) * kInverseDeviation;
}

namespace {

std::uint64_t mix(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash ^ (seed * 0x9e3779b97f4a7c15);
}

}  // namespace

RandomStream Seed::stream(std::string_view consumer) const {
  return RandomStream{mix(value_, consumer)};
}

Seed Seed::scope(std::string_view name) const {
  return name.empty() ? *this : Seed{mix(value_, name)};
}

}  // namespace virtdrive
