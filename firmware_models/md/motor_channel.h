// One motor's program: what moves it, how its reference is led, and the regulators, once a
// millisecond. It knows counts, rpm and amperes as its sensors give them; what it wants of its
// bridge stands in output().
//
//   motor.speed(1000);                  // as a host or the terminals ask for it, in the host's
//   sign motor.millisecond(measured); stage.drive(motor.output());
//
// Positive is CCW. INV_SIGN_CMD turns the host's sign against the motor's, for commands and for all
// that is reported.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_models/md/model.h"
#include "firmware_models/md/protections.h"
#include "firmware_models/md/settings.h"

namespace virtdrive::md {

/// The fifth byte of PID 193.
enum class ControlType : std::uint8_t { kOff, kSpeed, kPosition, kOpenLoop, kTorque };

/// What the bridge shall do until the next millisecond.
struct StageCommand {
  enum class Mode : std::uint8_t { kFree, kShort, kDriven };
  Mode mode = Mode::kFree;
  double output = 0;          // -1 .. 1 of the DC link, in the motor's sense
  bool only_driving = false;  // never against the current's own sense: no regeneration
  double limit_a = 0;         // of the current limiter
  double lead_deg = 0;        // commutation so much earlier, electrical
  bool overlap = false;       // legs conduct for 150 degrees instead of 120
};

/// What the sensors told in the last millisecond, in the motor's sense.
struct Measured {
  double rpm = 0;
  std::int64_t counts = 0;  // of the position sensor in use
  double current_a = 0;     // mean; positive makes torque towards CCW
  bool limited = false;     // the current limiter was at work
  double bus_v = 0;
  double heat_sink_degc = 25;
  std::uint8_t hall = 0;
  bool encoder_moves = true;
  bool permit_ccw = true, permit_cw = true;            // limit inputs
  double slow_start_volume = 0, slow_down_volume = 0;  // 0 .. 1
};

class MotorChannel {
 public:
  MotorChannel(const Model& model, const Settings& settings, std::size_t number)
      : model_(model), settings_(settings), number_(number) {}

  // --- Orders, in the host's sign; all but free() and brake() are ignored during an alarm ---
  void speed(double rpm);
  void open_loop(double output);  // -1023 .. 1023
  void torque(double torque);     // -1023 .. 1023 for MAX_LOAD
  /// To a position at up to `max_rpm`.
  void move_to(std::int32_t position, double max_rpm);
  void move_by(std::int32_t increment, double max_rpm);
  void free();
  void brake();
  void set_position(std::int32_t position);
  void reset_alarm();

  void millisecond(const Measured& measured);
  const StageCommand& output() const { return command_; }

  // --- What is reported, in the host's sign ---
  ControlType type() const;
  std::int32_t rpm() const;
  std::int32_t reference_rpm() const;
  std::int32_t output_counts() const;  // -1023 .. 1023
  std::int32_t position() const;
  std::int32_t target_position() const;
  double current_a() const { return mean_current_a_; }  // magnitude, mean of 50 ms
  std::uint8_t status() const { return protections_.status(); }
  std::uint8_t status2() const { return protections_.status2(); }
  std::uint8_t last_alarm() const { return protections_.last_alarm(); }
  bool in_position() const { return in_position_; }
  bool alarmed() const { return protections_.status() != 0; }
  int counts_per_turn() const;
  double rpm_per_count() const;  // of a speed in counts/s

 private:
  enum class Mode : std::uint8_t { kFree, kShort, kSpeed, kPosition, kOpenLoop, kTorque };

  std::int32_t command_sign() const;
  std::int32_t feedback_sign() const;
  std::int32_t encoder_sign() const;
  bool by_encoder() const;  // positions are
  double clamped_rpm(double rpm) const;
  double ramp_step(std::int32_t raw, double full_scale, double volume) const;
  bool take_over(Mode mode);
  void begin_move();
  void stop(Mode mode);

  void control();
  void control_speed();
  void hold();
  void control_position();
  void control_open_loop();
  void control_torque();
  void finish();
  void regulate_speed(double reference_rpm, bool frozen);
  bool stopped_by_limit(double direction);
  bool stopped_by_current();
  void watch();
  void drive(double output, bool only_driving);
  bool slow() const;

  const Model& model_;
  const Settings& settings_;
  std::size_t number_;

  Mode mode_ = Mode::kFree;
  bool armed_ = false;    // a reference that is not 0 came since power-up
  bool holding_ = false;  // speed 0 is held after a stop
  Measured now_{};
  double target_ = 0;     // rpm, output or torque, in the motor's sense
  double reference_ = 0;  // behind the ramp
  double integral_ = 0;
  double output_ = 0;        // -1023 .. 1023
  std::int64_t offset_ = 0;  // position less counts, in the motor's sense
  std::int64_t goal_ = 0;
  double goal_rpm_ = 0;
  std::int32_t within_ms_ = 0;
  bool in_position_ = false;
  std::int32_t over_limit_ms_ = 0;
  double mean_current_a_ = 0;
  Protections protections_;
  StageCommand command_;
};

}  // namespace virtdrive::md
