#include "plant/pump.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace virtdrive {

Pump::Pump(const PumpParameters& parameters) : p_(parameters) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("pump: {}, not {}", what, value));
  };
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  require(positive(p_.rated_radps), "rated_radps must be above 0", p_.rated_radps);
  require(positive(p_.rated_m3h), "rated_m3h must be above 0", p_.rated_m3h);
  require(positive(p_.rated_bar), "rated_bar must be above 0", p_.rated_bar);
  require(std::isfinite(p_.static_bar) && p_.static_bar >= 0, "static_bar must be 0 or more",
          p_.static_bar);
  require(std::isfinite(p_.shutoff_bar) && p_.shutoff_bar > p_.rated_bar + p_.static_bar,
          "shutoff_bar must be above rated_bar and static_bar together", p_.shutoff_bar);
  require(positive(p_.vessel_m3_per_bar), "vessel_m3_per_bar must be above 0",
          p_.vessel_m3_per_bar);
  slope_bar_ = (p_.shutoff_bar - p_.static_bar - p_.rated_bar) / (p_.rated_m3h * p_.rated_m3h);
  opening_ = p_.rated_m3h / std::sqrt(p_.rated_bar);
}

void Pump::set_demand(double demand) {
  VIRTDRIVE_CHECK(demand >= 0 && demand <= 2, "pump demand {}", demand);
  demand_ = demand;
}

double Pump::flow_m3h(double pressure_bar, double speed) const {
  const double head = p_.shutoff_bar * speed * std::max(0.0, speed);
  return std::sqrt(std::max(0.0, head - p_.static_bar - pressure_bar) / slope_bar_);
}

double Pump::demand_m3h(double pressure_bar) const {
  return demand_ * opening_ * std::sqrt(std::max(0.0, pressure_bar));
}

void Pump::advance_to(SimTime t, double speed_radps) {
  VIRTDRIVE_CHECK(t >= now_, "pump at {} ns asked to go back", now_.time_since_epoch().count());
  const double speed = speed_radps / p_.rated_radps;
  constexpr double kHour = 3600;
  constexpr double kStepS = 1e-3;
  const auto rate = [&](double bar) {
    return (flow_m3h(bar, speed) - demand_m3h(bar)) / kHour / p_.vessel_m3_per_bar;
  };
  const double duration_s = seconds(t - now_);
  const int steps = std::max(1, static_cast<int>(std::ceil(duration_s / kStepS)));
  const double h = duration_s / steps;
  for (int i = 0; i < steps; ++i) {
    // Heun; neither flow can turn the pressure below 0.
    const double first = rate(pressure_bar_);
    const double second = rate(std::max(0.0, pressure_bar_ + h * first));
    pressure_bar_ = std::max(0.0, pressure_bar_ + h / 2 * (first + second));
  }
  flow_m3h_ = flow_m3h(pressure_bar_, speed);
  now_ = t;
}

}  // namespace virtdrive
