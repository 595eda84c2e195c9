#include "firmware_models/toshiba_mcu/motor_channel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kZeroCurrentPeriods = 4;
constexpr double kCommandLag = 0.1;     // of torque control: the command follows the speed in 10 ms
constexpr double kMostTorqueMnm = 2e7;  // 100 times that still fits the telegram's 32 bits
constexpr double kForceHysteresis = 0.95;  // FOC falls back to Force at 5 % below SpeedChange
constexpr double kEmergencyVoltage =
    30;  // the driver block's over-voltage pin, 24 V board; assumed
constexpr double kDisconnectSpeed = 1000.0 / 32768;  // of full scale
constexpr int kDisconnectPeriods = 1000;
constexpr int kFirstStallCheckMs = 500;
constexpr double kStallEmfRatio = 0.7;
constexpr int kBadStallChecks = 2;
constexpr std::int32_t kRestartPositionDelayMs = 100;
constexpr int kHotChecks = 5;
constexpr double kTemperatureHysteresis = 5;

double with_sign_of(double magnitude, double sign) {
  return std::copysign(magnitude, sign);
}

}  // namespace

MotorChannel::MotorChannel(const ChannelSettings& settings) {
  set_settings(settings);
}

void MotorChannel::set_settings(const ChannelSettings& settings) {
  settings_ = settings;
  scaling_ = scale(settings_);
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
  if ((errors_ & bit(Fault::kOverTemperature)) != 0) return Outcome::kNotReady;
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
  iq_integral_a_ = now_.iq_ref_a;
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
  const auto limit = static_cast<std::int32_t>(scaling_.speed_limit_hz * 60 / scaling_.pole_pairs);
  rpm = std::clamp(rpm, -limit, limit);
  const bool wrong =
      (rpm < 0 && settings_.direction.value == 0) || (rpm > 0 && settings_.direction.value == 1);
  if (wrong)
    errors_ |= bit(Fault::kWrongDirection);
  else
    errors_ &= ~bit(Fault::kWrongDirection);
  set_target(wrong ? 0 : rpm);
}

void MotorChannel::set_target(std::int32_t rpm) {
  set_rpm_ = rpm;
  end_speed_reduction();
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
  for (const double hz : omega_history_hz_) sum += hz;
  return static_cast<std::int32_t>(sum / static_cast<double>(omega_history_hz_.size()) * 60 /
                                   scaling_.pole_pairs);
}

std::int32_t MotorChannel::target_rpm() const {
  return pwm_active() ? set_rpm_ : 0;
}

std::uint32_t MotorChannel::current_ma() const {
  return energised() ? static_cast<std::uint32_t>(std::abs(iq_integral_a_) * 1000) : 0;
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
      omega_history_hz_ = {};
      iq_integral_a_ = 0;
      now_.command_hz = now_.omega_hz = 0;
      break;
    case Stage::kBrake:
      output_.mode = Bridge::kShort;
      output_.short_share = settings_.brake_percentage.value / 100.0;
      forget_measurements();
      break;
    case Stage::kZeroCurrentMeasure:
      output_.mode = Bridge::kOff;
      zero_periods_ = 0;
      zero_sum_ = {};
      break;
    case Stage::kInitPosition:
      now_.theta_turns = 0;
      sine_ = 0;
      cosine_ = 1;
      break;
    case Stage::kForce:
      end_speed_reduction();
      if (from == Stage::kFoc) break;
      iq_integral_a_ = with_sign_of(scaling_.iq_start_a, set_rpm_ < 0 ? -1 : 1);
      break;
    case Stage::kFoc:
      iq_integral_a_ = with_sign_of(scaling_.iq_start_a, now_.command_hz);
      bad_stall_checks_ = 0;
      good_emf_per_hz_ = 0;
      break;
  }
  if (from == Stage::kZeroCurrentMeasure) d_integral_v_ = q_integral_v_ = 0;
}

// Nothing is measured or controlled any more; the angle may still be of use.
void MotorChannel::forget_measurements() {
  now_ = {.theta_turns = now_.theta_turns};
}

void MotorChannel::halt() {
  rpm_before_stop_.reset();
  end_speed_reduction();
  restart_in_polls_ = 0;
  angle_known_ = false;
  enter(Stage::kStop);
}

void MotorChannel::trip(Fault fault) {
  errors_ |= bit(fault);
  rpm_before_stop_.reset();
  end_speed_reduction();
  angle_known_ = false;
  enter(Stage::kEmergency);
}

// --- 1 kHz and slower ----------------------------------------------------------------------------

void MotorChannel::millisecond(const AdcReading& reading) {
  if (stage_ == Stage::kStop || stage_ == Stage::kEmergency) return;
  ++stage_ms_;
  if (pwm_active()) watch_bus(reading);
  switch (stage_) {
    case Stage::kBootstrap:
      if (stage_ms_ >= settings_.bootstrap_delay.value) enter(Stage::kZeroCurrentMeasure);
      break;
    case Stage::kBrake:
      if (stage_ms_ >= settings_.brake_time.value) halt();
      break;
    case Stage::kInitPosition: {
      const double part = position_delay_ms_ > 0 ? double(stage_ms_) / position_delay_ms_ : 1;
      iq_integral_a_ =
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
  omega_history_hz_[omega_index_] = now_.omega_hz;
  omega_index_ = (omega_index_ + 1) % omega_history_hz_.size();
}

double MotorChannel::target_hz() const {
  return reduced_target_hz_.value_or(set_rpm_ * scaling_.pole_pairs / 60);
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

void MotorChannel::watch_bus(const AdcReading& reading) {
  const double volts = reading.bus_counts * scaling_.bus_v_per_count;
  const std::int32_t over = settings_.over_voltage.value;
  const std::int32_t under = settings_.under_voltage.value;
  if (over > 0 && volts > over) trip(Fault::kSoftwareOverVoltage);
  if (under > 0 && volts < under) trip(Fault::kSoftwareUnderVoltage);
}

void MotorChannel::poll() {
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

void MotorChannel::watch_stall() {
  if (stage_ != Stage::kFoc || stage_ms_ < kFirstStallCheckMs || scaling_.stall_voltage_v <= 0) {
    return;
  }
  const double sign = now_.omega_hz < 0 ? -1 : 1;
  const double vqi = sign * q_integral_v_;
  const double emf_per_hz = (vqi - scaling_.resistance_ohm * sign * now_.iq_ref_a) /
                            std::max(std::abs(now_.omega_hz), 1e-3);
  if (vqi >= scaling_.stall_voltage_v && emf_per_hz >= kStallEmfRatio * good_emf_per_hz_) {
    good_emf_per_hz_ = emf_per_hz;
    bad_stall_checks_ = 0;
    errors_ &= ~bit(Fault::kStall);
    return;
  }
  if (++bad_stall_checks_ < kBadStallChecks) return;
  halt();
  errors_ |= bit(Fault::kStall);
  restart_in_polls_ = settings_.restart_mode.value == 1 ? 1 : 0;
}

void MotorChannel::temperature_check(double degc) {
  const double limit = settings_.over_temperature.value;
  if (degc >= limit) {
    if (++hot_checks_ <= kHotChecks || (errors_ & bit(Fault::kOverTemperature)) != 0) return;
    halt();
    errors_ |= bit(Fault::kOverTemperature);
  } else {
    hot_checks_ = 0;
    if (degc < limit - kTemperatureHysteresis) errors_ &= ~bit(Fault::kOverTemperature);
  }
}

// --- Each PWM period -----------------------------------------------------------------------------

void MotorChannel::pwm_interrupt(const AdcReading& reading) {
  if (stage_ == Stage::kZeroCurrentMeasure) {
    measure_zero_current(reading);
    return;
  }
  if (!energised()) return;
  measure(reading);
  if (protect(reading)) return;
  advance_angle();
  set_current_reference();
  control_currents();
}

void MotorChannel::measure_zero_current(const AdcReading& reading) {
  for (std::size_t i = 0; i < 3; ++i) zero_sum_[i] += reading.current_counts[i];
  if (++zero_periods_ < kZeroCurrentPeriods) return;
  for (std::size_t i = 0; i < 3; ++i) {
    zero_counts_[i] = static_cast<double>(zero_sum_[i]) / kZeroCurrentPeriods;
  }
  enter(angle_known_ ? Stage::kForce : Stage::kInitPosition);
  angle_known_ = false;
}

void MotorChannel::measure(const AdcReading& reading) {
  const double sign = settings_.sensor_direction.value == 1 ? -1 : 1;
  const double gain = sign * scaling_.current_a_per_count;
  const double a = gain * (reading.current_counts[0] - zero_counts_[0]);
  const double b = gain * (reading.current_counts[1] - zero_counts_[1]);
  const double c = gain * (reading.current_counts[2] - zero_counts_[2]);
  const double alpha = (2 * a - b - c) / 3;
  const double beta = (b - c) / std::numbers::sqrt3;
  now_.id_a = cosine_ * alpha + sine_ * beta;
  now_.iq_a = cosine_ * beta - sine_ * alpha;
  now_.bus_v = reading.bus_counts * scaling_.bus_v_per_count;
}

bool MotorChannel::protect(const AdcReading& reading) {
  const auto at_rail = [](int counts) { return counts <= 0 || counts >= kAdcMaximum; };
  if (std::ranges::any_of(reading.current_counts, at_rail)) {
    trip(Fault::kEmergency);
  } else if (now_.bus_v > kEmergencyVoltage) {
    trip(Fault::kOverVoltage);
  } else if (scaling_.over_current_a > 0 && std::abs(now_.iq_a) > scaling_.over_current_a) {
    trip(Fault::kSoftwareOverCurrent);
  } else if (stage_ == Stage::kForce &&
             std::abs(now_.command_hz) >= kDisconnectSpeed * scaling_.full_scale_hz) {
    const double current = std::hypot(now_.id_a, now_.iq_a);
    const bool missing = current < (scaling_.id_start_a + scaling_.iq_start_a) / 5;
    disconnected_periods_ = missing ? disconnected_periods_ + 1 : 0;
    if (disconnected_periods_ > kDisconnectPeriods) trip(Fault::kNoMotor);
  } else {
    disconnected_periods_ = 0;
  }
  return stage_ == Stage::kEmergency;
}

void MotorChannel::advance_angle() {
  switch (stage_) {
    case Stage::kForce:
      now_.omega_hz = now_.command_hz;
      break;
    case Stage::kFoc: {
      // The d-axis back-EMF is zero when the frame lies on the rotor, positive when it leads.
      const double emf_d = now_.vd_v - scaling_.resistance_ohm * now_.id_a +
                           kTwoPi * now_.omega_hz * scaling_.inductance_h * now_.iq_a;
      const double estimate =
          now_.command_hz - with_sign_of(scaling_.position_kp_hz_per_v, now_.command_hz) * emf_d;
      // The register ends at full scale.
      now_.omega_hz = std::clamp(estimate, -scaling_.full_scale_hz, scaling_.full_scale_hz);
      break;
    }
    default:
      now_.omega_hz = 0;
      return;
  }
  now_.theta_turns += now_.omega_hz * 1e-9 * static_cast<double>(scaling_.pwm_period.count());
  now_.theta_turns -= std::floor(now_.theta_turns);
  sine_ = std::sin(kTwoPi * now_.theta_turns);
  cosine_ = std::cos(kTwoPi * now_.theta_turns);
}

void MotorChannel::set_current_reference() {
  now_.id_ref_a = 0;
  if (stage_ != Stage::kFoc) {
    if (stage_ == Stage::kForce && now_.command_hz != 0) {
      iq_integral_a_ = with_sign_of(scaling_.iq_start_a, now_.command_hz);
    }
    now_.iq_ref_a = iq_integral_a_;
  } else if (method_ == Method::kTorque) {
    control_torque();
  } else {
    control_speed();
  }
}

// The torque asked for, lowered by the speed controller when the set speed is reached.
void MotorChannel::control_torque() {
  const double sign = set_rpm_ < 0 ? -1 : 1;
  const double wanted =
      scaling_.torque_nm_per_a > 0 ? torque_mnm_ * 1e-3 / scaling_.torque_nm_per_a : 0;
  const double limit = std::min(wanted, scaling_.iq_limit_a);
  const double error = sign * (target_hz() - now_.omega_hz);
  const double integral =
      std::clamp(sign * iq_integral_a_ + scaling_.speed_ki_a_per_hz * error, 0.0, limit);
  iq_integral_a_ = sign * integral;
  now_.iq_ref_a = sign * std::clamp(integral + scaling_.speed_kp_a_per_hz * error, 0.0, limit);
}

void MotorChannel::control_speed() {
  const double limit = scaling_.iq_limit_a;
  const double error = now_.command_hz - now_.omega_hz;
  iq_integral_a_ = std::clamp(iq_integral_a_ + scaling_.speed_ki_a_per_hz * error, -limit, limit);
  now_.iq_ref_a = std::clamp(iq_integral_a_ + scaling_.speed_kp_a_per_hz * error, -limit, limit);
}

void MotorChannel::control_currents() {
  const double error_d = now_.id_ref_a - now_.id_a;
  const double error_q = now_.iq_ref_a - now_.iq_a;
  d_integral_v_ += scaling_.id_ki * error_d;
  q_integral_v_ += scaling_.iq_ki * error_q;
  double vd = d_integral_v_ + scaling_.id_kp * error_d;
  double vq = q_integral_v_ + scaling_.iq_kp * error_q;

  // The space vector's circle; both integrators are calculated back from what is put out.
  const double limit = now_.bus_v / std::numbers::sqrt3;
  const double square = vd * vd + vq * vq;
  if (square > limit * limit) {
    const double share = limit / std::sqrt(square);
    vd *= share;
    vq *= share;
    d_integral_v_ = vd - scaling_.id_kp * error_d;
    q_integral_v_ = vq - scaling_.iq_kp * error_q;
  }
  now_.vd_v = vd;
  now_.vq_v = vq;
  modulate(cosine_ * vd - sine_ * vq, sine_ * vd + cosine_ * vq);
}

void MotorChannel::modulate(double v_alpha, double v_beta) {
  const double scale = now_.bus_v > 0 ? 1 / now_.bus_v : 0;
  const double half_beta = std::numbers::sqrt3 / 2 * v_beta;
  const std::array<double, 3> phase = {v_alpha * scale, (-v_alpha / 2 + half_beta) * scale,
                                       (-v_alpha / 2 - half_beta) * scale};
  // Space-vector modulation: the zero-sequence that centres the three duties.
  const auto [low, high] = std::ranges::minmax(phase);
  const double centre = 0.5 - (low + high) / 2;
  output_.mode = Bridge::kDriven;
  for (std::size_t i = 0; i < 3; ++i) output_.duty[i] = std::clamp(phase[i] + centre, 0.0, 1.0);
}

}  // namespace virtdrive::toshiba_mcu
