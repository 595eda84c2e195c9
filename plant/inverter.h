// What a three-phase two-level bridge is told to do, what it loses, and what can break in it.
//
//   kDriven  each leg as `legs` says: at its duty, high, low, or with its gates off (Hi-Z)
//   kShort   all low sides on (for a share of each period, then gates off)
//   kOff     all gates off: the currents go on through the body diodes
//
// So six-step with a floating phase is {.mode = kDriven, .duty = {0.6}, .legs = {kDuty, kLow,
// kHiZ}}. A leg that drives has its terminal at e * Vbus, e = duty - (dead time / period) * sign(i)
// (averaged), or switches within each period (`InverterParameters::switched`): centre-aligned, the
// high side on for `duty` of the period around its middle, both off for the dead time after each
// edge. At the period's start all driven legs are low: where drives with low-side shunts sample.
//
// Dead time, averaged: after each edge both switches are off and the current chooses a diode; over
// a period that takes (Vbus + 2 Vf) * dead_time / period from a positive current and adds it to a
// negative one. The sign is taken at the start of each PWM period and held, so that it is an input
// like the duty and never a discontinuity for the integrator. Around zero it is softened linearly
// within the current that the term itself moves in one period (Vbus * dead_time / L): held for a
// period, a bare sign would overshoot zero and chatter. A leg whose duty is 0 or 1 has no dead
// time.
#pragma once

#include <array>
#include <cstdint>

#include "core/sim_time.h"
#include "plant/transforms.h"

namespace virtdrive {

enum class Bridge : std::uint8_t { kOff, kShort, kDriven };

/// Of a leg in Bridge::kDriven.
enum class Leg : std::uint8_t { kDuty, kHigh, kLow, kHiZ };

struct BridgeCommand {
  Bridge mode = Bridge::kOff;
  PhaseValues duty{};         // kDriven: share of the period the high side is on, 0..1
  std::array<Leg, 3> legs{};  // kDriven
  double short_share = 1;     // kShort: share of each period with all low sides on, 0..1
  SimDuration pwm_period{0};  // > 0 where it matters: dead time, short_share below 1, switched
  SimDuration dead_time{0};   // kDriven: 0 .. below pwm_period
};

struct InverterParameters {
  double on_resistance_ohm = 0;  // of a switch, and of a diode beyond its forward voltage, >= 0
  double diode_v = 0;            // forward voltage of a body diode, >= 0
  bool switched = false;         // edges as events; needs BridgeCommand::pwm_period
  double loss_share = 0;  // of link voltage times phase current (rms): drawn from the link, >= 0
};

/// Throws SetupError unless every value is in its range.
void validate(const InverterParameters& inverter);

enum class SwitchFault : std::uint8_t { kNone, kStuckOpen, kStuckClosed };

/// What is broken. The body diode of a switch that is stuck open still conducts. Two switches of a
/// leg that are both closed short the link through their resistance.
struct BridgeFaults {
  std::array<bool, 3> phase_open{};  // the wire to the motor
  int shorted_phases = 0;            // 0: none, 1: a-b, 2: b-c, 3: c-a, at the terminals, no ohms
  std::array<SwitchFault, 3> upper{}, lower{};

  bool operator==(const BridgeFaults&) const = default;
};

/// The averaged share of Vbus at each phase terminal, dead time included. Currents in A, into the
/// motor; `inductance_h` the smaller of Ld and Lq.
PhaseValues effective_duty(const BridgeCommand& command, const PhaseValues& current_a, double bus_v,
                           double inductance_h, double diode_v = 0);

}  // namespace virtdrive
