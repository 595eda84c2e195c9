// The whole program of the MCU: three motor channels and the system around them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/toshiba_mcu/power_board.h"
#include "plant/axis.h"

namespace virtdrive::toshiba_mcu {

class Firmware {
 public:
  /// One axis a channel; they must outlive the firmware.
  Firmware(EventLoop& loop, std::span<Axis* const> axes, const Seed& seed);

  std::size_t channels() const { return boards_.size(); }
  PowerBoard& board(std::size_t channel) { return *boards_[channel]; }
  const PowerBoard& board(std::size_t channel) const { return *boards_[channel]; }

  /// FreeRTOS tick, 1 kHz since the reset; wraps at 32 bits.
  std::uint32_t tick() const;
  /// 1 at the first call after a reset, then 0 (5.1.63).
  int take_reset_status();

 private:
  EventLoop& loop_;
  SimTime reset_at_;
  bool just_reset_ = true;
  std::vector<std::unique_ptr<PowerBoard>> boards_;
};

}  // namespace virtdrive::toshiba_mcu
