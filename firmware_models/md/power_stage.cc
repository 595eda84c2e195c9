#include "firmware_models/md/power_stage.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "firmware_models/md/six_step.h"

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
constexpr double kSectorRad = std::numbers::pi / 3;

}  // namespace

PowerStage::PowerStage(EventLoop& loop, Axis& axis, double rated_current_a, const Seed& seed,
                       std::string_view name)
    : loop_(loop),
      axis_(axis),
      noise_(seed.stream(name)),
      shunt_{.adc = kAdc,
             .volts_per_amp = kAdc.reference_v / 2 / (kFullScale * rated_current_a),
             .noise_a = kNoise * rated_current_a},
      pwm_(loop.add(Phase::kControl, [this] { period(); })) {
  advance();
}

// --- Sensors -------------------------------------------------------------------------------------

void PowerStage::advance() {
  axis_.advance_to(loop_.now());
  see_hall();
}

// The capture unit takes the time of an edge: between two looks the rotor turns evenly.
void PowerStage::see_hall() {
  const double electrical = axis_.parameters().motor.pole_pairs * axis_.state().angle_rad;
  const double sectors = (electrical - kHallOffsetRad) / kSectorRad;
  const SimTime now = loop_.now();
  const double moved = sectors - seen_at_sectors_;
  SimTime edge = now;
  if (std::floor(sectors) != std::floor(seen_at_sectors_) && moved != 0) {
    const double boundary = moved > 0 ? std::floor(sectors) : std::floor(seen_at_sectors_);
    edge = seen_at_ + from_seconds(seconds(now - seen_at_) * (boundary - seen_at_sectors_) / moved);
  }
  code_ = hall_fault_.value_or(hall_bits(electrical, kHallOffsetRad));
  hall_.see(code_, edge);
  seen_at_sectors_ = sectors;
  seen_at_ = now;
}

double PowerStage::sample_current() {
  if (!driving_) return 0;
  const double seen = pair_current_a(sector(), axis_.phase_currents_a());
  const double counts = shunt_.counts(seen, noise_) - shunt_.zero_counts();
  return counts * kAdc.reference_v / (kAdc.full_scale() + 1) / shunt_.volts_per_amp;
}

PowerStage::Reading PowerStage::read() {
  advance();
  current_a_ = sample_current();
  const double mean = current_samples_ > 0 ? current_sum_a_ / current_samples_ : current_a_;
  current_sum_a_ = 0;
  current_samples_ = 0;
  return {.current_a = mean,
          .limited = std::exchange(limited_, false),
          .bus_v = std::round(axis_.state().bus_v * 10) / 10,
          .hall = code_,
          .encoder = encoder_.lines > 0 ? encoder_.count(axis_.state().angle_rad) : 0};
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
  axis_.set_bridge(six_step(sector(), command_.output, kPwmPeriod));
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
