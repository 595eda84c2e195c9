#include "firmware_models/toshiba_mcu/encoder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kHallUvwEdges = 6;  // of three sensors in an electrical turn
constexpr int kHallUvEdges = 4;   // of two
constexpr std::int32_t kAs5145hSteps = 4096;
// A speed is taken over so many edges or so long, whichever comes first, but not within less than
// two milliseconds.
constexpr std::int64_t kEnoughEdges = 32;
constexpr double kShortestS = 2e-3;
constexpr double kLongestS = 20e-3;

std::int64_t floor_of(double turns) {
  return static_cast<std::int64_t>(std::floor(turns));
}

}  // namespace

std::int64_t ShaftSensors::edges(EncoderType type, double angle_rad, int motor_pole_pairs) const {
  constexpr std::uint8_t kU = 1, kV = 2, kW = 4;
  switch (type) {
    case EncoderType::kNone:
      break;
    case EncoderType::kHallUvw:
      return hall.edges(motor_pole_pairs * angle_rad, kU | kV | kW);
    case EncoderType::kHallUv:
      return hall.edges(motor_pole_pairs * angle_rad, kU | kV);
    case EncoderType::kAbz:
    case EncoderType::kAb:
      return encoder.count(angle_rad);
    case EncoderType::kSinglePulse:
      return encoder.index_count(angle_rad);
    case EncoderType::kAs5145h:
      return floor_of(angle_rad / kTurn * kAs5145hSteps);
  }
  return 0;
}

bool ShaftSensors::heard(EncoderType type) const {
  switch (type) {
    case EncoderType::kAbz:
    case EncoderType::kAb:
      return !encoder.cable_broken;
    case EncoderType::kSinglePulse:
      return !encoder.cable_broken && !encoder.index_dead;
    case EncoderType::kAs5145h:
      return !magnet_lost;
    default:
      return true;
  }
}

void EncoderCounter::configure(const ChannelSettings& settings, const Scaling& scaling) {
  const auto type = static_cast<EncoderType>(settings.encoder.value);
  if (type != type_) fresh_ = true;
  type_ = type;
  usage_ = static_cast<EncoderUsage>(settings.encoder_usage.value);
  period_s_ = seconds(scaling.pwm_period);
  pattern_ = type_ == EncoderType::kHallUv ? kHallUvEdges : 1;
  switch (type_) {
    case EncoderType::kNone:
    case EncoderType::kHallUvw:
      counts_per_turn_ = kHallUvwEdges * scaling.pole_pairs;
      break;
    case EncoderType::kHallUv:
      counts_per_turn_ = kHallUvEdges * scaling.pole_pairs;
      break;
    case EncoderType::kAbz:
    case EncoderType::kAb:
    case EncoderType::kSinglePulse:
      counts_per_turn_ = std::max(1, settings.encoder_resolution.value);
      break;
    case EncoderType::kAs5145h:
      counts_per_turn_ = kAs5145hSteps;
      break;
  }
}

void EncoderCounter::update(std::int64_t edges, double electrical_turns, int direction) {
  if (emulated()) edges = floor_of(electrical_turns * kHallUvwEdges);
  if (fresh_) edges_ = edges;
  fresh_ = false;
  const std::int64_t passed = edges - edges_;
  edges_ = edges;
  if (passed == 0) return;
  count_ += type_ == EncoderType::kSinglePulse ? direction * std::abs(passed) : passed;
  if (std::abs(count_ - edge_count_) < pattern_) return;
  edge_count_ += (count_ - edge_count_) / pattern_ * pattern_;
  edge_at_ = now_;
}

void EncoderCounter::restart_speed() {
  edge_at_ = base_at_ = now_;
  base_count_ = edge_count_ = count_;
  speed_ = 0;
}

void EncoderCounter::millisecond() {
  if (!measures_speed()) return;
  const double between_s = static_cast<double>(edge_at_ - base_at_) * period_s_;
  const double waited_s = static_cast<double>(now_ - edge_at_) * period_s_;
  const std::int64_t counts = edge_count_ - base_count_;
  const bool enough = std::abs(counts) >= kEnoughEdges || between_s + waited_s >= kLongestS;
  if (between_s >= kShortestS && enough) {
    speed_ = static_cast<double>(counts) / counts_per_turn_ / between_s;
    base_count_ = edge_count_;
    base_at_ = edge_at_;
  }
  // No edge for so long: slower than one count in that time.
  if (waited_s > kLongestS) {
    const double most = static_cast<double>(pattern_) / (counts_per_turn_ * waited_s);
    speed_ = std::clamp(speed_, -most, most);
    if (waited_s > 50 * kLongestS) speed_ = 0;
  }
}

}  // namespace virtdrive::toshiba_mcu
