#include "scenarios/bench.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

// The one whose name is asked for, in a list of things that have names.
template <class Things, class NameOf>
auto& named(Things& things, std::string_view kind, std::string_view name, NameOf name_of) {
  std::vector<std::string_view> names;
  for (auto& thing : things) {
    if (name_of(*thing) == name) return *thing;
    names.push_back(name_of(*thing));
  }
  throw SetupError(unknown_name(kind, name, names));
}

std::string_view line_of(const DriveSpec& drive, const std::vector<LineSpec>& lines) {
  return drive.line.empty() ? std::string_view(lines.front().name) : drive.line;
}

}  // namespace

Bench::Bench(const BenchOptions& options) : seed_(options.seed) {
  if (options.drives.empty()) throw SetupError("a bench needs a drive");
  if (options.lines.empty()) throw SetupError("a bench needs a line");
  for (const LineSpec& line : options.lines) add_line(line, options);
  for (const DriveSpec& drive : options.drives) add_drive(drive, options);
  registry_.set_scope("");
}

void Bench::add_line(const LineSpec& spec, const BenchOptions& options) {
  for (const auto& other : lines_) {
    if (other->name == spec.name) throw SetupError(fmt::format("two lines named '{}'", spec.name));
  }
  const auto on_it = [&](const DriveSpec& drive) {
    return line_of(drive, options.lines) == spec.name;
  };
  const auto first = std::ranges::find_if(options.drives, on_it);
  if (first == options.drives.end()) {
    throw SetupError(fmt::format("no drive is on line '{}'", spec.name));
  }
  const int baud = spec.baud.value_or(find_drive(first->kind).default_baud);
  lines_.push_back(std::make_unique<NamedLine>(loop_, spec, baud, seed_));
}

void Bench::add_drive(const DriveSpec& spec, const BenchOptions& options) {
  for (const auto& other : drives_) {
    if (other->name() == spec.name) {
      throw SetupError(fmt::format("two drives named '{}'", spec.name));
    }
  }
  WireListener listener;
  if (options.listener) {
    listener = [tell = options.listener, name = spec.name](const WireEvent& event) {
      tell(name, event);
    };
  }
  // A line that is not there is the drive's mistake: say whose.
  const auto line_named = [&]() -> SerialLine& {
    try {
      return line(line_of(spec, options.lines));
    } catch (const SetupError& error) {
      throw SetupError(fmt::format("drive '{}': {}", spec.name, error.what()));
    }
  };
  drives_.push_back(
      std::make_unique<BenchDrive>(spec, BenchDrive::Surroundings{.loop = loop_,
                                                                  .line = line_named(),
                                                                  .seed = seed_,
                                                                  .integrator = options.integrator,
                                                                  .listener = std::move(listener),
                                                                  .notes = options.notes}));
  registry_.set_scope(spec.name);
  drives_.back()->register_signals(registry_);
}

BenchDrive& Bench::drive(std::string_view name) {
  return named(drives_, "drive", name,
               [](const BenchDrive& drive) -> auto& { return drive.name(); });
}

SerialLine& Bench::line(std::string_view name) {
  return named(lines_, "line", name, [](const NamedLine& line) -> auto& { return line.name; }).line;
}

std::unique_ptr<HostClient> Bench::host(BenchDrive& drive) {
  return drive.kind().make_host(std::make_unique<LineTransport>(loop_, drive.line()));
}

}  // namespace virtdrive
