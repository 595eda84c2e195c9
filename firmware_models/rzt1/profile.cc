#include "firmware_models/rzt1/profile.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "firmware_models/rzt1/counts.h"

namespace virtdrive::rzt1 {
namespace {

constexpr std::int64_t kOne = 1 << 16;
constexpr std::int64_t kHalf = kOne / 2;
// Where a trapezoid counts as arrived: 1/256 count, rounding of its integers.
constexpr std::int64_t kArrived = 1 << 8;

constexpr std::int64_t fixed(std::int32_t counts) {
  return static_cast<std::int64_t>(counts) * kOne;
}

// Counts are what a 32-bit register makes of them.
constexpr std::int64_t wrapped(std::int64_t position) {
  return fixed(static_cast<std::int32_t>(position >> 16)) + (position & (kOne - 1));
}

constexpr std::int64_t sign(std::int64_t x) {
  return x < 0 ? -1 : 1;
}

// As much as the 32-bit register holds.
constexpr std::int64_t clipped(std::int64_t velocity) {
  return std::clamp<std::int64_t>(velocity, -INT32_MAX, INT32_MAX);
}

std::int64_t stop_distance(std::int64_t speed, std::int64_t deceleration) {
  return speed * speed / (2 * deceleration);
}

// The fastest that one cycle of the mean of `speed` and it, and then stopping, do not lead beyond
// `remaining`: the largest x with x^2 / 2D + (x + speed) / 2 <= remaining.
std::int64_t fastest(std::int64_t speed, std::int64_t remaining, std::int64_t deceleration) {
  const double room = static_cast<double>(remaining) - static_cast<double>(speed) / 2;
  if (room <= 0) return 0;
  const auto d = static_cast<double>(deceleration);
  return static_cast<std::int64_t>((std::sqrt(d * d + 8 * d * room) - d) / 2);
}

}  // namespace

// --- Beginnings and ends -------------------------------------------------------------------------

void Profile::begin(Motion motion) {
  motion_ = motion;
  position_ = wrapped(position_);
  starved_ = false;
  empty_cycles_ = 0;
  cycle_ = 0;
}

void Profile::finish(std::int32_t position) {
  motion_ = Motion::kNone;
  state_ = ProfileState::kIdle;
  position_ = fixed(position);
  velocity_ = acceleration_ = 0;
}

void Profile::hold(std::int32_t position) {
  finish(position);
}

void Profile::shift(std::int32_t counts) {
  position_ = wrapped(position_ + fixed(counts));
  target_ = wrapped(target_ + fixed(counts));
  from_ += counts;
  start_.position = sum(start_.position, counts);
  end_.position = sum(end_.position, counts);
  for (std::size_t i = 0; i < pvt_count_; ++i) {
    std::int32_t& position = pvt_[(pvt_first_ + i) % kPvtCapacity].position;
    position = sum(position, counts);
  }
}

void Profile::move(std::int32_t target, const MotionLimits& limits, ProfileKind kind) {
  limits_ = limits;
  target_ = fixed(target);
  if (kind == ProfileKind::kTrapezoid) {
    begin(Motion::kTrapezoid);
    state_ = ProfileState::kAccelerating;
    return;
  }
  begin(Motion::kBlend);
  state_ = ProfileState::kAccelerating;
  if (kind == ProfileKind::kSpline) {
    plan_blend(limits, 1.0 / 3, 1.0 / 3);
  } else {
    plan_blend(limits, limits.acceleration_jerk / 2000.0, limits.deceleration_jerk / 2000.0);
  }
}

void Profile::jog(std::int64_t velocity, const MotionLimits& limits) {
  begin(Motion::kJog);
  limits_ = limits;
  jog_velocity_ = velocity;
  state_ = ProfileState::kAccelerating;
}

void Profile::stream(std::int32_t cycles, const MotionLimits& limits) {
  begin(Motion::kPvt);
  limits_ = limits;
  segment_cycles_ = std::max(1, cycles);
  end_ = {position(), 0};
  state_ = ProfileState::kStreaming;
  next_segment();
}

void Profile::follow(std::int32_t position, std::int32_t cycles) {
  if (motion_ != Motion::kFollow) begin(Motion::kFollow);
  state_ = ProfileState::kStreaming;
  target_ = fixed(position);
  segment_cycles_ = std::max(1, cycles);
}

void Profile::lead(std::int32_t position, std::int32_t velocity, std::int32_t acceleration,
                   ProfileState state) {
  motion_ = Motion::kLed;
  state_ = state;
  position_ = fixed(position);
  velocity_ = velocity;
  acceleration_ = acceleration;
}

void Profile::stop(std::int64_t deceleration) {
  if (motion_ == Motion::kNone || motion_ == Motion::kLed) return;
  limits_.deceleration = std::max<std::int64_t>(1, deceleration);
  limits_.velocity = std::abs(velocity_);
  const std::int64_t direction = sign(velocity_);
  // Up to the next count, so that it need not brake harder.
  const std::int64_t end =
      position_ + direction * stop_distance(std::abs(velocity_), limits_.deceleration);
  target_ = (direction > 0 ? (end + kOne - 1) : end) & ~(kOne - 1);
  motion_ = Motion::kTrapezoid;
  state_ = ProfileState::kDecelerating;
}

// --- Trapezoid and jog ---------------------------------------------------------------------------

void Profile::step() {
  switch (motion_) {
    case Motion::kTrapezoid:
      return step_trapezoid();
    case Motion::kJog:
      return step_jog();
    case Motion::kBlend:
      return step_blend();
    case Motion::kPvt:
      return step_pvt();
    case Motion::kFollow:
      return step_follow();
    case Motion::kNone:
    case Motion::kLed:
      return;
  }
}

void Profile::step_trapezoid() {
  const std::int64_t remaining = target_ - position_;
  const std::int64_t direction = remaining != 0 ? sign(remaining) : sign(velocity_);
  const std::int64_t room = std::abs(remaining);
  const std::int64_t before = velocity_ * direction;  // speed towards the target
  const std::int64_t a = limits_.acceleration, d = limits_.deceleration;

  std::int64_t after = 0;
  if (before < 0) {
    after = std::min<std::int64_t>(0, before + d);  // the other way: first it stops
  } else {
    after = before > limits_.velocity ? std::max(limits_.velocity, before - d)
                                      : std::min(limits_.velocity, before + a);
    if (stop_distance(after, d) + (before + after) / 2 > room) {
      after = std::max(std::min(after, fastest(before, room, d)), before - d);
    }
    after = std::max<std::int64_t>(0, after);
    const std::int64_t left = room - (before + after) / 2;
    if (before <= d && after <= d && left <= kArrived) {
      starved_ = starved_ && motion_ == Motion::kTrapezoid;
      return finish(static_cast<std::int32_t>(target_ >> 16));
    }
  }
  state_ = after > before   ? ProfileState::kAccelerating
           : after < before ? ProfileState::kDecelerating
                            : ProfileState::kConstant;
  acceleration_ = (after - before) * direction;
  position_ += direction * (before + after) / 2;
  velocity_ = after * direction;
  if (starved_) ++empty_cycles_;
}

void Profile::step_jog() {
  const std::int64_t before = velocity_;
  const bool slower = std::abs(jog_velocity_) < std::abs(before) ||
                      (before != 0 && (before < 0) != (jog_velocity_ < 0));
  const std::int64_t step = slower ? limits_.deceleration : limits_.acceleration;
  // Through 0 it changes from DEC to ACC.
  const std::int64_t aim = slower && (before < 0) != (jog_velocity_ < 0) ? 0 : jog_velocity_;
  velocity_ = before + std::clamp(aim - before, -step, step);
  acceleration_ = velocity_ - before;
  position_ = wrapped(position_ + (before + velocity_) / 2);
  state_ = velocity_ == before ? ProfileState::kConstant
           : slower            ? ProfileState::kDecelerating
                               : ProfileState::kAccelerating;
  if (jog_velocity_ == 0 && velocity_ == 0) {
    finish(static_cast<std::int32_t>((position_ + kHalf) >> 16));
  }
}

// --- Spline and Bezier ---------------------------------------------------------------------------

// Time along the curve, as a share of the rise: 3 h u (1-u)^2 + 3 (1-h) u^2 (1-u) + u^3.
double Profile::Rise::parameter_at(double t) const {
  const double share = t / cycles;
  double low = 0, high = 1, u = share;
  for (int i = 0; i < 60; ++i) {
    const double v = 1 - u;
    const double error = 3 * h * u * v * v + 3 * (1 - h) * u * u * v + u * u * u - share;
    if (std::fabs(error) < 1e-14) break;
    (error > 0 ? high : low) = u;
    const double slope = 3 * h * v * v + 6 * (1 - 2 * h) * u * v + 3 * h * u * u;
    const double newton = slope > 1e-9 ? u - error / slope : -1;
    u = newton > low && newton < high ? newton : (low + high) / 2;
  }
  return u;
}

double Profile::Rise::velocity_at(double u) const {
  return top * u * u * (3 - 2 * u);
}

// The integral of the velocity over time; half of top * cycles at the end.
double Profile::Rise::distance_at(double u) const {
  const double k = 2 - 6 * h;
  return 3 * top * cycles * u * u * u * (h + u * ((3 * k - 2 * h) / 4 + u * (-k + u * k / 3)));
}

void Profile::plan_blend(const MotionLimits& limits, double h_up, double h_down) {
  from_ = static_cast<double>(position_) / kOne;
  distance_ = static_cast<double>(target_ - position_) / kOne;
  direction_ = distance_ < 0 ? -1 : 1;
  distance_ = std::fabs(distance_);
  const double up = static_cast<double>(limits.acceleration) / kOne * (1 - h_up);
  const double down = static_cast<double>(limits.deceleration) / kOne * (1 - h_down);
  // The top that leaves no level part.
  const double highest = std::sqrt(2 * distance_ / (1 / up + 1 / down));
  const double top = std::min(static_cast<double>(limits.velocity) / kOne, highest);
  up_ = {.cycles = top / up, .top = top, .h = h_up};
  down_ = {.cycles = top / down, .top = top, .h = h_down};
  level_cycles_ = top > 0 ? distance_ / top - (up_.cycles + down_.cycles) / 2 : 0;
}

void Profile::step_blend() {
  const auto t = static_cast<double>(++cycle_);
  if (up_.top <= 0) {
    if (distance_ == 0) finish(static_cast<std::int32_t>(target_ >> 16));
    return;  // VEL is 0: it never gets anywhere
  }
  const double end = up_.cycles + level_cycles_ + down_.cycles;
  double way = 0, speed = 0;
  if (t >= end) return finish(static_cast<std::int32_t>(target_ >> 16));
  if (t < up_.cycles) {
    const double u = up_.parameter_at(t);
    way = up_.distance_at(u);
    speed = up_.velocity_at(u);
    state_ = ProfileState::kAccelerating;
  } else if (t < up_.cycles + level_cycles_) {
    way = up_.top * (up_.cycles / 2 + t - up_.cycles);
    speed = up_.top;
    state_ = ProfileState::kConstant;
  } else {
    const double u = down_.parameter_at(end - t);
    way = distance_ - down_.distance_at(u);
    speed = down_.velocity_at(u);
    state_ = ProfileState::kDecelerating;
  }
  set(from_ + direction_ * way, direction_ * speed);
}

void Profile::set(double position, double velocity) {
  const auto before = velocity_;
  position_ = static_cast<std::int64_t>(std::floor(position * kOne + 0.5)) + kHalf;
  position_ = wrapped(position_) & ~(kOne - 1);  // to the nearest count
  velocity_ = clipped(std::llround(velocity * kOne));
  acceleration_ = velocity_ - before;
}

// --- PVT and cyclic set-points -------------------------------------------------------------------

bool Profile::push(std::span<const PvtPoint> points) {
  if (points.size() > kPvtCapacity - pvt_count_) return false;
  for (const PvtPoint& point : points) {
    pvt_[(pvt_first_ + pvt_count_++) % kPvtCapacity] = point;
  }
  return true;
}

bool Profile::next_segment() {
  start_ = end_;
  cycle_ = 0;
  if (pvt_count_ == 0) return false;
  end_ = pvt_[pvt_first_];
  pvt_first_ = (pvt_first_ + 1) % kPvtCapacity;
  --pvt_count_;
  return true;
}

void Profile::step_pvt() {
  if (cycle_ == segment_cycles_ && !next_segment()) {
    if (start_.velocity == 0) return finish(start_.position);
    ++empty_cycles_;
    starved_ = true;
    stop(limits_.deceleration);
    return step_trapezoid();
  }
  ++cycle_;
  // Hermite's basis; velocities per cycle times the cycles of the segment are its tangents.
  const double n = segment_cycles_, s = static_cast<double>(cycle_) / n, r = 1 - s;
  const double m0 = start_.velocity * n / kOne, m1 = end_.velocity * n / kOne;
  const double way = difference(end_.position, start_.position);
  const double position =
      start_.position + way * s * s * (3 - 2 * s) + m0 * s * r * r - m1 * s * s * r;
  const double velocity =
      (way * 6 * s * r + m0 * (1 - 4 * s + 3 * s * s) + m1 * s * (3 * s - 2)) / n;
  set(position, velocity);
}

void Profile::step_follow() {
  const std::int64_t before = velocity_;
  if (segment_cycles_ > 0) {
    const std::int64_t left = fixed(static_cast<std::int32_t>((target_ - position_) >> 16)) +
                              ((target_ - position_) & (kOne - 1));
    const std::int64_t step = left / segment_cycles_;
    position_ += segment_cycles_ == 1 ? left : step;
    velocity_ = clipped(step);
    --segment_cycles_;
  } else {
    velocity_ = 0;
  }
  acceleration_ = velocity_ - before;
}

}  // namespace virtdrive::rzt1
