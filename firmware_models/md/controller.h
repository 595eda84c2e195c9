// A controller's program above its motors: who may move them (frames, terminals or a special
// function), the connector's inputs, heat sink and fan, and the settings that all share.
//
//   Controller controller(loop, axes, model, default_settings(model), seed);
//   if (MotorChannel* motor = controller.by_frame(0)) motor->speed(1000);
//
// One turn a millisecond. An order acts with the next one.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "firmware_models/md/model.h"
#include "firmware_models/md/motor_channel.h"
#include "firmware_models/md/power_stage.h"
#include "firmware_models/md/speed_input.h"

namespace virtdrive::md {

/// What the terminals' reference stands for. The document shows both and no PID that chooses.
enum class TerminalControl : std::uint8_t { kSpeed, kPosition };

class Controller {
 public:
  Controller(EventLoop& loop, std::span<Axis* const> axes, const Model& model,
             const Settings& settings, const Seed& seed);
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  const Model& model() const { return model_; }
  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings);
  void set_terminal_control(TerminalControl control) { terminal_control_ = control; }

  std::size_t motors() const { return motors_.size(); }
  const MotorChannel& motor(std::size_t number) const { return motors_[number].channel; }
  PowerStage& stage(std::size_t number) { return *motors_[number].stage; }

  // --- Frames ---
  /// The motor for a frame's order to move, from now on driven by frames; null if there is no such
  /// motor or a special function has it.
  MotorChannel* by_frame(std::size_t number);
  /// At once, whoever drives.
  void free(std::size_t number);
  void brake(std::size_t number);
  void set_position(std::size_t number, std::int32_t position);
  void reset_alarms();
  /// PID 100: 0 stop, 1 CCW, 2 CW at COM_TAR_SPEED.
  void start_stop(int state);
  std::int32_t com_tar_speed() const { return com_tar_speed_; }
  void set_com_tar_speed(std::int32_t rpm);
  /// START/STOP of the special function by frame (PID 184).
  void function_signal(bool on);
  /// CMD 44 and 45.
  void let_frames_drive(bool frames) { frames_drive_ = frames; }
  void save_preset(std::size_t number);
  void set_fan(bool on) { fan_wanted_ = on; }
  void set_clutch(bool engaged);
  /// A good frame came: feeds the communication watchdog (PID 185).
  void frame_came() { last_frame_ = loop_.now(); }

  // --- Bench ---
  Terminals& terminals(std::size_t number) { return motors_[number].pins; }
  const Terminals& terminals(std::size_t number) const { return motors_[number].pins; }
  double ambient_degc() const { return ambient_degc_; }
  void set_ambient_degc(double degc);

  // --- What is reported ---
  double heat_sink_degc() const { return heat_sink_degc_; }
  bool fan() const { return fan_; }
  bool clutch() const { return clutch_; }
  bool alarm_output() const;
  bool frames_drive() const { return frames_drive_; }
  double bus_v() const { return motors_.front().bus_v; }
  /// 0..1, mean of 50 ms: how long the brake resistor is on.
  double brake_duty() const { return brake_duty_; }
  std::uint8_t hall(std::size_t number) const { return motors_[number].hall; }
  std::int32_t seconds_up() const;

 private:
  struct Debounced {
    bool state = true;
    int differs_ms = 0;
    void see(bool now);
  };
  struct Motor {
    Motor(const Model& model, const Settings& settings, std::size_t number)
        : channel(model, settings, number) {}
    MotorChannel channel;
    std::unique_ptr<PowerStage> stage;
    Terminals pins;
    Debounced may_ccw, may_cw;
    bool ran = true;                // RUN/BRAKE at the last look
    bool reset_pin = false;         // ALARM_RESET at the last look
    bool start_pin = true;          // START/STOP at the last look
    bool signal = false;            // of the special function
    std::int64_t function_ms = -1;  // left to run; below 0: no end is set
    double bus_v = 0;
    std::uint8_t hall = 0;
    std::array<std::int64_t, 11> encoder_ms{};  // counts of the last milliseconds
  };

  void millisecond();
  void run(std::size_t number);
  Measured measure(Motor& motor, std::size_t number);
  void read_pins(std::size_t number);
  void follow_terminals(std::size_t number);
  void run_function(std::size_t number);
  void function_edge(Motor& motor, bool on);
  void watch_line();
  void heat();

  EventLoop& loop_;
  const Model& model_;
  Settings settings_;
  std::vector<Motor> motors_;
  TerminalControl terminal_control_ = TerminalControl::kSpeed;
  SimTime started_;
  SimTime last_frame_;
  bool frames_drive_ = false;
  int start_stop_ = 0;
  std::int32_t com_tar_speed_ = 0;
  bool fan_wanted_ = false, fan_ = false;
  bool clutch_ = false;
  double ambient_degc_ = 25;
  double heat_sink_degc_ = 25;
  double brake_duty_ = 0;
  Wakeup tick_;
};

}  // namespace virtdrive::md
