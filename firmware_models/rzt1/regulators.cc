#include "firmware_models/rzt1/regulators.h"

#include <algorithm>
#include <cstdlib>

#include "firmware_models/rzt1/counts.h"

namespace virtdrive::rzt1 {
namespace {

constexpr std::int64_t kFull = 32767;
constexpr int kLimitShift = 11;  // MLIMIT 32767: 1024 counts a cycle

}  // namespace

void Regulators::latch(const Settings& s) {
  kp_ = word(s.kp);
  ki_ = word(s.ki);
  kd_ = word(s.kd);
  il_ = word(s.il) << 8;
  vff_ = word(s.vff);
  aff_ = word(s.aff);
  vkp_ = word(s.vkp);
  vki_ = word(s.vki);
  vkd_ = word(s.vkd);
  ds_ = static_cast<std::int32_t>(std::max<std::int64_t>(1, word(s.ds)));
  max_error_ = s.max_error;
}

void Regulators::reset(std::int32_t position) {
  history_.fill(position);
  velocity_ = 0;
  error_sum_ = last_error_ = 0;
  velocity_sum_ = last_velocity_error_ = 0;
  output_ = 0;
}

void Regulators::observe(std::int32_t position) {
  const std::int32_t before = history_[oldest_];
  history_[oldest_] = position;
  oldest_ = (oldest_ + 1) % history_.size();
  const std::int64_t velocity = (static_cast<std::int64_t>(difference(position, before)) << 16) / 4;
  velocity_ = static_cast<std::int32_t>(std::clamp<std::int64_t>(velocity, INT32_MIN, INT32_MAX));
}

void Regulators::shift(std::int32_t counts) {
  for (std::int32_t& position : history_) position = sum(position, counts);
}

std::int32_t Regulators::step(std::int32_t command, std::int32_t velocity,
                              std::int32_t acceleration, std::int32_t actual,
                              const Settings& settings) {
  const std::int64_t e = std::clamp<std::int64_t>(difference(command, actual), -kFull, kFull);
  error_sum_ = std::clamp(error_sum_ + e, -il_, il_);
  std::int64_t target = kp_ * e + kd_ * (e - last_error_) + (ki_ * error_sum_ >> 8) +
                        (vff_ * (velocity >> 8) >> 7) + (aff_ * (acceleration >> 8) >> 8) +
                        settings.bias;
  last_error_ = e;
  const std::int64_t limit = word(settings.mlimit) << kLimitShift;
  target = std::clamp(target, -limit, limit);

  const std::int64_t ev = target - velocity_;
  const std::int64_t integral = vki_ == 0 ? 0 : velocity_sum_ + ev;
  if (std::abs(vki_ * integral >> 16) <= kFull) velocity_sum_ = integral;
  const std::int64_t q =
      (vkp_ * ev >> 12) + (vki_ * velocity_sum_ >> 16) + (vkd_ * (ev - last_velocity_error_) >> 12);
  last_velocity_error_ = ev;
  output_ = static_cast<std::int32_t>(std::clamp(q, -kFull, kFull));
  return output_;
}

}  // namespace virtdrive::rzt1
