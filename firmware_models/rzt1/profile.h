// The velocity profile generator (6.4): a command position, velocity and acceleration for each loop
// cycle.
//
//   profile.hold(position);
//   profile.move(target, limits, ProfileKind::kTrapezoid);
//   while (profile.state() != ProfileState::kIdle) { profile.step(); profile.position(); }
//
// The firmware computes ahead into a queue of 40 set-points; what the loop gets is the same.
// Trapezoid and jog run in 16.16 integers and may be changed under way. Spline and Bezier are one
// thing: velocity rises along a cubic Bezier curve over time, from standstill to the top and back,
// with level tangents of length `h` (of the phase's time): 0 is the trapezoid, 1/3 the cubic
// spline, 1/2 the steepest. The top acceleration is ACC: the rise takes VEL / (ACC (1 - h)), at
// most twice the trapezoid's. PVT is a cubic Hermite curve through the points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace virtdrive::rzt1 {

/// VPG_STATE.
enum class ProfileState : std::uint8_t {
  kIdle = 0,
  kAccelerating = 1,
  kDecelerating = 2,
  kConstant = 3,
  kStreaming = 4,
};

/// PRO.
enum class ProfileKind : std::uint8_t { kTrapezoid = 0, kSpline = 1, kBezier = 2, kPvt = 3 };

/// 16.16 counts per cycle and cycle squared; jerks 0..1000.
struct MotionLimits {
  std::int64_t velocity = 0;
  std::int64_t acceleration = 1;
  std::int64_t deceleration = 1;
  std::int32_t acceleration_jerk = 0, deceleration_jerk = 0;
};

struct PvtPoint {
  std::int32_t position = 0;
  std::int32_t velocity = 0;  // 16.16 counts per cycle
};

class Profile {
 public:
  static constexpr std::size_t kPvtCapacity = 100;

  std::int32_t position() const { return static_cast<std::int32_t>(position_ >> 16); }
  std::int32_t velocity() const { return static_cast<std::int32_t>(velocity_); }
  std::int32_t acceleration() const { return static_cast<std::int32_t>(acceleration_); }
  ProfileState state() const { return state_; }
  bool following() const { return motion_ == Motion::kFollow; }
  /// A trapezoid or a jog: it may be changed under way.
  bool changeable() const { return motion_ == Motion::kTrapezoid || motion_ == Motion::kJog; }

  /// Stands still there.
  void hold(std::int32_t position);
  /// The same motion `counts` further: POS was written.
  void shift(std::int32_t counts);

  /// From the present command on; not kPvt, and from standstill unless kTrapezoid.
  void move(std::int32_t target, const MotionLimits& limits, ProfileKind kind);
  /// Until told otherwise, at this velocity (16.16, signed); 0 ends it.
  void jog(std::int64_t velocity, const MotionLimits& limits);
  /// Through the queue, a point each `cycles`; the first is `cycles` away.
  void stream(std::int32_t cycles, const MotionLimits& limits);
  /// Straight to `position` within so many cycles, then stays there, ready for the next.
  void follow(std::int32_t position, std::int32_t cycles);
  /// Is told its command from outside: the gear's slave.
  void lead(std::int32_t position, std::int32_t velocity, std::int32_t acceleration,
            ProfileState state);
  /// As a trapezoid at this deceleration to the nearest count where that ends.
  void stop(std::int64_t deceleration);

  /// One loop cycle.
  void step();

  bool push(std::span<const PvtPoint> points);
  void clear_pvt() { pvt_count_ = 0; }
  std::int32_t pvt_depth() const { return static_cast<std::int32_t>(pvt_count_); }
  /// The queue ran dry under way; until the next motion.
  bool starved() const { return starved_; }
  /// Loop cycles in which the queue was found empty since the motion began.
  std::int32_t empty_cycles() const { return empty_cycles_; }

 private:
  enum class Motion : std::uint8_t { kNone, kTrapezoid, kJog, kBlend, kPvt, kFollow, kLed };

  /// One rise of velocity from 0 to `top` (counts per cycle) in `cycles`.
  struct Rise {
    double cycles = 0, top = 0, h = 0;
    double parameter_at(double t) const;
    double velocity_at(double u) const;
    double distance_at(double u) const;
  };

  void begin(Motion motion);
  void finish(std::int32_t position);
  void plan_blend(const MotionLimits& limits, double h_up, double h_down);
  void step_trapezoid();
  void step_jog();
  void step_blend();
  void step_pvt();
  void step_follow();
  void set(double position, double velocity);
  bool next_segment();

  Motion motion_ = Motion::kNone;
  ProfileState state_ = ProfileState::kIdle;
  std::int64_t position_ = 0;  // 48.16
  std::int64_t velocity_ = 0, acceleration_ = 0;

  MotionLimits limits_;
  std::int64_t target_ = 0;  // 48.16
  std::int64_t jog_velocity_ = 0;

  // Blend: from here, so far, with these two rises, level in between.
  double from_ = 0, distance_ = 0, direction_ = 1;
  Rise up_, down_;
  double level_cycles_ = 0;
  std::int64_t cycle_ = 0;

  // PVT: the segment and what follows it. Follow: cycles left.
  std::array<PvtPoint, kPvtCapacity> pvt_{};
  std::size_t pvt_first_ = 0, pvt_count_ = 0;
  PvtPoint start_{}, end_{};
  std::int32_t segment_cycles_ = 1;
  bool starved_ = false;
  std::int32_t empty_cycles_ = 0;
};

}  // namespace virtdrive::rzt1
