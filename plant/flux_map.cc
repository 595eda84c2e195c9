// FluxMap of plant/machine.h.
#include <algorithm>

#include "core/check.h"
#include "plant/machine.h"

namespace virtdrive {
namespace {

/// One axis of a bicubic interpolation: four neighbours with weights of their values in the value
/// and in the slope. Outside of the grid the edge's tangent goes on.
struct Weights {
  std::array<std::size_t, 4> index{};
  std::array<double, 4> value{}, slope{};
};

Weights weights_at(const std::vector<double>& axis, double x) {
  const double inside = std::clamp(x, axis.front(), axis.back());
  const auto above = std::upper_bound(axis.begin(), axis.end(), inside) - axis.begin();
  const auto last = static_cast<std::ptrdiff_t>(axis.size()) - 1;
  const auto k = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above - 1, 0, last - 1));
  const double h = axis[k + 1] - axis[k];
  const double t = (inside - axis[k]) / h;
  // Hermite basis and its derivative.
  const double h00 = (1 + 2 * t) * (1 - t) * (1 - t), h10 = t * (1 - t) * (1 - t);
  const double h01 = t * t * (3 - 2 * t), h11 = t * t * (t - 1);
  const double s00 = 6 * t * (t - 1), s10 = (1 - t) * (1 - 3 * t), s11 = t * (3 * t - 2);
  Weights w;
  const std::size_t before = k == 0 ? 0 : k - 1;
  const std::size_t after = std::min(k + 2, axis.size() - 1);
  w.index = {before, k, k + 1, after};
  // Slopes at the two inner points by differences over their neighbours (one-sided at the edge).
  const double left = 1 / (axis[k + 1] - axis[before]), right = 1 / (axis[after] - axis[k]);
  const auto fill = [&](std::array<double, 4>& to, double f0, double m0, double f1, double m1,
                        double scale) {
    to = {-m0 * h * left * scale, (f0 - m1 * h * right) * scale, (f1 + m0 * h * left) * scale,
          m1 * h * right * scale};
  };
  fill(w.value, h00, h10, h01, h11, 1);
  fill(w.slope, s00, s10, -s00, s11, 1 / h);
  for (std::size_t i = 0; i < 4; ++i) w.value[i] += (x - inside) * w.slope[i];
  return w;
}

}  // namespace

FluxMap::FluxMap(std::vector<double> current_d_a, std::vector<double> current_q_a,
                 std::vector<double> flux_d_wb, std::vector<double> flux_q_wb)
    : current_d_(std::move(current_d_a)),
      current_q_(std::move(current_q_a)),
      flux_d_(std::move(flux_d_wb)),
      flux_q_(std::move(flux_q_wb)) {
  const auto check_axis = [](const std::vector<double>& axis, const char* name) {
    if (axis.size() < 4) {
      throw SetupError(
          fmt::format("flux map: {} needs 4 or more points, not {}", name, axis.size()));
    }
    for (std::size_t i = 1; i < axis.size(); ++i) {
      if (!(axis[i] > axis[i - 1])) {
        throw SetupError(fmt::format("flux map: {} must ascend, {} follows {} at point {}", name,
                                     axis[i], axis[i - 1], i + 1));
      }
    }
  };
  check_axis(current_d_, "current_d_a");
  check_axis(current_q_, "current_q_a");
  const std::size_t size = current_d_.size() * current_q_.size();
  if (flux_d_.size() != size || flux_q_.size() != size) {
    throw SetupError(
        fmt::format("flux map: {} currents d by {} currents q need {} values of each "
                    "flux, not {} and {}",
                    current_d_.size(), current_q_.size(), size, flux_d_.size(), flux_q_.size()));
  }
  for (const double d : current_d_) {
    for (const double q : current_q_) {
      const Point p = at({d, q});
      if (p.dd > 0 && p.qq > 0 && p.dd * p.qq > p.dq * p.qd) continue;
      throw SetupError(
          fmt::format("flux map: not monotonic at i_d = {} A, i_q = {} A (incremental inductances "
                      "{:.3g}, {:.3g}, mutual {:.3g}, {:.3g} H): flux must grow with its current",
                      d, q, p.dd, p.qq, p.dq, p.qd));
    }
  }
}

FluxMap::Point FluxMap::at(Dq current_a) const {
  const Weights d = weights_at(current_d_, current_a.d), q = weights_at(current_q_, current_a.q);
  Point p{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t row = d.index[i] * current_q_.size();
    for (std::size_t k = 0; k < 4; ++k) {
      const double flux_d = flux_d_[row + q.index[k]], flux_q = flux_q_[row + q.index[k]];
      const double value = d.value[i] * q.value[k];
      const double by_d = d.slope[i] * q.value[k], by_q = d.value[i] * q.slope[k];
      p.flux_wb.d += value * flux_d;
      p.flux_wb.q += value * flux_q;
      p.dd += by_d * flux_d;
      p.dq += by_q * flux_d;
      p.qd += by_d * flux_q;
      p.qq += by_q * flux_q;
    }
  }
  return p;
}

}  // namespace virtdrive
