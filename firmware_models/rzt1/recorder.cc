#include "firmware_models/rzt1/recorder.h"

#include "firmware_models/rzt1/servo_axis.h"

namespace virtdrive::rzt1 {
namespace {

constexpr int kHighestSource = 21;
constexpr int kHighestTrigger = 10;

constexpr bool is_wide(int source) {
  return source < 8;
}

// 7.4: what the recorder does from the write of TRACE on.
constexpr Recorder::Mode kFirstMode[kHighestTrigger + 1] = {
    Recorder::Mode::kIdle,  Recorder::Mode::kRing,  Recorder::Mode::kUntilFull,
    Recorder::Mode::kArmed, Recorder::Mode::kRing,  Recorder::Mode::kRing,
    Recorder::Mode::kRing,  Recorder::Mode::kArmed, Recorder::Mode::kArmed,
    Recorder::Mode::kArmed, Recorder::Mode::kArmed};

}  // namespace

Result Recorder::set_channel(std::size_t channel, int source, std::size_t axis) {
  if (source < 0 || source > kHighestSource || (source > 3 && source < 8)) {
    return Result::kOutOfRange;
  }
  source_[channel] = source;
  axis_ = axis;
  return Result::kOk;
}

Result Recorder::set_trigger(int trigger) {
  if (trigger < 0 || trigger > kHighestTrigger) return Result::kOutOfRange;
  trigger_ = trigger;
  mode_ = kFirstMode[trigger];
  if (trigger == 0) return Result::kOk;
  next_ = count_ = 0;
  skipped_ = 0;
  primed_ = false;
  wide_ = is_wide(source_[0]);
  return Result::kOk;
}

std::int16_t Recorder::word(std::size_t channel, std::size_t index) const {
  return buffer_[channel][(next_ + kCapacity - count_ + index) % kCapacity];
}

std::int32_t Recorder::value(std::size_t channel, std::size_t index) const {
  const std::int32_t low = word(channel, index);
  if (channel != 0 || !wide_) return low;
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(word(3, index)) << 16 |
                                   (static_cast<std::uint32_t>(low) & 0xFFFF));
}

void Recorder::sample(const ServoAxis& axis, std::int32_t timing) {
  const std::int32_t ch1 = axis.trace(source_[0], timing);
  const bool was_primed = primed_;
  if (!primed_) {
    primed_ = true;
    was_moving_ = axis.moving();
    was_output_ = axis.output();
    was_inputs_ = axis.digital_inputs();
  }
  if (mode_ == Mode::kArmed && starts(axis, ch1)) {
    mode_ = trigger_ == 3 ? Mode::kRing : Mode::kUntilFull;
  }
  const bool stop = was_primed && mode_ == Mode::kRing && stops(axis, ch1);
  if (mode_ == Mode::kRing || mode_ == Mode::kUntilFull) record(axis, timing);
  if (stop || (mode_ == Mode::kUntilFull && count_ == kCapacity)) mode_ = Mode::kIdle;
  was_moving_ = axis.moving();
  was_output_ = axis.output();
  was_inputs_ = axis.digital_inputs();
}

bool Recorder::starts(const ServoAxis& axis, std::int32_t ch1) {
  const bool begins = axis.moving() && !was_moving_;
  switch (trigger_) {
    case 3:
      return begins || (!axis.servo_on() && axis.output() != 0);
    case 7:
      return begins || axis.output() != was_output_;
    case 8:
      return ((axis.digital_inputs() ^ was_inputs_) & level_) != 0;
    case 9:
      return ch1 > level_;
    case 10:
      return ch1 < level_;
    default:
      return false;
  }
}

bool Recorder::stops(const ServoAxis& axis, std::int32_t ch1) {
  switch (trigger_) {
    case 1:
      return was_moving_ && !axis.moving();
    case 3:
      return axis.servo_on() ? !axis.moving() : axis.output() == 0;
    case 4:
      return ((axis.digital_inputs() ^ was_inputs_) & level_) != 0;
    case 5:
      return ch1 > level_;
    case 6:
      return ch1 < level_;
    default:
      return false;
  }
}

void Recorder::record(const ServoAxis& axis, std::int32_t timing) {
  if (skipped_ > 0 && skipped_ < rate_) {
    ++skipped_;
    return;
  }
  skipped_ = 1;
  for (std::size_t i = 0; i < kChannels; ++i) {
    if (i == 3 && wide_) continue;
    buffer_[i][next_] = static_cast<std::int16_t>(axis.trace(source_[i], timing));
  }
  if (wide_) buffer_[3][next_] = static_cast<std::int16_t>(axis.trace(source_[0], timing) >> 16);
  next_ = (next_ + 1) % kCapacity;
  if (count_ < kCapacity) ++count_;
}

}  // namespace virtdrive::rzt1
