// A drive's non-volatile memory with what can go wrong in it: worn cells, a chip that takes no
// writes, and power that goes in the middle of one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "core/nvm.h"
#include "core/random.h"
#include "core/signals.h"

namespace virtdrive {

class FaultyMemory final : public NonVolatileMemory {
 public:
  FaultyMemory(std::unique_ptr<NonVolatileMemory> memory, const EventLoop& loop, const Seed& seed);

  std::optional<std::vector<std::uint8_t>> read(std::string_view block) override;
  bool write(std::string_view block, std::span<const std::uint8_t> bytes) override;
  bool erase() override;

  /// Power is gone: of a write that began less than write_time ago only the beginning has got to
  /// the cells; behind it is what was there before, or 0xFF.
  void power_lost();

  /// Adds the faults and the write time.
  void register_signals(Registry& registry);

 private:
  struct Write {
    std::string block;
    std::vector<std::uint8_t> before;  // what a torn write leaves behind its beginning
    SimTime at;
  };

  std::unique_ptr<NonVolatileMemory> memory_;
  const EventLoop& loop_;
  Seed seed_;
  std::size_t worn_bits_ = 0;  // of each block; the same ones each time
  bool locked_ = false;        // takes no writes
  SimDuration write_time_{};
  std::vector<Write> writes_;  // that may be under way
};

}  // namespace virtdrive
