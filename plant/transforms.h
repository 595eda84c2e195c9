// Space-vector transforms of a three-phase machine, amplitude-invariant: the length of a vector is
// the peak of the phase quantity. Phase a lies on the alpha axis, the d axis at the electrical
// angle from it; any zero-sequence part is dropped.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace virtdrive {

using PhaseValues = std::array<double, 3>;

struct AlphaBeta {
  double alpha = 0, beta = 0;
};

struct Dq {
  double d = 0, q = 0;
};

/// Cosine and sine of an electrical angle, computed once and used for several transforms.
struct Rotation {
  double cosine = 1, sine = 0;

  Rotation() = default;
  explicit Rotation(double angle_rad) : cosine(std::cos(angle_rad)), sine(std::sin(angle_rad)) {}
};

inline AlphaBeta clarke(const PhaseValues& abc) {
  return {(2 * abc[0] - abc[1] - abc[2]) / 3, (abc[1] - abc[2]) / std::numbers::sqrt3};
}

inline PhaseValues inverse_clarke(AlphaBeta x) {
  const double half_alpha = x.alpha / 2, beta_part = x.beta * (std::numbers::sqrt3 / 2);
  return {x.alpha, beta_part - half_alpha, -beta_part - half_alpha};
}

inline Dq park(AlphaBeta x, const Rotation& r) {
  return {x.alpha * r.cosine + x.beta * r.sine, x.beta * r.cosine - x.alpha * r.sine};
}

inline AlphaBeta inverse_park(Dq x, const Rotation& r) {
  return {x.d * r.cosine - x.q * r.sine, x.d * r.sine + x.q * r.cosine};
}

}  // namespace virtdrive
