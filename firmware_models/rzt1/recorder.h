// The data recorder (7.4): four channels of 512 words, filled from the 50 us task of the axis that
// CHn was written for last.
//
//   recorder.set_channel(0, 8, 1);   // axis 1: CH1 = position error
//   recorder.set_trigger(3);         // from the motion's start to its end
//   recorder.sample_count(), recorder.value(0, i)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware_models/rzt1/result.h"

namespace virtdrive::rzt1 {

/// What CHn chooses; 4..7 are reserved. Codes below 8 are 32 bits wide.
enum class TraceSource : std::uint8_t {
  kPosition = 0,
  kCommandVelocity = 1,
  kCommandAcceleration = 2,
  kI2t = 3,
  kPositionError = 8,
  kRegulatorOutput = 9,
  kTotalCurrent = 10,
  kDirectCurrent = 11,
  kQuadratureCurrent = 12,
  kDirectError = 13,
  kQuadratureError = 14,
  kRawA = 15,
  kRawB = 16,
  kPvtDepth = 17,
  kDirectVoltage = 18,
  kQuadratureVoltage = 19,
  kTaskTiming = 20,
  kPhaseAngle = 21,
};

class ServoAxis;

class Recorder {
 public:
  static constexpr std::size_t kCapacity = 512;  // TBSIZE
  static constexpr std::size_t kChannels = 4;

  /// TMODE.
  enum class Mode : std::uint8_t { kIdle = 0, kArmed = 1, kUntilFull = 2, kRing = 3 };

  /// CH1..CH4 (channel 0..3): a source code, 0..3 or 8..21, of axis 0 or 1. kOutOfRange for others.
  Result set_channel(std::size_t channel, int source, std::size_t axis);
  int channel(std::size_t channel) const { return source_[channel]; }
  /// The axis that is recorded.
  std::size_t axis() const { return axis_; }

  /// TRACE 0..10: begins anew, or ends. kOutOfRange for others.
  Result set_trigger(int trigger);
  int trigger() const { return trigger_; }
  Mode mode() const { return mode_; }
  /// TRATE: in 50 us; 0 counts as 1.
  void set_rate(int multiple) { rate_ = multiple; }
  int rate() const { return rate_; }
  /// TLEVEL: of CH1, or the mask of inputs (0..6 as in ServoAxis::digital_inputs()).
  void set_level(std::int32_t level) { level_ = level; }
  std::int32_t level() const { return level_; }

  /// Samples that are there, the oldest first.
  std::size_t sample_count() const { return count_; }
  /// True: CH1 is 32 bits wide, and buffer 3 has its high words.
  bool wide() const { return wide_; }
  /// A buffer's word.
  std::int16_t word(std::size_t channel, std::size_t index) const;
  /// As a host sees it: CH1 joined with its high word where that is recorded.
  std::int32_t value(std::size_t channel, std::size_t index) const;

  /// It needs the 50 us task.
  bool busy() const { return mode_ != Mode::kIdle; }
  /// The 50 us task, on the recorded axis, after the loops have run. `timing` is TIMER.
  void sample(const ServoAxis& axis, std::int32_t timing);

 private:
  void record(const ServoAxis& axis, std::int32_t timing);
  bool starts(const ServoAxis& axis, std::int32_t ch1);
  bool stops(const ServoAxis& axis, std::int32_t ch1);

  std::array<int, kChannels> source_{};
  std::size_t axis_ = 0;
  int trigger_ = 0;
  Mode mode_ = Mode::kIdle;
  int rate_ = 1;
  std::int32_t level_ = 0;
  int skipped_ = 0;

  std::array<std::array<std::int16_t, kCapacity>, kChannels> buffer_{};
  std::size_t next_ = 0, count_ = 0;
  bool wide_ = false;

  // As they were at the last sample, for edges.
  bool primed_ = false;
  bool was_moving_ = false;
  std::int32_t was_output_ = 0;
  std::uint8_t was_inputs_ = 0;
};

}  // namespace virtdrive::rzt1
