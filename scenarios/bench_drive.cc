#include "scenarios/bench_drive.h"

#include <fmt/format.h>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "core/check.h"
#include "scenarios/nvm_file.h"

namespace virtdrive {
namespace {

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<Motor> motors_of(const DriveSpec& spec, const DriveKind& kind) {
  const std::size_t given = spec.motors.size();
  if (given > 1 && given != kind.channels) {
    throw SetupError(fmt::format("{} motors for {}: it has {} channels; name one, or one each",
                                 given, kind.name, kind.channels));
  }
  std::vector<Motor> motors;
  for (std::size_t i = 0; i < kind.channels; ++i) {
    motors.push_back(find_motor(given == 0   ? kind.default_motor
                                : given == 1 ? std::string_view(spec.motors.front())
                                             : spec.motors[i]));
  }
  return motors;
}

std::unique_ptr<NonVolatileMemory> open_memory(const std::string& path, std::string_view drive,
                                               const NoteListener& notes) {
  if (path.empty()) return std::make_unique<MemoryInProcess>();
  return std::make_unique<NvmFile>(path, drive, notes);
}

// What can break between a drive's bridge and its motor, each thing under its name. `advance`
// brings the axis to the present.
void register_bridge_faults(Registry& registry, std::size_t channel, Axis& axis,
                            std::function<void()> advance) {
  const auto add = [&](const std::string& name, std::string doc, double maximum, auto member) {
    registry.add(Input{.signal = {name, "", std::move(doc),
                                  [&axis, member] {
                                    BridgeFaults faults = axis.bridge_faults();
                                    return static_cast<double>(member(faults));
                                  }},
                       .minimum = 0,
                       .maximum = maximum,
                       .write =
                           [&axis, advance, member](double value) {
                             advance();
                             BridgeFaults faults = axis.bridge_faults();
                             auto& broken = member(faults);
                             broken = static_cast<std::remove_reference_t<decltype(broken)>>(value);
                             axis.set_bridge_faults(faults);
                           },
                       .fault = true});
  };
  for (std::size_t phase = 0; phase < 3; ++phase) {
    const char letter = static_cast<char>('a' + phase);
    add(fmt::format("motor{}.phase_{}_open", channel, letter),
        fmt::format("The wire of phase {} is broken", letter), 1,
        [phase](BridgeFaults& faults) -> auto& { return faults.phase_open[phase]; });
  }
  // What shorts the link needs a resistance that limits the current.
  const bool resists = axis.parameters().inverter.on_resistance_ohm > 0;
  if (resists) {
    add(fmt::format("motor{}.phases_shorted", channel),
        "Two phases touch at the terminals: 1 a and b, 2 b and c, 3 c and a", 3,
        [](BridgeFaults& faults) -> auto& { return faults.shorted_phases; });
  }
  const double worst = resists ? 2 : 1;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const char letter = static_cast<char>('a' + leg);
    add(fmt::format("bridge{}.upper_{}_stuck", channel, letter),
        fmt::format("Upper switch of leg {}: 1 never conducts, 2 always does", letter), worst,
        [leg](BridgeFaults& faults) -> auto& { return faults.upper[leg]; });
    add(fmt::format("bridge{}.lower_{}_stuck", channel, letter),
        fmt::format("Lower switch of leg {}: 1 never conducts, 2 always does", letter), worst,
        [leg](BridgeFaults& faults) -> auto& { return faults.lower[leg]; });
  }
  registry.add(
      Input{.signal = {fmt::format("supply{}.off", channel), "", "The supply is switched off",
                       [&axis] { return axis.bus().supply_on() ? 0.0 : 1.0; }},
            .minimum = 0,
            .maximum = 1,
            .write =
                [&axis, advance](double off) {
                  advance();
                  axis.bus().set_supply(off == 0);
                },
            .fault = true});
  registry.add(Input{.signal = {fmt::format("load{}.locked", channel), "", "The shaft is held fast",
                                [&axis] { return axis.load().locked ? 1.0 : 0.0; }},
                     .minimum = 0,
                     .maximum = 1,
                     .write =
                         [&axis, advance](double locked) {
                           advance();
                           Load load = axis.load();
                           load.locked = locked != 0;
                           axis.set_load(load);
                         },
                     .fault = true});
}

}  // namespace

BenchDrive::BenchDrive(const DriveSpec& spec, const Surroundings& bench)
    : name_(spec.name),
      kind_(find_drive(spec.kind)),
      loop_(bench.loop),
      lines_(bench.lines),
      seed_(bench.seed.scope(spec.name)),
      motors_(motors_of(spec, kind_)),
      memory_(open_memory(spec.nvm, kind_.name, bench.notes)),
      load_steps_(parse_load(spec.load, kind_.channels)),
      load_step_(loop_.add(Phase::kScenario, [this] { apply_due_load_steps(); })) {
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    line_ends_.push_back(lines_[i] == nullptr ? nullptr : &lines_[i]->add_device());
  }
  drive_ = make_drive(spec, bench);
  attach();
  for (const std::string& assignment : spec.set) write(assignment);
  apply_due_load_steps();
}

std::unique_ptr<Drive> BenchDrive::make_drive(const DriveSpec& spec, const Surroundings& bench) {
  return kind_.make({.loop = loop_,
                     .ports = line_ends_,
                     .seed = seed_,
                     .memory = *memory_,
                     .motors = motors_,
                     .supply = bench.supply,
                     .integrator = bench.integrator,
                     .ideal_line = line().settings().timing == LineTiming::kIdeal,
                     .lenient = spec.lenient,
                     .listener = bench.listener,
                     .notes = bench.notes});
}

void BenchDrive::attach() {
  for (std::size_t i = 0; i < line_ends_.size(); ++i) {
    if (line_ends_[i] != nullptr) line_ends_[i]->attach(drive_->receiver(i));
  }
}

void BenchDrive::write(const std::string& assignment) {
  try {
    drive_->set_parameter(assignment);
  } catch (const SetupError& error) {
    throw SetupError(fmt::format("--set {}", error.what()));
  }
}

void BenchDrive::power_off() {
  if (!std::exchange(powered_, false)) return;
  drive_->power_off();
  for (LineEnd* const end : line_ends_) {
    if (end != nullptr) end->detach();
  }
}

void BenchDrive::power_on() {
  if (std::exchange(powered_, true)) return;
  attach();
  drive_->power_on();
}

void BenchDrive::reset() {
  if (!powered_) return;
  drive_->power_off();
  drive_->power_on();
}

void BenchDrive::apply_due_load_steps() {
  for (; next_load_step_ < load_steps_.size(); ++next_load_step_) {
    const LoadStep& step = load_steps_[next_load_step_];
    if (step.at > loop_.now()) {
      load_step_.at(step.at);
      return;
    }
    for (std::size_t i = 0; i < channels(); ++i) {
      if (step.channel.value_or(i) != i) continue;
      Axis& axis = drive_->axis(i);
      axis.advance_to(loop_.now());
      Load load = axis.load();
      load.*step.quantity = step.value;
      axis.set_load(load);
    }
  }
}

void BenchDrive::register_signals(Registry& registry) {
  for (std::size_t i = 0; i < channels(); ++i) register_channel(registry, i);
  drive_->register_signals(registry);
  const auto count = [&](std::string_view name, std::string doc, std::uint64_t WireCounters::* of) {
    registry.add(Signal{fmt::format("wire.{}", name), "", std::move(doc),
                        [this, of] { return static_cast<double>(drive_->wire_counters().*of); }});
  };
  count("requests", "Good requests that the drive has heard", &WireCounters::requests);
  count("replies", "Replies that it has sent", &WireCounters::replies);
  count("bad_frames", "Frames that it could not take", &WireCounters::bad_frames);
  count("bytes_lost", "Bytes that came while it was not listening", &WireCounters::bytes_lost);
}

void BenchDrive::register_channel(Registry& registry, std::size_t channel) {
  Axis& axis = drive_->axis(channel);
  // The plant is as far as its last control step; whoever looks at it brings it to the present.
  const auto present = [this, &axis]() -> const Axis& {
    axis.advance_to(loop_.now());
    return axis;
  };
  const auto signal = [&](std::string_view component, std::string_view quantity, std::string unit,
                          std::string doc, auto read) {
    registry.add(Signal{fmt::format("{}{}.{}", component, channel, quantity), std::move(unit),
                        std::move(doc), [present, read] { return read(present()); }});
  };
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
  signal("load", "torque", "Nm", "Torque that the load asks of the shaft",
         [](const Axis& a) { return a.load_torque_nm(); });

  const auto load_input = [&](std::string_view quantity, std::string unit, std::string doc,
                              double minimum, double Load::* member) {
    registry.add(Input{{fmt::format("load{}.{}", channel, quantity), std::move(unit),
                        std::move(doc), [&axis, member] { return axis.load().*member; }},
                       minimum,
                       kInfinity,
                       [present, &axis, member](double value) {
                         Load load = present().load();
                         load.*member = value;
                         axis.set_load(load);
                       }});
  };
  register_bridge_faults(registry, channel, axis, [this, &axis] { axis.advance_to(loop_.now()); });
  load_input("brake_torque", "Nm", "Torque against the motion", 0, &Load::brake_torque_nm);
  load_input("constant_torque", "Nm", "Torque against positive rotation", -kInfinity,
             &Load::external_torque_nm);
  load_input("quadratic", "Nm/(rad/s)^2", "Fan or pump", 0, &Load::quadratic_nm_per_radps2);
  load_input("viscous", "Nm/(rad/s)", "Viscous load", 0, &Load::viscous_nm_per_radps);
  load_input("inertia", "kgm2", "Inertia coupled to the shaft", 0, &Load::inertia_kgm2);
  registry.add(
      Input{{fmt::format("supply{}.voltage", channel), "V", "Open-circuit voltage of the supply",
             [&axis] { return axis.parameters().link.source_v; }},
            0,
            1000,
            [present, &axis](double volts) {
              present();
              axis.set_source_voltage(volts);
            }});
}

}  // namespace virtdrive
