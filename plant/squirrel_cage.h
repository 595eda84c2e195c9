// The rotor of an induction machine: what AxisModel adds to a stator winding for it.
//
//   v     = Rs i_s + Lls di_s/dt + dpsi_m/dt               all in the stator's frame
//   0     = Rr i_r + Llr di_r/dt + dpsi_m/dt - j we psi_r   psi_r = psi_m + Llr i_r
//   i_s + i_r = i_m(psi_m) = (1 + (|psi_m| / psi_sat)^S) / Lm psi_m
//   torque = 1.5 p (psi_m x i_s)
//
// (The T circuit, rotor quantities referred to the stator; P. Krause, "Analysis of Electric
// Machinery", chapter 6. Main flux saturation as a state: J. E. Brown, K. P. Kovacs, P. Vas, IEEE
// TPAS 1983, 10.1109/TPAS.1983.318085.)
//
// With i_s and psi_m as states nothing has to be solved for: seen from the terminals the machine is
// an EMF behind an inductance, like any other, and the rest follows from what flows.
#pragma once

#include "plant/transforms.h"

namespace virtdrive {

struct CageParameters {
  double rotor_resistance_ohm = 0;       // per phase, referred to the stator, > 0
  double stator_leakage_h = 0;           // > 0
  double rotor_leakage_h = 0;            // > 0
  double main_inductance_h = 0;          // unsaturated, > 0
  double saturation_flux_wb = 0;         // main flux that halves it; 0: does not saturate
  int saturation_exponent = 6;           // S: even, 2..20
  double rotor_resistance_per_k = 4e-3;  // aluminium
};

/// Throws SetupError unless every value is in its range.
void validate(const CageParameters& cage);

class SquirrelCage {
 public:
  explicit SquirrelCage(const CageParameters& parameters);

  /// What the stator sees at a state.
  struct Point {
    Dq emf_v;           // dpsi_m/dt while the stator's current is held
    double dd, dq, qq;  // inverse of the inductance behind it, symmetric
    Dq rotor_current_a;
  };
  /// `speed_radps` is electrical.
  Point at(Dq current_a, Dq main_flux_wb, double speed_radps) const;

  /// i_m(psi_m).
  Dq magnetizing_current_a(Dq main_flux_wb) const {
    const double g = conductance(square(main_flux_wb));
    return {g * main_flux_wb.d, g * main_flux_wb.q};
  }
  Dq rotor_flux_wb(Dq current_a, Dq main_flux_wb) const;
  /// The main flux with another stator current, while the rotor's flux stays what it is.
  Dq main_flux_wb(Dq rotor_flux_wb, Dq current_a) const;
  /// Energy in the iron and the leakage paths, J.
  double field_energy_j(Dq current_a, Dq main_flux_wb) const;

  void set_temperature(double degc, double reference_degc) {
    rotor_resistance_ohm_ = parameters.rotor_resistance_ohm *
                            (1 + parameters.rotor_resistance_per_k * (degc - reference_degc));
  }
  double rotor_resistance_ohm() const { return rotor_resistance_ohm_; }
  /// Seen from the terminals, unsaturated.
  double transient_inductance_h() const;
  /// A main flux below this is none.
  double no_flux_wb() const { return no_flux_wb_; }

  CageParameters parameters;

 private:
  static double square(Dq x) { return x.d * x.d + x.q * x.q; }
  double saturation(double flux2) const;
  double conductance(double flux2) const { return (1 + saturation(flux2)) * inverse_main_; }

  double rotor_resistance_ohm_;
  double inverse_main_, inverse_saturation2_ = 0, inverse_leakage_, leakage_ratio_;
  double no_flux_wb_;
};

inline double SquirrelCage::saturation(double flux2) const {
  if (inverse_saturation2_ == 0) return 0;
  const double base = flux2 * inverse_saturation2_;
  double product = 1;
  for (int i = parameters.saturation_exponent; i > 0; i -= 2) product *= base;
  return product;
}

inline SquirrelCage::Point SquirrelCage::at(Dq i, Dq psi, double w) const {
  const CageParameters& p = parameters;
  const double flux2 = square(psi), u = saturation(flux2);
  // di_m/dpsi_m has one value along psi_m and one across it.
  const double across = (1 + u) * inverse_main_;
  const double along = across + p.saturation_exponent * u * inverse_main_;
  const double open_across = 1 + p.rotor_leakage_h * across;
  const double open_along = 1 + p.rotor_leakage_h * along;
  const Dq rotor{across * psi.d - i.d, across * psi.q - i.q};
  const Dq rotor_flux{psi.d + p.rotor_leakage_h * rotor.d, psi.q + p.rotor_leakage_h * rotor.q};
  const Dq drive{-rotor_resistance_ohm_ * rotor.d - w * rotor_flux.q,
                 -rotor_resistance_ohm_ * rotor.q + w * rotor_flux.d};
  // Open stator: (1 + Llr di_m/dpsi_m) dpsi_m/dt = drive.
  const double e = 1 / open_across;
  const double inductance_across = inverse_leakage_ * open_across / (open_across + leakage_ratio_);
  if (u == 0) {
    return {{e * drive.d, e * drive.q}, inductance_across, 0, inductance_across, rotor};
  }
  const double inductance_along = inverse_leakage_ * open_along / (open_along + leakage_ratio_);
  const double per_flux2 = 1 / flux2;
  const double e_beyond = (1 / open_along - e) * per_flux2 * (psi.d * drive.d + psi.q * drive.q);
  const double beyond = (inductance_along - inductance_across) * per_flux2;
  return {{e * drive.d + e_beyond * psi.d, e * drive.q + e_beyond * psi.q},
          inductance_across + beyond * psi.d * psi.d,
          beyond * psi.d * psi.q,
          inductance_across + beyond * psi.q * psi.q,
          rotor};
}

}  // namespace virtdrive
