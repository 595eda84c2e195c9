// A periodic function by its samples: an EMF's shape, a cogging torque.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace virtdrive {

enum class Interpolation : std::uint8_t {
  kLinear,  // for shapes with corners at samples: a trapezoid
  kCubic,   // for smooth ones: through all samples, continuous slope (Catmull-Rom)
};

/// Value i holds at i / size of the period. Empty: 0 everywhere.
class PeriodicTable {
 public:
  PeriodicTable() = default;
  PeriodicTable(std::vector<double> values, Interpolation interpolation)
      : values_(std::move(values)), interpolation_(interpolation) {}

  bool empty() const { return values_.empty(); }
  const std::vector<double>& values() const { return values_; }
  Interpolation interpolation() const { return interpolation_; }

  /// At a position in periods; any number of them.
  double at(double periods) const {
    const auto size = static_cast<int>(values_.size());
    if (size == 0) return 0;
    const double place = (periods - std::floor(periods)) * size;
    const int left = std::min(static_cast<int>(place), size - 1);
    const double t = place - left;
    const auto value = [&](int i) {
      const int within = i < 0 ? i + size : i < size ? i : i - size;
      return values_[static_cast<std::size_t>(within)];
    };
    const double a = value(left), b = value(left + 1);
    if (interpolation_ == Interpolation::kLinear) return a + t * (b - a);
    const double slope_a = (b - value(left - 1)) / 2, slope_b = (value(left + 2) - a) / 2;
    const double d = b - a;
    return a +
           t * (slope_a + t * (3 * d - 2 * slope_a - slope_b + t * (slope_a + slope_b - 2 * d)));
  }

 private:
  std::vector<double> values_;
  Interpolation interpolation_ = Interpolation::kCubic;
};

}  // namespace virtdrive
