#include "plant/inverter.h"

#include <algorithm>

#include "core/check.h"

namespace virtdrive {

PhaseValues effective_duty(const BridgeCommand& command, const PhaseValues& current_a, double bus_v,
                           double inductance_h) {
  if (command.dead_time == SimDuration{0} || bus_v <= 0) return command.duty;
  const double lost_share = seconds(command.dead_time) / seconds(command.pwm_period);
  const double band_a = bus_v * seconds(command.dead_time) / inductance_h;
  PhaseValues effective{};
  for (std::size_t x = 0; x < 3; ++x) {
    const double duty = command.duty[x];
    const bool switches = duty > 0 && duty < 1;
    const double sign = std::clamp(current_a[x] / band_a, -1.0, 1.0);
    effective[x] = switches ? std::clamp(duty - lost_share * sign, 0.0, 1.0) : duty;
  }
  return effective;
}

void BodyDiodes::take_over(const PhaseValues& current_a) {
  for (std::size_t x = 0; x < 3; ++x) {
    diodes_[x] = current_a[x] > kZeroCurrentA    ? Diode::kLower
                 : current_a[x] < -kZeroCurrentA ? Diode::kUpper
                                                 : Diode::kBlocked;
  }
  if (conducting() < 2) diodes_ = {};
}

void BodyDiodes::block(int phase) {
  diodes_[static_cast<std::size_t>(phase)] = Diode::kBlocked;
  if (conducting() < 2) diodes_ = {};
}

int BodyDiodes::conducting() const {
  return static_cast<int>(3 - std::ranges::count(diodes_, Diode::kBlocked));
}

int BodyDiodes::floating() const {
  if (conducting() != 2) return -1;
  return static_cast<int>(std::ranges::find(diodes_, Diode::kBlocked) - diodes_.begin());
}

PhaseValues BodyDiodes::upper() const {
  PhaseValues share{};
  for (std::size_t x = 0; x < 3; ++x) share[x] = diodes_[x] == Diode::kUpper ? 1 : 0;
  return share;
}

}  // namespace virtdrive
