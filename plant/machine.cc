#include "plant/machine.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/check.h"

namespace virtdrive {
namespace {

using std::numbers::pi;

void require(bool good, const char* what, double value) {
  if (!good) throw SetupError(fmt::format("motor: {}, not {}", what, value));
}

bool not_negative(double x) {
  return std::isfinite(x) && x >= 0;
}

void validate(const PeriodicTable& table, const char* name) {
  if (table.empty()) return;
  require(table.values().size() >= 4, name, static_cast<double>(table.values().size()));
  for (const double value : table.values()) {
    if (!std::isfinite(value)) throw SetupError(fmt::format("motor: {}, all finite", name));
  }
}

/// x^n, n >= 0.
double power(double x, int n) {
  double product = 1;
  for (; n > 0; --n) product *= x;
  return product;
}

constexpr double kCornersFromRad = 5 * pi / 180;

}  // namespace

EmfShape EmfShape::trapezoid(double flat_rad) {
  require(flat_rad >= 0 && flat_rad < pi, "trapezoid: flat_rad must be 0 .. below pi", flat_rad);
  const bool exact = std::fabs(flat_rad - 2 * pi / 3) < 1e-9;
  const int size = exact ? 12 : 360;
  std::vector<double> values(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) {
    const double angle = 2 * pi * i / size;
    const double ramp_half = (pi - flat_rad) / 2;
    const double from_zero = std::min({angle, std::fabs(angle - pi), 2 * pi - angle});
    const double height = std::min(1.0, from_zero / ramp_half);
    values[static_cast<std::size_t>(i)] = angle <= pi ? height : -height;
  }
  return {PeriodicTable(std::move(values), Interpolation::kLinear)};
}

EmfShape EmfShape::harmonics(const std::vector<Harmonic>& harmonics) {
  constexpr int kSize = 3600;
  std::vector<double> values(kSize);
  for (std::size_t i = 0; i < kSize; ++i) {
    for (const Harmonic& h : harmonics) {
      values[i] += h.amplitude * std::sin(h.order * 2 * pi * static_cast<double>(i) / kSize);
    }
  }
  return {PeriodicTable(std::move(values), Interpolation::kCubic)};
}

PmsmParameters brushed_dc(double resistance_ohm, double inductance_h, double torque_nm_per_a,
                          double rated_current_a) {
  // Phases a and b in series; the frame stands so that q points from b to a, where a current i is
  // a vector of 2 / sqrt(3) i, so 1.5 psi 2 / sqrt(3) i = K i.
  return {.pole_pairs = 1,
          .resistance_ohm = resistance_ohm / 2,
          .inductance_d_h = inductance_h / 2,
          .inductance_q_h = inductance_h / 2,
          .flux_wb = torque_nm_per_a / std::numbers::sqrt3,
          .rated_current_a = rated_current_a};
}

PmsmParameters bldc_line_to_line(int pole_pairs, double resistance_ohm, double inductance_h,
                                 double torque_nm_per_a, double rated_current_a) {
  return {.pole_pairs = pole_pairs,
          .resistance_ohm = resistance_ohm / 2,
          .inductance_d_h = inductance_h / 2,
          .inductance_q_h = inductance_h / 2,
          // Two flat tops in series: K = 2 p psi.
          .flux_wb = torque_nm_per_a / (2 * pole_pairs),
          .rated_current_a = rated_current_a};
}

PmsmParameters induction_stator(int pole_pairs, double resistance_ohm, const CageParameters& cage,
                                double rated_current_a) {
  validate(cage);
  const double inductance_h = SquirrelCage(cage).transient_inductance_h();
  return {.pole_pairs = pole_pairs,
          .resistance_ohm = resistance_ohm,
          .inductance_d_h = inductance_h,
          .inductance_q_h = inductance_h,
          .rated_current_a = rated_current_a};
}

void validate(const MachineEffects& e) {
  validate(e.emf.table, "the EMF's shape needs 4 or more samples");
  require(e.emf.table.values().size() % 3 == 0, "the EMF's shape needs a multiple of 3 samples",
          static_cast<double>(e.emf.table.values().size()));
  validate(e.cogging_nm, "cogging_nm needs 4 or more samples");
  require(not_negative(e.iron_eddy_w_per_v2), "iron_eddy_w_per_v2 must be 0 or more",
          e.iron_eddy_w_per_v2);
  require(not_negative(e.iron_hysteresis_w), "iron_hysteresis_w must be 0 or more",
          e.iron_hysteresis_w);
  if (e.saturation && e.flux_map) {
    throw SetupError("motor: saturation in closed form or as a flux map, not both");
  }
  if (e.saturation) {
    const AnalyticSaturation& a = *e.saturation;
    require(a.d0 > 0 && std::isfinite(a.d0), "saturation d0 must be above 0", a.d0);
    require(a.q0 > 0 && std::isfinite(a.q0), "saturation q0 must be above 0", a.q0);
    for (const double factor : {a.dd, a.qq, a.dq}) {
      require(not_negative(factor), "saturation dd, qq and dq must be 0 or more", factor);
    }
    for (const int exponent : {a.s, a.t, a.u, a.v}) {
      require(exponent >= 0 && exponent <= 10, "saturation exponents are 0..10", exponent);
    }
  }
  if (e.cage) validate(*e.cage);
  const ThermalParameters& t = e.thermal;
  require(not_negative(t.winding_housing_k_per_w), "winding_housing_k_per_w must be 0 or more",
          t.winding_housing_k_per_w);
  if (t.winding_housing_k_per_w > 0) {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    require(positive(t.housing_ambient_k_per_w), "housing_ambient_k_per_w must be above 0",
            t.housing_ambient_k_per_w);
    require(positive(t.winding_j_per_k), "winding_j_per_k must be above 0", t.winding_j_per_k);
    require(positive(t.housing_j_per_k), "housing_j_per_k must be above 0", t.housing_j_per_k);
  }
}

Winding::Winding(const PmsmParameters& m, const MachineEffects& e, double series_ohm)
    : motor(m), loop(m), effects(e), series_ohm_(series_ohm) {
  sinusoidal_ = e.emf.table.empty();
  shaft_effects_ = !e.cogging_nm.empty() || e.iron_eddy_w_per_v2 > 0;
  inverse_d_ = 1 / m.inductance_d_h;
  inverse_q_ = 1 / m.inductance_q_h;
  least_inductance_ = std::min(m.inductance_d_h, m.inductance_q_h);
  if (e.saturation) {
    kind_ = Kind::kAnalytic;
    const AnalyticSaturation& a = *e.saturation;
    magnet_current_a_ = (a.d0 + a.dd * power(std::fabs(m.flux_wb), a.s)) * m.flux_wb;
    const double most_a = 2 * m.rated_current_a;
    for (const Dq i : {Dq{most_a, 0}, Dq{-most_a, 0}, Dq{0, most_a}}) {
      const Point p = at(state_with_current({m.flux_wb, 0}, i));
      least_inductance_ = std::min({least_inductance_, 1 / p.dd, 1 / p.qq});
    }
  } else if (e.flux_map) {
    kind_ = Kind::kMap;
    least_inductance_ = std::numeric_limits<double>::infinity();
    for (const double d : e.flux_map->current_d_a()) {
      for (const double q : e.flux_map->current_q_a()) {
        const FluxMap::Point p = e.flux_map->at({d, q});
        least_inductance_ = std::min({least_inductance_, p.dd, p.qq});
      }
    }
  }
  if (e.cage) {
    cage_.emplace(*e.cage);
    least_inductance_ = e.cage->stator_leakage_h;
  }
  const auto samples = static_cast<double>(e.emf.table.values().size());
  if (samples > 0 && e.emf.table.interpolation() == Interpolation::kLinear &&
      2 * pi / samples > kCornersFromRad) {
    corner_distance_ = 2 * pi / samples;
  }
  plain_ = sinusoidal_ && !shaft_effects_ && kind_ == Kind::kLinear && !e.commutator && !e.cage &&
           e.iron_hysteresis_w == 0 && e.thermal.winding_housing_k_per_w == 0;
  set_temperatures(e.thermal.reference_degc, e.thermal.reference_degc);
}

Winding::Point Winding::saturated(Dq s) const {
  const double warm_wb = loop.flux_wb - motor.flux_wb;  // what the magnets gained with temperature
  if (kind_ == Kind::kMap) {
    const FluxMap::Point p = effects.flux_map->at(s);
    const double determinant = p.dd * p.qq - p.dq * p.qd;
    return {s,
            {p.flux_wb.d + warm_wb, p.flux_wb.q},
            p.qq / determinant,
            -p.dq / determinant,
            -p.qd / determinant,
            p.dd / determinant};
  }
  const AnalyticSaturation& a = *effects.saturation;
  const double d = s.d - warm_wb, abs_d = std::fabs(d), abs_q = std::fabs(s.q);
  const double d_u = power(abs_d, a.u), q_v = power(abs_q, a.v);
  const double own_d = a.dd * power(abs_d, a.s), own_q = a.qq * power(abs_q, a.t);
  const double cross_d = a.dq / (a.v + 2) * d_u * q_v * abs_q * abs_q;
  const double cross_q = a.dq / (a.u + 2) * d_u * abs_d * abs_d * q_v;
  return {{(a.d0 + own_d + cross_d) * d - magnet_current_a_, (a.q0 + own_q + cross_q) * s.q},
          s,
          a.d0 + (a.s + 1) * own_d + (a.u + 1) * cross_d,
          a.dq * d_u * q_v * d * s.q,
          a.dq * d_u * q_v * d * s.q,
          a.q0 + (a.t + 1) * own_q + (a.v + 1) * cross_q};
}

Dq Winding::state_with_current(Dq near, Dq current_a) const {
  if (kind_ != Kind::kAnalytic) return current_a;
  Dq flux = near;
  for (int trial = 0; trial < 50; ++trial) {
    const Point p = at(flux);
    const Dq rest{current_a.d - p.current_a.d, current_a.q - p.current_a.q};
    if (std::hypot(rest.d, rest.q) < 1e-12 * motor.rated_current_a) break;
    const double determinant = p.dd * p.qq - p.dq * p.qd;
    flux.d += (p.qq * rest.d - p.dq * rest.q) / determinant;
    flux.q += (p.dd * rest.q - p.qd * rest.d) / determinant;
  }
  return flux;
}

Dq Winding::emf_beyond_sine(double electrical_rad, const Rotation& r) const {
  // With the magnets' flux on phase a at angle 0, its EMF rises through 0 at -180 degrees.
  const double turns = electrical_rad / (2 * pi) + 0.5;
  const Dq shape = park(clarke(effects.emf.table.at_thirds(turns)), r);
  return {shape.d, shape.q - 1};
}

void Winding::set_temperatures(double winding_degc, double magnet_degc) {
  const ThermalParameters& t = effects.thermal;
  loop.resistance_ohm =
      motor.resistance_ohm * (1 + t.resistance_per_k * (winding_degc - t.reference_degc)) +
      series_ohm_;
  if (cage_) cage_->set_temperature(magnet_degc, t.reference_degc);
  loop.flux_wb = motor.flux_wb * (1 + t.flux_per_k * (magnet_degc - t.reference_degc));
  if (cage_) {
    // What decays fastest is the leakage's flux, by both resistances.
    step_limit_ =
        cage_->transient_inductance_h() / (loop.resistance_ohm + cage_->rotor_resistance_ohm()) / 5;
    return;
  }
  step_limit_ = loop.resistance_ohm > 0 ? least_inductance_ / loop.resistance_ohm / 5
                                        : std::numeric_limits<double>::infinity();
}

}  // namespace virtdrive
