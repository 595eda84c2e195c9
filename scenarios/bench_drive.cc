#include "scenarios/bench_drive.h"

#include <fmt/format.h>
#include <utility>

#include "core/check.h"
#include "scenarios/nvm_file.h"
#include "scenarios/plant_signals.h"

namespace virtdrive {
namespace {

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

}  // namespace

BenchDrive::BenchDrive(const DriveSpec& spec, const Surroundings& bench)
    : name_(spec.name),
      kind_(find_drive(spec.kind)),
      loop_(bench.loop),
      lines_(bench.lines),
      seed_(bench.seed.scope(spec.name)),
      motors_(motors_of(spec, kind_)),
      memory_(open_memory(spec.nvm, kind_.name, bench.notes), loop_, seed_),
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
                     .can = bench.can != nullptr ? &bench.can->add_node() : nullptr,
                     .seed = seed_,
                     .memory = memory_,
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
  memory_.power_lost();
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
  power_off();
  power_on();
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
  for (std::size_t i = 0; i < channels(); ++i) {
    register_axis(registry, loop_, i, drive_->axis(i));
    register_supply(registry, loop_, fmt::format("supply{}", i), drive_->axis(i).bus());
  }
  drive_->register_signals(registry);
  memory_.register_signals(registry);
  const auto count = [&](std::string_view name, std::string doc, std::uint64_t WireCounters::* of) {
    registry.add(Signal{fmt::format("wire.{}", name), "", std::move(doc),
                        [this, of] { return static_cast<double>(drive_->wire_counters().*of); }});
  };
  count("requests", "Good requests that the drive has heard", &WireCounters::requests);
  count("replies", "Replies that it has sent", &WireCounters::replies);
  count("bad_frames", "Frames that it could not take", &WireCounters::bad_frames);
  count("bytes_lost", "Bytes that came while it was not listening", &WireCounters::bytes_lost);
}

}  // namespace virtdrive
