// The plant's runs that accuracy and speed are measured on: a reference run is driven by feedback,
// its commands are recorded and replayed to whatever is measured.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "plant/axis.h"
#include "plant/motor_library.h"

namespace virtdrive {

enum class PlantMode { kAveraged, kSwitched, kSixStep, kRectifying, kShorted, kOwnEffects };

struct PlantCase {
  PlantCase(std::string_view motor_name, PlantMode of, SimDuration pwm_period)
      : motor(motor_name), mode(of), period(pwm_period) {
    const Motor m = find_motor(motor);
    const double volts = m.rating.voltage_v;
    parameters.motor = m.electrical;
    parameters.mechanics = m.mechanics;
    parameters.link = {.source_v = volts,
                       .resistance_ohm = 0.02 * volts / m.electrical.rated_current_a,
                       .capacitance_f = 1e-3};
    parameters.inverter.switched = mode == PlantMode::kSwitched || mode == PlantMode::kSixStep;
    if (mode == PlantMode::kSixStep) {
      parameters.effects.emf = EmfShape::trapezoid(2 * std::numbers::pi / 3);
    }
    if (mode == PlantMode::kOwnEffects) {
      parameters.effects = m.effects;
      if (m.kind == MachineKind::kPmsm && !m.effects.saturation) add_effects();
    }
    load.inertia_kgm2 = 5 * m.mechanics.inertia_kgm2;
    // Line EMF at the start, of the link voltage.
    const double share = mode == PlantMode::kRectifying ? 1.5 : 0.4;
    start_speed_radps =
        m.electrical.flux_wb > 0
            ? share * volts / (std::numbers::sqrt3 * m.electrical.pole_pairs * m.electrical.flux_wb)
            : share * m.rating.speed_rpm * std::numbers::pi / 30;
  }

  std::string motor;
  PlantMode mode;
  SimDuration period;  // of the PWM
  SimDuration duration = std::chrono::milliseconds(50);
  AxisParameters parameters;
  Load load;
  double start_speed_radps = 0;

  std::string mode_name() const {
    switch (mode) {
      case PlantMode::kAveraged:
        return "averaged, current steps";
      case PlantMode::kSwitched:
        return "switched, current steps";
      case PlantMode::kSixStep:
        return "six-step, switched";
      case PlantMode::kRectifying:
        return "gates off, EMF above the link";
      case PlantMode::kShorted:
        return "short brake";
      case PlantMode::kOwnEffects:
        return own_effects_name();
    }
    return "";
  }

  Axis axis(Integrator integrator, double tolerance = kDefaultTolerance) const {
    Axis a(parameters, integrator, load, tolerance);
    a.set_motion(0.1, start_speed_radps);
    return a;
  }

  /// What a controller gives for the coming period.
  BridgeCommand command(const Axis& axis, int k) const {
    const AxisParameters& p = axis.parameters();
    const AxisState& x = axis.state();
    const double electrical = p.motor.pole_pairs * x.speed_radps;
    BridgeCommand c{.mode = Bridge::kDriven, .pwm_period = period};
    if (mode == PlantMode::kRectifying) return {.mode = Bridge::kOff};
    if (mode == PlantMode::kShorted) return {.mode = Bridge::kShort};
    if (mode == PlantMode::kSixStep) return six_step(axis.electrical_angle_rad());
    const double wanted =
        (k * seconds(period) > 0.4 * seconds(duration) ? 0.2 : 0.8) * p.motor.rated_current_a;
    // A deadbeat-like loop: half of the error is driven out in a period.
    const double gain = 0.3 * p.motor.inductance_d_h / seconds(period);
    Dq v = steady_state_voltage_v(p.motor, {0, wanted}, electrical);
    v.d += gain * (0 - x.i_d_a);
    v.q += gain * (wanted - x.i_q_a);
    const double angle = p.motor.pole_pairs * (x.angle_rad + x.speed_radps * seconds(period) / 2);
    c.duty = inverse_clarke(inverse_park(v, Rotation(angle)));
    for (double& d : c.duty) d = std::clamp(d / x.bus_v + 0.5, 0.05, 0.95);
    return c;
  }

  std::vector<BridgeCommand> record() const {
    Axis reference = axis(Integrator::kDefault, 1e-10);
    std::vector<BridgeCommand> commands;
    for (int k = 0; k * period < duration; ++k) {
      commands.push_back(command(reference, k));
      reference.set_bridge(commands.back());
      reference.advance_to(reference.now() + period);
    }
    return commands;
  }

  /// Phase currents at the end of each period.
  std::vector<PhaseValues> replay(Axis& axis, const std::vector<BridgeCommand>& commands) const {
    std::vector<PhaseValues> currents;
    currents.reserve(commands.size());
    for (const BridgeCommand& c : commands) {
      axis.set_bridge(c);
      axis.advance_to(axis.now() + period);
      currents.push_back(axis.phase_currents_a());
    }
    return currents;
  }

 private:
  /// What no motor of the library has a source for: a tenth of a fifth harmonic, cogging and iron
  /// loss of a twentieth of the rated torque each.
  void add_effects() {
    const PmsmParameters& m = parameters.motor;
    const double part_nm = 0.05 * torque_nm(m, {0, m.rated_current_a});
    std::vector<double> cogging;
    constexpr int kSamples = 720, kPeriods = 24;
    for (int i = 0; i < kSamples; ++i) {
      cogging.push_back(part_nm * std::sin(2 * std::numbers::pi * kPeriods * i / kSamples));
    }
    parameters.effects.emf = EmfShape::harmonics({{1, 1}, {5, 0.1}});
    parameters.effects.cogging_nm = PeriodicTable(std::move(cogging), Interpolation::kCubic);
    parameters.effects.iron_hysteresis_w = part_nm / (m.pole_pairs * m.flux_wb * m.flux_wb);
  }
  std::string own_effects_name() const {
    const MachineEffects& e = parameters.effects;
    std::string name = "averaged, current steps";
    if (e.saturation) name += ", saturation";
    if (e.thermal.winding_housing_k_per_w > 0) name += ", warming up";
    if (e.emf.table.interpolation() == Interpolation::kLinear) name += ", trapezoidal EMF";
    if (!e.cogging_nm.empty()) name += ", 5th harmonic, cogging, iron loss";
    return name;
  }
  BridgeCommand six_step(double electrical_rad) const {
    constexpr std::size_t kPlus[] = {0, 0, 1, 1, 2, 2}, kMinus[] = {1, 2, 2, 0, 0, 1};
    const int sixth = static_cast<int>(
        std::floor((electrical_rad + std::numbers::pi / 6) / (std::numbers::pi / 3)));
    const auto s = static_cast<std::size_t>(((sixth + 2) % 6 + 6) % 6);
    BridgeCommand c{
        .mode = Bridge::kDriven, .legs = {Leg::kHiZ, Leg::kHiZ, Leg::kHiZ}, .pwm_period = period};
    c.legs[kPlus[s]] = Leg::kDuty;
    c.duty[kPlus[s]] = 0.6;
    c.legs[kMinus[s]] = Leg::kLow;
    return c;
  }
};

/// Motors from large to small electrical time constant.
inline std::vector<PlantCase> plant_cases() {
  using namespace std::chrono_literals;
  std::vector<PlantCase> cases;
  const std::pair<const char*, SimDuration> motors[] = {
      {"ipmsm-2kw", 125us}, {"db42s03", 80us}, {"ec45-flat-24v", 50us}, {"gt2215", 41600ns}};
  for (const auto& [motor, period] : motors) {
    for (const PlantMode mode : {PlantMode::kAveraged, PlantMode::kSwitched, PlantMode::kSixStep,
                                 PlantMode::kRectifying, PlantMode::kShorted}) {
      cases.emplace_back(motor, mode, period);
    }
  }
  for (const auto& [motor, period] : {std::pair<const char*, SimDuration>{"syrm-7kw", 125us},
                                      {"ec45-flat-24v", 50us},
                                      {"db42s03", 80us}}) {
    cases.emplace_back(motor, PlantMode::kOwnEffects, period);
  }
  return cases;
}

}  // namespace virtdrive
