// From what is wanted to the voltage: ramp, limits, V/f curve, flying start and DC brake.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware_models/asd7/drive_program.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;
using std::numbers::sqrt2;
using std::numbers::sqrt3;

// Overvoltage limit: what share of its level the two actions span, and where raising begins.
constexpr double kLimitSpan = 0.06, kRaiseFrom = 0.97;
// Riding through lives on the load's energy from this much above MOFF on.
constexpr double kRideFrom = 1.1, kRideSpan = 0.08;
constexpr double kRideHzPerS = 60;
constexpr double kFastestStopS = 0.1;

// Flying start (assumed): a share of the voltage, swept down until the motor gives power.
constexpr double kSearchVoltage = 0.15;
constexpr double kSearchHzPerS = 40;
constexpr SimDuration kSearchSettles = 150ms;
constexpr double kSearchFilterS = 0.01;
constexpr double kSearchThreshold = 0.003;  // of the rated power
constexpr double kRecoveryS = 0.4;

constexpr double kEstimateS = 0.05;
constexpr double kSlipS = 0.1;
constexpr double kDcRiseS = 0.05;

double share(double value) {
  return std::clamp(value, 0.0, 1.0);
}

}  // namespace

void AcDrive::Impl::run(double step_s) {
  if (!output_on()) return;
  if (stage_.on()) estimate(step_s);
  switch (state_) {
    case State::kSearching:
      search(step_s);
      break;
    case State::kRecovering:
      recover(step_s);
      break;
    case State::kDcBraking:
      brake(step_s);
      break;
    case State::kRunning: {
      ramp(step_s);
      if (state_ != State::kRunning) break;
      const double hz = std::max(0.0, ramp_.hz() + raise_hz_ + slip_hz_);
      modulate(hz, curve().at(std::max(0.0, ramp_.hz() + raise_hz_)), step_s);
      break;
    }
    default:
      break;
  }
}

RampRate AcDrive::Impl::ramp_rate() const {
  const Settings& s = settings_;
  const double fastest_hz = s.maximum_frequency * kHundredth;
  const bool above = s.ramp_switch > 0 && ramp_.hz() > s.ramp_switch * kHundredth;
  const bool second = request_.second_ramp || above;
  const auto time_s = [](std::uint16_t tenths) { return std::max(tenths * 0.1, 0.01); };
  const double up_s = time_s(second ? s.acceleration2 : s.acceleration1);
  double down_s = time_s(second ? s.deceleration2 : s.deceleration1);
  if (request_.fastest_stop && !request_.run) down_s = std::min(down_s, kFastestStopS);
  return {.up_hz_per_s = fastest_hz / up_s,
          .down_hz_per_s = fastest_hz / down_s,
          .shape = static_cast<RampShape>(second ? s.ramp_shape2 : s.ramp_shape1),
          .up_s = up_s,
          .down_s = down_s,
          .lower = s.s_lower * 0.01,
          .upper = s.s_upper * 0.01,
          .base_hz = (request_.second_motor ? s.base_frequency2 : s.base_frequency1) * kHundredth};
}

double AcDrive::Impl::wanted_hz(double step_s) {
  const Settings& s = settings_;
  if (!pi_controls()) {
    pi_runs_ = false;
    return request_.hz;
  }
  const double feedback_hz =
      s.pi_feedback == 2 ? vib_hz(asked_.terminals, s) : via_hz(asked_.terminals, s);
  if (!pi_runs_) pi_.start(ramp_.hz(), feedback_hz);
  pi_runs_ = true;
  const double hz = pi_.step(request_.hz, feedback_hz,
                             {.proportional = s.pi_proportional * 0.01,
                              .integral_per_s = s.pi_integral * 0.01,
                              .filter_s = s.pi_filter * 0.1,
                              .least_hz = s.lower_limit * kHundredth,
                              .most_hz = std::min(s.upper_limit, s.maximum_frequency) * kHundredth},
                             step_s);
  return limited_hz(hz, s);
}

/// With the supply gone the load's energy holds the link up.
void AcDrive::Impl::ride_through() {
  const auto how = static_cast<RideThrough>(settings_.ride_through);
  if (how == RideThrough::kOff) return;
  const double from_v = kRideFrom * model_.link.off_below_v;
  if (bus_v_ >= from_v) return;
  if (how == RideThrough::kDecelerate) power_lost_stop_ = true;
  raise_hz_ = -model_.limit_raise_hz * share((from_v - bus_v_) / (kRideSpan * from_v));
}

void AcDrive::Impl::ramp(double step_s) {
  const Settings& s = settings_;
  const double start_hz = s.start_frequency * kHundredth;
  const bool stopping =
      !request_.run || forced_stop_ != Stop::kNone || power_lost_stop_ || lower_limit_stop_;
  const bool turning = request_.reverse != reverse_;
  wanted_hz_ = wanted_hz(step_s);
  const double target = stopping || turning ? 0 : wanted_hz_;
  RampRate rate = ramp_rate();

  raise_hz_ = 0;
  if (s.overvoltage_limit == 0 && s.braking_resistor == 0) {
    const double limit_v = model_.link.limit_v, span_v = kLimitSpan * limit_v;
    rate.down_hz_per_s *= std::max(share((limit_v - bus_v_) / span_v), 1e-6);
    raise_hz_ = model_.limit_raise_hz * share((bus_v_ - kRaiseFrom * limit_v) / span_v);
  }
  ride_through();

  const std::uint16_t level = request_.second_motor ? s.stall_level2 : s.stall_level1;
  const int guard = s.motor_guard % 4;
  const bool stall = (guard == 0 || guard == 2) && level < 200;
  const bool stalled = stall && current_a_ > level * 0.01 * model_.rated_current_a;
  if (raise_hz_ < 0) {
    const double depth = -raise_hz_ / model_.limit_raise_hz;
    rate.down_hz_per_s = kRideHzPerS * depth;
    rate.shape = RampShape::kLinear;
    ramp_.follow(std::min(ramp_.hz(), start_hz), rate, step_s);
  } else if (stalled && target < ramp_.hz()) {
    ramp_.hold();
  } else if (stalled) {
    rate.shape = RampShape::kLinear;
    ramp_.follow(std::min(ramp_.hz(), start_hz), rate, step_s);
  } else {
    ramp_.follow(target, rate, step_s);
  }

  // At the lower limit for long enough it may stop by itself.
  const bool at_least = !stopping && s.lower_limit_stop > 0 && ramp_.hz() == wanted_hz_ &&
                        wanted_hz_ <= s.lower_limit * kHundredth;
  at_lower_limit_s_ = at_least ? at_lower_limit_s_ + step_s : 0;
  if (at_least && at_lower_limit_s_ >= s.lower_limit_stop * 0.1) lower_limit_stop_ = true;

  const double brake_hz = s.dc_brake_frequency * kHundredth;
  const bool ends = stopping && !turning;
  if (ends && brake_hz > 0 && ramp_.hz() <= brake_hz) {
    begin_dc_brake(s.dc_brake_time * 0.1);
  } else if (target < start_hz && ramp_.hz() < start_hz) {
    end_stop();
  }
}

VoltageCurve AcDrive::Impl::curve() const {
  const Settings& s = settings_;
  const bool second = request_.second_motor;
  return {.kind = static_cast<VoltsPerHertz>(s.volts_per_hertz),
          .motor_v = motor_v_,
          .base_hz = (second ? s.base_frequency2 : s.base_frequency1) * kHundredth,
          .boost = (second ? s.torque_boost2 : s.torque_boost1) * 1e-3,
          .drop_v = drop_v_};
}

void AcDrive::Impl::modulate(double hz, double line_v, double step_s) {
  constexpr double kCircle = 2 * pi;
  const double way = reverse_ ? -1 : 1;
  if (settings_.supply_correction < 2) line_v *= bus_v_ / link_nominal_v_;
  line_v = std::min(line_v, bus_v_ / sqrt2);
  output_hz_ = way * hz;
  // The vector stands for the coming turn: that of its middle.
  angle_rad_ += kCircle * output_hz_ * std::min(step_s, kTurnS);
  if (std::fabs(angle_rad_) > kCircle) angle_rad_ = std::fmod(angle_rad_, kCircle);
  const Rotation r(angle_rad_ + kCircle * output_hz_ * kTurnS / 2);
  const double peak_v = line_v * sqrt2 / sqrt3;
  voltage_ = stage_.put({peak_v * r.cosine, peak_v * r.sine}, bus_v_);
  line_v_ = line_v;
}

/// Of the turn that has just ended: its voltage and the current at its end.
void AcDrive::Impl::estimate(double step_s) {
  const double gain = std::min(1.0, step_s / kEstimateS);
  const AlphaBeta i = now_.current, v = voltage_;
  const double length = std::hypot(v.alpha, v.beta);
  const double dot = v.alpha * i.alpha + v.beta * i.beta;
  const double cross = v.beta * i.alpha - v.alpha * i.beta;
  if (length > 0) {
    active_a_ += gain * (dot / length - active_a_);
    reactive_a_ += gain * ((reverse_ ? -cross : cross) / length - reactive_a_);
  }
  const double power_w = 1.5 * dot;
  output_w_ += gain * (power_w - output_w_);
  const double gap_w = power_w - 3 * model_.stator_ohm * now_.current2;
  search_w_ += std::min(1.0, step_s / kSearchFilterS) * (gap_w - search_w_);
  const double hz = std::fabs(output_hz_);
  const double pairs = std::round(60 * model_.supply_hz / settings_.rated_rpm);
  const double torque_nm = hz > 1 ? gap_w * pairs / (2 * pi * hz) : 0;
  torque_nm_ += gain * (torque_nm - torque_nm_);
  const double rated_nm = model_.power_w / (settings_.rated_rpm * pi / 30);
  const double rated_slip_hz = std::max(0.0, model_.supply_hz - settings_.rated_rpm * pairs / 60.0);
  const double load = torque_nm_ / rated_nm;
  const double way = reverse_ ? -1 : 1;
  speed_hz_ = state_ == State::kDcBraking ? 0 : way * (hz - rated_slip_hz * load);
  const auto kind = static_cast<VoltsPerHertz>(settings_.volts_per_hertz);
  if (kind == VoltsPerHertz::kAutomaticBoostAndSlip) {
    const double slip_hz = settings_.slip_gain * 0.01 * rated_slip_hz * load;
    slip_hz_ += std::min(1.0, step_s / kSlipS) * (slip_hz - slip_hz_);
  } else {
    slip_hz_ = 0;
  }
  // Without the magnetizing current's own feedback, which would run away.
  const double motor_a = settings_.rated_current * 0.1;
  const double drop = std::hypot(settings_.no_load_current * 0.01, active_a_ / sqrt2 / motor_a);
  drop_v_ = motor_v_ * settings_.boost_gain * 1e-3 * drop;
}

// --- Flying start --------------------------------------------------------------------------------

void AcDrive::Impl::search(double step_s) {
  const SimDuration passed = loop_.now() - state_since_;
  const double rise = share(seconds(passed) / (seconds(kSearchSettles) / 2));
  if (passed > kSearchSettles) {
    search_hz_ -= kSearchHzPerS * step_s;
    const double least_w = kSearchThreshold * model_.power_w;
    search_driven_ = search_driven_ || search_w_ > least_w;
    if (search_w_ < 0 && (search_driven_ || search_w_ < -least_w)) {
      state_ = State::kRecovering;
      recovery_ = 0;
      ramp_.put(search_hz_);
    }
  }
  const double start_hz = settings_.start_frequency * kHundredth;
  if (search_hz_ <= start_hz) {
    reverse_ = request_.reverse;
    begin_running(start_hz);
    return;
  }
  const double base_hz = curve().base_hz;
  modulate(search_hz_, rise * kSearchVoltage * motor_v_ * std::min(1.0, search_hz_ / base_hz),
           step_s);
}

void AcDrive::Impl::recover(double step_s) {
  recovery_ += step_s / kRecoveryS;
  const double line_v = curve().at(search_hz_);
  modulate(search_hz_, line_v * std::min(1.0, kSearchVoltage + (1 - kSearchVoltage) * recovery_),
           step_s);
  if (recovery_ < 1) return;
  const SimTime since = state_since_;
  begin_running(search_hz_);
  state_since_ = since;  // a flying start is no start from rest
}

// --- DC brake ------------------------------------------------------------------------------------

void AcDrive::Impl::brake(double step_s) {
  dc_left_s_ -= step_s;
  const bool over = dc_forced_ ? !request_.dc_brake : dc_left_s_ <= 0;
  if (over) {
    if (forced_stop_ != Stop::kNone) return trip(trip_after_stop_);
    return switch_off();
  }
  if (!dc_forced_ && request_.run && may_run() && request_.hz > 0) {
    switch_off();
    return begin_output();
  }
  output_hz_ = 0;
  // rms as the monitor counts it: the vector is sqrt(2) of that.
  const double wanted_a = sqrt2 * settings_.dc_brake_current * 0.01 * model_.rated_current_a;
  const double now_a = std::sqrt(2 * now_.current2);
  dc_v_ += model_.stator_ohm * (wanted_a - now_a) * step_s / kDcRiseS;
  dc_v_ = std::clamp(dc_v_, 0.0, 2 * model_.stator_ohm * wanted_a);
  const Rotation r(angle_rad_);
  voltage_ = stage_.put({dc_v_ * r.cosine, dc_v_ * r.sine}, bus_v_);
  line_v_ = dc_v_ * sqrt3 / sqrt2;
}

}  // namespace virtdrive::asd7
