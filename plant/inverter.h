// A three-phase two-level bridge, averaged over the PWM period, with its body diodes.
//
//   kDriven  a phase's terminal is at e * Vbus, e = duty - (dead time / period) * sign(i)
//   kShort   all low sides on: the terminals are at 0 (for a share of each period, then gates off)
//   kOff     gates off: the currents freewheel through the body diodes until they are 0
//
// Dead time: after each edge both switches are off and the current chooses a diode; over a period
// that takes Vbus * dead_time / period from a positive current and adds it to a negative one. The
// sign is taken at the start of each PWM period and held, so that it is an input like the duty and
// never a discontinuity for the integrator. Around zero it is softened linearly within the current
// that the term itself moves in one period (Vbus * dead_time / L): held for a period, a bare sign
// would overshoot zero and chatter. A phase that does not switch (duty 0 or 1) has no dead time.
#pragma once

#include <array>
#include <cstdint>

#include "core/sim_time.h"
#include "plant/transforms.h"

namespace virtdrive {

enum class Bridge : std::uint8_t { kOff, kShort, kDriven };

struct BridgeCommand {
  Bridge mode = Bridge::kOff;
  PhaseValues duty{};         // kDriven: share of the period the high side is on, 0..1
  double short_share = 1;     // kShort: share of each period with all low sides on, 0..1
  SimDuration pwm_period{0};  // > 0 where it matters: with dead time or a short_share below 1
  SimDuration dead_time{0};   // kDriven: 0 .. below pwm_period
};

/// The averaged share of Vbus at each phase terminal, dead time included. Currents in A, into the
/// motor; `inductance_h` the smaller of Ld and Lq.
PhaseValues effective_duty(const BridgeCommand& command, const PhaseValues& current_a, double bus_v,
                           double inductance_h);

enum class Diode : std::uint8_t { kBlocked, kUpper, kLower };

/// Which body diode each phase conducts through while the gates are off. A positive current (into
/// the motor) comes from the lower rail, a negative one goes into the upper rail.
///
/// The state is persistent: a phase blocks only when its current reaches 0, and a blocked phase
/// stays blocked until the gates go off anew. So the sequence is three phases, two in series, none,
/// and it cannot cycle. Limit: an EMF that would turn a diode on again (above a third of the bus
/// while two phases conduct, above Vbus between lines when none does: rectification into the bus)
/// is not modelled here.
class BodyDiodes {
 public:
  /// A current up to this is none (A).
  static constexpr double kZeroCurrentA = 1e-6;

  /// The gates go off with these currents.
  void take_over(const PhaseValues& current_a);
  void block(int phase);

  Diode operator[](int phase) const { return diodes_[static_cast<std::size_t>(phase)]; }
  int conducting() const;
  /// The one blocked phase while the two others conduct in series, else -1.
  int floating() const;
  /// 1 for a phase at the upper rail, else 0.
  PhaseValues upper() const;

 private:
  std::array<Diode, 3> diodes_{};
};

}  // namespace virtdrive
