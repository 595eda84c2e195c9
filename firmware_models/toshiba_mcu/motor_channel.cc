#include "firmware_models/toshiba_mcu/motor_channel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kCommandLag = 0.1;     // of torque control: the command follows the speed in 10 ms
constexpr double kMostTorqueMnm = 2e7;  // 100 times that still fits the telegram's 32 bits
constexpr double kForceHysteresis = 0.95;  // FOC falls back to Force at 5 % below SpeedChange
constexpr double kEncoderLag = 0.002;      // the encoder corrects the estimated speed in 0.5 s
constexpr double kStalledShare = 0.2;  // of the command: slower than that, an encoder says stall
constexpr std::int32_t kRestartPositionDelayMs = 100;
constexpr double kTurnApproachRpm = 10;
constexpr double kTurnApproachTurns = 1;
constexpr double kLinearApproachShare = 0.05;

double with_sign_of(double magnitude, double sign) {
  return std::copysign(magnitude, sign);
}

}  // namespace

MotorChannel::MotorChannel(const ChannelSettings& settings) {
  set_settings(settings);
}

void MotorChannel::set_settings(const ChannelSettings& settings) {
  const bool moved = settings.encoder_start_position != settings_.encoder_start_position;
  settings_ = settings;
  scaling_ = scale(settings_);
  encoder_.configure(settings_, scaling_);
  if (moved) position_origin_ = encoder_.total();
  output_.pwm_period = scaling_.pwm_period;
  output_.dead_time = std::chrono::nanoseconds(settings_.dead_time.value);
  // Without PWM periods nothing controls the currents any more.
  if (pwm_active() && scaling_.pwm_period <= SimDuration{}) halt();
}

// --- What the host asks for ----------------------------------------------------------------------

Outcome MotorChannel::start() {
  if (stage_ == Stage::kEmergency || stage_ == Stage::kBrake) return Outcome::kNotReady;
  if (stage_ != Stage::kStop) {
    if (rpm_before_stop_) set_target(*rpm_before_stop_);
    rpm_before_stop_.reset();
    return Outcome::kDone;
  }
  if (is_set(Fault::kOverTemperature)) return Outcome::kNotReady;
  if (scaling_.pwm_period == SimDuration{}) return Outcome::kRefused;
  errors_ = 0;
  method_ = std::exchange(next_method_, Method::kSpeed);
  position_delay_ms_ = settings_.position_delay.value;
  enter(Stage::kBootstrap);
  return Outcome::kDone;
}

Outcome MotorChannel::start_torque_control() {
  if (stage_ == Stage::kStop) next_method_ = Method::kTorque;
  const Outcome outcome = start();
  if (outcome != Outcome::kDone) next_method_ = Method::kSpeed;
  return outcome;
}

void MotorChannel::set_method(Method method) {
  if (!pwm_active()) {
    next_method_ = method;
    return;
  }
  if (method == method_) return;
  // Without a bump: the integral part goes on from the present reference, the ramp from the speed.
  now_.iq_integral_a = now_.iq_ref_a;
  if (torque_controlled()) now_.command_hz = now_.omega_hz;
  method_ = method;
}

std::int32_t MotorChannel::torque_limit_mnm() const {
  const double limit = scaling_.iq_limit_a * scaling_.torque_nm_per_a * 1000;
  return static_cast<std::int32_t>(std::min(limit + 0.5, kMostTorqueMnm));
}

Outcome MotorChannel::stop() {
  if (stage_ == Stage::kStop && restart_in_polls_ == 0) return Outcome::kRefused;
  if (stage_ == Stage::kBrake) return Outcome::kDone;
  motion_.abort();
  if (errors_ != 0) {
    errors_ &= bit(Fault::kOverTemperature);
    halt();
    return Outcome::kDone;
  }
  switch (settings_.shutdown_mode.value) {
    case 0:
      halt();
      break;
    case 1:
      enter(Stage::kBrake);
      break;
    default:
      set_method(Method::kSpeed);  // a ramp is a matter of speed
      if (!rpm_before_stop_) rpm_before_stop_ = set_rpm_;
      set_target(0);
  }
  return Outcome::kDone;
}

void MotorChannel::set_speed_rpm(std::int32_t rpm) {
  motion_.abort();
  const auto limit = static_cast<std::int32_t>(scaling_.speed_limit_hz * 60 / scaling_.pole_pairs);
  rpm = std::clamp(rpm, -limit, limit);
  if (allows(rpm))
    errors_ &= ~bit(Fault::kWrongDirection);
  else
    errors_ |= bit(Fault::kWrongDirection);
  set_target(allows(rpm) ? rpm : 0);
}

bool MotorChannel::allows(double direction) const {
  const std::int32_t only = settings_.direction.value;  // 0 forward, 1 backward, 2 both
  return !(direction < 0 && only == 0) && !(direction > 0 && only == 1);
}

void MotorChannel::set_target(std::int32_t rpm) {
  set_rpm_ = rpm;
  end_speed_reduction();
}

// --- Motion --------------------------------------------------------------------------------------

Outcome MotorChannel::do_turn(std::int32_t turns, std::int32_t max_rpm) {
  if (max_rpm == 0) return Outcome::kRefused;
  if (!allows(turns)) {
    errors_ |= bit(Fault::kWrongDirection);
    return Outcome::kRefused;
  }
  const std::int64_t from = motion_.kind() == Motion::Kind::kTurn ? turn_target_ : turn_number();
  const Outcome outcome = start();
  if (outcome != Outcome::kDone) return outcome;
  set_method(Method::kSpeed);
  turn_target_ = from + turns;
  motion_.begin(Motion::Kind::kTurn, turns,
                {.max_rpm = static_cast<double>(max_rpm),
                 .approach_rpm = kTurnApproachRpm,
                 .approach_turns = kTurnApproachTurns});
  step_motion();
  return Outcome::kDone;
}

bool MotorChannel::do_linear_motion(std::uint32_t position, std::int32_t max_rpm) {
  const auto low = static_cast<std::uint32_t>(settings_.encoder_min_position.value);
  const auto high = static_cast<std::uint32_t>(settings_.encoder_max_position.value);
  const std::int32_t approach_rpm = settings_.encoder_approach.value;
  if (position < low || position > high || max_rpm == 0 || approach_rpm == 0) return false;
  if (motion_.running()) return false;
  position_target_ = position;
  const double pulses = static_cast<double>(position) - absolute_position();
  if (!allows(pulses)) {
    errors_ |= bit(Fault::kWrongDirection);
    return false;
  }
  if (start() != Outcome::kDone) return false;
  set_method(Method::kSpeed);
  const double turns = pulses * scaling_.gear_factor / encoder_.counts_per_turn();
  motion_.begin(Motion::Kind::kLinear, turns,
                {.max_rpm = static_cast<double>(max_rpm),
                 .approach_rpm = static_cast<double>(approach_rpm),
                 .approach_turns = kLinearApproachShare * std::abs(turns)});
  step_motion();
  return true;
}

void MotorChannel::abort_linear_motion() {
  if (motion_.kind() != Motion::Kind::kLinear) return;
  motion_.abort();
  set_target(0);
}

std::uint32_t MotorChannel::absolute_position() const {
  const double pulses =
      static_cast<double>(encoder_.total() - position_origin_) / scaling_.gear_factor;
  return static_cast<std::uint32_t>(settings_.encoder_start_position.value) +
         static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(pulses)));
}

std::int32_t MotorChannel::turn_number() const {
  const double turns =
      encoder_.emulated() ? observer_.electrical_turns() / scaling_.pole_pairs : encoder_.turns();
  return static_cast<std::int32_t>(turns);
}

double MotorChannel::turns_left() const {
  if (motion_.kind() == Motion::Kind::kLinear) {
    const double pulses = static_cast<double>(position_target_) - absolute_position();
    return pulses * scaling_.gear_factor / encoder_.counts_per_turn();
  }
  const double turns =
      encoder_.emulated() ? observer_.electrical_turns() / scaling_.pole_pairs : encoder_.turns();
  return static_cast<double>(turn_target_) - turns;
}

void MotorChannel::step_motion() {
  if (!motion_.running()) return;
  const Motion::Kind kind = motion_.kind();
  const double rpm =
      motion_.speed_rpm(turns_left(), scaling_.acceleration_hz_per_s / scaling_.pole_pairs,
                        scaling_.gear_factor / encoder_.counts_per_turn());
  const double limit_hz = scaling_.speed_limit_hz;
  motion_hz_ = std::clamp(rpm * scaling_.pole_pairs / 60, -limit_hz, limit_hz);
  set_rpm_ = static_cast<std::int32_t>(std::lround(motion_hz_ * 60 / scaling_.pole_pairs));
  if (motion_.running()) return;
  if (kind == Motion::Kind::kTurn)
    stop();
  else
    now_.command_hz = 0;  // held where it is
}

// --- What the host can read ----------------------------------------------------------------------

bool MotorChannel::pwm_active() const {
  return stage_ == Stage::kBootstrap || stage_ == Stage::kZeroCurrentMeasure || energised();
}

bool MotorChannel::energised() const {
  return stage_ == Stage::kInitPosition || stage_ == Stage::kForce || stage_ == Stage::kFoc;
}

std::int32_t MotorChannel::actual_rpm() const {
  if (!energised()) return 0;
  double sum = 0;
  for (const double hz : speed_history_hz_) sum += hz;
  return static_cast<std::int32_t>(sum / static_cast<double>(speed_history_hz_.size()) * 60 /
                                   scaling_.pole_pairs);
}

std::int32_t MotorChannel::target_rpm() const {
  return pwm_active() ? set_rpm_ : 0;
}

std::uint32_t MotorChannel::current_ma() const {
  return energised() ? static_cast<std::uint32_t>(std::abs(now_.iq_integral_a) * 1000) : 0;
}

std::uint32_t MotorChannel::torque() const {
  // 34 mNm/A and 60 mA give 204, as in the document's example.
  const double factor = scaling_.torque_nm_per_a * 1000;
  return static_cast<std::uint32_t>(std::min(factor * current_ma() / 10, 4294967295.0));
}

std::int32_t MotorChannel::target_torque() const {
  return pwm_active() ? torque_mnm_ * 100 : 0;  // 1 mNm is 0.1 Ncm
}

// --- Stages --------------------------------------------------------------------------------------

void MotorChannel::enter(Stage stage) {
  const Stage from = stage_;
  stage_ = stage;
  stage_ms_ = 0;
  switch (stage) {
    case Stage::kStop:
    case Stage::kEmergency:
      output_.mode = Bridge::kOff;
      forget_measurements();
      break;
    case Stage::kBootstrap:
      output_.mode = Bridge::kShort;
      output_.short_share = 1;
      speed_history_hz_ = {};
      encoder_offset_hz_ = 0;
      encoder_.restart_speed();
      break;
    case Stage::kBrake:
      output_.mode = Bridge::kShort;
      output_.short_share = settings_.brake_percentage.value / 100.0;
      forget_measurements();
      break;
    case Stage::kZeroCurrentMeasure:
      output_.mode = Bridge::kOff;
      currents_.begin_zero_current();
      break;
    case Stage::kInitPosition:
      observer_.align(now_);
      break;
    case Stage::kForce:
      end_speed_reduction();
      if (from == Stage::kFoc) break;
      now_.iq_integral_a = with_sign_of(scaling_.iq_start_a, set_rpm_ < 0 ? -1 : 1);
      break;
    case Stage::kFoc:
      now_.iq_integral_a = with_sign_of(scaling_.iq_start_a, now_.command_hz);
      protections_.begin_foc();
      break;
  }
}

// Nothing is measured or controlled any more; the angle may still be of use.
void MotorChannel::forget_measurements() {
  now_ = {.theta_turns = now_.theta_turns, .sine = now_.sine, .cosine = now_.cosine};
}

void MotorChannel::halt() {
  rpm_before_stop_.reset();
  motion_.abort();
  end_speed_reduction();
  restart_in_polls_ = 0;
  angle_known_ = false;
  enter(Stage::kStop);
}

void MotorChannel::trip(Fault fault) {
  errors_ |= bit(fault);
  rpm_before_stop_.reset();
  motion_.abort();
  end_speed_reduction();
  angle_known_ = false;
  enter(Stage::kEmergency);
}

// --- 1 kHz and slower ----------------------------------------------------------------------------

void MotorChannel::millisecond(const Reading& reading) {
  if (stage_ == Stage::kStop || stage_ == Stage::kEmergency) return;
  ++stage_ms_;
  encoder_.millisecond();
  if (pwm_active()) {
    if (const auto fault = Protections::bus(reading, settings_, scaling_)) trip(*fault);
  }
  step_motion();
  switch (stage_) {
    case Stage::kBootstrap:
      if (stage_ms_ >= settings_.bootstrap_delay.value) enter(Stage::kZeroCurrentMeasure);
      break;
    case Stage::kBrake:
      if (stage_ms_ >= settings_.brake_time.value) halt();
      break;
    case Stage::kInitPosition: {
      const double part = position_delay_ms_ > 0 ? double(stage_ms_) / position_delay_ms_ : 1;
      now_.iq_integral_a =
          with_sign_of(scaling_.iq_start_a * std::min(part, 1.0), set_rpm_ < 0 ? -1 : 1);
      if (stage_ms_ >= position_delay_ms_) enter(Stage::kForce);
      break;
    }
    case Stage::kForce:
      ramp_command();
      if (std::abs(now_.command_hz) >= scaling_.speed_change_hz) enter(Stage::kFoc);
      break;
    case Stage::kFoc:
      reduce_speed();
      ramp_command();
      if (std::abs(now_.command_hz) < kForceHysteresis * scaling_.speed_change_hz) {
        enter(Stage::kForce);
      }
      break;
    default:
      break;
  }
  const double encoder_hz = encoder_.speed_turns_per_s() * scaling_.pole_pairs;
  encoder_offset_hz_ += kEncoderLag * (encoder_hz - now_.omega_hz - encoder_offset_hz_);
  speed_history_hz_[speed_index_] = encoder_.measures_speed() ? encoder_hz : now_.omega_hz;
  speed_index_ = (speed_index_ + 1) % speed_history_hz_.size();
}

double MotorChannel::target_hz() const {
  if (reduced_target_hz_) return *reduced_target_hz_;
  return motion_.running() ? motion_hz_ : set_rpm_ * scaling_.pole_pairs / 60;
}

void MotorChannel::ramp_command() {
  if (torque_controlled()) {
    // The estimator wants the command near the true speed.
    now_.command_hz += kCommandLag * (now_.omega_hz - now_.command_hz);
    return;
  }
  const double target = target_hz();
  const double step = scaling_.acceleration_hz_per_s * 1e-3;
  now_.command_hz += std::clamp(target - now_.command_hz, -step, step);
}

void MotorChannel::reduce_speed() {
  const double limit = scaling_.speed_reduction_a;
  if (method_ == Method::kSpeed && limit > 0 && std::abs(now_.iq_ref_a) > limit) {
    reduced_target_hz_ = now_.omega_hz;
    errors_ |= bit(Fault::kSpeedReduction);
  } else {
    end_speed_reduction();
  }
}

void MotorChannel::end_speed_reduction() {
  reduced_target_hz_.reset();
  errors_ &= ~bit(Fault::kSpeedReduction);
}

void MotorChannel::poll(const SpeedSignals& signals) {
  follow_external_speed(signals);
  if (restart_in_polls_ > 0 && --restart_in_polls_ == 0) {
    position_delay_ms_ = kRestartPositionDelayMs;
    enter(Stage::kBootstrap);
    return;
  }
  if (rpm_before_stop_ && actual_rpm() == 0) {
    const bool keep_angle = stage_ == Stage::kForce;
    halt();
    angle_known_ = keep_angle;
    return;
  }
  watch_stall();
}

void MotorChannel::follow_external_speed(const SpeedSignals& signals) {
  const auto method = static_cast<ExternalSpeed>(settings_.external_speed_control.value);
  if (method == ExternalSpeed::kNone) {
    external_on_ = false;
    return;
  }
  const double limit_rpm = scaling_.speed_limit_hz * 60 / scaling_.pole_pairs;
  const double rpm = wanted_share(method, signals) * limit_rpm;
  const bool on = rpm != 0;
  if (on) set_speed_rpm(static_cast<std::int32_t>(rpm));
  if (on == external_on_) return;
  external_on_ = on;
  if (on)
    start();
  else
    stop();
}

void MotorChannel::watch_stall() {
  if (stage_ != Stage::kFoc) return;
  using Check = Protections::StallCheck;
  const double encoder_hz = encoder_.speed_turns_per_s() * scaling_.pole_pairs;
  const Check check = encoder_.measures_speed()
                          ? protections_.stall_by_encoder(std::abs(encoder_hz),
                                                          kStalledShare * std::abs(now_.command_hz),
                                                          scaling_, stage_ms_)
                          : protections_.stall(now_, scaling_, stage_ms_);
  if (check == Check::kGood) errors_ &= ~bit(Fault::kStall);
  if (check != Check::kStalled) return;
  halt();
  errors_ |= bit(Fault::kStall);
  restart_in_polls_ = settings_.restart_mode.value == 1 ? 1 : 0;
}

void MotorChannel::temperature_check(double degc) {
  switch (protections_.temperature(degc, settings_)) {
    case Protections::Heat::kTooHot:
      if (is_set(Fault::kOverTemperature)) break;
      halt();
      errors_ |= bit(Fault::kOverTemperature);
      break;
    case Protections::Heat::kReleased:
      errors_ &= ~bit(Fault::kOverTemperature);
      break;
    case Protections::Heat::kBetween:
      break;
  }
}

// --- Each PWM period -----------------------------------------------------------------------------

void MotorChannel::pwm_interrupt(const Reading& reading) {
  encoder_.period();
  read_encoder(reading.encoder_count);
  if (const auto fault = Protections::pins(reading)) {
    trip(*fault);
    return;
  }
  if (stage_ == Stage::kZeroCurrentMeasure) {
    if (!currents_.zero_current(reading)) return;
    now_.vd_integral_v = now_.vq_integral_v = 0;
    enter(angle_known_ ? Stage::kForce : Stage::kInitPosition);
    angle_known_ = false;
    return;
  }
  if (!energised()) return;
  currents_.measure(reading, settings_, scaling_, now_);
  if (const auto fault = protections_.currents(reading, now_, scaling_, stage_)) {
    trip(*fault);
    return;
  }
  observer_.advance(stage_, now_.command_hz, scaling_, now_);
  set_current_reference();
  currents_.control(scaling_, now_);
  output_.mode = Bridge::kDriven;
  output_.duty = now_.duty;
}

void MotorChannel::read_encoder(std::int64_t edges) {
  encoder_.update(edges, observer_.electrical_turns(), now_.command_hz < 0 ? -1 : 1);
}

void MotorChannel::set_current_reference() {
  now_.id_ref_a = 0;
  if (stage_ != Stage::kFoc)
    hold_force_current();
  else if (method_ == Method::kTorque)
    control_torque();
  else
    control_speed();
}

void MotorChannel::hold_force_current() {
  if (stage_ == Stage::kForce && now_.command_hz != 0) {
    const double current = with_sign_of(scaling_.iq_start_a, now_.command_hz);
    // A motion that turns back must not swing the rotor over: the vector stays where it is.
    if (motion_.running() && current * now_.iq_integral_a < 0) observer_.turn_frame_over(now_);
    now_.iq_integral_a = current;
  }
  now_.iq_ref_a = now_.iq_integral_a;
}

// The torque asked for, lowered by the speed controller when the set speed is reached.
void MotorChannel::control_torque() {
  const double sign = set_rpm_ < 0 ? -1 : 1;
  const double wanted =
      scaling_.torque_nm_per_a > 0 ? torque_mnm_ * 1e-3 / scaling_.torque_nm_per_a : 0;
  const double limit = std::min(wanted, scaling_.iq_limit_a);
  const double error = sign * (target_hz() - measured_hz());
  const double integral =
      std::clamp(sign * now_.iq_integral_a + scaling_.speed_ki_a_per_hz * error, 0.0, limit);
  now_.iq_integral_a = sign * integral;
  now_.iq_ref_a = sign * std::clamp(integral + scaling_.speed_kp_a_per_hz * error, 0.0, limit);
}

void MotorChannel::control_speed() {
  const double limit = scaling_.iq_limit_a;
  const double error = now_.command_hz - measured_hz();
  double& integral = now_.iq_integral_a;
  integral = std::clamp(integral + scaling_.speed_ki_a_per_hz * error, -limit, limit);
  now_.iq_ref_a = std::clamp(integral + scaling_.speed_kp_a_per_hz * error, -limit, limit);
}

// The estimator is quick, an encoder is true.
double MotorChannel::measured_hz() const {
  return encoder_.measures_speed() ? now_.omega_hz + encoder_offset_hz_ : now_.omega_hz;
}

}  // namespace virtdrive::toshiba_mcu
