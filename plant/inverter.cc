#include "plant/inverter.h"

#include <algorithm>

#include "core/check.h"

namespace virtdrive {

void validate(const InverterParameters& inverter) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("inverter: {} must be 0 or more, not {}", what, value));
  };
  const auto not_negative = [](double x) { return std::isfinite(x) && x >= 0; };
  require(not_negative(inverter.on_resistance_ohm), "on_resistance_ohm",
          inverter.on_resistance_ohm);
  require(not_negative(inverter.diode_v), "diode_v", inverter.diode_v);
  require(not_negative(inverter.loss_share), "loss_share", inverter.loss_share);
}

PhaseValues effective_duty(const BridgeCommand& command, const PhaseValues& current_a, double bus_v,
                           double inductance_h, double diode_v) {
  if (command.dead_time == SimDuration{0} || bus_v <= 0) return command.duty;
  const double dead_share = seconds(command.dead_time) / seconds(command.pwm_period);
  const double lost_share = dead_share * (1 + 2 * diode_v / bus_v);
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

}  // namespace virtdrive
