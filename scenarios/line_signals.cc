#include "scenarios/line_signals.h"

#include <chrono>
#include <fmt/format.h>
#include <utility>

namespace virtdrive {
namespace {

// How much later a delayed byte begins, until somebody says otherwise.
constexpr SimDuration kDelay = std::chrono::milliseconds(1);

void register_line_faults(Registry& registry, const std::string& prefix, SerialLine& line,
                          LineDirection direction) {
  const auto change = [&line, direction](auto&& make) {
    LineFaults faults = line.faults(direction);
    make(faults);
    line.set_faults(direction, faults);
  };
  const auto add = [&]<class Member>(std::string_view name, std::string doc, double maximum,
                                     std::string unit, Member LineFaults::* member) {
    registry.add(Input{
        .signal = {fmt::format("{}_{}", prefix, name), std::move(unit), std::move(doc),
                   [&line, direction, member] {
                     return static_cast<double>(line.faults(direction).*member);
                   }},
        .minimum = 0,
        .maximum = maximum,
        .write =
            [change, member](double value) {
              change([&](LineFaults& faults) { faults.*member = static_cast<Member>(value); });
            },
        .fault = true});
  };
  add("lost", "Probability that a byte is lost", 1, "", &LineFaults::lost);
  add("flipped", "Probability that a bit of a byte is flipped", 1, "", &LineFaults::flipped);
  add("duplicated", "Probability that a byte is heard twice", 1, "", &LineFaults::duplicated);
  add("delayed", "Probability that a byte begins later, and all behind it", 1, "",
      &LineFaults::delayed);
  add("noise", "Characters of noise while nobody talks", 1e5, "1/s", &LineFaults::noise_per_s);
  add("stuck", "The wires are held: 1 low, 2 high", 2, "", &LineFaults::stuck);
  add("cut", "Nothing that is said gets anywhere", 1, "", &LineFaults::cut);
  change([](LineFaults& faults) { faults.delay = kDelay; });
  registry.add(
      Input{.signal = {prefix + "_delay", "s", "How much later a delayed byte begins",
                       [&line, direction] { return seconds(line.faults(direction).delay); }},
            .minimum = 0,
            .maximum = 10,
            .write = [change](double value) {
              change([&](LineFaults& faults) { faults.delay = from_seconds(value); });
            }});
}

}  // namespace

void register_line(Registry& registry, const std::string& name, SerialLine& line) {
  const auto count = [&](std::string_view quantity, std::uint64_t LineCounters::* member,
                         std::string doc) {
    registry.add(Signal{fmt::format("{}.{}", name, quantity), "", std::move(doc),
                        [&line, member] { return double(line.counters().*member); }});
  };
  count("bytes_to_drives", &LineCounters::to_device, "Bytes that drives have heard");
  count("bytes_to_host", &LineCounters::to_host, "Bytes that the host has heard");
  count("garbled", &LineCounters::garbled, "Bytes said at settings that a listener has not");
  count("collisions", &LineCounters::collisions, "Times that one began to talk over another");
  register_line_faults(registry, name + ".to_drives", line, LineDirection::kToDevices);
  register_line_faults(registry, name + ".to_host", line, LineDirection::kToHost);
}

void register_can(Registry& registry, const std::string& name, CanBus& bus) {
  const auto count = [&](std::string_view quantity, std::uint64_t CanCounters::* member,
                         std::string doc) {
    registry.add(Signal{fmt::format("{}.{}", name, quantity), "", std::move(doc),
                        [&bus, member] { return double(bus.counters().*member); }});
  };
  count("frames", &CanCounters::frames, "CAN frames that somebody took");
  count("errors", &CanCounters::errors, "CAN error frames");
  registry.add(
      Input{.signal = {name + ".bus_cut", "", "The CAN wires are cut: nobody hears anybody",
                       [&bus] { return double(bus.cut()); }},
            .minimum = 0,
            .maximum = 1,
            .write = [&bus](double cut) { bus.set_cut(cut > 0); },
            .fault = true});
}

}  // namespace virtdrive
