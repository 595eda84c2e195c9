#include "pty/serial_line.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

void check_settings(const LineSettings& s) {
  VIRTDRIVE_CHECK(
      s.baud > 0 && s.data_bits >= 5 && s.data_bits <= 8 && s.stop_bits >= 1 && s.stop_bits <= 2,
      "a line of {} baud, {} data bits, {} stop bits", s.baud, s.data_bits, s.stop_bits);
}

bool parity_bit(std::uint8_t byte, const LineSettings& settings) {
  const auto data = static_cast<std::uint8_t>(byte & ((1U << settings.data_bits) - 1));
  return (std::popcount(data) % 2 != 0) != (settings.parity == Parity::kOdd);
}

/// The line's level, bit time by bit time of the sender.
std::vector<bool> levels(std::span<const std::uint8_t> bytes, const LineSettings& settings) {
  std::vector<bool> bits;
  bits.reserve(bytes.size() * static_cast<std::size_t>(settings.character_bits()));
  for (const std::uint8_t byte : bytes) {
    bits.push_back(false);
    for (int i = 0; i < settings.data_bits; ++i) bits.push_back((byte >> i & 1) != 0);
    if (settings.parity != Parity::kNone) bits.push_back(parity_bit(byte, settings));
    bits.insert(bits.end(), static_cast<std::size_t>(settings.stop_bits), true);
  }
  return bits;
}

/// Stop bits do not matter: a receiver looks at the first one only.
bool understand_each_other(const LineSettings& a, const LineSettings& b) {
  return a.baud == b.baud && a.data_bits == b.data_bits && a.parity == b.parity;
}

bool close_enough(int a, int b) {
  return std::abs(a - b) <= SerialLine::kBaudTolerance * std::min(a, b);
}

}  // namespace

SimDuration LineSettings::time_of(std::int64_t count) const {
  if (timing == LineTiming::kIdeal) return SimDuration{0};
  return SimDuration{count * character_bits() * kNsPerSecond / baud};
}

std::vector<ResampledByte> resample(std::span<const std::uint8_t> bytes, const LineSettings& sender,
                                    const LineSettings& listener) {
  // In units of 1 / (2 from to) s a sender's bit, a receiver's bit and half of it are integers.
  const std::int64_t sender_bit = 2 * std::int64_t{listener.baud};
  const std::int64_t half = sender.baud;
  const std::vector<bool> bits = levels(bytes, sender);
  const auto index = [&](std::int64_t t) { return static_cast<std::size_t>(t / sender_bit); };
  const auto level = [&](std::int64_t t) { return index(t) >= bits.size() || bits[index(t)]; };

  std::vector<ResampledByte> heard;
  std::size_t edge = 0;  // the sender's bit at whose start the line falls
  while (edge < bits.size()) {
    std::int64_t t = static_cast<std::int64_t>(edge) * sender_bit + half;
    if (!level(t)) {
      ResampledByte character;
      for (int i = 0; i < listener.data_bits; ++i) {
        t += 2 * half;
        if (level(t)) character.byte |= static_cast<std::uint8_t>(1U << i);
      }
      if (listener.parity != Parity::kNone) {
        t += 2 * half;
        character.error = level(t) != parity_bit(character.byte, listener);
      }
      t += 2 * half;
      character.error |= !level(t);
      character.arrival = SimDuration{static_cast<std::int64_t>(edge) * kNsPerSecond / sender.baud +
                                      listener.character_bits() * kNsPerSecond / listener.baud};
      heard.push_back(character);
    }
    edge = index(t);
    while (edge < bits.size() && !bits[edge]) ++edge;
    while (edge < bits.size() && bits[edge]) ++edge;
  }
  return heard;
}

SerialLine::Lane::Lane(EventLoop& loop, std::uint64_t* lost,
                       std::function<void(std::uint8_t)> deliver)
    : loop_(loop),
      lost_(lost),
      deliver_(std::move(deliver)),
      wakeup_(loop.add(Phase::kBytes, [this] { deliver_due(); })) {}

SimTime SerialLine::Lane::send(std::span<const std::uint8_t> bytes, const LineSettings& sender) {
  for (const std::uint8_t byte : bytes) {
    start(sender);
    if (characters_.size() == kMaxQueued) {
      ++*lost_;
      continue;
    }
    leave(1);
    push(byte, idle_);
  }
  return std::max(idle_, loop_.now());
}

SimTime SerialLine::Lane::send(std::span<const ResampledByte> heard, std::size_t sent,
                               const LineSettings& sender) {
  start(sender);
  const SimTime from = std::max(idle_, loop_.now());
  const bool ideal = sender.timing == LineTiming::kIdeal;
  for (const ResampledByte& character : heard) {
    if (characters_.size() == kMaxQueued) {
      ++*lost_;
      continue;
    }
    push(character.byte, from + (ideal ? SimDuration{0} : character.arrival));
  }
  leave(sent);
  return std::max(idle_, loop_.now());
}

// A burst goes on while its characters follow each other without a gap at one baud rate.
void SerialLine::Lane::start(const LineSettings& sender) {
  if (idle_ >= loop_.now() && sender == sender_ && burst_count_ < sender.baud) return;
  // After `baud` characters a burst has lasted a whole number of seconds: starting anew is exact.
  burst_start_ = std::max(idle_, loop_.now());
  burst_count_ = 0;
  sender_ = sender;
}

void SerialLine::Lane::leave(std::size_t count) {
  burst_count_ += static_cast<std::int64_t>(count);
  idle_ = burst_start_ + sender_.time_of(burst_count_);
}

void SerialLine::Lane::push(std::uint8_t byte, SimTime arrival) {
  if (!characters_.empty()) arrival = std::max(arrival, characters_.back().arrival);
  characters_.push_back({arrival, byte});
  if (characters_.size() == 1) wakeup_.at(arrival);
}

void SerialLine::Lane::deliver_due() {
  while (!characters_.empty() && characters_.front().arrival <= loop_.now()) {
    const std::uint8_t byte = characters_.front().byte;
    characters_.pop_front();
    deliver_(byte);
  }
  if (!characters_.empty()) wakeup_.at(characters_.front().arrival);
}

SerialLine::SerialLine(EventLoop& loop, const LineSettings& settings)
    : loop_(loop),
      settings_(settings),
      to_device_(loop, &counters_.to_device_lost,
                 [this](std::uint8_t byte) {
                   if (device_ == nullptr) return;
                   ++counters_.to_device;
                   device_->receive(byte);
                 }),
      to_host_(loop, &counters_.to_host_lost, [this](std::uint8_t byte) {
        if (!host_listener_) return;
        ++counters_.to_host;
        host_listener_(byte, loop_.now());
      }) {
  check_settings(settings_);
}

void SerialLine::host_send(std::span<const std::uint8_t> bytes) {
  if (host_tap_) host_tap_(bytes, host_, loop_.now());
  carry(to_device_, bytes, host_line(), settings_);
}

SimTime SerialLine::device_send(std::span<const std::uint8_t> bytes) {
  return carry(to_host_, bytes, settings_, host_line());
}

SimTime SerialLine::carry(Lane& lane, std::span<const std::uint8_t> bytes,
                          const LineSettings& sender, const LineSettings& listener) {
  if (understand_each_other(sender, listener)) return lane.send(bytes, sender);
  counters_.garbled += bytes.size();
  std::vector<ResampledByte> heard = resample(bytes, sender, listener);
  // Who checks parity throws away what fails it.
  if (listener.parity != Parity::kNone) std::erase_if(heard, std::mem_fn(&ResampledByte::error));
  return lane.send(heard, bytes.size(), sender);
}

void SerialLine::set_baud(int baud) {
  settings_.baud = baud;
  check_settings(settings_);
}

void SerialLine::set_host(const HostSettings& host) {
  host_ = host;
  check_settings(host_line());
}

LineSettings SerialLine::host_line() const {
  LineSettings line = settings_;
  if (host_.baud != 0 && !close_enough(host_.baud, settings_.baud)) line.baud = host_.baud;
  if (host_.stop_bits != 0) line.stop_bits = host_.stop_bits;
  if (host_.data_bits != 0) line.data_bits = host_.data_bits;
  if (host_.parity) line.parity = *host_.parity;
  return line;
}

}  // namespace virtdrive
