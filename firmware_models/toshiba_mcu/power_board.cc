#include "firmware_models/toshiba_mcu/power_board.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kTick = 1ms;
constexpr SimDuration kSlowTask = 100ms;
constexpr int kSlowTasksPerSecond = 10;

constexpr Adc kAdc{.bits = 12, .reference_v = 5.0};

// Vishay NTCLE100E3103JB0, which the maker's boards carry: 10 kOhm, B25/85 3977 K. The resistor
// that it divides with is assumed.
constexpr NtcSensor kThermistor{
    .adc = kAdc, .r25_ohm = 10e3, .beta_k = 3977, .fixed_ohm = 10e3, .supply_v = 5.0};
constexpr double kColdestDegc = -40;  // range of MMS_Temperature (5.1.65)
constexpr double kHottestDegc = 150;

SimTime next_multiple(SimTime now, SimDuration period) {
  return SimTime{(now.time_since_epoch() / period + 1) * period};
}

}  // namespace

PowerBoard::PowerBoard(EventLoop& loop, Axis& axis, const Seed& seed, std::string_view name,
                       const BoardHardware& hardware, std::function<void()> after_interrupt)
    : loop_(loop),
      axis_(axis),
      hardware_(hardware),
      after_interrupt_(std::move(after_interrupt)),
      channel_(kFactorySettings),
      bus_sensor_{.adc = kAdc, .volts_per_volt = hardware.bus_v_per_v},
      thermistor_(kThermistor),
      noise_(seed.stream(fmt::format("{}.adc", name))),
      pwm_(loop.add(Phase::kControl, [this] { pwm_interrupt(); })),
      tick_(loop.add(Phase::kControl, [this] { millisecond(); })),
      slow_(loop.add(Phase::kControl, [this] { slow_tasks(); })) {
  for (CurrentSensor& sensor : current_sensors_) {
    sensor = {.adc = kAdc,
              .volts_per_amp = hardware.current_v_per_a,
              .offset_a = hardware.zero_error_a * (2 * noise_.uniform() - 1),
              .noise_a = hardware.noise_a};
  }
  load_registers();
  read_encoder();
  slow_.at(next_multiple(loop.now(), kSlowTask));
}

PowerBoard::~PowerBoard() {
  axis_.advance_to(loop_.now());
  axis_.set_bridge({.mode = Bridge::kOff});
}

Outcome PowerBoard::start() {
  read_encoder();
  const Outcome outcome = channel_.start();
  follow();
  return outcome;
}

Outcome PowerBoard::start_torque_control() {
  read_encoder();
  const Outcome outcome = channel_.start_torque_control();
  follow();
  return outcome;
}

Outcome PowerBoard::stop() {
  const Outcome outcome = channel_.stop();
  follow();
  return outcome;
}

Outcome PowerBoard::do_turn(std::int32_t turns, std::int32_t max_rpm) {
  read_encoder();
  const Outcome outcome = channel_.do_turn(turns, max_rpm);
  follow();
  return outcome;
}

bool PowerBoard::do_linear_motion(std::uint32_t position, std::int32_t max_rpm) {
  read_encoder();
  const bool taken = channel_.do_linear_motion(position, max_rpm);
  follow();
  return taken;
}

void PowerBoard::set_speed_rpm(std::int32_t rpm) {
  channel_.set_speed_rpm(rpm);
}

void PowerBoard::set_settings(const ChannelSettings& settings) {
  read_encoder();
  channel_.set_settings(settings);
  const double gain = kCurrentGains[static_cast<std::size_t>(settings.current_gain.value)];
  for (CurrentSensor& sensor : current_sensors_) {
    sensor.volts_per_amp = hardware_.current_v_per_a * gain;
  }
  read_encoder();  // of another type, perhaps
  follow();
}

void PowerBoard::set_inputs(const BoardInputs& inputs) {
  read_encoder();
  const bool other_edges = inputs.shaft.hall != inputs_.shaft.hall;
  inputs_ = inputs;
  // A counter goes on from where it is, whichever Hall sensors it will hear from now on; a disc
  // that slips passes edges.
  counted_edges(!other_edges);
  for (std::size_t i = 0; i < 3; ++i) current_sensors_[i].fault = inputs.shunts[i];
  bus_sensor_.fault = inputs.bus_divider;
  if (!inputs.emergency || !channel_.pwm_active()) return;
  channel_.pwm_interrupt(read_inputs());  // the pin interrupts at once
  follow();
}

std::int32_t PowerBoard::encoder_count() {
  read_encoder();
  return channel_.encoder().count();
}

std::uint32_t PowerBoard::absolute_position() {
  read_encoder();
  return channel_.absolute_position();
}

std::int32_t PowerBoard::turn_number() {
  read_encoder();
  return channel_.turn_number();
}

double PowerBoard::bus_v() {
  return read_inputs().bus_counts * channel_.scaling().bus_v_per_count;
}

double PowerBoard::temperature_degc() {
  double degc = inputs_.temperature_degc;
  if (axis_.parameters().effects.thermal.winding_housing_k_per_w > 0) {
    axis_.advance_to(loop_.now());
    degc = std::max(degc, axis_.winding_degc());
  }
  thermistor_.fault = inputs_.thermistor;
  const double measured = thermistor_.temperature_degc(thermistor_.counts(degc));
  return std::clamp(measured, kColdestDegc, kHottestDegc);
}

Reading PowerBoard::read_inputs() {
  axis_.advance_to(loop_.now());
  const PhaseValues currents = axis_.leg_currents_a();
  const double bus_v = axis_.state().bus_v;
  Reading reading;
  for (std::size_t i = 0; i < 3; ++i) {
    reading.current_counts[i] = current_sensors_[i].counts(currents[i], noise_);
  }
  reading.bus_counts = bus_sensor_.counts(bus_v, noise_);
  reading.encoder_count = counted_edges();
  reading.emergency_pin = inputs_.emergency;
  reading.over_voltage_pin = bus_v > hardware_.over_voltage_pin_v;
  return reading;
}

void PowerBoard::read_encoder() {
  if (channel_.settings().encoder.value != 0) axis_.advance_to(loop_.now());
  channel_.read_encoder(counted_edges());
}

std::int64_t PowerBoard::counted_edges(bool heard) {
  const auto type = static_cast<EncoderType>(channel_.settings().encoder.value);
  const ShaftSensors& shaft = inputs_.shaft;
  if (type == EncoderType::kNone) return 0;
  counter_.see(shaft.edges(type, axis_.state().angle_rad, axis_.parameters().motor.pole_pairs),
               heard && shaft.heard(type));
  return counter_.count();
}

void PowerBoard::load_registers() {
  axis_.advance_to(loop_.now());
  axis_.set_bridge(channel_.output());
  loaded_ = channel_.output().mode;
}

void PowerBoard::pwm_interrupt() {
  if (channel_.output().mode == Bridge::kDriven) load_registers();
  channel_.pwm_interrupt(read_inputs());
  if (after_interrupt_) after_interrupt_();
  follow();
}

void PowerBoard::millisecond() {
  channel_.millisecond(read_inputs());
  follow();
}

void PowerBoard::slow_tasks() {
  channel_.poll({.adc_counts = kAdc.counts(inputs_.speed_v),
                 .pwm_high = inputs_.speed_pwm,
                 .servo_us = inputs_.speed_servo_us,
                 .reverse = inputs_.speed_reverse});
  if (++polls_ == kSlowTasksPerSecond) {
    polls_ = 0;
    channel_.temperature_check(temperature_degc());
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
