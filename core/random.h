// Chance, repeatable: one seed per simulation, split by name into one stream per consumer.
//
// A consumer that draws more or less does not move the others. The distributions are our own
// because the standard ones differ from library to library, and a seed must give the same bits
// everywhere.
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace virtdrive {

class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t bits() { return engine_(); }
  /// Uniform in [0, 1).
  double uniform();
  /// Mean 0, deviation 1, bell-shaped and within +-3.47: the sum of four uniform numbers. For noise
  /// of sensors that is as good as a normal distribution, and ten times cheaper.
  double bell();

 private:
  std::mt19937_64 engine_;
};

class Seed {
 public:
  explicit Seed(std::uint64_t value) : value_(value) {}

  std::uint64_t value() const { return value_; }
  /// The stream of a consumer, e.g. "motor0.current_adc".
  RandomStream stream(std::string_view consumer) const;
  /// A seed of its own for one of several equals, e.g. "left"; "" is this seed.
  Seed scope(std::string_view name) const;

 private:
  std::uint64_t value_;
};

}  // namespace virtdrive
