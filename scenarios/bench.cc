#include "scenarios/bench.h"

#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <utility>

#include "scenarios/nvm_file.h"

namespace virtdrive {
namespace {

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::unique_ptr<NonVolatileMemory> open_memory(const BenchOptions& options,
                                               std::string_view drive) {
  if (options.nvm.empty()) return std::make_unique<MemoryInProcess>();
  return std::make_unique<NvmFile>(options.nvm, drive, options.notes);
}

}  // namespace

Bench::Bench(const BenchOptions& options)
    : kind_(find_drive(options.drive)),
      motor_(find_motor(options.motor.empty() ? kind_.default_motor : options.motor)),
      seed_(options.seed),
      line_(loop_, {.timing = options.line, .baud = options.baud.value_or(kind_.default_baud)}),
      memory_(open_memory(options, kind_.name)),
      drive_(kind_.make({.loop = loop_,
                         .port = line_.device_port(),
                         .seed = seed_,
                         .memory = *memory_,
                         .motor = motor_,
                         .integrator = options.integrator,
                         .ideal_line = options.line == LineTiming::kIdeal,
                         .lenient = options.lenient,
                         .listener = options.listener,
                         .notes = options.notes})),
      load_steps_(parse_load(options.load)),
      load_step_(loop_.add(Phase::kScenario, [this] { apply_due_load_steps(); })) {
  line_.attach(drive_->receiver());
  for (std::size_t i = 0; i < drive_->channels(); ++i) register_plant(i);
  drive_->register_signals(registry_);
  for (const std::string& assignment : options.set) drive_->set_parameter(assignment);
  apply_due_load_steps();
}

void Bench::apply_due_load_steps() {
  for (; next_load_step_ < load_steps_.size(); ++next_load_step_) {
    const LoadStep& step = load_steps_[next_load_step_];
    if (step.at > loop_.now()) {
      load_step_.at(step.at);
      return;
    }
    for (std::size_t i = 0; i < drive_->channels(); ++i) {
      Axis& axis = drive_->axis(i);
      axis.advance_to(loop_.now());
      Load load = axis.load();
      load.*step.quantity = step.value;
      axis.set_load(load);
    }
  }
}

void Bench::register_plant(std::size_t channel) {
  Axis& axis = drive_->axis(channel);
  // The plant is as far as its last control step; whoever looks at it brings it to the present.
  const auto present = [this, &axis]() -> const Axis& {
    axis.advance_to(loop_.now());
    return axis;
  };
  const auto signal = [&](std::string_view component, std::string_view quantity, std::string unit,
                          std::string doc, auto read) {
    registry_.add(Signal{fmt::format("{}{}.{}", component, channel, quantity), std::move(unit),
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
    registry_.add(Input{{fmt::format("load{}.{}", channel, quantity), std::move(unit),
                         std::move(doc), [&axis, member] { return axis.load().*member; }},
                        minimum,
                        kInfinity,
                        [present, &axis, member](double value) {
                          Load load = present().load();
                          load.*member = value;
                          axis.set_load(load);
                        }});
  };
  load_input("brake_torque", "Nm", "Torque against the motion", 0, &Load::brake_torque_nm);
  load_input("constant_torque", "Nm", "Torque against positive rotation", -kInfinity,
             &Load::external_torque_nm);
  load_input("quadratic", "Nm/(rad/s)^2", "Fan or pump", 0, &Load::quadratic_nm_per_radps2);
  load_input("viscous", "Nm/(rad/s)", "Viscous load", 0, &Load::viscous_nm_per_radps);
  load_input("inertia", "kgm2", "Inertia coupled to the shaft", 0, &Load::inertia_kgm2);
  registry_.add(
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
