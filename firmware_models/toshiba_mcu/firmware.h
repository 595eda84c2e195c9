// The whole program of the MCU: three motor channels and the system around them.
//
// It lives from a reset to the next one or to the loss of power. It may be made and destroyed at
// any time over axes that live on: while there is none, and in its reset, the gates are off and the
// motors do what physics makes them do.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "firmware_models/toshiba_mcu/oscilloscope.h"
#include "firmware_models/toshiba_mcu/power_board.h"
#include "plant/axis.h"

namespace virtdrive::toshiba_mcu {

class Firmware {
 public:
  /// One axis a channel; they must outlive the firmware.
  Firmware(EventLoop& loop, std::span<Axis* const> axes, const Seed& seed,
           const BoardHardware& hardware = kLowVoltageBoard);

  std::size_t channels() const { return boards_.size(); }
  PowerBoard& board(std::size_t channel) { return *boards_[channel]; }
  const PowerBoard& board(std::size_t channel) const { return *boards_[channel]; }

  /// One of each for the whole device.
  SnapshotScope& snapshot_scope() { return snapshot_scope_; }
  StreamScope& stream_scope() { return stream_scope_; }

  /// FreeRTOS tick, 1 kHz since the reset; wraps at 32 bits.
  std::uint32_t tick() const;
  /// 1 at the first call after a reset, then 0 (5.1.63).
  int take_reset_status();
  /// Share of the CPU's time, from the PWM interrupts that come now (5.1.64).
  int system_load_percent() const;

  /// A number that this image keeps: no demo application acts on it.
  std::uint8_t demo_state() const { return demo_state_; }
  void set_demo_state(std::uint8_t state) { demo_state_ = state; }

 private:
  void after_interrupt(std::size_t channel);

  EventLoop& loop_;
  SimTime reset_at_;
  bool just_reset_ = true;
  std::uint8_t demo_state_ = 0;
  SnapshotScope snapshot_scope_;
  StreamScope stream_scope_;
  std::vector<std::unique_ptr<PowerBoard>> boards_;
};

}  // namespace virtdrive::toshiba_mcu
