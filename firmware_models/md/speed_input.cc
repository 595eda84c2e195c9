#include "firmware_models/md/speed_input.h"

#include <algorithm>
#include <cmath>

namespace virtdrive::md {
namespace {

constexpr double kFull = 1023;
constexpr double kReferenceV = 5;
constexpr double kLeastPulseHz = 2'000, kFullPulseHz = 500'000;
constexpr double kRcCentreMs = 1.5, kRcSpanMs = 0.45;

double through(double magnitude, const CurvePoint& first, const CurvePoint& second) {
  double x0 = 0, y0 = 0;
  if (first.x > 0 && second.x > 0 && second.x <= first.x) return magnitude;
  for (const CurvePoint& point : {first, second, CurvePoint{1023, 1023}}) {
    if (point.x <= 0) continue;
    if (magnitude <= point.x) return y0 + (magnitude - x0) * (point.y - y0) / (point.x - x0);
    x0 = point.x;
    y0 = point.y;
  }
  return magnitude;
}

double signed_input(const Terminals& pins, const Settings& settings) {
  switch (static_cast<InputType>(settings.input_type)) {
    case InputType::kJoystick:
      return without_dead_zone(2.0 * analog_counts(pins) - kFull, settings.dead_zone);
    case InputType::kRcServo: {
      if (pins.rc_ms <= 0) return 0;
      const double raw = (pins.rc_ms - kRcCentreMs) / kRcSpanMs * kFull;
      return without_dead_zone(std::clamp(raw, -kFull, kFull), settings.dead_zone);
    }
    case InputType::kPulse:
      if (pins.pulse_hz < kLeastPulseHz) return 0;
      return std::min(kFull, pins.pulse_hz / kFullPulseHz * kFull);
    case InputType::kAnalog:
    case InputType::kStep:
      break;
  }
  return between_limits(analog_counts(pins), settings.low_speed_limit, settings.high_speed_limit);
}

}  // namespace

bool started(const Terminals& pins, const Settings& settings) {
  return pins.start != (settings.start_inv_sign != 0);
}

bool running(const Terminals& pins, const Settings& settings) {
  return pins.run != (settings.run_inv_sign != 0);
}

std::uint8_t input_byte(const Terminals& pins) {
  constexpr int kEncoderInputsOpen = 0x60;
  return static_cast<std::uint8_t>(int{pins.int_speed} | pins.alarm_reset << 1 | pins.cw << 2 |
                                   pins.run << 3 | pins.start << 4 | kEncoderInputsOpen);
}

std::int32_t analog_counts(const Terminals& pins) {
  const double share = pins.pwm_duty > 0 ? pins.pwm_duty : pins.speed_v / kReferenceV;
  return static_cast<std::int32_t>(std::lround(std::clamp(share, 0.0, 1.0) * kFull));
}

double between_limits(double raw, std::int32_t low, std::int32_t high) {
  const double top = high > low ? high : kFull;
  if (raw < low) return 0;
  return raw >= top ? kFull : (raw - low) / (top - low) * kFull;
}

// The dead zone is counted on the converter's scale, whose half is the whole travel (assumed): 100
// is 2.5 V +- 0.49 V, the 2..3 V that the document prints.
double without_dead_zone(double raw, std::int32_t dead_zone) {
  const double zone = std::min(2.0 * dead_zone, kFull);
  const double beyond = std::fabs(raw) - zone;
  return beyond <= 0 ? 0 : std::copysign(beyond / (kFull - zone) * kFull, raw);
}

double curve(double raw, const Settings& settings) {
  const std::size_t first = raw < 0 ? 2 : 0;
  const double y = through(std::fabs(raw), settings.curve[first], settings.curve[first + 1]);
  return std::copysign(y, raw);
}

double speed_input(const Terminals& pins, const Settings& settings) {
  return curve(signed_input(pins, settings), settings);
}

double volume_input(const Terminals& pins, const Settings& settings) {
  return between_limits(std::clamp(pins.volume, 0.0, 1.0) * kFull, settings.low_volume_limit,
                        settings.high_volume_limit);
}

std::size_t step_number(const Terminals& pins) {
  return static_cast<std::size_t>(pins.int_speed) + 2 * static_cast<std::size_t>(pins.run) +
         4 * static_cast<std::size_t>(pins.start);
}

double position_input(double raw, const Settings& settings) {
  const double end = raw < 0 ? settings.posi_min : settings.posi_max;
  return settings.posi_cen + (end - settings.posi_cen) * std::fabs(raw) / kFull;
}

}  // namespace virtdrive::md
