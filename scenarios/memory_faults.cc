#include "scenarios/memory_faults.h"

#include <algorithm>
#include <utility>

namespace virtdrive {
namespace {

constexpr std::uint8_t kErased = 0xFF;
constexpr double kMostWornBits = 1000;
constexpr double kLongestWrite_s = 10;

}  // namespace

FaultyMemory::FaultyMemory(std::unique_ptr<NonVolatileMemory> memory, const EventLoop& loop,
                           const Seed& seed)
    : memory_(std::move(memory)), loop_(loop), seed_(seed.scope("memory")) {}

std::optional<std::vector<std::uint8_t>> FaultyMemory::read(std::string_view block) {
  auto bytes = memory_->read(block);
  if (!bytes || bytes->empty()) return bytes;
  RandomStream chance = seed_.stream(block);
  for (std::size_t i = 0; i < worn_bits_; ++i) {
    const std::uint64_t bit = chance.bits() % (8 * bytes->size());
    (*bytes)[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  return bytes;
}

bool FaultyMemory::write(std::string_view block, std::span<const std::uint8_t> bytes) {
  if (locked_) return false;
  std::erase_if(writes_, [&](const Write& write) { return loop_.now() - write.at >= write_time_; });
  if (write_time_ > SimDuration{}) {
    auto before = memory_->read(block).value_or(std::vector<std::uint8_t>{});
    before.resize(bytes.size(), kErased);
    writes_.push_back({std::string(block), std::move(before), loop_.now()});
  }
  return memory_->write(block, bytes);
}

bool FaultyMemory::erase() {
  return !locked_ && memory_->erase();
}

void FaultyMemory::power_lost() {
  for (const Write& write : std::exchange(writes_, {})) {
    const SimDuration spent = loop_.now() - write.at;
    auto bytes = memory_->read(write.block);
    if (spent >= write_time_ || !bytes) continue;
    const auto done = static_cast<std::ptrdiff_t>(static_cast<std::int64_t>(bytes->size()) *
                                                  spent.count() / write_time_.count());
    std::copy(write.before.begin() + done, write.before.end(), bytes->begin() + done);
    memory_->write(write.block, *bytes);
  }
}

void FaultyMemory::register_signals(Registry& registry) {
  registry.add(
      Input{.signal = {"memory.worn_bits", "", "So many bits of each block are read wrongly",
                       [this] { return static_cast<double>(worn_bits_); }},
            .minimum = 0,
            .maximum = kMostWornBits,
            .write = [this](double bits) { worn_bits_ = static_cast<std::size_t>(bits); },
            .fault = true});
  registry.add(Input{.signal = {"memory.locked", "", "The memory takes no writes",
                                [this] { return locked_ ? 1.0 : 0.0; }},
                     .minimum = 0,
                     .maximum = 1,
                     .write = [this](double locked) { locked_ = locked != 0; },
                     .fault = true});
  registry.add(
      Input{.signal = {"memory.write_time", "s",
                       "How long a write takes: power that goes meanwhile leaves it torn",
                       [this] { return std::chrono::duration<double>(write_time_).count(); }},
            .minimum = 0,
            .maximum = kLongestWrite_s,
            .write = [this](double time_s) { write_time_ = from_seconds(time_s); }});
}

}  // namespace virtdrive
