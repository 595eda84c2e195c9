#include "firmware_models/md/power_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

// 16 kHz; near the limit the comparator is looked at eight times a period. Assumed, as are the
// converter (12 bits over four times the rated current) and its noise.
constexpr SimDuration kPwmPeriod = 62'500ns;
constexpr int kSlices = 8;
constexpr double kWatchedFrom = 0.6;  // of the limit
constexpr Adc kAdc{.bits = 12, .reference_v = 5.0};
constexpr double kFullScale = 4;   // of the rated current
constexpr double kNoise = 5e-4;    // of the rated current
constexpr double kBraking = 0.01;  // of the rated current: less is noise

}  // namespace

PowerStage::PowerStage(EventLoop& loop, Axis& axis, double rated_current_a, const Seed& seed,
                       std::string_view name)
    : loop_(loop),
      axis_(axis),
      noise_(seed.stream(name)),
      shunt_{.adc = kAdc,
             .volts_per_amp = kAdc.reference_v / 2 / (kFullScale * rated_current_a),
             .noise_a = kNoise * rated_current_a},
      bus_(axis.bus()),
      has_chopper_(bus_.parameters().chopper.on_v > 0),
      pwm_(loop.add(Phase::kControl, [this] { period(); })) {
  advance();
}

// --- Sensors -------------------------------------------------------------------------------------

void PowerStage::advance() {
  axis_.advance_to(loop_.now());
  if (has_chopper_ && bus_.chopper_on()) braking_ += loop_.now() - seen_at_;
  see_hall();
}

// The capture unit takes the time of the last edge: between two looks the rotor turns evenly.
void PowerStage::see_hall() {
  const double electrical_rad = axis_.parameters().motor.pole_pairs * axis_.state().angle_rad;
  const SimTime now = loop_.now();
  const std::uint8_t code = sensors_.hall.bits(electrical_rad);
  if (code != code_) {
    const double moved_rad = electrical_rad - seen_at_rad_;
    const auto edge_rad = sensors_.hall.next_edge_rad(electrical_rad, moved_rad < 0);
    const double share = edge_rad && moved_rad != 0 ? (*edge_rad - seen_at_rad_) / moved_rad : 1;
    hall_.see(code, seen_at_ + from_seconds(seconds(now - seen_at_) * std::clamp(share, 0.0, 1.0)));
  }
  code_ = code;
  seen_at_rad_ = electrical_rad;
  seen_at_ = now;
}

void PowerStage::see_encoder() {
  if (sensors_.encoder.lines == 0) return;
  encoder_.see(sensors_.encoder.count(axis_.state().angle_rad), !sensors_.encoder.cable_broken);
}

void PowerStage::set_sensors(const StageSensors& sensors) {
  advance();
  see_encoder();
  const bool other = sensors.encoder.lines != sensors_.encoder.lines;
  sensors_ = sensors;
  shunt_.fault = sensors.shunt;
  if (other) encoder_ = {};
  see_encoder();
}

double PowerStage::sample_current() {
  if (!driving_) return 0;
  const double seen = overlapped_ ? overlapped_current_a(sector(), axis_.leg_currents_a())
                                  : pair_current_a(sector(), axis_.leg_currents_a());
  const double counts = shunt_.counts(seen, noise_) - shunt_.zero_counts();
  return counts * kAdc.reference_v / (kAdc.full_scale() + 1) / shunt_.volts_per_amp;
}

PowerStage::Reading PowerStage::read() {
  advance();
  see_encoder();
  current_a_ = sample_current();
  const double mean = current_samples_ > 0 ? current_sum_a_ / current_samples_ : current_a_;
  current_sum_a_ = 0;
  current_samples_ = 0;
  const SimDuration since = loop_.now() - std::exchange(read_at_, loop_.now());
  const SimDuration braking = std::exchange(braking_, SimDuration{});
  return {.current_a = mean,
          .limited = std::exchange(limited_, false),
          .bus_v = std::round(axis_.state().bus_v * 10) / 10,
          .hall = code_,
          .encoder = encoder_.count(),
          .brake_share = since > SimDuration{} ? seconds(braking) / seconds(since) : 0};
}

// --- Gates ---------------------------------------------------------------------------------------

void PowerStage::command(const StageCommand& command) {
  command_ = command;
  held_off_ = false;
  switch (command_.mode) {
    case StageCommand::Mode::kFree:
      cut({.mode = Bridge::kOff});
      break;
    case StageCommand::Mode::kShort:
      cut({.mode = Bridge::kShort});
      break;
    case StageCommand::Mode::kDriven:
      if (bridge_ != Bridge::kDriven && !cut_) drive_bridge();
      break;
  }
  follow();
}

void PowerStage::period() {
  advance();
  const bool begins = slice_ == 0;
  if (command_.mode == StageCommand::Mode::kDriven) {
    current_a_ = sample_current();
    current_sum_a_ += current_a_;
    ++current_samples_;
    const double along = current_a_ * (command_.output < 0 ? -1 : 1);
    if (begins) cut_ = false;
    if (command_.only_driving &&
        along < -kBraking * shunt_.adc.reference_v / 2 / shunt_.volts_per_amp / kFullScale) {
      held_off_ = true;
    }
    if (held_off_) {
      cut({.mode = Bridge::kOff});
    } else if (std::fabs(current_a_) > command_.limit_a) {
      // At first a driving current goes on in the low sides; a braking one, or one that the rotor
      // drives on, goes into the link.
      const bool circulates = along > 0 && !cut_;
      limited_ = cut_ = true;
      cut(circulates ? six_step(sector(), 0, kPwmPeriod) : BridgeCommand{.mode = Bridge::kOff});
      driving_ = circulates;
    } else if (!cut_) {
      drive_bridge();
    }
  }
  follow();
}

void PowerStage::drive_bridge() {
  if (!hall_sector(code_)) return cut({.mode = Bridge::kOff});
  overlapped_ = overlaps();
  axis_.set_bridge(overlapped_ ? six_step_overlapped(sector(), command_.output, kPwmPeriod)
                               : six_step(sector(), command_.output, kPwmPeriod));
  bridge_ = Bridge::kDriven;
  driving_ = true;
}

void PowerStage::cut(const BridgeCommand& command) {
  if (bridge_ == command.mode && command.mode != Bridge::kDriven) return;
  axis_.set_bridge(command);
  bridge_ = command.mode;
  driving_ = false;
}

// The sector to commutate for: that of the Hall code, or with a phase lead the next one already.
int PowerStage::sector() const {
  const int here = hall_sector(code_).value_or(0);
  const SimDuration interval = hall_.last_interval();
  if (command_.lead_deg <= 0 || interval <= SimDuration{}) return here;
  const SimDuration since = loop_.now() - hall_.last_edge();
  if (seconds(since) < seconds(interval) * (1 - command_.lead_deg / 60) || since > 2 * interval) {
    return here;
  }
  return (here + (command_.output < 0 ? 5 : 1)) % 6;
}

// For the last 30 of a sector's 60 degrees.
bool PowerStage::overlaps() const {
  const SimDuration interval = hall_.last_interval();
  if (!command_.overlap || interval <= SimDuration{}) return false;
  const SimDuration since = loop_.now() - hall_.last_edge();
  return since > interval / 2 && since < 2 * interval;
}

bool PowerStage::near_limit() const {
  return command_.mode == StageCommand::Mode::kDriven &&
         std::fabs(current_a_) > kWatchedFrom * command_.limit_a;
}

// Periods come while the bridge drives or the rotor turns.
void PowerStage::follow() {
  const bool turns = axis_.state().speed_radps != 0;
  if (command_.mode != StageCommand::Mode::kDriven && !turns) {
    pwm_.cancel();
    slice_ = 0;
    return;
  }
  if (pwm_.due() != kNever && pwm_.due() > loop_.now()) return;
  const bool close = near_limit();
  if (!close && slice_ == 0) {
    pwm_.at(loop_.now() + kPwmPeriod);
    return;
  }
  slice_ = (slice_ + 1) % kSlices;
  pwm_.at(loop_.now() + kPwmPeriod / kSlices);
}

void PowerStage::set_clutch(double torque_nm) {
  if (torque_nm == clutch_nm_) return;
  axis_.advance_to(loop_.now());
  Load load = axis_.load();
  load.brake_torque_nm = std::max(0.0, load.brake_torque_nm + torque_nm - clutch_nm_);
  axis_.set_load(load);
  clutch_nm_ = torque_nm;
}

}  // namespace virtdrive::md
