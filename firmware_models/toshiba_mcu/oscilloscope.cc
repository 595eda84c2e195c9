#include "firmware_models/toshiba_mcu/oscilloscope.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "firmware_models/toshiba_mcu/motor_channel.h"

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kQ15 = 32768;
constexpr double kQ14 = 16384;
constexpr int kSectors = 12;  // of an electrical turn

std::int16_t rounded(double value) {
  return static_cast<std::int16_t>(std::clamp(std::round(value), -32768.0, 32767.0));
}

std::int16_t share(double value, double full_scale) {
  return full_scale > 0 ? rounded(value / full_scale * kQ15) : std::int16_t{0};
}

struct ScopeSignal {
  std::string_view name;
  std::string_view doc;
  std::int16_t (*read)(const MotorChannel&);
};

using Read = std::int16_t (*)(const MotorChannel&);

template <auto Member>
constexpr Read kVolts =
    [](const MotorChannel& c) { return share(c.internals().*Member, c.scaling().full_scale_v); };
template <auto Member>
constexpr Read kAmperes =
    [](const MotorChannel& c) { return share(c.internals().*Member, c.scaling().full_scale_a); };
template <auto Member>
constexpr Read kHertz =
    [](const MotorChannel& c) { return share(c.internals().*Member, c.scaling().full_scale_hz); };
template <std::size_t Phase>
constexpr Read kDuty =
    [](const MotorChannel& c) { return rounded(c.internals().duty[Phase] * kQ14); };
template <std::size_t Phase>
constexpr Read kPhaseCurrent = [](const MotorChannel& c) {
  return share(c.internals().current_a[Phase], c.scaling().full_scale_a);
};

using L = LoopState;

// Scales: the shifts of the maker's published firmware. The user variables are this image's choice.
constexpr std::array<ScopeSignal, kScopeSignals> kSignals = {{
    {"Va", "duty of phase a, 16384 is 100 %", kDuty<0>},
    {"Vb", "duty of phase b", kDuty<1>},
    {"Vc", "duty of phase c", kDuty<2>},
    {"Valpha", "32768 is v_max", kVolts<&L::v_alpha_v>},
    {"Vbeta", "32768 is v_max", kVolts<&L::v_beta_v>},
    {"Id", "32768 is a_max", kAmperes<&L::id_a>},
    {"Id_Ref", "32768 is a_max", kAmperes<&L::id_ref_a>},
    {"Iq", "32768 is a_max", kAmperes<&L::iq_a>},
    {"Iq_Ref", "32768 is a_max", kAmperes<&L::iq_ref_a>},
    {"Vd", "32768 is v_max", kVolts<&L::vd_v>},
    {"Vq", "32768 is v_max", kVolts<&L::vq_v>},
    {"Vdi", "d integral part, 32768 is v_max", kVolts<&L::vd_integral_v>},
    {"Vqi", "q integral part, 32768 is v_max", kVolts<&L::vq_integral_v>},
    {"Theta", "32768 is an electrical turn",
     [](const MotorChannel& c) {
       return static_cast<std::int16_t>(c.internals().theta_turns * kQ15);
     }},
    {"Omega", "speed that turns theta, 32768 is HzMax", kHertz<&L::omega_hz>},
    {"Omega_Calc", "the position estimator's speed, 32768 is HzMax", kHertz<&L::omega_calc_hz>},
    {"SIN_Theta", "32768 is 1", [](const MotorChannel& c) { return share(c.internals().sine, 1); }},
    {"COS_Theta", "32768 is 1",
     [](const MotorChannel& c) { return share(c.internals().cosine, 1); }},
    {"Sector", "0..11, of 30 degrees each",
     [](const MotorChannel& c) {
       return static_cast<std::int16_t>(c.internals().theta_turns * kSectors);
     }},
    {"VDC", "32768 is v_max", kVolts<&L::bus_v>},
    {"Ia", "32768 is a_max", kPhaseCurrent<0>},
    {"Ib", "32768 is a_max", kPhaseCurrent<1>},
    {"Ic", "32768 is a_max", kPhaseCurrent<2>},
    {"Ialpha", "32768 is a_max", kAmperes<&L::i_alpha_a>},
    {"Ibeta", "32768 is a_max", kAmperes<&L::i_beta_a>},
    {"VE_Stage", "MotorStage",
     [](const MotorChannel& c) { return static_cast<std::int16_t>(c.stage()); }},
    {"User1", "ramped speed command, 32768 is HzMax", kHertz<&L::command_hz>},
    {"User2", "integral part of Iq_Ref, 32768 is a_max", kAmperes<&L::iq_integral_a>},
    {"User3", "target speed, rpm", [](const MotorChannel& c) { return rounded(c.target_rpm()); }},
    {"User4", "actual speed, rpm", [](const MotorChannel& c) { return rounded(c.actual_rpm()); }},
    {"User5", "encoder counter, lower 16 bits",
     [](const MotorChannel& c) { return static_cast<std::int16_t>(c.encoder().count()); }},
    {"User6", "ErrorState",
     [](const MotorChannel& c) { return static_cast<std::int16_t>(c.errors()); }},
}};

}  // namespace

std::string_view scope_signal_name(unsigned bit) {
  return kSignals[bit].name;
}
std::string_view scope_signal_doc(unsigned bit) {
  return kSignals[bit].doc;
}
std::int16_t scope_value(const MotorChannel& channel, unsigned bit) {
  return kSignals[bit].read(channel);
}

// --- Which signals, how often --------------------------------------------------------------------

ScopeChannels::ScopeChannels(std::size_t motor, std::uint32_t selected, std::uint8_t spread)
    : motor_(motor), spread_(spread), waited_(spread) {
  for (std::uint8_t bit = 0; bit < kScopeSignals; ++bit) {
    if ((selected >> bit & 1U) != 0) bits_[count_++] = bit;
  }
}

bool ScopeChannels::due() {
  if (waited_ < spread_) {
    ++waited_;
    return false;
  }
  waited_ = 0;
  return true;
}

std::span<const std::int16_t> ScopeChannels::sample(const MotorChannel& channel) {
  for (std::size_t i = 0; i < count_; ++i) values_[i] = scope_value(channel, bits_[i]);
  return std::span(values_).first(count_);
}

// --- Snapshot ------------------------------------------------------------------------------------

std::uint16_t SnapshotScope::arm(const Request& request) {
  const int signals = std::popcount(request.selected);
  *this = {};
  if (signals == 0 || signals > kMostSignals) return 0;
  request_ = request;
  channels_ = {request.motor, request.selected, request.spread};
  const std::size_t depth = kIdentity.dso_size / channels_.size();
  ring_.assign(depth * channels_.size(), 0);
  const bool centred = (request.mode & 2) != 0 && request.trigger_on != 0;
  to_come_ = centred ? depth / 2 : depth;
  triggered_ = request.trigger_on == 0;
  trigger_bit_ = triggered_ ? 0 : static_cast<unsigned>(std::bit_width(request.trigger_on) - 1);
  blocks_ = (ring_.size() + kBlock - 1) / kBlock;
  logging_ = true;
  return static_cast<std::uint16_t>(blocks_);
}

bool SnapshotScope::triggers(std::int16_t value) {
  const std::int16_t before = std::exchange(last_, value);
  if (std::exchange(first_, false)) return false;
  const bool rising = (request_.mode & 1) != 0;
  const std::int16_t low = rising ? before : value;
  const std::int16_t high = rising ? value : before;
  return low < high && low <= request_.level && request_.level <= high;
}

void SnapshotScope::log(const MotorChannel& channel) {
  if (!channels_.due()) return;
  const std::size_t depth = ring_.size() / channels_.size();
  if (!triggered_) {
    // What lies before a centred trigger has to be there first.
    const bool filled = sets_ >= depth - to_come_;
    triggered_ = triggers(scope_value(channel, trigger_bit_)) && filled;
  }
  const auto set = channels_.sample(channel);
  std::ranges::copy(set, ring_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = (at_ + set.size()) % ring_.size();
  sets_ = std::min(sets_ + 1, depth);
  if (triggered_ && --to_come_ == 0) {
    logging_ = false;
    start_ = at_;
  }
}

Outcome SnapshotScope::next_block(std::array<std::int16_t, kBlock>& block) {
  if (logging_) return Outcome::kNotReady;
  if (fetched_ == blocks_) return Outcome::kRefused;
  for (std::size_t i = 0; i < kBlock; ++i) {
    block[i] = ring_[(start_ + fetched_ * kBlock + i) % ring_.size()];
  }
  ++fetched_;
  return Outcome::kDone;
}

// --- Stream --------------------------------------------------------------------------------------

Outcome StreamScope::enable(std::size_t motor, std::uint32_t selected, std::uint8_t spread) {
  if (selected == 0) return Outcome::kRefused;
  channels_ = {motor, selected, spread};
  periods_ = 0;
  enabled_ = true;
  return Outcome::kDone;
}

void StreamScope::stream(const MotorChannel& channel) {
  const auto frequency = static_cast<std::uint32_t>(channel.settings().pwm_frequency.value);
  const auto timestamp = static_cast<std::uint16_t>(periods_);
  periods_ = periods_ + 1 < frequency ? periods_ + 1 : 0;
  if (channels_.due() && sink_) sink_(timestamp, channels_.sample(channel));
}

}  // namespace virtdrive::toshiba_mcu
