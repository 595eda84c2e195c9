// From a torque or voltage demand to the duty cycles of three phases (6.2), each 50 us: the current
// PIs of field-oriented control, inverse Park, space-vector modulation.
//
// Currents in AD counts, voltages +-32767: Vdc / sqrt(3) of phase peak in d and q, what the linear
// range of the modulation gives; Vdc / 3 in a bare vector. Two-level and averaged.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_models/rzt1/settings.h"
#include "plant/transforms.h"

namespace virtdrive::rzt1 {

class CurrentLoop {
 public:
  void reset();

  /// Id and Iq from two phases, the third being what is left; `rotor` at the d axis.
  void measure(const std::array<std::int32_t, 2>& current_counts, const Rotation& rotor);
  /// Two-phase motors: one current.
  void measure(std::int32_t current_counts);

  /// FOC: currents of `d` and `q` (AD counts) at `rotor`.
  void control(std::int32_t d, std::int32_t q, const Rotation& rotor, const Settings& gains);
  /// Voltages d and q at `rotor`.
  void drive(std::int32_t d, std::int32_t q, const Rotation& rotor);
  /// A vector along a direction of the stator, 32767 = Vdc / 3.
  void vector(std::int32_t amplitude, double angle_rad);
  /// A voltage of q / 32768 of the link between U and V.
  void two_phase(std::int32_t q);
  /// Duties told by the host, 32767 = 100 %.
  void host(const std::array<std::int32_t, 3>& counts);
  /// All phases at one potential: shorted.
  void brake();

  const PhaseValues& duty() const { return duty_; }
  std::int32_t duty_counts(std::size_t phase) const;
  std::int32_t id() const { return id_; }
  std::int32_t iq() const { return iq_; }
  std::int32_t id_error() const { return id_error_; }
  std::int32_t iq_error() const { return iq_error_; }
  std::int32_t vd() const { return vd_; }
  std::int32_t vq() const { return vq_; }

 private:
  void modulate(AlphaBeta share);

  std::int32_t id_ = 0, iq_ = 0;
  std::int32_t id_error_ = 0, iq_error_ = 0;
  std::int64_t d_sum_ = 0, q_sum_ = 0;
  std::int32_t vd_ = 0, vq_ = 0;
  PhaseValues duty_{1, 1, 1};
};

}  // namespace virtdrive::rzt1
