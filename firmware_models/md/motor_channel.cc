#include "firmware_models/md/motor_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace virtdrive::md {
namespace {

constexpr double kFull = 1023;
constexpr double kTickS = 1e-3;

// GAIN_FACTOR of the document's torque formula, and the integrals' times: open in every source,
// chosen so that gains seen on real devices (P 50..6000, I 500..6000) are stable on all motors.
constexpr double kSpeedGainFactor = 16384, kSpeedIntegral = 40;
constexpr double kTorqueGainFactor = 128, kTorqueIntegral = 100;

constexpr double kLimiter = 1.2;  // of MAX_LOAD
constexpr std::int32_t kInPositionMs = 50;
constexpr std::int32_t kCurrentLimitSwitchMs = 100;
constexpr double kCurrentWindowMs = 50;

// Unsigned arithmetic: positions wrap at 32 bits.
std::int32_t wrapped(std::int64_t counts) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(counts));
}

double towards(double from, double to, double step) {
  return from < to ? std::min(to, from + step) : std::max(to, from - step);
}

}  // namespace

// --- Signs and scales ----------------------------------------------------------------------------

std::int32_t MotorChannel::command_sign() const {
  return (number_ == 0 ? settings_.inv_sign : settings_.inv_sign2) != 0 ? -1 : 1;
}

std::int32_t MotorChannel::feedback_sign() const {
  const bool out = (number_ == 0 ? settings_.inv_sign_out : settings_.inv_sign_out2) != 0;
  return out ? -command_sign() : command_sign();
}

// Positions by the encoder are told with the other sign (seen on real controllers).
std::int32_t MotorChannel::encoder_sign() const {
  return by_encoder() ? -1 : 1;
}

bool MotorChannel::by_encoder() const {
  return settings_.use_eposi != 0 && settings_.enc_ppr > 0;
}

int MotorChannel::counts_per_turn() const {
  return by_encoder() ? 4 * settings_.enc_ppr : hall_counts_per_turn(settings_.hall_type);
}

double MotorChannel::rpm_per_count() const {
  return 60.0 / counts_per_turn();
}

double MotorChannel::clamped_rpm(double rpm) const {
  const double most = settings_.max_rpm;
  const double within = std::clamp(rpm, -most, most);
  return std::fabs(within) < settings_.min_rpm ? 0 : within;
}

// Per millisecond; a setting of 0 leaves it to the board's volume, and that at 0 is a step.
double MotorChannel::ramp_step(std::int32_t raw, double full_scale, double volume) const {
  const double share = raw > 0 ? raw / kFull : volume;
  const double time_s = share * settings_.max_ss_time;
  return time_s > 0 ? full_scale / time_s * kTickS : std::numeric_limits<double>::infinity();
}

bool MotorChannel::slow() const {
  return std::fabs(now_.rpm) < std::max(10.0, 0.01 * settings_.max_rpm);
}

// --- Orders --------------------------------------------------------------------------------------

// Another mode begins from what is there: the ramp at the speed, the integral at the output.
bool MotorChannel::take_over(Mode mode) {
  if (alarmed()) return false;
  if (mode_ != mode) {
    reference_ = mode == Mode::kOpenLoop ? output_ : now_.rpm;
    integral_ = output_;
    mode_ = mode;
    begin_move();
  }
  holding_ = false;
  return true;
}

void MotorChannel::begin_move() {
  in_position_ = false;
  within_ms_ = 0;
}

void MotorChannel::speed(double rpm) {
  const double wanted = command_sign() * clamped_rpm(rpm);
  if (wanted == 0 && (mode_ == Mode::kFree || mode_ == Mode::kShort) && (!armed_ || slow())) return;
  if (holding_ && wanted == 0) return;
  if (!take_over(Mode::kSpeed)) return;
  armed_ = armed_ || wanted != 0;
  target_ = wanted;
}

void MotorChannel::open_loop(double output) {
  if (!take_over(Mode::kOpenLoop)) return;
  target_ = command_sign() * std::clamp(output, -kFull, kFull);
  armed_ = armed_ || target_ != 0;
}

void MotorChannel::torque(double torque) {
  if (!take_over(Mode::kTorque)) return;
  target_ = command_sign() * std::clamp(torque, -kFull, kFull);
  armed_ = armed_ || target_ != 0;
}

void MotorChannel::move_to(std::int32_t position, double max_rpm) {
  if (!take_over(Mode::kPosition)) return;
  armed_ = true;
  // The nearest way round the 32 bits.
  const std::int64_t here = now_.counts + offset_;
  const std::int64_t goal =
      here + wrapped(std::int64_t{command_sign() * encoder_sign()} * position - here);
  if (goal != goal_) begin_move();
  goal_ = goal;
  goal_rpm_ = std::clamp<double>(std::fabs(max_rpm), 0, settings_.max_rpm);
}

void MotorChannel::move_by(std::int32_t increment, double max_rpm) {
  const std::int64_t here = std::int64_t{command_sign() * encoder_sign()} * (now_.counts + offset_);
  move_to(wrapped(here + increment), max_rpm);
}

void MotorChannel::stop(Mode mode) {
  mode_ = mode;
  target_ = reference_ = integral_ = output_ = 0;
  holding_ = in_position_ = false;
  command_ = {.mode =
                  mode == Mode::kShort ? StageCommand::Mode::kShort : StageCommand::Mode::kFree};
}

void MotorChannel::free() {
  stop(Mode::kFree);
}

void MotorChannel::brake() {
  stop(alarmed() ? Mode::kFree : Mode::kShort);
}

void MotorChannel::set_position(std::int32_t position) {
  const std::int64_t offset =
      std::int64_t{feedback_sign() * encoder_sign()} * position - now_.counts;
  goal_ += offset - offset_;  // a move under way goes on as it was
  offset_ = offset;
}

void MotorChannel::reset_alarm() {
  protections_.reset();
}

// --- Reports -------------------------------------------------------------------------------------

ControlType MotorChannel::type() const {
  switch (mode_) {
    case Mode::kSpeed:
      return ControlType::kSpeed;
    case Mode::kPosition:
      return ControlType::kPosition;
    case Mode::kOpenLoop:
      return ControlType::kOpenLoop;
    case Mode::kTorque:
      return ControlType::kTorque;
    case Mode::kFree:
    case Mode::kShort:
      break;
  }
  return ControlType::kOff;
}

std::int32_t MotorChannel::rpm() const {
  return feedback_sign() * static_cast<std::int32_t>(std::lround(now_.rpm));
}

std::int32_t MotorChannel::reference_rpm() const {
  const bool is_speed = mode_ == Mode::kSpeed || mode_ == Mode::kPosition;
  return is_speed ? feedback_sign() * static_cast<std::int32_t>(std::lround(reference_)) : 0;
}

std::int32_t MotorChannel::output_counts() const {
  return feedback_sign() * static_cast<std::int32_t>(std::lround(output_));
}

std::int32_t MotorChannel::position() const {
  return wrapped(feedback_sign() * encoder_sign() * (now_.counts + offset_));
}

std::int32_t MotorChannel::target_position() const {
  return mode_ == Mode::kPosition ? wrapped(feedback_sign() * encoder_sign() * goal_) : position();
}

// --- The millisecond -----------------------------------------------------------------------------

void MotorChannel::millisecond(const Measured& measured) {
  now_ = measured;
  mean_current_a_ += (std::fabs(now_.current_a) - mean_current_a_) / kCurrentWindowMs;
  control();
  watch();
}

void MotorChannel::control() {
  if (now_.bus_v < model_.bus.off_below * (command_.mode == StageCommand::Mode::kFree ? 1.05 : 1) &&
      mode_ != Mode::kFree && mode_ != Mode::kShort) {
    output_ = integral_ = reference_ = 0;  // goes on by itself when the voltage is back
    command_ = {};
    return;
  }
  switch (mode_) {
    case Mode::kFree:
      output_ = 0;
      command_ = {};
      return;
    case Mode::kShort:
      output_ = 0;
      command_ = {.mode = StageCommand::Mode::kShort};
      return;
    case Mode::kSpeed:
      return control_speed();
    case Mode::kPosition:
      return control_position();
    case Mode::kOpenLoop:
      return control_open_loop();
    case Mode::kTorque:
      return control_torque();
  }
}

void MotorChannel::drive(double output, bool only_driving) {
  output_ = std::clamp(output, -kFull, kFull);
  const double lead = output_ >= 0 ? settings_.ccw_phase_offset : settings_.cw_phase_offset;
  command_ = {.mode = StageCommand::Mode::kDriven,
              .output = output_ / kFull,
              .only_driving = only_driving,
              .limit_a = kLimiter * max_load_a(model_, settings_) *
                         (model_.temperature_sensor ? derating(now_.heat_sink_degc) : 1),
              .lead_deg = lead,
              .overlap = settings_.over_modulation != 0};
}

void MotorChannel::regulate_speed(double reference_rpm, bool frozen) {
  const double error = (reference_rpm - now_.rpm) * kFull / settings_.max_rpm;
  const double proportional = settings_.p_gain * error / kSpeedGainFactor;
  if (!frozen && !now_.limited) {
    integral_ += settings_.i_gain * error / kSpeedGainFactor * kSpeedIntegral * kTickS;
  }
  // The integral holds no more than what the output has room for.
  integral_ = std::clamp(integral_, std::min(0.0, -kFull - proportional),
                         std::max(0.0, kFull - proportional));
  integral_ = std::clamp(integral_, -kFull, kFull);
  output_ = std::clamp(proportional + integral_, -kFull, kFull);
}

// A limit stops the motor, whatever the mode, and drops the command. True if it did.
bool MotorChannel::stopped_by_limit(double direction) {
  const bool blocked = (direction > 0 && !now_.permit_ccw) || (direction < 0 && !now_.permit_cw);
  if (blocked) stop(settings_.limit_stop_cond != 0 ? Mode::kShort : Mode::kFree);
  return blocked;
}

bool MotorChannel::stopped_by_current() {
  const bool over =
      settings_.tq_limit_sw != 0 && std::fabs(now_.current_a) > 0.9 * max_load_a(model_, settings_);
  over_limit_ms_ = over ? over_limit_ms_ + 1 : 0;
  if (over_limit_ms_ < kCurrentLimitSwitchMs) return false;
  over_limit_ms_ = 0;
  stop(settings_.limit_stop_cond != 0 ? Mode::kShort : Mode::kFree);
  return true;
}

// What becomes of a motor that has been brought to 0 (PID 24).
void MotorChannel::finish() {
  switch (settings_.zero_vel_ctrl) {
    case 1:
      if (!holding_) {
        integral_ = 0;
        goal_ = now_.counts + offset_;
      }
      holding_ = true;
      mode_ = Mode::kSpeed;
      target_ = reference_ = 0;
      break;
    case 2:
      stop(Mode::kShort);
      break;
    default:
      stop(Mode::kFree);
      break;
  }
}

void MotorChannel::control_speed() {
  const double full = settings_.max_rpm;
  if (target_ == 0 && settings_.zero_vel_ctrl == 3) return stop(Mode::kFree);
  const bool grows = std::fabs(target_) > std::fabs(reference_) && target_ * reference_ >= 0;
  const double up = ramp_step(settings_.slow_start, full, now_.slow_start_volume);
  const double down = ramp_step(settings_.slow_down, full, now_.slow_down_volume);
  // A reversal goes through 0.
  const double next = target_ * reference_ < 0 ? 0 : target_;
  reference_ = towards(reference_, next, grows ? up : down);
  if (reference_ == 0 && target_ != 0) reference_ = towards(0, target_, up);

  if (stopped_by_limit(reference_) || stopped_by_current()) return;
  if (target_ == 0 && reference_ == 0 && !holding_ && slow()) finish();
  if (mode_ != Mode::kSpeed) return;
  if (holding_) return hold();

  regulate_speed(reference_, false);
  const bool only_driving = settings_.regeneration == 0;
  if (only_driving && (reference_ == 0 || output_ * reference_ <= 0)) {
    if (reference_ == 0 || integral_ * reference_ < 0) integral_ = 0;
    output_ = 0;
    command_ = {};
    return;
  }
  drive(output_, only_driving);
}

// The servo lock: back to where the motor came to rest. Within a count nothing is integrated: an
// integral of what single Hall edges tell of the speed would swing from edge to edge for ever.
void MotorChannel::hold() {
  const double error = static_cast<double>(goal_ - (now_.counts + offset_));
  const double wanted = settings_.pv_gain / 10.0 * error * rpm_per_count();
  const double most = settings_.max_rpm;
  regulate_speed(std::clamp(wanted, -most, most), std::fabs(error) <= 1);
  drive(output_, false);
}

void MotorChannel::control_position() {
  const std::int64_t here = now_.counts + offset_;
  const double error = static_cast<double>(goal_ - here);
  const double window = std::max(1, settings_.in_position);
  const bool near = std::fabs(error) <= window;
  within_ms_ = near && slow() ? within_ms_ + 1 : 0;
  in_position_ = within_ms_ >= kInPositionMs;
  if (in_position_ && settings_.in_position > 0) {
    finish();
    in_position_ = true;
    return;
  }

  // v = min(Kv |e|, sqrt(2 d |e|), v_max), its growth limited to a; all in rpm.
  const double up = ramp_step(settings_.posi_ss, settings_.max_rpm, 0);
  const double slope = ramp_step(settings_.posi_sd, settings_.max_rpm, 0) / kTickS;  // rpm/s
  const double distance = std::fabs(error) * rpm_per_count();
  const double fastest =
      std::min({settings_.pv_gain / 10.0 * distance, std::sqrt(2 * slope * distance), goal_rpm_});
  const double wanted = std::copysign(fastest, error);
  const bool grows = wanted * reference_ >= 0 && std::fabs(wanted) > std::fabs(reference_);
  if (wanted * reference_ < 0)
    reference_ = towards(reference_, 0, slope * kTickS);
  else
    reference_ = grows ? towards(reference_, wanted, up) : wanted;

  if (stopped_by_limit(reference_) || stopped_by_current()) return;
  regulate_speed(reference_, settings_.in_position == 0 && std::fabs(error) <= 1);
  drive(output_, false);
}

void MotorChannel::control_open_loop() {
  const bool grows = std::fabs(target_) > std::fabs(reference_) && target_ * reference_ >= 0;
  const double step = grows ? ramp_step(settings_.slow_start, kFull, now_.slow_start_volume)
                            : ramp_step(settings_.slow_down, kFull, now_.slow_down_volume);
  const double next = target_ * reference_ < 0 ? 0 : target_;
  reference_ = towards(reference_, next, step);
  if (reference_ == 0 && target_ != 0) {
    reference_ =
        towards(0, target_, ramp_step(settings_.slow_start, kFull, now_.slow_start_volume));
  }
  if (stopped_by_limit(reference_) || stopped_by_current()) return;
  if (target_ == 0 && reference_ == 0) {
    stop(settings_.zero_vel_ctrl == 2 ? Mode::kShort : Mode::kFree);
    return;
  }
  integral_ = reference_;
  drive(reference_, settings_.regeneration == 0);
}

void MotorChannel::control_torque() {
  if (stopped_by_limit(target_) || stopped_by_current()) return;
  if (target_ == 0) {
    output_ = integral_ = 0;
    command_ = {};
    return;
  }
  const double error = target_ - now_.current_a * kFull / max_load_a(model_, settings_);
  const double proportional = settings_.tq_p_gain * error / kTorqueGainFactor;
  integral_ += settings_.tq_i_gain * error / kTorqueGainFactor * kTorqueIntegral * kTickS;
  integral_ = std::clamp(integral_, -kFull, kFull);
  drive(proportional + integral_, false);
}

void MotorChannel::watch() {
  const bool is_speed = mode_ == Mode::kSpeed && !holding_;
  const Watched watched{
      .rpm = now_.rpm,
      .reference_rpm = is_speed ? reference_ : 0,
      .output = output_,
      .current_a = std::fabs(now_.current_a),
      .mean_current_a = mean_current_a_,
      .max_load_a = max_load_a(model_, settings_),
      .max_rpm = static_cast<double>(settings_.max_rpm),
      .bus_v = now_.bus_v,
      .over_v = model_.bus.over,
      .heat_sink_degc = model_.temperature_sensor ? now_.heat_sink_degc : 0,
      .hall = now_.hall,
      .speed_control = is_speed,
      .watches_stall = mode_ != Mode::kTorque && !holding_,
      .encoder_expected = settings_.enc_ppr > 0,
      .encoder_moves = now_.encoder_moves,
  };
  if (protections_.watch(watched) || alarmed()) {
    if (mode_ != Mode::kFree) stop(Mode::kFree);
    command_ = {};
  }
}

}  // namespace virtdrive::md
