#include "plant/sensors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

double noisy(double value, double deviation, RandomStream& noise) {
  return deviation > 0 ? value + deviation * noise.bell() : value;
}

}  // namespace

std::int32_t Adc::counts(double input_v) const {
  const double steps = input_v / reference_v * (full_scale() + 1.0);
  return static_cast<std::int32_t>(std::clamp(steps, 0.0, static_cast<double>(full_scale())));
}

std::int32_t CurrentSensor::counts(double current_a, RandomStream& noise) const {
  const double measured_a = noisy((current_a + offset_a) * (1 + gain_error), noise_a, noise);
  return adc.counts(adc.reference_v / 2 + measured_a * volts_per_amp);
}

std::int32_t VoltageSensor::counts(double voltage_v, RandomStream& noise) const {
  return adc.counts(noisy(voltage_v, noise_v, noise) * volts_per_volt);
}

std::uint8_t hall_bits(double electrical_angle_rad, double offset_rad) {
  // The sector of 60 degrees decides; its bits C, B, A from 0 degrees on.
  constexpr std::uint8_t kBits[6] = {0b101, 0b001, 0b011, 0b010, 0b110, 0b100};
  const double turns = (electrical_angle_rad - offset_rad) / kTurn;
  const auto sector = static_cast<int>((turns - std::floor(turns)) * 6);
  return kBits[std::min(sector, 5)];
}

std::int64_t Encoder::count(double angle_rad) const {
  return static_cast<std::int64_t>(std::floor(angle_rad / kTurn * 4 * lines));
}

std::int64_t Encoder::index_count(double angle_rad) const {
  return static_cast<std::int64_t>(std::floor(angle_rad / kTurn));
}

}  // namespace virtdrive
