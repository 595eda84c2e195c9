// Overload as an integral: what a load r beyond 1.1 may last.
//
//   trips after t150 (1.5^2 - 1.1^2) / (r^2 - 1.1^2)      r > 1.1
//
// The integral runs from 0 to 1 and falls by the same law below 1.1.
#pragma once

#include <algorithm>

namespace virtdrive::asd7 {

class Overload {
 public:
  /// `t150_s`: time to the trip at r = 1.5.
  void step(double r, double t150_s, double step_s) {
    constexpr double kFree = 1.1 * 1.1, kSpan = 1.5 * 1.5 - kFree;
    level_ = std::clamp(level_ + (r * r - kFree) / (kSpan * t150_s) * step_s, 0.0, 1.0);
  }
  double level() const { return level_; }
  bool full() const { return level_ >= 1; }
  void clear() { level_ = 0; }

 private:
  double level_ = 0;
};

/// A braking resistor: the energy beyond its rating.
class ResistorOverload {
 public:
  /// Full at 10 s of its rating.
  void step(double power_w, double rating_w, double step_s) {
    if (rating_w <= 0) return;
    level_ = std::clamp(level_ + (power_w / rating_w - 1) / 10 * step_s, 0.0, 1.0);
  }
  double level() const { return level_; }
  bool full() const { return level_ >= 1; }
  void clear() { level_ = 0; }

 private:
  double level_ = 0;
};

/// A condition that has to last.
class Lasting {
 public:
  /// True once it has stood for `limit_s`.
  bool see(bool condition, double limit_s, double step_s) {
    stood_s_ = condition ? stood_s_ + step_s : 0;
    return condition && stood_s_ >= limit_s - 1e-9;
  }
  void clear() { stood_s_ = 0; }

 private:
  double stood_s_ = 0;
};

}  // namespace virtdrive::asd7
