// What lies between one motor's program and the motor: the bridge with its gate logic and current
// limiter, a shunt in the link, the Hall sensors on the capture unit, an encoder where one is
// fitted, a mechanical brake.
//
// The program gives a command each millisecond; from then on the gate logic works by itself, PWM
// period by PWM period: it follows the Hall code, cuts a period short at the current limit, and
// where only driving is wanted switches off when the current would brake. The shunt sees the
// motor's current only while two legs drive it: not while it is shorted or free.
#pragma once

#include <cstdint>
#include <optional>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/md/hall.h"
#include "firmware_models/md/motor_channel.h"
#include "firmware_models/md/six_step.h"
#include "plant/axis.h"
#include "plant/sensors.h"

namespace virtdrive::md {

/// What is fitted around one motor, and what is wrong with it.
struct StageSensors {
  HallSensors hall{.offset_rad = kHallOffsetRad};
  Encoder encoder{.lines = 0};  // none
  SensorFault shunt{};
};

class PowerStage {
 public:
  /// `name` names the noise's stream.
  PowerStage(EventLoop& loop, Axis& axis, double rated_current_a, const Seed& seed,
             std::string_view name);
  PowerStage(const PowerStage&) = delete;
  PowerStage& operator=(const PowerStage&) = delete;

  struct Reading {
    double current_a = 0;  // mean since the last reading, positive makes torque towards CCW
    bool limited = false;  // the limiter was at work since then
    double bus_v = 0;
    std::uint8_t hall = 0;
    std::int64_t encoder = 0;
    double brake_share = 0;  // of the time since then: the link's brake resistor was on
  };
  /// Brings the motor to the present, and what the sensors told since the last call.
  Reading read();
  void command(const StageCommand& command);

  const HallCounter& hall() const { return hall_; }

  const StageSensors& sensors() const { return sensors_; }
  void set_sensors(const StageSensors& sensors);
  /// The mechanical brake holds this much (Nm); 0: released.
  void set_clutch(double torque_nm);

 private:
  void period();
  void advance();
  void see_hall();
  void see_encoder();
  double sample_current();
  bool overlaps() const;
  void drive_bridge();
  void cut(const BridgeCommand& command);
  int sector() const;
  void follow();
  bool near_limit() const;

  EventLoop& loop_;
  Axis& axis_;
  RandomStream noise_;
  CurrentSensor shunt_;
  StageSensors sensors_;
  EdgeCounter encoder_;
  HallCounter hall_;
  std::uint8_t code_ = 0;
  double seen_at_rad_ = 0;  // electrical angle at the last look
  SimTime seen_at_ = kSimStart;

  StageCommand command_;
  Bridge bridge_ = Bridge::kOff;
  bool driving_ = false;   // two legs drive: the shunt sees the current
  bool cut_ = false;       // until the next period
  bool held_off_ = false;  // until the next command: the current would brake
  int slice_ = 0;          // of the period, where it is watched closely
  double current_a_ = 0;
  double current_sum_a_ = 0;
  int current_samples_ = 0;
  bool limited_ = false;
  bool overlapped_ = false;  // three legs conduct
  const DcBus bus_;
  const bool has_chopper_;
  SimTime read_at_ = kSimStart;
  SimDuration braking_{};
  double clutch_nm_ = 0;
  Wakeup pwm_;
};

}  // namespace virtdrive::md
