// Position PID with feed-forwards into velocity PID (4.1.3, 6.3), once a loop cycle, in the
// firmware's integers:
//
//   e = clip(command - actual)
//   o = KP e + KD de + (KI sum(e) >> 8) + VFF vel + AFF acc + BIAS     target velocity, 16.16
//   q = (VKP ev >> 12) + (VKI sum(ev) >> 16) + (VKD dev >> 12)         +-32767
//
// The cascade is 4.1.3's; the document has no scaling. The shifts are those of the successor's
// published example but for VFF (32767 = 100 %), limit and window, chosen so that the loops are
// damped on the bench's motor.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_models/rzt1/settings.h"

namespace virtdrive::rzt1 {

class Regulators {
 public:
  /// The buffered gains (figure 6.6).
  void latch(const Settings& settings);
  /// The servo goes on: integrals 0, at rest.
  void reset(std::int32_t position);

  /// Each loop cycle, servo on or off: the velocity over the last four.
  void observe(std::int32_t position);
  /// The q output for a command; MLIMIT and BIAS act at once, so they are taken from `settings`.
  std::int32_t step(std::int32_t command, std::int32_t velocity, std::int32_t acceleration,
                    std::int32_t actual, const Settings& settings);
  void rest() { output_ = 0; }
  /// POS was written.
  void shift(std::int32_t counts);

  std::int32_t velocity() const { return velocity_; }  // 16.16 counts per cycle
  std::int32_t output() const { return output_; }
  /// As latched.
  std::int32_t loop_slots() const { return ds_; }
  std::int32_t max_error() const { return max_error_; }

 private:
  std::int64_t kp_ = 0, ki_ = 0, kd_ = 0, il_ = 0, vff_ = 0, aff_ = 0;
  std::int64_t vkp_ = 0, vki_ = 0, vkd_ = 0;
  std::int32_t ds_ = 2, max_error_ = 0;

  std::array<std::int32_t, 4> history_{};  // of positions, the oldest next to be replaced
  std::size_t oldest_ = 0;
  std::int32_t velocity_ = 0;
  std::int64_t error_sum_ = 0, last_error_ = 0;
  std::int64_t velocity_sum_ = 0, last_velocity_error_ = 0;
  std::int32_t output_ = 0;
};

}  // namespace virtdrive::rzt1
