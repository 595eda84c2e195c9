#include "firmware_models/rzt1/servo_drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/check.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kSlot = 50us;
constexpr SimDuration kForeground = 1ms;
constexpr SimDuration kEncoderStart = 150ms;  // 5.3
constexpr Adc kAdc{.bits = 12, .reference_v = 3.3};
constexpr double kBusCountsPerV = 8;
constexpr double kCountsPerDegc = 20;
constexpr double kMidScale = 2048;

// The inverter over its surroundings (assumed): 40 K at 10 A of TC, first order in 100 s.
constexpr double kWarmthK = 40, kWarmthA = 10;
constexpr double kWarmthPerMs = 1e-3 / 100;

// TIMER: 7500 counts of 150 MHz a period. What the task takes is assumed.
constexpr std::int32_t kTaskCounts = 600;
constexpr std::int32_t kAmplifierCounts = 750;
constexpr std::int32_t kServoCounts = 900;

SimTime next_multiple(SimTime now, SimDuration period) {
  return SimTime{(now.time_since_epoch() / period + 1) * period};
}

std::uint8_t input_pins(const AxisHardware& hardware, double angle) {
  const HomeSwitch& home = hardware.home_switch;
  if (home.input <= 0) return hardware.input_pins;
  const unsigned bit = 1U << (home.input - 1);
  const bool active = angle >= home.from_rad && angle < home.to_rad;
  return static_cast<std::uint8_t>(active ? hardware.input_pins | bit : hardware.input_pins & ~bit);
}

}  // namespace

ServoDrive::ServoDrive(EventLoop& loop, std::span<Axis* const> axes,
                       const std::array<Settings, kAxes>& settings, Hardware& hardware,
                       const Seed& seed, const FirmwareOptions& options)
    : loop_(loop),
      hardware_(hardware),
      options_(options),
      current_sensor_{.adc = kAdc,
                      .volts_per_amp = kAdc.reference_v / 2 / hardware.current_full_scale_a,
                      .noise_a = hardware.current_noise_a},
      bus_sensor_{.adc = kAdc,
                  .volts_per_volt = kBusCountsPerV * kAdc.reference_v / (kAdc.full_scale() + 1)},
      noise_(seed.stream("servo.adc")),
      task_(loop.add(Phase::kControl, [this] { task(); })) {
  VIRTDRIVE_CHECK(axes.size() == kAxes, "{} axes", axes.size());
  for (std::size_t i = 0; i < kAxes; ++i) {
    units_[i].plant = axes[i];
    units_[i].pole_pairs = axes[i]->parameters().motor.pole_pairs;
  }
  start(settings);
}

ServoDrive::~ServoDrive() {
  for (Unit& unit : units_) switch_off(unit);
}

void ServoDrive::restart(const std::array<Settings, kAxes>& settings) {
  start(settings);
}

void ServoDrive::start(const std::array<Settings, kAxes>& settings) {
  recorder_ = {};
  outputs_ = {};
  encoders_answer_at_ = loop_.now() + kEncoderStart;
  for (std::size_t i = 0; i < kAxes; ++i) {
    Unit& unit = units_[i];
    switch_off(unit);
    unit.seen_rad = unit.plant->state().angle_rad;
    unit.servo.emplace(i, settings[i], hardware_.axis[i], options_, [this, i] { wake(i); });
  }
  units_[0].axis().join(units_[1].axis());
  units_[1].axis().join(units_[0].axis());
  for (std::size_t i = 0; i < kAxes; ++i) {
    units_[i].awake = true;
    slot(i);
    millisecond(units_[i]);
  }
  task_.cancel();
  schedule();
}

// --- Scheduling ----------------------------------------------------------------------------------

void ServoDrive::wake(std::size_t number) {
  units_[number].awake = true;
  schedule();
}

void ServoDrive::schedule() {
  const bool awake = units_[0].awake || units_[1].awake;
  const SimTime next = next_multiple(loop_.now(), awake ? kSlot : kForeground);
  if (task_.due() > next) task_.at(next);
}

void ServoDrive::task() {
  ++slots_;
  const bool foreground = loop_.now().time_since_epoch() % kForeground == SimDuration{};
  // The leader of a gear first: its slave gets the command of the same cycle.
  const std::size_t first = units_[1].axis().leads() ? 1 : 0;
  for (const std::size_t i : {first, 1 - first}) {
    if (units_[i].awake || foreground) slot(i);
  }
  timer_ = measure_timing();
  if (recorder_.busy()) recorder_.sample(units_[recorder_.axis()].axis(), timer_);
  for (std::size_t i = 0; foreground && i < kAxes; ++i) {
    millisecond(units_[i]);
    const bool recorded = recorder_.busy() && recorder_.axis() == i;
    units_[i].awake = recorded || !units_[i].axis().idle() || !at_rest(units_[i]);
  }
  schedule();
}

bool ServoDrive::at_rest(const Unit& unit) const {
  return unit.plant->state().speed_radps == 0;
}

void ServoDrive::slot(std::size_t number) {
  Unit& unit = units_[number];
  unit.plant->advance_to(loop_.now());
  if (unit.awake) load(unit, hardware_.axis[number]);
  unit.axis().slot(sample(number));
  // Gates go off at once, and a faulty inverter's by itself; duties are loaded with the next
  // period.
  const bool off = unit.axis().slot_output().mode == SlotOutput::Mode::kOff;
  if (off || hardware_.axis[number].amplifier_fault) switch_off(unit);
}

void ServoDrive::millisecond(Unit& unit) {
  unit.axis().millisecond(bus_sensor_.counts(unit.plant->state().bus_v, noise_),
                          inverter_counts(unit));
  if (unit.axis().slot_output().mode == SlotOutput::Mode::kOff) switch_off(unit);
}

std::int32_t ServoDrive::inverter_counts(Unit& unit) {
  if (unit.loaded == SlotOutput::Mode::kOff) {
    unit.warmth_k -= unit.warmth_k * kWarmthPerMs;
  } else {
    const double amperes = unit.axis().total_current() * hardware_.current_full_scale_a / kMidScale;
    const double target = kWarmthK * amperes * amperes / (kWarmthA * kWarmthA);
    unit.warmth_k += (target - unit.warmth_k) * kWarmthPerMs;
  }
  const double degc = hardware_.axis[unit.axis().number()].inverter_degc + unit.warmth_k;
  return static_cast<std::int32_t>(
      std::clamp(degc * kCountsPerDegc, 0.0, static_cast<double>(kAdc.full_scale())));
}

std::int32_t ServoDrive::measure_timing() const {
  std::int32_t counts = kTaskCounts;
  for (const Unit& unit : units_) {
    if (unit.axis().amplifier_on()) counts += kAmplifierCounts;
    if (unit.axis().servo_on()) counts += kServoCounts;
  }
  return counts;
}

Result ServoDrive::set_trigger(int trigger) {
  const Result result = recorder_.set_trigger(trigger);
  if (recorder_.busy()) wake(recorder_.axis());
  return result;
}

void ServoDrive::hardware_changed() {
  for (std::size_t i = 0; i < kAxes; ++i) wake(i);
}

std::uint16_t ServoDrive::inputs() const {
  const unsigned one = units_[0].axis().digital_inputs(), two = units_[1].axis().digital_inputs();
  return static_cast<std::uint16_t>(one >> 4 | two >> 4 << 4 | (one & 15) << 8 | (two & 15) << 12);
}

// --- Sensors -------------------------------------------------------------------------------------

SlotReading ServoDrive::sample(std::size_t number) {
  Unit& unit = units_[number];
  const AxisHardware& hardware = hardware_.axis[number];
  const double angle = unit.plant->state().angle_rad;
  SlotReading reading;
  reading.shaft = read_shaft(unit, hardware, angle);
  const PhaseValues phases = unit.plant->phase_currents_a();
  PhaseValues channels{};
  for (std::size_t i = 0; i < 3; ++i) {
    channels[static_cast<std::size_t>(hardware.wiring[i])] = phases[i];
  }
  for (std::size_t i = 0; i < 2; ++i) {
    current_sensor_.offset_a = hardware.current_offset_a[i];
    reading.current_counts[i] =
        current_sensor_.counts(channels[i], noise_) - current_sensor_.zero_counts();
  }
  reading.amplifier_fault = hardware.amplifier_fault;
  if (unit.axis().reads_inputs()) {
    reading.input_pins = input_pins(hardware, angle);
    reading.hall_pins = hall_pins(number, angle);
  }
  return reading;
}

ShaftReading ServoDrive::read_shaft(Unit& unit, const AxisHardware& hardware, double angle) const {
  ShaftReading reading;
  if (unit.axis().settings().etype == 0) {
    const double seen = hardware.incremental_cut ? unit.seen_rad : angle;
    reading.edges = hardware.incremental.count(seen);
    if (const auto edges = hardware.incremental.index_capture(unit.seen_rad, seen)) {
      reading.index = true;
      reading.index_edges = *edges;
    }
    unit.seen_rad = seen;
    return reading;
  }
  using Answer = ShaftReading::Answer;
  unit.seen_rad = angle;
  if (loop_.now() < encoders_answer_at_) return reading;
  reading.answer = hardware.absolute.silent ? Answer::kNone : Answer::kWord;
  reading.word = hardware.absolute.sensor.read(angle);
  reading.single_turn_bits = hardware.absolute.sensor.single_turn_bits;
  return reading;
}

std::uint8_t ServoDrive::hall_pins(std::size_t number, double angle) const {
  using Plug = AxisHardware::HallPlug;
  const AxisHardware& hardware = hardware_.axis[number];
  const Plug read = hardware_.dip_halls_at_encoder[number] ? Plug::kEncoder : Plug::kP5;
  if (hardware.hall_plug != read) return 0;
  return hardware.halls.bits(units_[number].pole_pairs * angle);
}

// --- Gates ---------------------------------------------------------------------------------------

void ServoDrive::load(Unit& unit, const AxisHardware& hardware) {
  const SlotOutput& output = unit.axis().slot_output();
  if (output.mode == SlotOutput::Mode::kOff || hardware.amplifier_fault) return;
  BridgeCommand command{.mode = Bridge::kDriven,
                        .pwm_period = kSlot,
                        .dead_time = from_seconds(hardware_.dead_time_s)};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto channel = static_cast<std::size_t>(hardware.wiring[i]);
    command.duty[i] = output.duty[channel];
    if (output.mode == SlotOutput::Mode::kTwoPhase && channel == 2) command.legs[i] = Leg::kHiZ;
  }
  unit.plant->set_bridge(command);
  unit.loaded = output.mode;
}

void ServoDrive::switch_off(Unit& unit) {
  if (unit.loaded == SlotOutput::Mode::kOff && unit.servo) return;
  unit.plant->advance_to(loop_.now());
  unit.plant->set_bridge({.mode = Bridge::kOff});
  unit.loaded = SlotOutput::Mode::kOff;
}

}  // namespace virtdrive::rzt1
