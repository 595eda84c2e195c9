#include "plant/axis.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "plant/circuit.h"

namespace virtdrive {

DcBus::DcBus(const DcLinkParameters& parameters, Integrator integrator, double tolerance)
    : circuit_(std::make_shared<Circuit>(parameters, integrator, tolerance)) {}

void DcBus::advance_to(SimTime t) {
  circuit_->advance_to(t);
}
SimTime DcBus::now() const {
  return circuit_->now;
}
void DcBus::set_source_voltage(double source_v) {
  circuit_->set_source(source_v, circuit_->link.on);
}
void DcBus::set_supply(bool on) {
  circuit_->set_source(circuit_->link.p.source_v, on);
}
const DcLinkParameters& DcBus::parameters() const {
  return circuit_->link.p;
}
bool DcBus::supply_on() const {
  return circuit_->link.on;
}
double DcBus::voltage_v() const {
  return circuit_->bus_v();
}
double DcBus::source_current_a() const {
  return circuit_->source_current();
}
bool DcBus::chopper_on() const {
  return circuit_->link.chopper_on;
}
double DcBus::chopper_degc() const {
  const Circuit& c = *circuit_;
  return c.link.has_chopper() ? c.x[DcLink::kChopperDegc] : c.link.p.chopper.ambient_degc;
}
void DcBus::set_mains(const MainsInput& input) {
  circuit_->set_mains(input);
}
const MainsInput& DcBus::mains() const {
  return circuit_->link.mains.input();
}
void DcBus::set_chopper(bool enabled) {
  circuit_->set_chopper(enabled);
}
bool DcBus::at_rest() const {
  return circuit_->at_rest();
}

Axis::Axis(const AxisParameters& parameters, Integrator integrator, const Load& load,
           double tolerance)
    : Axis(parameters, DcBus(parameters.link, integrator, tolerance), load) {}

Axis::Axis(const AxisParameters& parameters, const DcBus& bus, const Load& load)
    : circuit_(bus.circuit_), unit_(&circuit_->add(parameters, load)) {
  unit_->parameters.link = circuit_->link.p;
}

void Axis::advance_to(SimTime t) {
  circuit_->advance_to(t);
}
SimTime Axis::now() const {
  return circuit_->now;
}

void Axis::set_bridge(const BridgeCommand& command) {
  unit_->set_bridge(command, circuit_->now, circuit_->bus_v());
  circuit_->inputs_changed(unit_);
}
void Axis::set_bridge_faults(const BridgeFaults& faults) {
  unit_->set_bridge_faults(faults, circuit_->now, circuit_->bus_v());
  circuit_->inputs_changed(unit_);
}
void Axis::set_load(const Load& load) {
  unit_->set_load(load);
  circuit_->inputs_changed(unit_);
}
void Axis::set_torque_profile(std::vector<TorqueStep> profile) {
  unit_->set_torque_profile(std::move(profile), circuit_->now);
  circuit_->inputs_changed(unit_);
}
void Axis::set_motion(double angle_rad, double speed_radps) {
  unit_->set_motion(angle_rad, speed_radps);
  circuit_->inputs_changed(unit_);
}
void Axis::set_temperatures(double winding_degc, double magnet_degc) {
  unit_->set_temperatures(winding_degc, magnet_degc);
}
void Axis::set_source_voltage(double source_v) {
  bus().set_source_voltage(source_v);
}

const AxisState& Axis::state() const {
  const double* x = unit_->x;
  const Dq i = unit_->model.current(x);
  unit_->published = {i.d, i.q, x[AxisModel::kSpeed], x[AxisModel::kAngle], circuit_->bus_v()};
  return unit_->published;
}
const AxisParameters& Axis::parameters() const {
  unit_->parameters.link = circuit_->link.p;
  return unit_->parameters;
}
const Load& Axis::load() const {
  return unit_->load;
}
const BridgeFaults& Axis::bridge_faults() const {
  return unit_->bridges.faults();
}
PhaseValues Axis::phase_currents_a() const {
  return unit_->phase_currents();
}
PhaseValues Axis::leg_currents_a() const {
  return unit_->bridges.leg_currents_a(unit_->phase_currents(), circuit_->bus_v());
}
double Axis::link_current_a() const {
  return unit_->model.electrical(unit_->x, circuit_->bus_v()).bridge_a;
}
PhaseValues Axis::terminal_voltages_v() const {
  return unit_->bridges.terminal_voltages(
      unit_->model.terminal_voltages(unit_->x, circuit_->bus_v()), circuit_->bus_v());
}
double Axis::main_flux_wb() const {
  if (!unit_->model.winding.cage()) return 0;
  const Dq flux = unit_->model.main_flux(unit_->x);
  return std::hypot(flux.d, flux.q);
}
double Axis::torque_nm() const {
  return unit_->torque();
}
double Axis::load_torque_nm() const {
  return unit_->model.shaft.load_torque(unit_->x + AxisModel::kShaft, unit_->torque(),
                                        unit_->drag());
}
double Axis::load_speed_radps() const {
  return unit_->model.shaft.load_speed(unit_->x + AxisModel::kShaft);
}
double Axis::load_angle_rad() const {
  return unit_->model.shaft.load_angle(unit_->x + AxisModel::kShaft);
}
double Axis::winding_degc() const {
  return unit_->winding_degc();
}
double Axis::magnet_degc() const {
  return unit_->magnet_degc();
}
double Axis::source_current_a() const {
  return circuit_->source_current();
}

double Axis::electrical_angle_rad() const {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double angle = unit_->model.electrical_angle(unit_->x);
  const double within = angle - kTurn * std::floor(angle / kTurn);
  return within < kTurn ? within : 0;
}

bool Axis::at_rest() const {
  return !unit_->active && circuit_->settled;
}

AxisCounters Axis::counters() const {
  AxisCounters counters = circuit_->counters;
  counters.derivative_evaluations = circuit_->solver.derivative_evaluations();
  counters.time_events = unit_->time_events;
  return counters;
}

}  // namespace virtdrive
