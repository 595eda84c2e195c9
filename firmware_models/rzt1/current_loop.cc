#include "firmware_models/rzt1/current_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace virtdrive::rzt1 {
namespace {

constexpr std::int32_t kFull = 32767;
constexpr double kDutyFull = 32767;

std::int32_t clipped(std::int64_t v, std::int32_t limit) {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, -limit, limit));
}

std::int32_t rounded(double x) {
  return static_cast<std::int32_t>(x < 0 ? x - 0.5 : x + 0.5);
}

// One PI with a damping term; its integral is held within the voltage there is.
std::int64_t regulate(std::int32_t error, std::int32_t last_error, std::int64_t& sum,
                      const Settings& gains) {
  const std::int64_t qki = gains.qki;
  if (qki > 0) {
    sum = std::clamp<std::int64_t>(sum + error, -kFull / qki, kFull / qki);
  } else {
    sum = 0;
  }
  return static_cast<std::int64_t>(gains.qkp) * error + qki * sum +
         (static_cast<std::int64_t>(gains.qkd) * (error - last_error) >> 4);
}

}  // namespace

void CurrentLoop::reset() {
  d_sum_ = q_sum_ = 0;
  id_error_ = iq_error_ = 0;
  vd_ = vq_ = 0;
}

void CurrentLoop::measure(const std::array<std::int32_t, 2>& counts, const Rotation& rotor) {
  const double u = counts[0], v = counts[1];
  const Dq current = park({u, (u + 2 * v) / std::numbers::sqrt3}, rotor);
  id_ = rounded(current.d);
  iq_ = rounded(current.q);
}

void CurrentLoop::measure(std::int32_t counts) {
  id_ = 0;
  iq_ = counts;
}

void CurrentLoop::control(std::int32_t d, std::int32_t q, const Rotation& rotor,
                          const Settings& gains) {
  const std::int32_t id_error = d - id_, iq_error = q - iq_;
  const std::int32_t vd = clipped(regulate(id_error, id_error_, d_sum_, gains), kFull);
  const auto left = static_cast<std::int32_t>(
      std::sqrt(static_cast<double>(kFull) * kFull - static_cast<double>(vd) * vd));
  const std::int32_t vq = clipped(regulate(iq_error, iq_error_, q_sum_, gains), left);
  id_error_ = id_error;
  iq_error_ = iq_error;
  drive(vd, vq, rotor);
}

void CurrentLoop::drive(std::int32_t d, std::int32_t q, const Rotation& rotor) {
  vd_ = d;
  vq_ = q;
  constexpr double kScale = 1 / (kFull * std::numbers::sqrt3);
  modulate(inverse_park({d * kScale, q * kScale}, rotor));
}

void CurrentLoop::vector(std::int32_t amplitude, double angle_rad) {
  vd_ = vq_ = 0;
  const double length = amplitude / (3.0 * kFull);
  modulate({length * std::cos(angle_rad), length * std::sin(angle_rad)});
}

// Space-vector modulation: the zero sequence centres the three between the rails.
void CurrentLoop::modulate(AlphaBeta share) {
  const PhaseValues v = inverse_clarke(share);
  const auto [low, high] = std::minmax({v[0], v[1], v[2]});
  const double centre = 0.5 - (low + high) / 2;
  for (std::size_t i = 0; i < 3; ++i) duty_[i] = std::clamp(v[i] + centre, 0.0, 1.0);
}

void CurrentLoop::two_phase(std::int32_t q) {
  vd_ = 0;
  vq_ = q;
  const double half = q / 65536.0;
  duty_ = {0.5 + half, 0.5 - half, 0.5};
}

void CurrentLoop::host(const std::array<std::int32_t, 3>& counts) {
  vd_ = vq_ = 0;
  for (std::size_t i = 0; i < 3; ++i) duty_[i] = std::clamp(counts[i] / kDutyFull, 0.0, 1.0);
}

void CurrentLoop::brake() {
  vd_ = vq_ = 0;
  duty_ = {0.5, 0.5, 0.5};
}

std::int32_t CurrentLoop::duty_counts(std::size_t phase) const {
  return rounded(duty_[phase] * kDutyFull);
}

}  // namespace virtdrive::rzt1
