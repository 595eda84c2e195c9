#include "firmware_models/toshiba_mcu/power_board.h"

#include <fmt/format.h>

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kTick = 1ms;
constexpr SimDuration kSlowTask = 100ms;
constexpr int kSlowTasksPerSecond = 10;

// The board as it is built, whatever the parameters take it for: M37Sigma, 316 mV/A and 91 mV/V
// on a 12-bit converter of 5 V. Zero error and noise of the amplifiers: assumed, about two counts
// and a half count.
constexpr Adc kAdc{.bits = 12, .reference_v = 5.0};
constexpr double kCurrentSensitivity = 0.316;  // V/A
constexpr double kVoltageSensitivity = 0.091;  // V/V
constexpr double kZeroErrorA = 0.008;
constexpr double kNoiseA = 0.002;

SimTime next_multiple(SimTime now, SimDuration period) {
  return SimTime{(now.time_since_epoch() / period + 1) * period};
}

}  // namespace

PowerBoard::PowerBoard(EventLoop& loop, Axis& axis, const Seed& seed, std::string_view name)
    : loop_(loop),
      axis_(axis),
      channel_(kFactorySettings),
      bus_sensor_{.adc = kAdc, .volts_per_volt = kVoltageSensitivity},
      noise_(seed.stream(fmt::format("{}.adc", name))),
      pwm_(loop.add(Phase::kControl, [this] { pwm_interrupt(); })),
      tick_(loop.add(Phase::kControl, [this] { millisecond(); })),
      slow_(loop.add(Phase::kControl, [this] { slow_tasks(); })) {
  for (CurrentSensor& sensor : current_sensors_) {
    sensor = {.adc = kAdc,
              .volts_per_amp = kCurrentSensitivity,
              .offset_a = kZeroErrorA * (2 * noise_.uniform() - 1),
              .noise_a = kNoiseA};
  }
  slow_.at(next_multiple(loop.now(), kSlowTask));
}

Outcome PowerBoard::start() {
  const Outcome outcome = channel_.start();
  follow();
  return outcome;
}

Outcome PowerBoard::start_torque_control() {
  const Outcome outcome = channel_.start_torque_control();
  follow();
  return outcome;
}

Outcome PowerBoard::stop() {
  const Outcome outcome = channel_.stop();
  follow();
  return outcome;
}

void PowerBoard::set_speed_rpm(std::int32_t rpm) {
  channel_.set_speed_rpm(rpm);
}

void PowerBoard::set_settings(const ChannelSettings& settings) {
  channel_.set_settings(settings);
  follow();
}

double PowerBoard::bus_v() {
  return read_converters().bus_counts * channel_.scaling().bus_v_per_count;
}

AdcReading PowerBoard::read_converters() {
  axis_.advance_to(loop_.now());
  const PhaseValues currents = axis_.phase_currents_a();
  AdcReading reading;
  for (std::size_t i = 0; i < 3; ++i) {
    reading.current_counts[i] = current_sensors_[i].counts(currents[i], noise_);
  }
  reading.bus_counts = bus_sensor_.counts(axis_.state().bus_v, noise_);
  return reading;
}

void PowerBoard::load_registers() {
  axis_.advance_to(loop_.now());
  axis_.set_bridge(channel_.output());
  loaded_ = channel_.output().mode;
}

void PowerBoard::pwm_interrupt() {
  if (channel_.output().mode == Bridge::kDriven) load_registers();
  channel_.pwm_interrupt(read_converters());
  follow();
}

void PowerBoard::millisecond() {
  channel_.millisecond(read_converters());
  follow();
}

void PowerBoard::slow_tasks() {
  channel_.poll();
  if (++polls_ == kSlowTasksPerSecond) {
    polls_ = 0;
    channel_.temperature_check(temperature_degc_);
  }
  follow();
  slow_.at(loop_.now() + kSlowTask);
}

// After each call of the program: gates that it switched off or shorted act at once, and interrupts
// come as long as it needs them.
void PowerBoard::follow() {
  const Bridge wanted = channel_.output().mode;
  if (wanted != Bridge::kDriven && wanted != loaded_) load_registers();

  const SimDuration period = channel_.scaling().pwm_period;
  if (!channel_.pwm_active() || period <= SimDuration{})
    pwm_.cancel();
  else if (pwm_.due() == kNever)
    pwm_.at(loop_.now() + period);

  const bool idle = channel_.stage() == Stage::kStop || channel_.stage() == Stage::kEmergency;
  if (idle)
    tick_.cancel();
  else if (tick_.due() == kNever)
    tick_.at(next_multiple(loop_.now(), kTick));
}

}  // namespace virtdrive::toshiba_mcu
