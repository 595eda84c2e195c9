#include "firmware_models/asd7/drive_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;
using std::numbers::sqrt2;

// How often the program looks while the output is off, and while the CPU is dead. Assumed.
constexpr SimDuration kIdleTurn = 2ms, kDeadTurn = 10ms;
constexpr SimDuration kStart = 1s;  // of the CPU, while the link charges
constexpr SimDuration kResetSilence = 2s;
constexpr SimDuration kContactDelay = 300ms;
constexpr SimDuration kRetryAfter = 1s;
constexpr SimDuration kSecondStop = 1s;  // two STOP keys within this: emergency
constexpr SimDuration kOl1Cools = 30s, kOlCools = 120s;
constexpr double kRetriesForgottenS = 10;

bool may_retry(Trip trip) {
  switch (trip) {
    case Trip::kOc1:
    case Trip::kOc2:
    case Trip::kOc3:
    case Trip::kOcl:
    case Trip::kOp1:
    case Trip::kOp2:
    case Trip::kOp3:
    case Trip::kOl1:
    case Trip::kOl2:
    case Trip::kOlr:
    case Trip::kOh:
    case Trip::kUp1:
      return true;
    default:
      return false;
  }
}

template <typename Integer>
Integer clamped(double value) {
  return static_cast<Integer>(std::clamp(std::round(value),
                                         double{std::numeric_limits<Integer>::min()},
                                         double{std::numeric_limits<Integer>::max()}));
}

std::uint16_t unsigned_of(double value) {
  return clamped<std::uint16_t>(value);
}
std::int16_t signed_of(double value) {
  return clamped<std::int16_t>(value);
}

}  // namespace

AcDrive::Impl::Impl(EventLoop& loop, Axis& axis, const Model& model, const Settings& settings,
                    const Memory& memory, const Seed& seed)
    : model_(model),
      settings_(settings),
      memory_(memory),
      loop_(loop),
      axis_(axis),
      stage_(axis, model.rated_current_a, 1.25 * model.link.trip_v, seed),
      motor_v_(model.supply_v),
      link_nominal_v_(sqrt2 * model.supply_v),
      last_tick_(loop.now()),
      tick_wakeup_(loop.add(Phase::kControl, [this] { tick(); })) {
  axis_.advance_to(loop.now());
  axis_.bus().set_chopper(false);
  bus_v_ = bus_shown_v_ = stage_.sample().bus_v;
  if (bus_v_ > model.link.on_above_v) {
    start_cpu();
  } else {
    die();
  }
  tick_wakeup_.at(loop.now());
}

// --- Life ----------------------------------------------------------------------------------------

void AcDrive::Impl::die() {
  const bool lived = life_ == Life::kAlive;
  switch_off();
  life_ = Life::kDead;
  born_at_ = kNever;
  state_ = State::kReady;
  trip_ = Trip::kNone;
  alarms_ = 0;
  inverter_.clear();
  motor_.clear();
  resistor_.clear();
  if (lived && on_stop_) on_stop_();
}

void AcDrive::Impl::restart() {
  switch_off();
  life_ = Life::kResetting;
  born_at_ = loop_.now() + kResetSilence;
  memory_.kept_trip = 0;
  if (on_stop_) on_stop_();
  wake();
}

void AcDrive::Impl::start_cpu() {
  life_ = Life::kAlive;
  born_at_ = kNever;
  state_ = State::kReady;
  trip_ = Trip::kNone;
  forced_stop_ = Stop::kNone;
  power_lost_stop_ = lower_limit_stop_ = search_wanted_ = communication_alarm_ = false;
  asked_ = {.terminals = asked_.terminals};
  asked_anew_ = true;
  axis_.bus().set_chopper(settings_.braking_resistor != 0);
  if (on_start_) on_start_();
  if (settings_.keep_trip == 0) memory_.kept_trip = 0;
  if (memory_.kept_trip != 0) {
    trip_ = static_cast<Trip>(memory_.kept_trip);
    tripped_at_ = loop_.now();
    frozen_ = monitor();
    state_ = State::kTripped;
  }
}

void AcDrive::Impl::look_at_supply() {
  const LinkLevels& levels = model_.link;
  const SimTime now = loop_.now();
  if (life_ != Life::kDead && bus_v_ < levels.control_v) die();
  if (life_ == Life::kDead) {
    if (bus_v_ < levels.control_v) {
      born_at_ = kNever;
    } else if (born_at_ == kNever) {
      born_at_ = now + kStart;
    }
  }
  if (life_ != Life::kAlive && born_at_ <= now) start_cpu();

  DcBus bus = axis_.bus();
  MainsInput mains = bus.mains();
  if (bus_v_ < levels.off_below_v) {
    undervoltage_ = true;
    contact_at_ = kNever;
    if (mains.contact) {
      mains.contact = false;
      bus.set_mains(mains);
    }
  } else if (!mains.contact && bus_v_ > levels.on_above_v && alive()) {
    if (contact_at_ == kNever) contact_at_ = now + kContactDelay;
    if (contact_at_ <= now) {
      mains.contact = true;
      bus.set_mains(mains);
    }
  }
  if (mains.contact && bus_v_ > levels.on_above_v) undervoltage_ = false;
}

bool AcDrive::Impl::reset_allowed() const {
  const SimDuration passed = loop_.now() - tripped_at_;
  if (trip_ == Trip::kOl1) return passed >= kOl1Cools;
  if (trip_ == Trip::kOl2 || trip_ == Trip::kOlr) return passed >= kOlCools;
  return true;
}

void AcDrive::Impl::wake() {
  if (!output_on() || tick_wakeup_.due() == kNever) tick_wakeup_.at(loop_.now());
}

// --- What it is told -----------------------------------------------------------------------------

void AcDrive::Impl::set_settings(const Settings& settings) {
  if (settings.braking_resistor != settings_.braking_resistor) {
    axis_.advance_to(loop_.now());
    axis_.bus().set_chopper(settings.braking_resistor != 0);
  }
  settings_ = settings;
  asked_anew_ = true;
  wake();
}

AcDrive::CommandResult AcDrive::Impl::set_command(std::uint16_t word) {
  if (!alive()) return CommandResult::kIgnored;
  const bool emergency_edge =
      (word & kCommandEmergency) != 0 && (asked_.command & kCommandEmergency) == 0;
  if ((word & kCommandReset) != 0) {
    if (!tripped() || !reset_allowed()) return CommandResult::kIgnored;
    restart();
    return CommandResult::kRestarts;
  }
  asked_.command = word;
  asked_anew_ = true;
  if (emergency_edge) {
    emergency(static_cast<EmergencyStop>(settings_.emergency_stop), Trip::kE);
  }
  wake();
  return CommandResult::kTaken;
}

void AcDrive::Impl::set_command2(std::uint16_t word) {
  if (!alive()) return;
  constexpr std::uint16_t kClearEnergies = 1 << 1;
  if ((word & kClearEnergies) != 0 && (asked_.command2 & kClearEnergies) == 0) {
    memory_.input_kwh = memory_.output_kwh = 0;
  }
  asked_.command2 = word;
  asked_anew_ = true;
  wake();
}

void AcDrive::Impl::set_terminals(const Terminals& terminals) {
  const bool reset_edge = terminals.reset && !asked_.terminals.reset;
  asked_.terminals = terminals;
  asked_anew_ = true;
  if (alive() && reset_edge && tripped() && reset_allowed()) restart();
  wake();
}

void AcDrive::Impl::press(PanelKey key) {
  if (!alive()) return;
  switch (key) {
    case PanelKey::kRun:
      if (!tripped()) asked_.panel_run = true;
      break;
    case PanelKey::kReset:
      if (tripped() && reset_allowed()) restart();
      break;
    case PanelKey::kStop: {
      asked_.panel_run = false;
      const bool second = loop_.now() - panel_stop_at_ <= kSecondStop;
      panel_stop_at_ = loop_.now();
      if (second && request_.command_source != CommandSource::kPanel && !tripped()) {
        emergency(static_cast<EmergencyStop>(settings_.emergency_stop), Trip::kE);
      }
      break;
    }
  }
  asked_anew_ = true;
  wake();
}

void AcDrive::Impl::inject(Trip cause) {
  injected_ = cause;
  wake();
}

void AcDrive::Impl::communication_lost() {
  if (!alive() || tripped()) return;
  if (settings_.time_out_action == 0) {
    communication_alarm_ = true;
    return;
  }
  emergency(settings_.time_out_action == 2 ? EmergencyStop::kRamp : EmergencyStop::kCoast,
            Trip::kErr5);
}

void AcDrive::Impl::emergency(EmergencyStop how, Trip then) {
  if (tripped()) return;
  if (!output_on() || how == EmergencyStop::kCoast) return trip(then);
  trip_after_stop_ = then;
  if (how == EmergencyStop::kRamp) {
    forced_stop_ = Stop::kRamp;
    return;
  }
  forced_stop_ = Stop::kDcBrake;
  switch_off();
  state_ = State::kDemagnetizing;
  state_since_ = loop_.now();
}

void AcDrive::Impl::trip(Trip cause) {
  if (state_ == State::kTripped || !alive()) return;
  frozen_ = monitor();
  frozen_.status =
      static_cast<std::uint16_t>((frozen_.status & ~kStatusReady) | kStatusFault | kStatusTripped);
  const bool ran = output_on();
  switch_off();
  trip_ = cause;
  tripped_at_ = loop_.now();
  forced_stop_ = Stop::kNone;
  asked_.panel_run = false;
  if (ran && retries_left_ > 0 && may_retry(cause)) {
    --retries_left_;
    retry_at_ = loop_.now() + kRetryAfter;
    state_ = State::kRetryWait;
    return;
  }
  state_ = State::kTripped;
  std::ranges::rotate(memory_.past_trips, memory_.past_trips.end() - 1);
  memory_.past_trips.front() = static_cast<std::uint8_t>(cause);
  if (settings_.keep_trip != 0) memory_.kept_trip = static_cast<std::uint8_t>(cause);
  ++memory_.eeprom_writes;
}

void AcDrive::Impl::retry() {
  trip_ = Trip::kNone;
  state_ = State::kReady;
  search_wanted_ = true;
  running_s_ = 0;
}

// --- The turn ------------------------------------------------------------------------------------

SimDuration AcDrive::Impl::next_step() const {
  if (output_on()) return kTurn;
  return alive() ? kIdleTurn : kDeadTurn;
}

void AcDrive::Impl::tick() {
  const SimTime now = loop_.now();
  const double step_s = seconds(now - last_tick_);
  last_tick_ = now;
  ++ticks_;
  axis_.advance_to(now);
  now_ = stage_.sample();
  bus_v_ = now_.bus_v;
  look_at_supply();
  if (alive()) {
    measure(step_s);
    guard_fast();
    guard_slow(step_s);
    decide(step_s);
    run(step_s);
    count(step_s);
  }
  tick_wakeup_.at(now + next_step());
}

void AcDrive::Impl::measure(double step_s) {
  const bool turns = step_s < 1.5 * seconds(kTurn);
  if (turns) {
    square_sum_ += now_.current2 - squares_[square_at_];
    squares_[square_at_] = now_.current2;
    square_at_ = (square_at_ + 1) % kWindow;
    // Rounding does not pile up.
    if (square_at_ == 0) {
      square_sum_ = 0;
      for (const double square : squares_) square_sum_ += square;
    }
  } else if (square_sum_ != kWindow * now_.current2) {
    squares_.fill(now_.current2);
    square_sum_ = kWindow * now_.current2;
  }
  current_a_ = std::sqrt(std::max(0.0, square_sum_ / kWindow));
  const auto filter = [step_s](double& value, double next, double time_s) {
    value += (next - value) * std::min(1.0, step_s / time_s);
  };
  filter(shown_current_a_, current_a_, 0.1);
  filter(bus_shown_v_, bus_v_, 0.05);
  filter(filtered_hz_, speed_hz_, 1.0);
  for (std::size_t k = 0; k < 3; ++k) {
    filter(phase_squares_[k], now_.current_a[k] * now_.current_a[k], 0.05);
  }
  if (asked_anew_) {
    request_ = request_of(asked_, settings_);
    asked_anew_ = false;
  }
}

bool AcDrive::Impl::may_run() const {
  return !undervoltage_ && !request_.coast && !power_lost_stop_ && !lower_limit_stop_ &&
         forced_stop_ == Stop::kNone;
}

void AcDrive::Impl::decide(double step_s) {
  if (state_ == State::kTripped) return;
  if (state_ == State::kRetryWait) {
    if (loop_.now() >= retry_at_) retry();
    return;
  }
  if (!request_.run) power_lost_stop_ = lower_limit_stop_ = search_wanted_ = false;
  if (lower_limit_stop_ && request_.hz > settings_.lower_limit * kHundredth + 0.2) {
    lower_limit_stop_ = false;
  }
  if (!output_on()) return decide_standing(step_s);
  if (undervoltage_ || request_.coast) {
    search_wanted_ = undervoltage_ && settings_.flying_start != 0;
    if (forced_stop_ != Stop::kNone) return trip(trip_after_stop_);
    return switch_off();
  }
  if (request_.dc_brake && state_ != State::kDcBraking && forced_stop_ == Stop::kNone) {
    switch_off();
    state_ = State::kDemagnetizing;
    state_since_ = loop_.now();
  }
}

void AcDrive::Impl::decide_standing(double) {
  const SimTime now = loop_.now();
  const bool brake = request_.dc_brake || forced_stop_ == Stop::kDcBrake;
  if (state_ == State::kDemagnetizing) {
    const bool wanted = brake || (request_.run && may_run());
    if (!wanted || undervoltage_ || request_.coast) {
      state_ = State::kReady;
      if (forced_stop_ != Stop::kNone) trip(trip_after_stop_);
      return;
    }
    if (seconds(now - state_since_) < model_.demagnetize_s) return;
    if (brake) return begin_dc_brake(settings_.emergency_brake_time * 0.1);
    state_ = State::kSearching;
    state_since_ = now;
    const double fastest = settings_.maximum_frequency * kHundredth;
    const bool again = settings_.flying_start == 1 || last_hz_ > 0;
    search_hz_ = again && last_hz_ > 0 ? std::min(fastest, 1.1 * last_hz_ + 1) : fastest;
    reverse_ = again ? last_reverse_ : request_.reverse;
    search_driven_ = false;
    search_w_ = 0;
    return;
  }
  if (undervoltage_ || request_.coast) return;
  if (brake) {
    state_ = State::kDemagnetizing;
    return;
  }
  const double start_hz = settings_.start_frequency * kHundredth;
  if (!request_.run || !may_run() || (request_.hz < start_hz && !pi_controls())) return;
  begin_output();
}

void AcDrive::Impl::begin_output() {
  if (injected_ == Trip::kOca) return trip(Trip::kOca);
  if (!search_wanted_) retries_left_ = settings_.retries;
  running_s_ = 0;
  if (search_wanted_ || settings_.flying_start == 2) {
    state_ = State::kDemagnetizing;
    return;
  }
  reverse_ = request_.reverse;
  begin_running(settings_.start_frequency * kHundredth);
}

void AcDrive::Impl::begin_running(double hz) {
  state_ = State::kRunning;
  state_since_ = loop_.now();
  search_wanted_ = false;
  pi_runs_ = false;
  raise_hz_ = slip_hz_ = 0;
  ramp_.put(hz);
}

void AcDrive::Impl::begin_dc_brake(double duration_s) {
  state_ = State::kDcBraking;
  state_since_ = loop_.now();
  dc_forced_ = request_.dc_brake && forced_stop_ == Stop::kNone;
  dc_left_s_ = duration_s;
  dc_v_ = 0;
  ramp_.put(0);
}

void AcDrive::Impl::switch_off() {
  stage_.off();
  if (!output_on()) return;
  last_hz_ = state_ == State::kRunning ? ramp_.hz() : state_ == State::kDcBraking ? 0 : search_hz_;
  last_reverse_ = reverse_;
  state_ = State::kReady;
  state_since_ = loop_.now();
  output_hz_ = line_v_ = active_a_ = reactive_a_ = output_w_ = torque_nm_ = speed_hz_ = 0;
  raise_hz_ = slip_hz_ = drop_v_ = wanted_hz_ = 0;
  voltage_ = {};
  at_lower_limit_s_ = 0;
  ramp_.put(0);
}

/// The ramp has ended below the start frequency.
void AcDrive::Impl::end_stop() {
  if (forced_stop_ != Stop::kNone) return trip(trip_after_stop_);
  if (request_.run && may_run() && request_.reverse != reverse_) {
    reverse_ = request_.reverse;
    ramp_.put(settings_.start_frequency * kHundredth);
    return;
  }
  switch_off();
}

void AcDrive::Impl::count(double step_s) {
  const double factor =
      settings_.carrier > 0 && heat_sink_degc_ > 85 ? 0.8 : 1;  // half the carrier
  const double r = current_a_ / model_.rated_current_a;
  heat_sink_degc_ += (40 * factor * r * r - (heat_sink_degc_ - ambient_degc_)) / 600 * step_s;
  if (!output_on()) return;
  const double kwh = step_s / 3.6e6;
  memory_.output_kwh += std::max(0.0, output_w_) * kwh;
  memory_.input_kwh += std::max(0.0, output_w_ + model_.standing_load_w) * kwh;
  running_s_ += step_s;
  if (running_s_ > kRetriesForgottenS) retries_left_ = settings_.retries;
  run_fraction_s_ += step_s;
  if (run_fraction_s_ < 1) return;
  run_fraction_s_ -= 1;
  if (++memory_.run_seconds % 3600 == 0) ++memory_.eeprom_writes;
}

// --- What is reported ----------------------------------------------------------------------------

double AcDrive::Impl::output_hz() const {
  return reverse_ ? -ramp_.hz() : ramp_.hz();
}

std::uint16_t AcDrive::Impl::status() const {
  if (!alive()) return 0;
  unsigned bits = 0;
  if ((alarms_ & ~kAlarmUnderVoltage) != 0) bits |= kStatusAlarm;
  if (tripped()) {
    bits = kStatusTripped;
    if (state_ == State::kTripped) bits |= kStatusFault;
    if (trip_ == Trip::kE) bits |= kStatusEmergency;
    return static_cast<std::uint16_t>(bits);
  }
  bits |= undervoltage_ ? kStatusUnderVoltage : kStatusReady;
  if (request_.second_motor) bits |= kStatusSecondMotor;
  if (settings_.pi_control != 0 && request_.pi_off) bits |= kStatusPiOff;
  if (request_.second_ramp) bits |= kStatusSecondRamp;
  if (request_.coast) bits |= kStatusCoast;
  if (request_.run && !request_.coast && !undervoltage_) bits |= kStatusRunRequested;
  if (output_on()) {
    bits |= kStatusRunning;
    if (reverse_) bits |= kStatusReverse;
    if (request_.jog) bits |= kStatusJog;
    if (state_ == State::kDcBraking) bits |= kStatusDcBraking;
  }
  return static_cast<std::uint16_t>(bits);
}

Monitor AcDrive::Impl::monitor() const {
  Monitor m;
  const auto percent = [](double value, double whole) { return value / whole * 1e4; };
  const double rated_a = model_.rated_current_a;
  const double motor_a = settings_.rated_current * 0.1;
  const double rated_nm = model_.power_w / (settings_.rated_rpm * pi / 30);
  const double sign = reverse_ ? -1 : 1;
  const Terminals& t = asked_.terminals;
  m.output_frequency = unsigned_of(ramp_.hz() * 100);
  m.status = status();
  m.frequency_command = unsigned_of((output_on() ? wanted_hz_ : request_.hz) * 100);
  m.reverse = output_on() ? reverse_ : request_.reverse;
  m.output_current = unsigned_of(percent(shown_current_a_, rated_a));
  m.input_voltage = unsigned_of(percent(bus_shown_v_, sqrt2 * model_.class_v));
  m.output_voltage = unsigned_of(percent(line_v_, model_.class_v));
  unsigned pins = (t.forward ? 1U : 0) | (t.reverse ? 2U : 0) | (t.reset ? 4U : 0);
  for (std::size_t i = 0; i < t.preset.size(); ++i) pins |= (t.preset[i] ? 1U : 0) << (3 + i);
  pins |= t.standby ? 1U << 7 : 0;
  m.input_terminals = static_cast<std::uint16_t>(pins);
  const bool reached = state_ == State::kRunning && ramp_.hz() == wanted_hz_;
  m.output_terminals =
      static_cast<std::uint16_t>((output_on() && ramp_.hz() > 0 ? 1U : 0) | (reached ? 2U : 0) |
                                 (state_ == State::kTripped ? 4U : 0));
  m.compensated_frequency = signed_of(output_hz_ * 100);
  m.estimated_speed = signed_of(speed_hz_ * 100);
  m.filtered_speed = signed_of(filtered_hz_ * 100);
  m.torque = signed_of(percent(sign * torque_nm_, rated_nm));
  m.torque_current = signed_of(percent(sign * active_a_ / sqrt2, rated_a));
  m.exciting_current = signed_of(percent(reactive_a_ / sqrt2, rated_a));
  m.pi_feedback =
      signed_of((settings_.pi_feedback == 2 ? vib_hz(t, settings_) : via_hz(t, settings_)) * 100);
  m.motor_overload = unsigned_of(motor_.level() * 1e4);
  m.inverter_overload = unsigned_of(inverter_.level() * 1e4);
  m.resistor_overload = unsigned_of(resistor_.level() * 100);
  m.motor_load = unsigned_of(motor_a > 0 ? shown_current_a_ / motor_a * 100 : 0);
  m.inverter_load = unsigned_of(shown_current_a_ / rated_a * 100);
  const double lost_w =
      inverter_of(model_).loss_share * bus_shown_v_ * shown_current_a_ + model_.standing_load_w;
  m.input_power = unsigned_of(std::max(0.0, output_w_ + lost_w) / 10);
  m.output_power = unsigned_of(std::max(0.0, output_w_) / 10);
  m.via = t.via;
  m.vib = t.vib;
  m.command_source = static_cast<std::uint16_t>(request_.command_source);
  m.frequency_source = request_.frequency_source;
  m.operating_speed = unsigned_of(std::fabs(speed_hz_) * 100);
  m.heat_sink = signed_of(heat_sink_degc_);
  return m;
}

}  // namespace virtdrive::asd7
