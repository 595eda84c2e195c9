#include "scenarios/sensor_signals.h"

#include <algorithm>
#include <fmt/format.h>
#include <numbers>
#include <type_traits>
#include <utility>

namespace virtdrive {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

struct Range {
  double minimum, maximum;
};

/// A fault that is a number in the sensor, `scale` times what is shown.
template <class T>
void add(Registry& registry, std::string name, std::string unit, std::string doc, Range range,
         T& target, const SensorChanged& changed, double scale = 1) {
  registry.add(Input{.signal = {std::move(name), std::move(unit), std::move(doc),
                                [&target, scale] { return static_cast<double>(target) / scale; }},
                     .minimum = range.minimum,
                     .maximum = range.maximum,
                     .write =
                         [&target, scale, changed](double value) {
                           target = static_cast<T>(value * scale);
                           changed();
                         },
                     .fault = true});
}

}  // namespace

void name_sensor(Registry& registry, const std::string& name, HallSensors& sensors,
                 SensorChanged changed) {
  using Output = HallSensors::Output;
  for (std::size_t i = 0; i < 3; ++i) {
    const char letter = static_cast<char>('a' + i);
    add(registry, fmt::format("{}.{}_stuck", name, letter), "",
        fmt::format("Hall sensor {}: 1 stays low, 2 stays high", letter), {0, 2}, sensors.output[i],
        changed);
    add(registry, fmt::format("{}.{}_misplaced", name, letter), "deg",
        fmt::format("Hall sensor {} switches so much late (electrical)", letter), {-60, 60},
        sensors.placement_error_rad[i], changed, kRadPerDeg);
  }
  for (const auto& [code, output] : {std::pair{0, Output::kStuckLow}, {7, Output::kStuckHigh}}) {
    registry.add(Input{.signal = {fmt::format("{}.code_{}", name, code), "",
                                  fmt::format("The Hall cable is broken: code {}", code),
                                  [&sensors, stuck = output] {
                                    return std::ranges::count(sensors.output, stuck) == 3 ? 1.0
                                                                                          : 0.0;
                                  }},
                       .minimum = 0,
                       .maximum = 1,
                       .write =
                           [&sensors, stuck = output, changed](double there) {
                             const bool broken = std::ranges::count(sensors.output, stuck) == 3;
                             if (there > 0)
                               sensors.output.fill(stuck);
                             else if (broken)
                               sensors.output.fill(Output::kWorking);
                             changed();
                           },
                       .fault = true});
  }
}

void name_sensor(Registry& registry, const std::string& name, Encoder& encoder,
                 SensorChanged changed) {
  add(registry, name + ".slip", "deg", "The disc has slipped so far behind the shaft", {-360, 360},
      encoder.slip_rad, changed, kRadPerDeg);
  add(registry, name + ".missed", "counts", "Edges that the counter has missed", {-1e6, 1e6},
      encoder.missed_counts, changed);
  add(registry, name + ".index_dead", "", "The index never comes", {0, 1}, encoder.index_dead,
      changed);
  add(registry, name + ".cable_broken", "", "The encoder's cable is broken: no edges come", {0, 1},
      encoder.cable_broken, changed);
}

void name_sensor(Registry& registry, const std::string& name, AbsoluteEncoder& encoder,
                 SensorChanged changed) {
  add(registry, name + ".crc", "", "Each frame's check fails", {0, 1}, encoder.crc_fault, changed);
  add(registry, name + ".battery", "", "The battery: 1 low, 2 lost, with the turns", {0, 2},
      encoder.battery, changed);
}

void name_sensor(Registry& registry, const std::string& name, const std::string& what,
                 const std::string& unit, double most, SensorFault& fault, SensorChanged changed) {
  add(registry, name + "offset", unit, what + " reads so much too high", {-most, most},
      fault.offset, changed);
  add(registry, name + "gain", "", what + ": 0.1 reads 10 % too much, -1 nothing", {-2, 10},
      fault.gain, changed);
  add(registry, name + "stuck", "", what + ": 1 reads the lowest count, 2 the highest", {0, 2},
      fault.stuck, changed);
}

}  // namespace virtdrive
