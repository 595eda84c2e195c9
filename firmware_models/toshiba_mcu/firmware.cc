#include "firmware_models/toshiba_mcu/firmware.h"

#include <fmt/format.h>
#include <utility>

namespace virtdrive::toshiba_mcu {

Firmware::Firmware(EventLoop& loop, std::span<Axis* const> axes, const Seed& seed)
    : loop_(loop), reset_at_(loop.now()) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    boards_.push_back(
        std::make_unique<PowerBoard>(loop, *axes[i], seed, fmt::format("board{}", i)));
  }
}

std::uint32_t Firmware::tick() const {
  using namespace std::chrono_literals;
  return static_cast<std::uint32_t>((loop_.now() - reset_at_) / 1ms);
}

int Firmware::take_reset_status() {
  return std::exchange(just_reset_, false) ? 1 : 0;
}

}  // namespace virtdrive::toshiba_mcu
