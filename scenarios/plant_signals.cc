#include "scenarios/plant_signals.h"

#include <array>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

namespace virtdrive {
namespace {

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHighestMains = 1.5;     // of its rated voltage
constexpr double kHighestSupplyV = 1000;  // assumed: above any drive's over-voltage trip

// One axis, its names and the present.
class AxisNames {
 public:
  AxisNames(Registry& registry, const EventLoop& loop, std::size_t channel, Axis& axis)
      : registry_(registry), loop_(loop), channel_(channel), axis_(axis) {}

  void add_motor();
  void add_load();
  void add_faults();

 private:
  std::string name(std::string_view component, std::string_view quantity) const {
    return fmt::format("{}{}.{}", component, channel_, quantity);
  }
  auto present() const {
    return [&loop = loop_, &axis = axis_]() -> Axis& {
      axis.advance_to(loop.now());
      return axis;
    };
  }
  template <class Read>
  void signal(std::string_view component, std::string_view quantity, std::string unit,
              std::string doc, Read read) {
    registry_.add(Signal{name(component, quantity), std::move(unit), std::move(doc),
                         [present = present(), read] { return read(present()); }});
  }
  // `member` picks what is written out of a whole that is taken, changed and put back.
  template <class Take, class Put, class Member>
  void part(std::string full_name, std::string unit, std::string doc, double minimum,
            double maximum, bool fault, Take take, Put put, Member member) {
    registry_.add(Input{.signal = {std::move(full_name), std::move(unit), std::move(doc),
                                   [&axis = axis_, take, member] {
                                     auto whole = take(axis);
                                     return static_cast<double>(member(whole));
                                   }},
                        .minimum = minimum,
                        .maximum = maximum,
                        .write =
                            [present = present(), take, put, member](double value) {
                              Axis& axis = present();
                              auto whole = take(axis);
                              auto& target = member(whole);
                              target =
                                  static_cast<std::remove_reference_t<decltype(target)>>(value);
                              put(axis, whole);
                            },
                        .fault = fault});
  }
  template <class Member>
  void load(std::string_view quantity, std::string unit, std::string doc, double minimum,
            double maximum, Member Load::* member, bool fault = false) {
    part(
        name("load", quantity), std::move(unit), std::move(doc), minimum, maximum, fault,
        [](const Axis& axis) { return axis.load(); },
        [](Axis& axis, const Load& load) { axis.set_load(load); },
        [member](Load& load) -> auto& { return load.*member; });
  }
  template <class Member>
  void broken(std::string full_name, std::string doc, double worst, Member member) {
    part(
        std::move(full_name), "", std::move(doc), 0, worst, true,
        [](const Axis& axis) { return axis.bridge_faults(); },
        [](Axis& axis, const BridgeFaults& faults) { axis.set_bridge_faults(faults); }, member);
  }

  Registry& registry_;
  const EventLoop& loop_;
  std::size_t channel_;
  Axis& axis_;
};

void AxisNames::add_motor() {
  signal("motor", "speed", "rpm", "Rotor speed",
         [](const Axis& a) { return a.state().speed_radps * kRpmPerRadps; });
  signal("motor", "angle", "deg", "Rotor angle, mechanical, counted on over the turns",
         [](const Axis& a) { return a.state().angle_rad * kDegPerRad; });
  signal("motor", "torque", "Nm", "Air-gap torque", [](const Axis& a) { return a.torque_nm(); });
  signal("motor", "current_d", "A", "d current, in the rotor's frame",
         [](const Axis& a) { return a.state().i_d_a; });
  signal("motor", "current_q", "A", "q current, in the rotor's frame",
         [](const Axis& a) { return a.state().i_q_a; });
  for (std::size_t phase = 0; phase < 3; ++phase) {
    const char letter = static_cast<char>('a' + phase);
    signal("motor", fmt::format("current_{}", letter), "A",
           fmt::format("Current into phase {}", letter),
           [phase](const Axis& a) { return a.phase_currents_a()[phase]; });
  }
  signal("bus", "voltage", "V", "DC link voltage", [](const Axis& a) { return a.state().bus_v; });
  signal("bus", "current", "A", "Current out of the supply",
         [](const Axis& a) { return a.source_current_a(); });
}

void AxisNames::add_load() {
  signal("load", "torque", "Nm", "Torque that the load asks of the shaft",
         [](const Axis& a) { return a.load_torque_nm(); });
  load("brake_torque", "Nm", "Torque against the motion", 0, kInfinity, &Load::brake_torque_nm);
  load("constant_torque", "Nm", "Torque against positive rotation", -kInfinity, kInfinity,
       &Load::external_torque_nm);
  load("quadratic", "Nm/(rad/s)^2", "Fan or pump", 0, kInfinity, &Load::quadratic_nm_per_radps2);
  load("viscous", "Nm/(rad/s)", "Viscous load", 0, kInfinity, &Load::viscous_nm_per_radps);
  load("inertia", "kgm2", "Inertia coupled to the shaft", 0, kInfinity, &Load::inertia_kgm2);
  load("locked", "", "The shaft is held fast", 0, 1, &Load::locked, true);
}

void AxisNames::add_faults() {
  // What shorts the link needs a resistance that limits the current.
  const bool resists = axis_.parameters().inverter.on_resistance_ohm > 0;
  if (resists) {
    broken(name("motor", "phases_shorted"),
           "Two phases touch at the terminals: 1 a and b, 2 b and c, 3 c and a", 3,
           [](BridgeFaults& faults) -> auto& { return faults.shorted_phases; });
  }
  const double worst = resists ? 2 : 1;
  const std::string_view how = resists ? "1 never conducts, 2 always does" : "1 never conducts";
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const char letter = static_cast<char>('a' + leg);
    broken(name("motor", fmt::format("phase_{}_open", letter)),
           fmt::format("The wire of phase {} is broken", letter), 1,
           [leg](BridgeFaults& faults) -> auto& { return faults.phase_open[leg]; });
    broken(name("bridge", fmt::format("upper_{}_stuck", letter)),
           fmt::format("Upper switch of leg {}: {}", letter, how), worst,
           [leg](BridgeFaults& faults) -> auto& { return faults.upper[leg]; });
    broken(name("bridge", fmt::format("lower_{}_stuck", letter)),
           fmt::format("Lower switch of leg {}: {}", letter, how), worst,
           [leg](BridgeFaults& faults) -> auto& { return faults.lower[leg]; });
  }
}

}  // namespace

void register_axis(Registry& registry, const EventLoop& loop, std::size_t channel, Axis& axis) {
  AxisNames names(registry, loop, channel, axis);
  names.add_motor();
  names.add_load();
  names.add_faults();
}

namespace {

// A link on the mains: a dip, a lost phase. Its voltage is that between two lines, rms.
template <class Present>
void register_mains(Registry& registry, const std::string& name, const DcBus& bus,
                    Present present) {
  const double rated_v = bus.parameters().mains.voltage_v;
  const auto change = [present](auto&& make) {
    DcBus now = present();
    MainsInput mains = now.mains();
    make(mains);
    now.set_mains(mains);
  };
  registry.add(Input{.signal = {name + ".voltage", "V", "Mains, rms between two lines",
                                [bus, rated_v] { return bus.mains().level[0] * rated_v; }},
                     .minimum = 0,
                     .maximum = kHighestMains * rated_v,
                     .write = [change, rated_v](double volts) {
                       change([&](MainsInput& mains) { mains.level.fill(volts / rated_v); });
                     }});
  const auto fault = [&](std::string_view what, std::string doc, auto missing, auto put) {
    registry.add(Input{
        .signal = {fmt::format("{}.{}", name, what), "", std::move(doc),
                   [bus, missing] { return missing(bus.mains()) ? 1.0 : 0.0; }},
        .minimum = 0,
        .maximum = 1,
        .write = [change, put](
                     double there) { change([&](MainsInput& mains) { put(mains, there == 0); }); },
        .fault = true});
  };
  fault(
      "off", "The mains are switched off",
      [](const MainsInput& mains) { return mains.connected == std::array{false, false, false}; },
      [](MainsInput& mains, bool on) { mains.connected.fill(on); });
  const int phases = bus.parameters().mains.phases;
  for (std::size_t phase = 0; phase < static_cast<std::size_t>(phases); ++phase) {
    const char letter = "rst"[phase];
    fault(
        fmt::format("phase_{}_lost", letter),
        fmt::format("Phase {} of the mains is not there", letter),
        [phase](const MainsInput& mains) { return !mains.connected[phase]; },
        [phase](MainsInput& mains, bool on) { mains.connected[phase] = on; });
  }
}

}  // namespace

void register_supply(Registry& registry, const EventLoop& loop, const std::string& name,
                     const DcBus& bus) {
  const auto present = [&loop, bus] {
    DcBus now = bus;
    now.advance_to(loop.now());
    return now;
  };
  if (bus.parameters().mains.phases > 0) return register_mains(registry, name, bus, present);
  registry.add(Input{.signal = {name + ".voltage", "V", "Open-circuit voltage of the supply",
                                [bus] { return bus.parameters().source_v; }},
                     .minimum = 0,
                     .maximum = kHighestSupplyV,
                     .write = [present](double volts) { present().set_source_voltage(volts); }});
  registry.add(Input{.signal = {name + ".off", "", "The supply is switched off",
                                [bus] { return bus.supply_on() ? 0.0 : 1.0; }},
                     .minimum = 0,
                     .maximum = 1,
                     .write = [present](double off) { present().set_supply(off == 0); },
                     .fault = true});
}

}  // namespace virtdrive
