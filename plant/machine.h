// Any machine with permanent magnets or brushes, as one winding in its rotor's frame.
//
//   dpsi/dt = v - R i - we J psi - we psi_m (h - q)      psi: flux linkage, i = i(psi)
//   torque  = 1.5 p (psi x i + psi_m (h - q) . i) + cogging - iron loss / speed
//
// What differs from machine to machine is data:
//   PMSM        psi linear in i (Ld, Lq), or saturated: an analytic i(psi), or a map psi(i)
//   BLDC        h, the EMF's shape in dq, is no longer the unit vector q of a sine: a trapezoid
//   brushed DC  the commutator holds the frame still; one current, from a to b
//   voice coil  the same in a line: 1 rad stands for 1 m, 1 Nm for 1 N, 1 kg m2 for 1 kg
//   induction   no magnets; a cage (squirrel_cage.h) adds the rotor's circuit, in the stator's
//   frame
//
// The winding is a star without neutral, so only what lies in Clarke's plane can act: an EMF's
// zero-sequence part (the third harmonic of a trapezoid) drives no current between two terminals.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "plant/periodic_table.h"
#include "plant/pmsm.h"
#include "plant/squirrel_cage.h"

namespace virtdrive {

/// The EMF of phase a over one electrical turn, counted from its rise through 0 at forward
/// rotation, as a share of (electrical speed * flux_wb). A sine machine's is sin.
struct EmfShape {
  /// Empty: a sine. The number of samples is a multiple of 3, so that the phases match.
  PeriodicTable table;

  /// A trapezoid whose flat top is this wide (electrical), 0 .. below pi, height 1. 120 degrees
  /// is exact; other widths to a degree.
  static EmfShape trapezoid(double flat_rad);
  /// sum of amplitude * sin(order * angle), smooth.
  struct Harmonic {
    int order = 1;
    double amplitude = 1;
  };
  static EmfShape harmonics(const std::vector<Harmonic>& harmonics);
};

/// Saturation in closed form, with cross-saturation, as fitted to synchronous reluctance and
/// interior-magnet machines:
///
///   i_d = (d0 + dd |psi_d|^S + dq / (V + 2) |psi_d|^U |psi_q|^(V + 2)) psi_d - i_m
///   i_q = (q0 + qq |psi_q|^T + dq / (U + 2) |psi_d|^(U + 2) |psi_q|^V) psi_q
///
/// with i_m such that i_d = 0 at the magnets' flux (M. Hinkkanen et al., "Sensorless self-
/// commissioning of synchronous reluctance motors at standstill without rotor locking", IEEE TIA
/// 2017, doi 10.1109/TIA.2016.2644624). The field's energy is a function of the state.
struct AnalyticSaturation {
  double d0 = 0, dd = 0, q0 = 0, qq = 0, dq = 0;  // A/Wb, A/Wb^(S + 1), ...
  int s = 0, t = 0, u = 0, v = 0;                 // exponents, 0..10
};

/// Flux linkages tabulated over a grid of currents, as a finite-element program gives them, with
/// bicubic (Catmull-Rom) interpolation and straight continuation outside of the grid.
class FluxMap {
 public:
  /// `flux_d[i * size of q + k]` belongs to (current_d_a[i], current_q_a[k]). Throws SetupError
  /// unless the axes ascend, have 4 or more points each, and the map is monotonic: each flux grows
  /// with its own current and the incremental inductances keep a positive determinant (else the
  /// currents do not follow from the fluxes). The message names the grid point.
  FluxMap(std::vector<double> current_d_a, std::vector<double> current_q_a,
          std::vector<double> flux_d_wb, std::vector<double> flux_q_wb);

  struct Point {
    Dq flux_wb;
    double dd, dq, qd, qq;  // incremental inductances d flux / d current, H
  };
  Point at(Dq current_a) const;
  const std::vector<double>& current_d_a() const { return current_d_; }
  const std::vector<double>& current_q_a() const { return current_q_; }

 private:
  std::vector<double> current_d_, current_q_, flux_d_, flux_q_;
};

/// Two nodes: the winding heats the housing (with the magnets), the housing the ambient air.
struct ThermalParameters {
  double winding_housing_k_per_w = 0;  // 0: temperatures stay as they are
  double housing_ambient_k_per_w = 0;
  double winding_j_per_k = 0, housing_j_per_k = 0;
  double ambient_degc = 25;
  double reference_degc = 25;         // of resistance_ohm and flux_wb
  double resistance_per_k = 3.93e-3;  // copper
  double flux_per_k = 0;              // e.g. -1.2e-3 NdFeB, -2e-3 ferrite
};

/// What the linear machine with a sinusoidal EMF leaves out.
struct MachineEffects {
  EmfShape emf;
  std::shared_ptr<const AnalyticSaturation> saturation;  // instead of inductance_d_h, _q_h
  std::shared_ptr<const FluxMap> flux_map;               // instead of those and flux_wb's share
  ThermalParameters thermal;
  PeriodicTable cogging_nm;       // over a turn of the shaft
  double iron_eddy_w_per_v2 = 0;  // loss / (we |psi|)^2: the reciprocal of a resistance / 1.5
  double iron_hysteresis_w = 0;   // loss / (|we| |psi|^2), W s / Wb^2 rad: a drag like friction
  bool commutator = false;        // brushes: phase c does not exist
  std::optional<CageParameters> cage;  // an induction machine's rotor
};

/// Parameters of a brushed DC motor: terminals a and b, torque constant = EMF constant.
PmsmParameters brushed_dc(double resistance_ohm, double inductance_h, double torque_nm_per_a,
                          double rated_current_a);

/// Parameters of a BLDC as its data sheet prints them, line to line: resistance, inductance and
/// torque constant of two phases in series under the flat tops of EmfShape::trapezoid.
PmsmParameters bldc_line_to_line(int pole_pairs, double resistance_ohm, double inductance_h,
                                 double torque_nm_per_a, double rated_current_a);

/// The stator of an induction machine; its inductances are what a short circuit of the rotor leaves
/// of them.
PmsmParameters induction_stator(int pole_pairs, double resistance_ohm, const CageParameters& cage,
                                double rated_current_a);

/// Throws SetupError unless every value is in its range.
void validate(const MachineEffects& effects);

/// The winding between two events: parameters prepared for the derivative.
class Winding {
 public:
  /// The magnetic state: what the two electrical state variables stand for.
  struct Point {
    Dq current_a, flux_wb;
    double dd, dq, qd, qq;  // inverse incremental inductances d current / d flux, 1/H
  };

  /// `series_ohm`: of the switches, in each phase.
  Winding(const PmsmParameters& motor, const MachineEffects& effects, double series_ohm = 0);

  /// The state variables are currents, or with AnalyticSaturation fluxes.
  Point at(Dq state) const {
    if (kind_ != Kind::kLinear) return saturated(state);
    return {
        state,      {loop.inductance_d_h * state.d + loop.flux_wb, loop.inductance_q_h * state.q},
        inverse_d_, 0,
        0,          inverse_q_};
  }
  Dq state_rate(const Point& p, Dq flux_rate) const {
    if (kind_ == Kind::kAnalytic) return flux_rate;
    return {p.dd * flux_rate.d + p.dq * flux_rate.q, p.qd * flux_rate.d + p.qq * flux_rate.q};
  }
  /// The state that carries a current, found from a state near it.
  Dq state_with_current(Dq near, Dq current_a) const;

  /// What a shape adds to the unit EMF of a sine machine, in dq.
  Dq emf_beyond_sine(double electrical_rad, const Rotation& r) const;
  bool sinusoidal() const { return sinusoidal_; }
  /// Cogging or eddy currents act on the shaft.
  bool shaft_effects() const { return shaft_effects_; }
  void set_temperatures(double winding_degc, double magnet_degc);
  /// The least inductance of any state, for step sizes.
  double least_inductance_h() const { return least_inductance_; }
  /// Distance of corners of the EMF in rad (electrical); 0: it is smooth.
  double corner_distance_rad() const { return corner_distance_; }

  /// A linear sine machine with nothing else that acts: pmsm.h is all of it.
  bool plain() const { return plain_; }
  /// For the fast integrator: a fifth of the least electrical time constant.
  double step_limit_s() const { return step_limit_; }
  double resistance_ohm() const { return loop.resistance_ohm - series_ohm_; }
  /// Of an induction machine, else null.
  const SquirrelCage* cage() const { return cage_ ? &*cage_ : nullptr; }

  PmsmParameters motor;  // as given
  PmsmParameters loop;   // at the present temperatures, with what is in series
  MachineEffects effects;

 private:
  enum class Kind : std::uint8_t { kLinear, kAnalytic, kMap };

  Point saturated(Dq state) const;

  Kind kind_ = Kind::kLinear;
  bool sinusoidal_ = true, shaft_effects_ = false, plain_ = true;
  double series_ohm_ = 0, step_limit_ = 0;
  double inverse_d_ = 0, inverse_q_ = 0, least_inductance_ = 0, corner_distance_ = 0;
  double magnet_current_a_ = 0;  // of AnalyticSaturation
  std::optional<SquirrelCage> cage_;
};

}  // namespace virtdrive
