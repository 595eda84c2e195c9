#include "firmware_models/toshiba_mcu/protections.h"

#include <algorithm>
#include <cmath>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr double kDisconnectSpeed = 1000.0 / 32768;  // of full scale
constexpr int kDisconnectPeriods = 1000;
constexpr int kFirstStallCheckMs = 500;
constexpr double kStallEmfRatio = 0.7;
constexpr int kBadStallChecks = 2;
constexpr int kHotChecks = 5;
constexpr double kTemperatureHysteresis = 5;

}  // namespace

std::optional<Fault> Protections::pins(const Reading& reading) {
  if (reading.emergency_pin) return Fault::kEmergency;
  if (reading.over_voltage_pin) return Fault::kOverVoltage;
  return std::nullopt;
}

std::optional<Fault> Protections::bus(const Reading& reading, const ChannelSettings& settings,
                                      const Scaling& scaling) {
  const double volts = reading.bus_counts * scaling.bus_v_per_count;
  const std::int32_t over = settings.over_voltage.value;
  const std::int32_t under = settings.under_voltage.value;
  if (over > 0 && volts > over) return Fault::kSoftwareOverVoltage;
  if (under > 0 && volts < under) return Fault::kSoftwareUnderVoltage;
  return std::nullopt;
}

std::optional<Fault> Protections::currents(const Reading& reading, const LoopState& now,
                                           const Scaling& scaling, Stage stage) {
  const auto at_end = [](int counts) { return counts <= 0 || counts >= kAdcMaximum; };
  if (std::ranges::any_of(reading.current_counts, at_end)) return Fault::kEmergency;
  if (scaling.over_current_a > 0 && std::abs(now.iq_a) > scaling.over_current_a) {
    return Fault::kSoftwareOverCurrent;
  }
  const bool turning = stage == Stage::kForce &&
                       std::abs(now.command_hz) >= kDisconnectSpeed * scaling.full_scale_hz;
  const double current = std::hypot(now.id_a, now.iq_a);
  const bool missing = turning && current < (scaling.id_start_a + scaling.iq_start_a) / 5;
  disconnected_periods_ = missing ? disconnected_periods_ + 1 : 0;
  if (disconnected_periods_ > kDisconnectPeriods) return Fault::kNoMotor;
  return std::nullopt;
}

void Protections::begin_foc() {
  bad_stall_checks_ = 0;
  good_emf_per_hz_ = 0;
}

Protections::StallCheck Protections::stall(const LoopState& now, const Scaling& scaling,
                                           int ms_in_foc) {
  if (ms_in_foc < kFirstStallCheckMs || scaling.stall_voltage_v <= 0) return StallCheck::kNotDue;
  const double sign = now.omega_hz < 0 ? -1 : 1;
  const double vqi = sign * now.vq_integral_v;
  const double emf_per_hz =
      (vqi - scaling.resistance_ohm * sign * now.iq_ref_a) / std::max(std::abs(now.omega_hz), 1e-3);
  const bool good =
      vqi >= scaling.stall_voltage_v && emf_per_hz >= kStallEmfRatio * good_emf_per_hz_;
  if (good) good_emf_per_hz_ = emf_per_hz;
  return judge(good);
}

Protections::StallCheck Protections::stall_by_encoder(double hz, double least_hz,
                                                      const Scaling& scaling, int ms_in_foc) {
  if (ms_in_foc < kFirstStallCheckMs || scaling.stall_voltage_v <= 0) return StallCheck::kNotDue;
  return judge(hz >= least_hz);
}

Protections::StallCheck Protections::judge(bool good) {
  if (good) {
    bad_stall_checks_ = 0;
    return StallCheck::kGood;
  }
  return ++bad_stall_checks_ < kBadStallChecks ? StallCheck::kSuspicious : StallCheck::kStalled;
}

Protections::Heat Protections::temperature(double degc, const ChannelSettings& settings) {
  const double limit = settings.over_temperature.value;
  if (degc >= limit) return ++hot_checks_ > kHotChecks ? Heat::kTooHot : Heat::kBetween;
  hot_checks_ = 0;
  return degc < limit - kTemperatureHysteresis ? Heat::kReleased : Heat::kBetween;
}

}  // namespace virtdrive::toshiba_mcu
