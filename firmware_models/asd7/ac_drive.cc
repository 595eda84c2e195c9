#include "firmware_models/asd7/ac_drive.h"

#include <utility>

#include "firmware_models/asd7/drive_program.h"

namespace virtdrive::asd7 {

AcDrive::AcDrive(EventLoop& loop, Axis& axis, const Model& model, const Settings& settings,
                 const Memory& memory, const Seed& seed)
    : impl_(std::make_unique<Impl>(loop, axis, model, settings, memory, seed)) {}
AcDrive::~AcDrive() = default;

const Model& AcDrive::model() const {
  return impl_->model_;
}
bool AcDrive::alive() const {
  return impl_->alive();
}
void AcDrive::set_on_start(std::function<void()> on_start) {
  impl_->on_start_ = std::move(on_start);
}
void AcDrive::set_on_stop(std::function<void()> on_stop) {
  impl_->on_stop_ = std::move(on_stop);
}

const Settings& AcDrive::settings() const {
  return impl_->settings_;
}
void AcDrive::set_settings(const Settings& settings) {
  impl_->set_settings(settings);
}
bool AcDrive::running() const {
  return impl_->output_on() || (impl_->alive() && !impl_->tripped() && impl_->request_.run);
}
const Memory& AcDrive::memory() const {
  return impl_->memory_;
}
void AcDrive::count_eeprom_write() {
  ++impl_->memory_.eeprom_writes;
}

AcDrive::CommandResult AcDrive::set_command(std::uint16_t word) {
  return impl_->set_command(word);
}
std::uint16_t AcDrive::command() const {
  return impl_->asked_.command;
}
void AcDrive::set_command2(std::uint16_t word) {
  impl_->set_command2(word);
}
std::uint16_t AcDrive::command2() const {
  return impl_->asked_.command2;
}
void AcDrive::set_frequency(std::uint16_t frequency) {
  if (!alive()) return;
  impl_->asked_.frequency = frequency;
  impl_->asked_anew_ = true;
  impl_->wake();
}
std::uint16_t AcDrive::frequency() const {
  return impl_->asked_.frequency;
}
void AcDrive::communication_lost() {
  impl_->communication_lost();
}
void AcDrive::communication_found() {
  impl_->communication_alarm_ = false;
}

void AcDrive::press(PanelKey key) {
  impl_->press(key);
}
void AcDrive::set_panel_frequency(std::uint16_t frequency) {
  if (!alive()) return;
  impl_->asked_.panel_frequency = frequency;
  impl_->asked_anew_ = true;
  impl_->wake();
}
std::uint16_t AcDrive::panel_frequency() const {
  return impl_->asked_.panel_frequency;
}
void AcDrive::set_terminals(const Terminals& terminals) {
  impl_->set_terminals(terminals);
}
const Terminals& AcDrive::terminals() const {
  return impl_->asked_.terminals;
}

void AcDrive::set_ambient_degc(double degc) {
  impl_->heat_sink_degc_ += degc - impl_->ambient_degc_;
  impl_->ambient_degc_ = degc;
}
double AcDrive::ambient_degc() const {
  return impl_->ambient_degc_;
}
void AcDrive::inject(Trip cause) {
  impl_->inject(cause);
}
void AcDrive::eeprom_failed(Trip how) {
  impl_->trip(how);
}

Trip AcDrive::trip() const {
  return impl_->trip_;
}
std::uint16_t AcDrive::alarms() const {
  return impl_->alarms_;
}
bool AcDrive::tripped() const {
  return impl_->tripped();
}
Monitor AcDrive::monitor() const {
  return impl_->monitor();
}
Monitor AcDrive::frozen() const {
  return impl_->tripped() ? impl_->frozen_ : impl_->monitor();
}
bool AcDrive::fault_relay() const {
  return (impl_->status() & kStatusFault) != 0;
}
std::uint16_t AcDrive::run_hours() const {
  return static_cast<std::uint16_t>(impl_->memory_.run_seconds / 3600);
}
double AcDrive::bus_v() const {
  return impl_->bus_v_;
}
double AcDrive::heat_sink_degc() const {
  return impl_->heat_sink_degc_;
}
double AcDrive::output_hz() const {
  return impl_->output_hz();
}
double AcDrive::process_frequency_hz() const {
  return impl_->process_hz();
}
std::uint64_t AcDrive::ticks() const {
  return impl_->ticks_;
}

}  // namespace virtdrive::asd7
