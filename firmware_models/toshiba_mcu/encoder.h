// Encoders: what the board's inputs count, and what the program makes of it.
//
// Encoder (5.1.15)   counts a turn                       wired on the bench
// 0 none             6 per electrical turn, emulated     -
// 1 Hall UVW         6 per electrical turn               the motor's three Hall sensors
// 2 Hall UV          4 per electrical turn               two of them
// 3 ABZ, 4 AB        EncoderResolution                   500 lines, four edges each
// 5 single pulse     EncoderResolution, no direction     the index track: one pulse a turn
// 6 AS5145H          4096                                12-bit magnetic encoder
#pragma once

#include <cstdint>

#include "firmware_models/toshiba_mcu/scaling.h"
#include "firmware_models/toshiba_mcu/settings.h"
#include "plant/sensors.h"

namespace virtdrive::toshiba_mcu {

enum class EncoderType : std::uint8_t {
  kNone,
  kHallUvw,
  kHallUv,
  kAbz,
  kAb,
  kSinglePulse,
  kAs5145h
};
enum class EncoderUsage : std::uint8_t { kNone, kSpeed, kEvent };

/// What is wired to one motor on the bench.
struct ShaftSensors {
  HallSensors hall{};
  Encoder encoder{.lines = 500};
  bool magnet_lost = false;  // the AS5145H stands still

  /// Edges since some angle at the inputs that `type` evaluates. kSinglePulse: index pulses passed,
  /// whichever way.
  std::int64_t edges(EncoderType type, double angle_rad, int motor_pole_pairs) const;
  /// False while those inputs hear nothing.
  bool heard(EncoderType type) const;
};

/// The program's counter and speed measurement for one channel.
class EncoderCounter {
 public:
  /// A new type begins at the present edge, with the counter unchanged.
  void configure(const ChannelSettings& settings, const Scaling& scaling);

  /// A reading of the inputs; `direction` (+1, -1) is what a single pulse is taken for. With no
  /// encoder `electrical_turns` of the observer are counted instead.
  void update(std::int64_t edges, double electrical_turns, int direction);
  /// Once each PWM period: the time base of the speed.
  void period() { ++now_; }
  /// The speed is measured anew from here.
  void restart_speed();
  /// Once each millisecond: brings the measured speed up to date.
  void millisecond();

  /// Free-running, wraps at 32 bits.
  std::int32_t count() const { return static_cast<std::int32_t>(count_); }
  std::int64_t total() const { return count_; }
  /// By the settings; at least 1.
  double counts_per_turn() const { return counts_per_turn_; }
  double turns() const { return static_cast<double>(count_) / counts_per_turn_; }
  bool emulated() const { return type_ == EncoderType::kNone; }
  /// True if the settings want speed from an encoder, and there is one.
  bool measures_speed() const { return usage_ == EncoderUsage::kSpeed && !emulated(); }
  /// Mechanical, from the edges of the last 2 to 20 ms; falls towards 0 when none come.
  double speed_turns_per_s() const { return speed_; }

 private:
  EncoderType type_ = EncoderType::kNone;
  EncoderUsage usage_ = EncoderUsage::kNone;
  double counts_per_turn_ = 1;
  double period_s_ = 0;

  std::int64_t edges_ = 0;  // of the last reading
  bool fresh_ = true;       // the next reading only sets edges_
  std::int64_t count_ = 0;

  // Speed: counts between two edges over the time between them, in PWM periods. Of edges that lie
  // unevenly only each `pattern_`-th is taken.
  std::int64_t pattern_ = 1;
  std::int64_t now_ = 0;
  std::int64_t edge_at_ = 0, base_at_ = 0;
  std::int64_t edge_count_ = 0, base_count_ = 0;
  double speed_ = 0;
};

}  // namespace virtdrive::toshiba_mcu
