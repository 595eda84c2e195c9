#include "firmware_models/asd7/reference.h"

#include <algorithm>

namespace virtdrive::asd7 {
namespace {

constexpr double kHundredth = 0.01;

std::size_t preset_of(const Terminals& terminals) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < terminals.preset.size(); ++i) {
    number |= terminals.preset[i] ? std::size_t{1} << i : 0;
  }
  return number;
}

double source_hz(std::uint16_t source, const Asked& asked, const Settings& s) {
  switch (static_cast<FrequencySource>(source)) {
    case FrequencySource::kPanel:
      return asked.panel_frequency * kHundredth;
    case FrequencySource::kVia:
      return via_hz(asked.terminals, s);
    case FrequencySource::kVib:
      return vib_hz(asked.terminals, s);
    case FrequencySource::kViaAndVib:
      return via_hz(asked.terminals, s) + vib_hz(asked.terminals, s);
    case FrequencySource::kSerial:
      return asked.frequency * kHundredth;
  }
  return 0;
}

}  // namespace

double analog_hz(std::uint16_t value, std::uint16_t point1, std::uint16_t frequency1,
                 std::uint16_t point2, std::uint16_t frequency2) {
  const double low = frequency1 * kHundredth, high = frequency2 * kHundredth;
  if (point2 <= point1) return value > point1 ? high : low;
  const double share = (double{1} * value - point1) / (point2 - point1);
  return low + (high - low) * std::clamp(share, 0.0, 1.0);
}

double via_hz(const Terminals& t, const Settings& s) {
  return analog_hz(t.via, s.via_point1, s.via_frequency1, s.via_point2, s.via_frequency2);
}

double vib_hz(const Terminals& t, const Settings& s) {
  return analog_hz(t.vib, s.vib_point1, s.vib_frequency1, s.vib_point2, s.vib_frequency2);
}

double limited_hz(double hz, const Settings& s) {
  const double most = std::min(s.upper_limit, s.maximum_frequency) * kHundredth;
  hz = std::clamp(hz, std::min(s.lower_limit * kHundredth, most), most);
  for (const SpeedJump& jump : s.jumps) {
    const double half = jump.width * kHundredth / 2, middle = jump.frequency * kHundredth;
    if (jump.width > 0 && hz > middle - half && hz < middle + half) {
      hz = std::max(0.0, middle - half);
    }
  }
  return hz;
}

Request request_of(const Asked& asked, const Settings& s) {
  const Terminals& t = asked.terminals;
  const std::uint16_t word = t.local ? 0 : asked.command;
  Request r;
  r.command_source = (word & kCommandPriority) != 0 ? CommandSource::kSerial
                     : t.local                      ? CommandSource::kTerminals
                                                    : static_cast<CommandSource>(s.command_source);
  std::size_t preset = 0;
  switch (r.command_source) {
    case CommandSource::kSerial:
      r.run = (word & kCommandRun) != 0;
      r.reverse = (word & kCommandReverse) != 0;
      r.jog = (word & kCommandJog) != 0;
      r.dc_brake = (word & kCommandDcBrake) != 0;
      r.coast = (word & kCommandCoast) != 0;
      r.second_ramp = (word & kCommandSecondRamp) != 0;
      r.second_motor = (word & kCommandSecondMotor) != 0;
      r.pi_off = (word & kCommandPiOff) != 0;
      preset = word & kCommandPreset;
      break;
    case CommandSource::kPanel:
      r.run = asked.panel_run;
      r.reverse = s.panel_reverse != 0;
      break;
    case CommandSource::kTerminals:
      r.run = t.forward || t.reverse;
      r.reverse = t.reverse;  // both: reverse, as terminals of this family have it
      preset = preset_of(t);
      break;
  }
  r.coast = r.coast || !t.standby;
  r.fastest_stop = (asked.command2 & (1U << 7)) != 0;
  if (((asked.command2 >> 8) & 3U) == 1) r.second_ramp = true;

  double hz = 0;
  if (r.jog) {
    r.frequency_source = kSourceJog;
    r.hz = std::min(s.jog_frequency, s.maximum_frequency) * kHundredth;
    return r;
  }
  if (preset != 0) {
    r.frequency_source = kSourcePreset;
    hz = s.preset_speeds[preset - 1] * kHundredth;
  } else if ((word & kCommandFrequencyPriority) != 0) {
    r.frequency_source = static_cast<std::uint16_t>(FrequencySource::kSerial);
    hz = asked.frequency * kHundredth;
  } else {
    r.frequency_source =
        t.local ? static_cast<std::uint16_t>(FrequencySource::kPanel) : s.frequency_source;
    hz = source_hz(r.frequency_source, asked, s);
    if (s.source_switch == 1 && hz < 1 && !t.local) {
      r.frequency_source = s.frequency_source2;
      hz = source_hz(r.frequency_source, asked, s);
    }
  }
  r.hz = limited_hz(hz, s);
  return r;
}

}  // namespace virtdrive::asd7
