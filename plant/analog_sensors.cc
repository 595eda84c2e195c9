#include "plant/analog_sensors.h"

#include <algorithm>
#include <cmath>

namespace virtdrive {
namespace {

constexpr double kKelvin = 273.15;
constexpr double kReferenceK = 298.15;  // 25 degC

std::int32_t end_of(const Adc& adc, SensorFault::Stuck stuck) {
  return stuck == SensorFault::Stuck::kHigh ? adc.full_scale() : 0;
}

double noisy(double value, double deviation, RandomStream& noise) {
  return deviation > 0 ? value + deviation * noise.bell() : value;
}

}  // namespace

std::int32_t Adc::counts(double input_v) const {
  if (stuck_counts) return *stuck_counts;
  const double steps = input_v / reference_v * (full_scale() + 1.0);
  return static_cast<std::int32_t>(std::clamp(steps, 0.0, static_cast<double>(full_scale())));
}

std::int32_t CurrentSensor::counts(double current_a, RandomStream& noise) const {
  if (fault.stuck != SensorFault::Stuck::kNo) return end_of(adc, fault.stuck);
  const double sensed_a = fault.distorted(current_a);
  const double measured_a = noisy((sensed_a + offset_a) * (1 + gain_error), noise_a, noise);
  return adc.counts(adc.reference_v / 2 + measured_a * volts_per_amp);
}

std::int32_t VoltageSensor::counts(double voltage_v, RandomStream& noise) const {
  if (fault.stuck != SensorFault::Stuck::kNo) return end_of(adc, fault.stuck);
  const double sensed_v = fault.distorted(voltage_v);
  const double measured_v = noisy((sensed_v + offset_v) * (1 + gain_error), noise_v, noise);
  return adc.counts(measured_v * volts_per_volt);
}

double NtcSensor::resistance_ohm(double degc) const {
  return r25_ohm * std::exp(beta_k * (1 / (degc + kKelvin) - 1 / kReferenceK));
}

double NtcSensor::voltage_v(double degc) const {
  // The share of the supply that falls off the thermistor.
  double share = 0;
  switch (fault) {
    case Fault::kNone: {
      const double ntc_ohm = resistance_ohm(degc);
      share = ntc_ohm / (ntc_ohm + fixed_ohm);
      break;
    }
    case Fault::kOpen:
      share = 1;
      break;
    case Fault::kShorted:
      break;
  }
  return supply_v * (ntc_to_supply ? 1 - share : share);
}

double NtcSensor::temperature_degc(std::int32_t counts) const {
  const double input_v = (counts + 0.5) * adc.reference_v / (adc.full_scale() + 1.0);
  const double share =
      std::clamp(ntc_to_supply ? 1 - input_v / supply_v : input_v / supply_v, 1e-9, 1 - 1e-9);
  const double ntc_ohm = fixed_ohm * share / (1 - share);
  return 1 / (1 / kReferenceK + std::log(ntc_ohm / r25_ohm) / beta_k) - kKelvin;
}

PhaseBits upper_on(const PhaseValues& duty, double period_share) {
  PhaseBits bits = 0;
  for (unsigned phase = 0; phase < 3; ++phase) {
    if (std::abs(period_share - 0.5) * 2 < duty[phase]) bits |= static_cast<PhaseBits>(1U << phase);
  }
  return bits;
}

double link_current_a(const PhaseValues& current_a, PhaseBits upper) {
  double sum_a = 0;
  for (unsigned phase = 0; phase < 3; ++phase) {
    if ((upper >> phase & 1U) != 0) sum_a += current_a[phase];
  }
  return sum_a;
}

double leg_shunt_current_a(const PhaseValues& current_a, PhaseBits lower, int phase) {
  return (lower >> phase & 1) != 0 ? current_a[static_cast<std::size_t>(phase)] : 0;
}

}  // namespace virtdrive
