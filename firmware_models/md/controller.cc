#include "firmware_models/md/controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kTick = 1ms;
constexpr int kDebounceMs = 10;  // assumed
constexpr int kEncoderWindowMs = 10;
constexpr double kBrakeDutyMs = 50;
constexpr double kFull = 1023;

// Heat sink (assumed): 30 K over ambient at the rated current, first order in 300 s; a fan halves.
constexpr double kHeatSinkK = 30;
constexpr double kHeatSinkS = 300;
constexpr double kFanOnDegc = 45, kFanOffDegc = 40;
constexpr double kClutchOfRated = 1.5;  // assumed

constexpr std::int64_t kNoEnd = -1;

}  // namespace

void Controller::Debounced::see(bool now) {
  differs_ms = now == state ? 0 : differs_ms + 1;
  if (differs_ms < kDebounceMs) return;
  state = now;
  differs_ms = 0;
}

Controller::Controller(EventLoop& loop, std::span<Axis* const> axes, const Model& model,
                       const Settings& settings, const Seed& seed)
    : loop_(loop),
      model_(model),
      settings_(settings),
      started_(loop.now()),
      last_frame_(loop.now()),
      frames_drive_(settings.ui_com != 0),
      tick_(loop.add(Phase::kControl, [this] { millisecond(); })) {
  motors_.reserve(axes.size());  // the channels refer to settings_, the stages stay where they are
  for (std::size_t i = 0; i < axes.size(); ++i) {
    Motor& motor = motors_.emplace_back(model_, settings_, i);
    motor.stage = std::make_unique<PowerStage>(loop, *axes[i], model.current_a, seed,
                                               fmt::format("stage{}.adc", i));
    motor.bus_v = motor.stage->read().bus_v;
  }
  tick_.at(loop.now());
}

void Controller::set_settings(const Settings& settings) {
  if (settings.func_type != settings_.func_type) {
    // No edge is seen when the function changes.
    for (Motor& motor : motors_) {
      motor.function_ms = kNoEnd;
      motor.signal = false;
    }
  }
  if (settings.ui_com != settings_.ui_com) frames_drive_ = settings.ui_com != 0;
  settings_ = settings;
}

// --- Frames --------------------------------------------------------------------------------------

MotorChannel* Controller::by_frame(std::size_t number) {
  if (number >= motors_.size() || settings_.func_type != 0) return nullptr;
  frames_drive_ = true;
  start_stop_ = 0;
  return &motors_[number].channel;
}

void Controller::free(std::size_t number) {
  frames_drive_ = true;
  start_stop_ = 0;
  motors_[number].function_ms = kNoEnd;
  motors_[number].channel.free();
}

void Controller::brake(std::size_t number) {
  frames_drive_ = true;
  start_stop_ = 0;
  motors_[number].function_ms = kNoEnd;
  motors_[number].channel.brake();
}

void Controller::set_position(std::size_t number, std::int32_t position) {
  motors_[number].channel.set_position(position);
}

void Controller::reset_alarms() {
  for (Motor& motor : motors_) motor.channel.reset_alarm();
}

void Controller::start_stop(int state) {
  if (com_tar_speed_ == 0 || settings_.func_type != 0) return;
  const int direction = state == 1 ? 1 : state == 2 ? -1 : 0;
  for (std::size_t i = 0; i < motors_.size(); ++i) by_frame(i)->speed(direction * com_tar_speed_);
  start_stop_ = direction;
}

void Controller::set_com_tar_speed(std::int32_t rpm) {
  com_tar_speed_ = rpm;
  for (Motor& motor : motors_) {
    if (start_stop_ != 0) motor.channel.speed(start_stop_ * rpm);
  }
}

void Controller::function_signal(bool on) {
  for (Motor& motor : motors_) {
    if (motor.signal != on) function_edge(motor, on);
  }
}

void Controller::save_preset(std::size_t number) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    settings_.presets[number - 1][i] = motors_[i].channel.position();
  }
}

void Controller::set_clutch(bool engaged) {
  if (!model_.clutch) return;
  clutch_ = engaged;
  for (Motor& motor : motors_) {
    motor.stage->set_clutch(engaged ? kClutchOfRated * model_.rated_torque_nm : 0);
  }
}

void Controller::set_ambient_degc(double degc) {
  heat_sink_degc_ += degc - ambient_degc_;
  ambient_degc_ = degc;
}

bool Controller::alarm_output() const {
  const bool alarm =
      std::ranges::any_of(motors_, [](const Motor& m) { return m.channel.alarmed(); });
  return alarm != (settings_.inv_alarm != 0);
}

std::int32_t Controller::seconds_up() const {
  return static_cast<std::int32_t>((loop_.now() - started_) / 1s);
}

// --- The millisecond -----------------------------------------------------------------------------

void Controller::millisecond() {
  watch_line();
  for (std::size_t i = 0; i < motors_.size(); ++i) run(i);
  heat();
  tick_.at(loop_.now() + kTick);
}

void Controller::run(std::size_t number) {
  Motor& motor = motors_[number];
  read_pins(number);
  if (settings_.func_type != 0)
    run_function(number);
  else if (!frames_drive_)
    follow_terminals(number);
  motor.channel.millisecond(measure(motor, number));
  motor.stage->command(motor.channel.output());
}

Measured Controller::measure(Motor& motor, std::size_t number) {
  const PowerStage::Reading reading = motor.stage->read();
  motor.bus_v = reading.bus_v;
  if (number == 0) brake_duty_ += (reading.brake_share - brake_duty_) / kBrakeDutyMs;
  motor.hall = reading.hall;
  std::ranges::rotate(motor.encoder_ms, motor.encoder_ms.end() - 1);
  motor.encoder_ms.front() = reading.encoder;
  const std::int64_t moved = motor.encoder_ms.front() - motor.encoder_ms.back();

  const HallCounter& hall = motor.stage->hall();
  const double hall_rpm = hall.rpm(loop_.now(), hall_counts_per_turn(settings_.hall_type));
  const bool by_encoder = settings_.enc_ppr > 0;
  const double encoder_rpm = by_encoder ? 60.0 * static_cast<double>(moved) /
                                              (4.0 * settings_.enc_ppr * kEncoderWindowMs * 1e-3)
                                        : 0;
  const bool encoder_position = settings_.use_eposi != 0 && by_encoder;
  return {.rpm = by_encoder ? encoder_rpm : hall_rpm,
          .counts = encoder_position ? reading.encoder : hall.count(),
          .current_a = reading.current_a,
          .limited = reading.limited,
          .bus_v = reading.bus_v,
          .heat_sink_degc = heat_sink_degc_,
          .hall = reading.hall,
          .encoder_moves = moved != 0 || hall_rpm == 0,
          .permit_ccw = motors_[number].may_ccw.state,
          .permit_cw = motors_[number].may_cw.state,
          .slow_start_volume = motor.pins.slow_start_volume,
          .slow_down_volume = motor.pins.slow_down_volume};
}

void Controller::read_pins(std::size_t number) {
  Motor& motor = motors_[number];
  const Terminals& pins = motor.pins;
  const bool limits = settings_.use_limit_sw != 0 && frames_drive_;
  const bool start_is_limit = limits && settings_.func_type == 0;
  motor.may_ccw.see(!start_is_limit || started(pins, settings_));
  motor.may_cw.see(!limits || pins.cw);

  const bool runs = running(pins, settings_);
  if (frames_drive_ && motor.ran && !runs) motor.channel.brake();
  motor.ran = runs;
  if (pins.alarm_reset && !motor.reset_pin) motor.channel.reset_alarm();
  motor.reset_pin = pins.alarm_reset;
}

void Controller::follow_terminals(std::size_t number) {
  Motor& motor = motors_[number];
  MotorChannel& channel = motor.channel;
  const Terminals& pins = motor.pins;
  const bool steps = settings_.input_type == static_cast<int>(InputType::kStep);
  const double rpm_of_full = settings_.max_rpm / kFull;
  if (steps) {
    const std::size_t step = step_number(pins);
    const double rpm = step == 0 ? 0 : step_rpm(settings_, step);
    return channel.speed(pins.cw ? -rpm : rpm);
  }
  if (!running(pins, settings_)) {
    if (channel.type() != ControlType::kOff) channel.brake();
    return;
  }
  const bool two_sided = settings_.input_type == static_cast<int>(InputType::kJoystick) ||
                         settings_.input_type == static_cast<int>(InputType::kRcServo);
  if (terminal_control_ == TerminalControl::kPosition) {
    if (!started(pins, settings_)) return channel.speed(0);
    const double position = position_input(speed_input(pins, settings_), settings_);
    return channel.move_to(static_cast<std::int32_t>(std::lround(position)),
                           settings_.tar_posi_vel);
  }
  double full = 0;  // of 1023
  if (started(pins, settings_)) {
    full = !pins.int_speed         ? speed_input(pins, settings_)
           : settings_.tar_vel > 0 ? settings_.tar_vel / rpm_of_full
                                   : volume_input(pins, settings_);
  }
  if (pins.cw && !(two_sided && !pins.int_speed)) full = -full;
  if (settings_.tq_ctrl != 0)
    channel.torque(full);
  else
    channel.speed(full * rpm_of_full);
}

// --- Special functions (p. 29) -------------------------------------------------------------------

void Controller::run_function(std::size_t number) {
  Motor& motor = motors_[number];
  const bool pin = started(motor.pins, settings_);
  if (pin != motor.start_pin) {
    motor.start_pin = pin;
    if (pin != motor.signal) function_edge(motor, pin);
  }
  if (motor.function_ms > 0 && --motor.function_ms == 0) {
    motor.function_ms = kNoEnd;
    motor.channel.speed(0);
  }
}

void Controller::function_edge(Motor& motor, bool on) {
  enum Function { kSpeed = 1, kPosition, kMomentary, kAdd };
  motor.signal = on;
  const std::int64_t delay_ms = std::int64_t{100} * std::max(0, settings_.func_delay);
  const auto run = [&](std::int64_t for_ms) {
    motor.channel.speed(settings_.func_speed);
    motor.function_ms = for_ms;
  };
  switch (settings_.func_type) {
    case kSpeed:
      if (on) run(std::max<std::int64_t>(delay_ms, 1));
      break;
    case kPosition:
      if (on) {
        motor.channel.move_by(settings_.func_posi_increment, std::abs(settings_.func_posi_speed));
      }
      break;
    case kMomentary:
      if (on)
        run(kNoEnd);
      else
        motor.channel.speed(0);
      break;
    case kAdd:
      if (on)
        run(kNoEnd);
      else
        motor.function_ms = std::max<std::int64_t>(delay_ms, 1);
      break;
    default:
      break;
  }
}

// --- Surroundings --------------------------------------------------------------------------------

// What a controller does when its host falls silent is not told; it stops as for speed 0 (assumed).
void Controller::watch_line() {
  if (settings_.watch_delay == 0 || !frames_drive_) return;
  if (loop_.now() - last_frame_ < settings_.watch_delay * 100ms) return;
  for (Motor& motor : motors_) {
    if (motor.channel.type() != ControlType::kOff) motor.channel.speed(0);
  }
}

void Controller::heat() {
  double rise = 0;
  for (const Motor& motor : motors_) {
    const double load = motor.channel.current_a() / model_.current_a;
    rise += kHeatSinkK / static_cast<double>(motors_.size()) * load * load;
  }
  const double settles = ambient_degc_ + rise * (fan_ ? 0.5 : 1);
  heat_sink_degc_ += (settles - heat_sink_degc_) * seconds(kTick) / kHeatSinkS;
  const bool warm = fan_ ? heat_sink_degc_ > kFanOffDegc : heat_sink_degc_ >= kFanOnDegc;
  fan_ = fan_wanted_ || (model_.temperature_sensor && warm);
}

}  // namespace virtdrive::md
