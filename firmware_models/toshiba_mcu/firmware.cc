#include "firmware_models/toshiba_mcu/firmware.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace virtdrive::toshiba_mcu {
namespace {

// Assumed: the simulation has no CPU. Tasks and communication, and what a PWM interrupt takes of an
// 80 MHz Cortex-M3 whose vector engine does the transforms.
constexpr double kTaskLoad = 0.05;
constexpr double kInterruptS = 8e-6;

}  // namespace

Firmware::Firmware(EventLoop& loop, std::span<Axis* const> axes, const Seed& seed,
                   const BoardHardware& hardware)
    : loop_(loop), reset_at_(loop.now()) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    boards_.push_back(std::make_unique<PowerBoard>(loop, *axes[i], seed, fmt::format("board{}", i),
                                                   hardware, [this, i] { after_interrupt(i); }));
  }
}

void Firmware::after_interrupt(std::size_t channel) {
  const MotorChannel& of = boards_[channel]->channel();
  snapshot_scope_.sample(channel, of);
  stream_scope_.sample(channel, of);
}

std::uint32_t Firmware::tick() const {
  using namespace std::chrono_literals;
  return static_cast<std::uint32_t>((loop_.now() - reset_at_) / 1ms);
}

int Firmware::take_reset_status() {
  return std::exchange(just_reset_, false) ? 1 : 0;
}

int Firmware::system_load_percent() const {
  double load = kTaskLoad;
  for (const auto& board : boards_) {
    const MotorChannel& channel = board->channel();
    if (channel.pwm_active()) load += kInterruptS * channel.settings().pwm_frequency.value;
  }
  return static_cast<int>(std::lround(100 * std::min(load, 1.0)));
}

}  // namespace virtdrive::toshiba_mcu
