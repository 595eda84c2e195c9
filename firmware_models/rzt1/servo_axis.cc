#include "firmware_models/rzt1/servo_axis.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "firmware_models/rzt1/counts.h"
#include "firmware_models/rzt1/recorder.h"

namespace virtdrive::rzt1 {
namespace {

constexpr double kTurnRad = 2 * std::numbers::pi;
constexpr double kSixthRad = std::numbers::pi / 3;
constexpr std::int32_t kErrorClip = 32767;
constexpr std::int64_t kAbruptly = 32;   // times the deceleration (6.5.6)
constexpr int kCurrentShift = 5;         // 32767: 1023 counts, half the converter's range
constexpr std::int32_t kRange = 2047;    // of the current converter
constexpr std::int32_t kNoise = 3;       // counts that are no current
constexpr std::int32_t kHostPhases = 3;  // PCMODE
constexpr std::int32_t kTwoPhases = 2;   // PHASES

// PMAP: the phase that each of the channels U, V, W gets.
constexpr std::array<std::array<std::uint8_t, 3>, 6> kPhaseOfChannel{
    {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}, {1, 0, 2}, {2, 0, 1}, {2, 1, 0}}};

const std::array<std::uint8_t, 3>& mapping(const Settings& settings) {
  return kPhaseOfChannel[static_cast<std::size_t>(settings.pmap)];
}

}  // namespace

ServoAxis::ServoAxis(std::size_t number, const Settings& settings, AxisHardware& hardware,
                     const FirmwareOptions& options, std::function<void()> wake)
    : number_(number),
      settings_(settings),
      hardware_(hardware),
      options_(options),
      wake_(std::move(wake)),
      interlocks_(options.error_time_ms) {
  start_encoder();
  regulators_.latch(settings_);
  inputs_.set_halls_inverted(settings_.hinvert != 0);
}

void ServoAxis::start_encoder() {
  const auto type = static_cast<EncoderType>(settings_.etype);
  position_.start(type, settings_.pinvert != 0);
  const bool absolute = position_.absolute();
  if (absolute) {
    absolute_type_ = type;
  } else {
    settings_.porigin = 0;
  }
  phasing_.set_origin(settings_.porigin);
  phasing_.set_phased(absolute);
  profile_.hold(0);
  regulators_.reset(0);
}

// --- Gear ----------------------------------------------------------------------------------------

bool ServoAxis::leads() const {
  if (settings_.type != 2 || partner_ == nullptr) return false;
  return number_ == 0 || partner_->settings_.type != 2;
}

std::int32_t ServoAxis::geared_down(std::int64_t value) const {
  std::int64_t numerator = settings_.gear_in, denominator = settings_.gear_out;
  if (options_.gear_inverted) std::swap(numerator, denominator);
  const std::int64_t product = value * numerator;
  const std::int64_t quotient = product / denominator;
  return static_cast<std::int32_t>(quotient - (product % denominator < 0 ? 1 : 0));
}

// Of the leader: the slave stands where the gear wants it, whatever its encoder counted.
void ServoAxis::preset_slave() {
  ServoAxis& slave = *partner_;
  const std::int32_t wanted = geared_down(profile_.position());
  slave.shift(difference(wanted, slave.profile_.position()));
}

template <class Order>
Result ServoAxis::both(Order order) {
  if (!geared()) return order(*this);
  ServoAxis& leader = leads() ? *this : *partner_;
  const Result first = order(leader);
  const Result second = order(*leader.partner_);
  return first != Result::kOk ? first : second;
}

// --- Power ---------------------------------------------------------------------------------------

Result ServoAxis::ready() const {
  if (interlocks_.blocks(settings_)) return Result::kInterlock;
  if (amplifier_fault_) return Result::kFault;
  return Result::kOk;
}

Result ServoAxis::on() {
  const Result result = both([](ServoAxis& axis) { return axis.switch_on(); });
  if (geared() && result == Result::kOk) (leads() ? *this : *partner_).preset_slave();
  return result;
}

Result ServoAxis::switch_on() {
  if (const Result result = ready(); result != Result::kOk) return result;
  if (settings_.pcmode == kHostPhases) return Result::kOk;
  if (position_.absolute() && !position_.answers()) return Result::kFault;
  if (phasing_.busy()) return servo_on_ ? Result::kOk : Result::kInvalidState;
  wake_();
  regulators_.latch(settings_);
  if (servo_on_) return Result::kOk;
  interlocks_.clear_status();
  position_.clear_wrapped();
  amplifier_on_ = servo_on_ = true;
  off_after_stop_ = false;
  profile_.hold(position());
  regulators_.reset(position());
  current_.reset();
  if (settings_.sim != 0 || settings_.phases == kTwoPhases) {
    phasing_.set_phased(true);
  } else if (!phased()) {
    phasing_.align(settings_, position(), halls(), false);
  }
  return Result::kOk;
}

Result ServoAxis::off() {
  return both([](ServoAxis& axis) {
    axis.switch_off();
    return Result::kOk;
  });
}

// The amplifier stays on: without an output it shorts the winding, which brakes (6.5.6).
void ServoAxis::switch_off() {
  wake_();
  servo_on_ = off_after_stop_ = false;
  homing_.abort();
  phasing_.abort();
  vector_.reset();
  profile_.hold(position());
  profile_.clear_pvt();
  regulators_.rest();
  current_.reset();
}

Result ServoAxis::enable() {
  return both([](ServoAxis& axis) { return axis.switch_power(true); });
}

Result ServoAxis::disable() {
  return both([](ServoAxis& axis) { return axis.switch_power(false); });
}

Result ServoAxis::switch_power(bool on) {
  wake_();
  if (!on) {
    amplifier_on_ = false;
    switch_off();
    commutate();
    return Result::kOk;
  }
  if (const Result result = ready(); result != Result::kOk) return result;
  if (amplifier_on_) return Result::kOk;
  interlocks_.clear_status();
  position_.clear_wrapped();
  amplifier_on_ = true;
  if (!phased() && settings_.pimode == 1 && hall_sector(halls())) {
    phasing_.align(settings_, position(), halls(), false);
  }
  return Result::kOk;
}

// --- Motion --------------------------------------------------------------------------------------

std::int64_t ServoAxis::deceleration() const {
  return std::max<std::int64_t>(1, settings_.dec != 0 ? settings_.dec : settings_.acc);
}

MotionLimits ServoAxis::limits() const {
  return {.velocity = settings_.vel,
          .acceleration = std::max<std::int64_t>(1, settings_.acc),
          .deceleration = deceleration(),
          .acceleration_jerk = settings_.ajerk,
          .deceleration_jerk = settings_.djerk};
}

void ServoAxis::latch() {
  regulators_.latch(settings_);
  latched_limits_ = limits();
  if (leads()) partner_->regulators_.latch(partner_->settings_);
}

void ServoAxis::begin_motion() {
  wake_();
  off_after_stop_ = false;
  latch();
}

Result ServoAxis::may_move() const {
  if (interlocks_.blocks(settings_)) return Result::kInterlock;
  if (amplifier_fault_ || (interlocks_.status() & kAmplifierFault) != 0) return Result::kFault;
  if (follows() || busy() || (leads() && partner_->busy())) return Result::kInvalidState;
  return Result::kOk;
}

Result ServoAxis::go() {
  if (!servo_on_) {
    if (interlocks_.blocks(settings_)) return Result::kInterlock;
    latch();
    return Result::kOk;
  }
  if (const Result result = may_move(); result != Result::kOk) return result;
  if (moving() && !profile_.changeable()) return Result::kInvalidState;
  if (jog_direction_ != 0) {
    begin_motion();
    profile_.jog(jog_direction_ * latched_limits_.velocity, latched_limits_);
    return Result::kOk;
  }
  const auto kind = static_cast<ProfileKind>(settings_.pro);
  if (kind != ProfileKind::kTrapezoid && moving()) return Result::kInvalidState;
  if (kind == ProfileKind::kPvt) {
    if (profile_.pvt_depth() < 2) return Result::kInvalidState;
    begin_motion();
    profile_.stream(settings_.itime, latched_limits_);
    return Result::kOk;
  }
  begin_motion();
  if (distance_ != 0) target_ = sum(position(), distance_);
  profile_.move(target_, latched_limits_, kind);
  return Result::kOk;
}

Result ServoAxis::start_jog(int direction) {
  jog_direction_ = direction;
  return servo_on_ ? go() : Result::kOk;
}

Result ServoAxis::forward() {
  return start_jog(1);
}

Result ServoAxis::reverse() {
  return start_jog(-1);
}

Result ServoAxis::jog(std::int32_t velocity) {
  if (!servo_on_) return Result::kInvalidState;
  if (const Result result = may_move(); result != Result::kOk) return result;
  if (moving() && !profile_.changeable()) return Result::kInvalidState;
  begin_motion();
  profile_.jog(velocity, latched_limits_);
  return Result::kOk;
}

Result ServoAxis::follow(std::int32_t position, std::int32_t cycles) {
  if (!servo_on_) return Result::kInvalidState;
  if (const Result result = may_move(); result != Result::kOk) return result;
  if (!profile_.following()) {
    if (moving()) return Result::kInvalidState;
    begin_motion();
  }
  profile_.follow(position, cycles);
  return Result::kOk;
}

void ServoAxis::halt(std::int64_t deceleration) {
  wake_();
  homing_.abort();
  phasing_.abort();
  profile_.clear_pvt();
  if (servo_on_) regulators_.latch(settings_);
  profile_.stop(deceleration);
}

Result ServoAxis::quick_stop(std::int64_t deceleration) {
  return both([deceleration](ServoAxis& axis) {
    axis.halt(deceleration);
    return Result::kOk;
  });
}

Result ServoAxis::stop() {
  return quick_stop(deceleration());
}

Result ServoAxis::abort() {
  return quick_stop(kAbruptly * deceleration());
}

Result ServoAxis::home() {
  if (!servo_on_ || moving()) return Result::kInvalidState;
  if (const Result result = may_move(); result != Result::kOk) return result;
  begin_motion();
  carry_out(homing_.start({.position = position(), .inputs = digital_inputs()}, settings_,
                          options_.homing));
  return Result::kOk;
}

Result ServoAxis::align() {
  if (const Result result = ready(); result != Result::kOk) return result;
  if (position_.absolute() && !position_.answers()) return Result::kFault;
  if (busy() || moving() || settings_.pcmode == kHostPhases) return Result::kInvalidState;
  wake_();
  if (settings_.sim != 0 || settings_.phases == kTwoPhases) {
    phasing_.set_phased(true);
    return Result::kOk;
  }
  amplifier_on_ = true;
  phasing_.align(settings_, position(), halls(), true);
  return Result::kOk;
}

Result ServoAxis::setup() {
  if (const Result result = ready(); result != Result::kOk) return result;
  if (servo_on_ || busy()) return Result::kInvalidState;
  wake_();
  amplifier_on_ = true;
  phasing_.set_phased(false);
  phasing_.start_setup();
  return Result::kOk;
}

void ServoAxis::reset_errors() {
  interlocks_.reset_errors();
}

void ServoAxis::set_target(std::int32_t position) {
  target_ = position;
  distance_ = 0;
  jog_direction_ = 0;
}

void ServoAxis::set_distance(std::int32_t counts) {
  distance_ = counts;
  jog_direction_ = 0;
}

Result ServoAxis::init_pvt(std::int32_t time_slice, std::optional<std::int32_t> watermark) {
  if (time_slice <= 0) return Result::kOutOfRange;
  if (moving()) return Result::kInvalidState;
  settings_.itime = time_slice;
  if (watermark) settings_.wmark = *watermark;
  profile_.clear_pvt();
  pvt_announced_ = true;
  return Result::kOk;
}

Result ServoAxis::push_pvt(std::span<const PvtPoint> points) {
  return profile_.push(points) ? Result::kOk : Result::kOverflow;
}

Result ServoAxis::push_pvt_velocity(std::int32_t velocity) {
  pending_.velocity = velocity;
  return push_pvt({&pending_, 1});
}

// --- Parameters ----------------------------------------------------------------------------------

Result ServoAxis::set(std::int32_t Settings::* parameter, std::int32_t value) {
  const auto is = [&](std::int32_t Settings::* other) { return parameter == other; };
  if (is(&Settings::porigin)) {
    set_phase_origin(value);
    return Result::kOk;
  }
  if (is(&Settings::etype)) return set_encoder_type(value);
  if (is(&Settings::ds) && value == 0) return Result::kOk;  // Appendix A
  // What something is divided by, and what is an index.
  if ((is(&Settings::ds) || is(&Settings::pole_pairs) || is(&Settings::ecpr) ||
       is(&Settings::pcounts) || is(&Settings::gear_in) || is(&Settings::gear_out) ||
       is(&Settings::itime)) &&
      value <= 0) {
    return Result::kOutOfRange;
  }
  if ((is(&Settings::pmap) && (value < 0 || value > 5)) ||
      (is(&Settings::phases) && value != 2 && value != 3) ||
      (is(&Settings::pro) && (value < 0 || value > 3)) ||
      (is(&Settings::type) && (value < 1 || value > 3))) {
    return Result::kOutOfRange;
  }
  const bool structural = is(&Settings::type) || is(&Settings::sim) || is(&Settings::pinvert) ||
                          is(&Settings::phases) || is(&Settings::pcmode);
  if (structural && value != settings_.*parameter) {
    if (servo_on_ || busy() || (partner_ != nullptr && geared() && partner_->servo_on_)) {
      return Result::kInvalidState;
    }
    wake_();
  }
  settings_.*parameter = value;
  if (is(&Settings::ecpr) || is(&Settings::pole_pairs)) {
    settings_.pcounts = std::max(1, settings_.ecpr / settings_.pole_pairs);
  } else if (is(&Settings::hinvert)) {
    inputs_.set_halls_inverted(value != 0);
    wake_();
  } else if (is(&Settings::pinvert)) {
    position_.set_inverted(value != 0);
  } else if (is(&Settings::pvector)) {
    host_phases_ = false;
    wake_();
  } else if (is(&Settings::pcmode)) {
    host_phases_ = false;
  }
  return Result::kOk;
}

// The interface takes one protocol until the next reset (6.1).
Result ServoAxis::set_encoder_type(std::int32_t type) {
  if (type < 0 || type > static_cast<std::int32_t>(EncoderType::kHiperfaceDsl)) {
    return Result::kOutOfRange;
  }
  if (type == settings_.etype) return Result::kOk;
  const bool absolute = type != 0;
  const bool taken = absolute_type_ && *absolute_type_ != static_cast<EncoderType>(type);
  const bool absent = number_ == 0 && !options_.absolute_on_both;
  if (servo_on_ || busy() || (absolute && (taken || absent))) return Result::kInvalidState;
  wake_();
  settings_.etype = type;
  settings_.ecpr =
      absolute ? 1 << hardware_.absolute.sensor.single_turn_bits : 4 * hardware_.incremental.lines;
  settings_.pcounts = std::max(1, settings_.ecpr / settings_.pole_pairs);
  settings_.porigin = 0;
  start_encoder();
  return Result::kOk;
}

Settings ServoAxis::saved() const {
  Settings settings = settings_;
  if (position_.absolute()) settings.porigin = difference(settings.porigin, position_.offset());
  return settings;
}

Result ServoAxis::restore(const Settings& saved) {
  if (servo_on_ || busy()) return Result::kInvalidState;
  if (const Result result = set_encoder_type(saved.etype); result != Result::kOk) return result;
  for (const SavedSetting& setting : saved_settings()) {
    if (setting.member != &Settings::porigin) settings_.*setting.member = saved.*setting.member;
  }
  if (position_.absolute()) set_phase_origin(sum(saved.porigin, position_.offset()));
  position_.set_inverted(settings_.pinvert != 0);
  inputs_.set_halls_inverted(settings_.hinvert != 0);
  wake_();
  return Result::kOk;
}

void ServoAxis::set_phase_origin(std::int32_t position) {
  phasing_.set_origin(position);
  settings_.porigin = position;
}

Result ServoAxis::set_output(std::int32_t q) {
  if (servo_on_) return Result::kInvalidState;
  output_q_ = q;
  host_phases_ = false;
  wake_();
  return Result::kOk;
}

Result ServoAxis::set_output_d(std::int32_t d) {
  if (servo_on_) return Result::kInvalidState;
  output_d_ = d;
  wake_();
  return Result::kOk;
}

Result ServoAxis::set_phase_output(std::size_t phase, std::int32_t counts) {
  if (settings_.pcmode != kHostPhases) return Result::kInvalidState;
  if (!host_phases_) host_counts_.fill(0);
  host_phases_ = true;
  host_counts_[phase] = counts;
  wake_();
  return Result::kOk;
}

// --- Encoder -------------------------------------------------------------------------------------

void ServoAxis::shift(std::int32_t counts) {
  position_.shift(counts);
  profile_.shift(counts);
  target_ = sum(target_, counts);
  hall_position_ = sum(hall_position_, counts);
  set_phase_origin(sum(phasing_.origin(), counts));
  phasing_.shift(counts);
  regulators_.shift(counts);
}

Result ServoAxis::set_position(std::int32_t position) {
  if (follows() && servo_on_) return Result::kInvalidState;
  shift(difference(position, this->position()));
  if (leads() && servo_on_) preset_slave();
  return Result::kOk;
}

std::int32_t ServoAxis::take_index() {
  position_.clear_captured();
  return position_.index();
}

std::uint32_t ServoAxis::encoder_id() const {
  return position_.answers() ? hardware_.absolute.id : 0;
}

Result ServoAxis::read_encoder_word(std::uint16_t& word) const {
  const auto& eeprom = hardware_.absolute.eeprom;
  const auto address = static_cast<std::size_t>(settings_.eaddr);
  if (!position_.absolute() || address >= eeprom.size()) return Result::kOutOfRange;
  if (!position_.answers()) return Result::kExecution;
  word = eeprom[address];
  return Result::kOk;
}

Result ServoAxis::write_encoder_word(std::uint16_t word) {
  std::uint16_t before = 0;
  if (const Result result = read_encoder_word(before); result != Result::kOk) return result;
  hardware_.absolute.eeprom[static_cast<std::size_t>(settings_.eaddr)] = word;
  return Result::kOk;
}

// --- Reports -------------------------------------------------------------------------------------

std::uint16_t ServoAxis::status() const {
  constexpr std::uint16_t kFaults = kEncoderSilent | kEncoderCrc | kEncoderBatteryLost;
  std::uint32_t bits = interlocks_.status();
  const auto add = [&](bool condition, std::uint32_t bit) { bits |= condition ? bit : 0; };
  add(!moving(), kMotionComplete);
  add(servo_on_, kServoOn);
  add(amplifier_on_, kAmplifierOn);
  add(position_.captured(), kIndexCaptured);
  add((position_.status() & kFaults) != 0, kEncoderFault);
  add((position_.status() & kEncoderBatteryLow) != 0, kEncoderWarning);
  add((pvt_announced_ || profile_state() == ProfileState::kStreaming) &&
          pvt_depth() <= settings_.wmark,
      kPvtLow);
  add(phased(), kPhased);
  add(busy(), kBusy);
  add(profile_.starved(), kPvtStarved);
  add(position_.wrapped(), kPositionWrapped);
  return static_cast<std::uint16_t>(bits);
}

bool ServoAxis::busy() const {
  return homing_.busy() || phasing_.busy();
}

std::int32_t ServoAxis::position_error() const {
  if (!servo_on_) return 0;
  return std::clamp(difference(profile_.position(), position()), -kErrorClip, kErrorClip);
}

std::int32_t ServoAxis::velocity_counts() const {
  return std::clamp(velocity() >> 16, -kErrorClip - 1, kErrorClip);
}

std::int32_t ServoAxis::raw_current(std::size_t channel) const {
  return current_counts_[channel];
}

std::int32_t ServoAxis::total_current() const {
  return std::abs(current_counts_[0]) + std::abs(current_counts_[1]);
}

std::int32_t ServoAxis::trace(int source, std::int32_t timing) const {
  switch (static_cast<TraceSource>(source)) {
    case TraceSource::kPosition:
      return position();
    case TraceSource::kCommandVelocity:
      return command_velocity();
    case TraceSource::kCommandAcceleration:
      return command_acceleration();
    case TraceSource::kI2t:
      return i2t();
    case TraceSource::kPositionError:
      return position_error();
    case TraceSource::kRegulatorOutput:
      return servo_on_ ? regulator_output() : output_q_;
    case TraceSource::kTotalCurrent:
      return total_current();
    case TraceSource::kDirectCurrent:
      return direct_current();
    case TraceSource::kQuadratureCurrent:
      return quadrature_current();
    case TraceSource::kDirectError:
      return direct_error();
    case TraceSource::kQuadratureError:
      return quadrature_error();
    case TraceSource::kRawA:
      return raw_current(0);
    case TraceSource::kRawB:
      return raw_current(1);
    case TraceSource::kPvtDepth:
      return pvt_depth();
    case TraceSource::kDirectVoltage:
      return direct_voltage();
    case TraceSource::kQuadratureVoltage:
      return quadrature_voltage();
    case TraceSource::kTaskTiming:
      return timing;
    case TraceSource::kPhaseAngle:
      return phase_angle();
  }
  return 0;
}

// --- The 50 us task ------------------------------------------------------------------------------

bool ServoAxis::over_range() const {
  const std::int32_t third = -(current_counts_[0] + current_counts_[1]);
  return std::abs(current_counts_[0]) >= kRange || std::abs(current_counts_[1]) >= kRange ||
         std::abs(third) >= kRange;
}

void ServoAxis::slot(const SlotReading& reading) {
  current_counts_ = reading.current_counts;
  amplifier_fault_ = reading.amplifier_fault;
  if (amplifier_on_ && over_range()) {  // POE3 takes the outputs away by itself
    interlocks_.output_disabled();
    (void)disable();
  }
  if (settings_.sim == 0) position_.read(reading.shaft);
  if (++slots_ >= regulators_.loop_slots()) {
    slots_ = 0;
    loop_cycle(reading);
  }
  phase_angle_ = phasing_.angle(position(), settings_);
  commutate();
}

void ServoAxis::loop_cycle(const SlotReading& reading) {
  const std::uint8_t before = halls();
  inputs_.sample(reading.input_pins, reading.hall_pins);
  if (halls() != before) hall_position_ = position();
  regulators_.observe(position());

  const bool searching = phasing_.busy();
  vector_ = phasing_.step(position(), halls(), settings_);
  settings_.porigin = phasing_.origin();
  if (searching && !phasing_.busy()) end_search();

  if (homing_.busy()) home_on();
  if (servo_on_) regulate();
}

void ServoAxis::end_search() {
  vector_.reset();
  inputs_.set_halls_inverted(settings_.hinvert != 0);
  current_.reset();
  if (phasing_.last_search() == Phasing::Search::kSetup) {
    amplifier_on_ = false;
    return;
  }
  if (!servo_on_) return;
  if (phasing_.failed()) {
    (void)off();
    return;
  }
  profile_.hold(position());
  regulators_.reset(position());
  if (leads()) preset_slave();
  if (follows()) partner_->preset_slave();
}

void ServoAxis::regulate() {
  if (phasing_.busy()) {
    profile_.hold(position());
    return;
  }
  profile_.step();
  if (leads() && partner_->servo_on_ && !partner_->phasing_.busy()) {
    partner_->profile_.lead(geared_down(profile_.position()), geared_down(profile_.velocity()),
                            geared_down(profile_.acceleration()), profile_.state());
  }
  if (settings_.sim != 0) position_.simulate(profile_.position());
  regulators_.step(profile_.position(), profile_.velocity(), profile_.acceleration(), position(),
                   settings_);
  if (off_after_stop_ && !moving()) (void)off();
}

void ServoAxis::home_on() {
  // Polled each 100 us (7.6).
  if (regulators_.loop_slots() == 1) {
    polled_last_ = !polled_last_;
    if (polled_last_) return;
  }
  carry_out(homing_.step({.position = position(),
                          .position_error = position_error(),
                          .moving = moving(),
                          .captured = position_.captured(),
                          .index = position_.index(),
                          .inputs = digital_inputs()},
                         settings_, options_.homing));
}

void ServoAxis::carry_out(const HomingOrder& order) {
  using What = HomingOrder::What;
  switch (order.what) {
    case What::kNothing:
      return;
    case What::kArmIndex:
      position_.clear_captured();
      profile_.move(order.value, latched_limits_, ProfileKind::kTrapezoid);
      return;
    case What::kMove:
      profile_.move(order.value, latched_limits_, ProfileKind::kTrapezoid);
      return;
    case What::kStop:
      profile_.stop(latched_limits_.deceleration);
      return;
    case What::kSetHere:
      shift(difference(order.value, position()));
      profile_.hold(position());
      break;
    case What::kShiftHome:
      shift(difference(0, order.value));
      profile_.move(0, latched_limits_, ProfileKind::kTrapezoid);
      break;
  }
  if (leads()) preset_slave();
}

// --- Commutation ---------------------------------------------------------------------------------

void ServoAxis::commutate() {
  using Mode = SlotOutput::Mode;
  if (!amplifier_on_ || settings_.sim != 0) {
    slot_output_.mode = Mode::kOff;
    return;
  }
  if (settings_.phases == kTwoPhases) {
    current_.measure(current_counts_[0]);
    current_.two_phase(servo_on_ ? regulators_.output() : output_q_);
    slot_output_ = {Mode::kTwoPhase, current_.duty()};
    return;
  }
  commutate_three();
  const auto& phase = mapping(settings_);
  slot_output_.mode = Mode::kThreePhase;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    slot_output_.duty[channel] = current_.duty()[phase[channel]];
  }
}

void ServoAxis::commutate_three() {
  // PANGLE is that of the flux which makes torque, 90 degrees ahead of the d axis.
  const Rotation rotor(static_cast<double>(phase_angle_) / settings_.pcounts * kTurnRad -
                       kTurnRad / 4);
  const auto& phase = mapping(settings_);
  std::array<std::int32_t, 3> counts{};
  counts[phase[0]] = current_counts_[0];
  counts[phase[1]] = current_counts_[1];
  counts[phase[2]] = -(current_counts_[0] + current_counts_[1]);
  current_.measure({counts[0], counts[1]}, rotor);

  if (vector_) return current_.vector(vector_->amplitude, vector_->angle_rad);
  if (settings_.pcmode == kHostPhases) {
    if (host_phases_) return current_.host(host_counts_);
    return current_.vector(output_q_, settings_.pvector * kSixthRad);
  }
  const std::int32_t q = servo_on_ ? regulators_.output() : output_q_;
  const std::int32_t d = servo_on_ ? 0 : output_d_;
  if (!servo_on_ && q == 0 && d == 0) {
    current_.reset();
    return current_.brake();
  }
  const bool angle_known = servo_on_ ? phasing_.usable() : phased();
  if (settings_.pcmode == 2 || !angle_known) {
    const auto sector = hall_sector(halls());
    if (!sector) return current_.brake();
    return current_.drive(0, q, Rotation(*sector * kSixthRad));
  }
  if (settings_.pcmode == 0) return current_.drive(d, q, rotor);
  current_.control(d >> kCurrentShift, q >> kCurrentShift, rotor, settings_);
}

// --- Each millisecond ----------------------------------------------------------------------------

void ServoAxis::millisecond(std::int32_t bus_counts, std::int32_t temperature_counts) {
  bus_counts_ = bus_counts;
  temperature_counts_ = temperature_counts;
  carry_out(interlocks_.check({.total_current = total_current(),
                               .bus_counts = bus_counts,
                               .temperature_counts = temperature_counts,
                               .amplifier_fault = amplifier_fault_,
                               .inputs = digital_inputs(),
                               .watch_error = servo_on_ && !phasing_.busy(),
                               .moving = moving(),
                               .position = position(),
                               .position_error = position_error(),
                               .max_error = regulators_.max_error(),
                               .velocity = velocity(),
                               .command_position = command_position(),
                               .command_velocity = command_velocity(),
                               .loop_slots = regulators_.loop_slots(),
                               .empty_cycles = profile_.empty_cycles()},
                              settings_));
}

void ServoAxis::carry_out(const InterlockOrder& order) {
  if (order.power_off && (amplifier_on_ || servo_on_)) {
    (void)disable();
  } else if (order.servo_off && (servo_on_ || busy())) {
    (void)off();
  } else if (order.stop) {
    (void)stop();
    off_after_stop_ = order.stop_off;
  }
}

bool ServoAxis::idle() const {
  const bool quiet = !amplifier_on_ || (output_q_ == 0 && output_d_ == 0 && !host_phases_);
  return !servo_on_ && !busy() && quiet && inputs_.settled() && velocity() == 0 &&
         total_current() <= kNoise;
}

}  // namespace virtdrive::rzt1
