#include "pty/uart.h"

#include <algorithm>
#include <bit>

namespace virtdrive {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

// Edges and sampling points are rounded down to 1 ns each. Where a sample meets an edge exactly, as
// with a listener at half the rate, it takes the later bit, and this makes up for the rounding.
constexpr SimDuration kAfterMiddle{2};

bool parity_bit(std::uint8_t byte, const LineSettings& settings) {
  const auto data = static_cast<std::uint8_t>(byte & ((1U << settings.data_bits) - 1));
  return (std::popcount(data) % 2 != 0) != (settings.parity == Parity::kOdd);
}

SimDuration middle_of_bit(int bit, const LineSettings& settings) {
  return SimDuration{(2 * bit + 1) * kNsPerSecond / (2 * std::int64_t{settings.baud})} +
         kAfterMiddle;
}

}  // namespace

// --- Levels --------------------------------------------------------------------------------------

void Levels::append(SimTime t, bool high, int talker) {
  if (high != this->high()) changes_.push_back({t, high, talker});
}

std::deque<Levels::Change>::const_iterator Levels::after(SimTime t) const {
  return std::upper_bound(changes_.begin(), changes_.end(), t,
                          [](SimTime time, const Change& change) { return time < change.time; });
}

bool Levels::high_at(SimTime t) const {
  const auto next = after(t);
  return next == changes_.begin() ? high_before_ : std::prev(next)->high;
}

int Levels::talker_at(SimTime t) const {
  const auto next = after(t);
  return next == changes_.begin() ? kNoTalker : std::prev(next)->talker;
}

Levels::Fall Levels::next_fall(SimTime t) const {
  auto change = after(t);
  if (change != changes_.end() && change->high) ++change;
  return change == changes_.end() ? Fall{} : Fall{change->time, change->talker};
}

void Levels::forget_before(SimTime t) {
  while (!changes_.empty() && changes_.front().time < t) {
    high_before_ = changes_.front().high;
    changes_.pop_front();
  }
}

void Levels::clear() {
  changes_.clear();
  high_before_ = true;
}

// --- Uart ----------------------------------------------------------------------------------------

void Uart::listen_from(SimTime t) {
  from_ = t;
  anew_ = true;
}

Levels::Fall Uart::start(const Levels& levels) const {
  if (anew_ && !levels.high_at(from_)) return {from_, levels.talker_at(from_)};
  return levels.next_fall(from_);
}

SimTime Uart::due(const Levels& levels, const LineSettings& settings) const {
  const SimTime edge = start(levels).time;
  return edge == kNever ? kNever : edge + reading_time(settings);
}

std::optional<WireByte> Uart::read(const Levels& levels, const LineSettings& settings,
                                   SimTime until) {
  for (;;) {
    const Levels::Fall edge = start(levels);
    if (edge.time == kNever || edge.time + reading_time(settings) > until) return std::nullopt;
    int bit = 0;
    const auto sample = [&] {
      anew_ = false;
      from_ = edge.time + middle_of_bit(bit++, settings);
      return levels.high_at(from_);
    };
    if (sample()) continue;
    WireByte heard{
        .begin = edge.time, .end = edge.time + reading_time(settings), .talker = edge.talker};
    for (int i = 0; i < settings.data_bits; ++i) {
      if (sample()) heard.byte |= static_cast<std::uint8_t>(1U << i);
    }
    if (settings.parity != Parity::kNone) {
      heard.error = sample() != parity_bit(heard.byte, settings);
    }
    if (!sample()) heard.error = true;
    return heard;
  }
}

// --- What is said --------------------------------------------------------------------------------

SimDuration reading_time(const LineSettings& settings) {
  LineSettings one_stop_bit = settings;
  one_stop_bit.timing = LineTiming::kReal;
  one_stop_bit.stop_bits = 1;
  return one_stop_bit.character_time();
}

std::uint16_t character_levels(std::uint8_t byte, const LineSettings& settings, bool wrong_parity) {
  unsigned levels = (byte & ((1U << settings.data_bits) - 1)) << 1;
  int bits = 1 + settings.data_bits;
  if (settings.parity != Parity::kNone) {
    const bool high = parity_bit(byte, settings) != wrong_parity;
    levels |= (high ? 1U : 0U) << bits++;
  }
  return static_cast<std::uint16_t>(levels | ((1U << settings.stop_bits) - 1) << bits);
}

std::vector<WireByte> resample(std::span<const std::uint8_t> bytes, const LineSettings& sender,
                               const LineSettings& listener) {
  Levels levels;
  std::int64_t bit_times = 0;
  for (const std::uint8_t byte : bytes) {
    const std::uint16_t bits = character_levels(byte, sender);
    for (int bit = 0; bit < sender.character_bits(); ++bit, ++bit_times) {
      levels.append(kSimStart + SimDuration{bit_times * kNsPerSecond / sender.baud},
                    (bits >> bit & 1) != 0);
    }
  }
  std::vector<WireByte> heard;
  Uart uart;
  while (const auto byte = uart.read(levels, listener, kNever)) heard.push_back(*byte);
  return heard;
}

}  // namespace virtdrive
