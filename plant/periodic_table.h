// A periodic function by its samples: an EMF's shape, a cogging torque.
#pragma once

#include <algorithm>
#include <array>
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
    if (values_.empty()) return 0;
    const Place p = place(periods);
    return value(p.left, p.between);
  }
  /// At a position, a third of a period before it and two thirds: the phases of a winding, whose
  /// table is not empty and has a multiple of 3 samples.
  std::array<double, 3> at_thirds(double periods) const {
    const Place p = place(periods);
    const int third = size() / 3;
    return {value(p.left, p.between), value(within(p.left - third), p.between),
            value(within(p.left - 2 * third), p.between)};
  }

 private:
  struct Place {
    int left;  // the sample before
    double between;
  };

  int size() const { return static_cast<int>(values_.size()); }
  int within(int i) const { return i < 0 ? i + size() : i < size() ? i : i - size(); }
  double sample(int i) const { return values_[static_cast<std::size_t>(within(i))]; }
  Place place(double periods) const {
    const double place = (periods - std::floor(periods)) * size();
    const int left = std::min(static_cast<int>(place), size() - 1);
    return {left, place - left};
  }
  double value(int left, double t) const {
    const double a = sample(left), b = sample(left + 1);
    if (interpolation_ == Interpolation::kLinear) return a + t * (b - a);
    const double slope_a = (b - sample(left - 1)) / 2, slope_b = (sample(left + 2) - a) / 2;
    const double d = b - a;
    return a +
           t * (slope_a + t * (3 * d - 2 * slope_a - slope_b + t * (slope_a + slope_b - 2 * d)));
  }

  std::vector<double> values_;
  Interpolation interpolation_ = Interpolation::kCubic;
};

}  // namespace virtdrive
