// The protections of AcDrive.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware_models/asd7/drive_program.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;
using std::numbers::sqrt2;

constexpr double kOverCurrent = 2.2;  // of the rated peak
constexpr SimDuration kStarting = 100ms;
constexpr double kHeatSinkTripDegc = 95, kHeatSinkAlarmDegc = 85;
constexpr double kInverterT150S = 60;
constexpr double kFarOver = 1.8, kFarOverS = 2;
constexpr double kAlarmLevel = 0.5;
constexpr double kMoffTripS = 0.05;
constexpr double kRippleWindowS = 0.025;
constexpr double kRippleOfLostPhase = 0.03;  // of the link, peak to peak, assumed
constexpr double kInputPhaseS = 10, kInputPhaseCurrent = 0.5;
constexpr double kOutputPhaseS = 1;

}  // namespace

Trip AcDrive::Impl::by_motion(Trip accelerating, Trip decelerating, Trip other) const {
  if (state_ != State::kRunning || ramp_.slope() == 0) return other;
  return ramp_.slope() > 0 ? accelerating : decelerating;
}

void AcDrive::Impl::guard_fast() {
  if (tripped()) return;
  const double limit_a = kOverCurrent * sqrt2 * model_.rated_current_a;
  const auto over = [&](double i) { return std::fabs(i) > limit_a; };
  if (output_on() && std::ranges::any_of(now_.current_a, over)) {
    const bool starting = loop_.now() - state_since_ < kStarting && state_ == State::kRunning;
    return trip(starting ? Trip::kOcl : by_motion(Trip::kOc1, Trip::kOc2, Trip::kOc3));
  }
  if (bus_v_ > model_.link.trip_v) trip(by_motion(Trip::kOp1, Trip::kOp2, Trip::kOp3));
}

void AcDrive::Impl::guard_slow(double step_s) {
  guard_overload(step_s);
  if (state_ != State::kTripped) {
    switch (injected_) {
      case Trip::kErr2:
      case Trip::kErr3:
      case Trip::kErr4:
      case Trip::kErr7:
        trip(injected_);
        break;
      case Trip::kEf2:
        if (output_on()) trip(injected_);
        break;
      default:
        break;
    }
    if (asked_.terminals.thermistor) trip(Trip::kOh2);
    if (heat_sink_degc_ > kHeatSinkTripDegc) trip(Trip::kOh);
  }
  guard_phases(step_s);
  guard_load(step_s);
  if (moff_.see(undervoltage_ && request_.run && !tripped(), kMoffTripS, step_s) &&
      settings_.undervoltage_trip == 1) {
    trip(Trip::kUp1);
  }
  look_at_alarms();
}

void AcDrive::Impl::guard_overload(double step_s) {
  const double r = current_a_ / model_.rated_current_a;
  inverter_.step(r, kInverterT150S, step_s);
  const double hz = ramp_.hz(), knee_hz = settings_.derating_frequency * 0.01;
  const bool own_fan = settings_.motor_guard < 4;
  const double cooling = own_fan && hz < knee_hz ? 0.6 + 0.4 * hz / knee_hz : 1;
  const double protection =
      (request_.second_motor ? settings_.motor_protection2 : settings_.motor_protection1) * 0.01;
  const double motor_a = protection * settings_.rated_current * 0.1 * cooling;
  if (motor_a > 0 && settings_.motor_overload_time > 0) {
    motor_.step(current_a_ / motor_a, settings_.motor_overload_time, step_s);
  }
  const double ohm = settings_.resistor_ohm * 0.1;
  const bool braking = settings_.braking_resistor != 0;
  if (braking && ohm > 0) {
    const double power_w = axis_.bus().chopper_on() ? bus_v_ * bus_v_ / ohm : 0;
    resistor_.step(power_w, settings_.resistor_power * 10.0, step_s);
  }
  if (!output_on()) return;
  if (inverter_.full() || far_over_.see(r > kFarOver, kFarOverS, step_s)) return trip(Trip::kOl1);
  const int guard = settings_.motor_guard % 4;
  if (motor_.full() && (guard == 0 || guard == 1)) return trip(Trip::kOl2);
  if (resistor_.full() && braking) trip(Trip::kOlr);
}

void AcDrive::Impl::guard_phases(double step_s) {
  // A lost phase of the supply shows as ripple at twice its frequency.
  bus_high_v_ = std::max(bus_high_v_, bus_v_);
  bus_low_v_ = std::min(bus_low_v_, bus_v_);
  ripple_left_s_ -= step_s;
  if (ripple_left_s_ <= 0) {
    ripple_v_ = bus_high_v_ - bus_low_v_;
    bus_high_v_ = bus_low_v_ = bus_v_;
    ripple_left_s_ = kRippleWindowS;
  }
  if (!output_on() || tripped()) {
    input_phase_.clear();
    output_phase_.clear();
    return;
  }
  const bool rippled = ripple_v_ > kRippleOfLostPhase * bus_shown_v_ &&
                       shown_current_a_ > kInputPhaseCurrent * model_.rated_current_a;
  if (input_phase_.see(rippled && settings_.input_phase_guard == 1, kInputPhaseS, step_s)) {
    return trip(Trip::kEphi);
  }
  const auto [least, most] = std::minmax({phase_squares_[0], phase_squares_[1], phase_squares_[2]});
  const double some_a = 0.1 * model_.rated_current_a;
  const bool lost = state_ == State::kRunning && most > some_a * some_a && least < 0.0025 * most;
  if (output_phase_.see(lost && settings_.output_phase_guard == 1, kOutputPhaseS, step_s)) {
    trip(Trip::kEpho);
  }
}

void AcDrive::Impl::guard_load(double step_s) {
  if (!output_on() || tripped()) {
    low_current_.clear();
    over_torque_.clear();
    alarms_ &= static_cast<std::uint16_t>(~(kAlarmLowCurrent | kAlarmOverTorque));
    return;
  }
  const bool low = current_a_ < settings_.low_current * 0.01 * model_.rated_current_a;
  const double rated_nm = model_.power_w / (settings_.rated_rpm * pi / 30);
  const bool over =
      settings_.over_torque > 0 && std::fabs(torque_nm_) > settings_.over_torque * 0.01 * rated_nm;
  const auto flag = [&](AlarmBit bit, bool on) {
    alarms_ = static_cast<std::uint16_t>(on ? alarms_ | bit : alarms_ & ~bit);
  };
  const bool low_lasts = low_current_.see(low, settings_.low_current_time, step_s);
  const bool over_lasts = over_torque_.see(over, settings_.over_torque_time * 0.1, step_s);
  flag(kAlarmLowCurrent, low_lasts);
  flag(kAlarmOverTorque, over_lasts);
  if (low_lasts && settings_.low_current_trip == 1) return trip(Trip::kUc);
  if (over_lasts && settings_.over_torque_trip == 1) trip(Trip::kOt);
}

void AcDrive::Impl::look_at_alarms() {
  unsigned bits = alarms_ & (kAlarmLowCurrent | kAlarmOverTorque);
  const double stall_level =
      (request_.second_motor ? settings_.stall_level2 : settings_.stall_level1) * 0.01;
  if (current_a_ > stall_level * model_.rated_current_a) bits |= kAlarmOverCurrent;
  if (inverter_.level() >= kAlarmLevel) bits |= kAlarmInverterOverload;
  if (motor_.level() >= kAlarmLevel) bits |= kAlarmMotorOverload;
  if (resistor_.level() >= kAlarmLevel) bits |= kAlarmResistorOverload;
  if (heat_sink_degc_ >= kHeatSinkAlarmDegc) bits |= kAlarmHeatSink;
  if (bus_v_ > model_.link.limit_v) bits |= kAlarmOverVoltage;
  if (undervoltage_) bits |= kAlarmUnderVoltage;
  if (communication_alarm_) bits |= kAlarmCommunication;
  if (power_lost_stop_) bits |= kAlarmPowerLossStop;
  if (lower_limit_stop_) bits |= kAlarmLowerLimitStop;
  const std::uint64_t hours = memory_.run_seconds / 3600;
  if (settings_.run_hours_alarm > 0 && hours >= 100ULL * settings_.run_hours_alarm) {
    bits |= kAlarmRunHours;
  }
  alarms_ = static_cast<std::uint16_t>(bits);
}

}  // namespace virtdrive::asd7
