#include "core/random.h"

#include <cmath>
#include <numbers>

namespace virtdrive {

double RandomStream::uniform() {
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double RandomStream::normal() {
  // Box and Muller, "A note on the generation of random normal deviates", 1958.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

RandomStream Seed::stream(std::string_view consumer) const {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : consumer) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return RandomStream{hash ^ (value_ * 0x9e3779b97f4a7c15)};
}

}  // namespace virtdrive
