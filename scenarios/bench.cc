#include "scenarios/bench.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/line_signals.h"
#include "scenarios/line_transport.h"
#include "scenarios/plant_signals.h"

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

// The line at a drive's port; "" where none is.
std::string_view line_at(const DriveSpec& drive, std::size_t port,
                         const std::vector<LineSpec>& lines) {
  if (port == 0) return drive.line.empty() ? lines.front().name : drive.line;
  return port <= drive.other_lines.size() ? std::string_view(drive.other_lines[port - 1]) : "";
}

// The port of the first drive that is on a line.
const PortKind& first_port_on(const LineSpec& line, const BenchOptions& options) {
  for (const DriveSpec& drive : options.drives) {
    const std::vector<PortKind>& ports = find_drive(drive.kind).ports;
    for (std::size_t i = 0; i < ports.size(); ++i) {
      if (line_at(drive, i, options.lines) == line.name) return ports[i];
    }
  }
  throw SetupError(fmt::format("no drive is on line '{}'", line.name));
}

}  // namespace

Bench::Bench(const BenchOptions& options) : seed_(options.seed) {
  if (options.drives.empty()) throw SetupError("a bench needs a drive");
  if (options.lines.empty()) throw SetupError("a bench needs a line");
  for (const LineSpec& line : options.lines) add_line(line, options);
  for (const SupplySpec& supply : options.supplies) add_supply(supply, options.integrator);
  for (const DriveSpec& drive : options.drives) add_drive(drive, options);
  registry_.set_scope("");
  for (const auto& supply : supplies_) {
    register_supply(registry_, loop_, supply->name, supply->bus);
  }
  for (const auto& line : lines_) register_line(registry_, line->name, line->line);
}

void Bench::add_line(const LineSpec& spec, const BenchOptions& options) {
  for (const auto& other : lines_) {
    if (other->name == spec.name) throw SetupError(fmt::format("two lines named '{}'", spec.name));
  }
  const PortKind& port = first_port_on(spec, options);
  const Duplex duplex = spec.duplex.value_or(port.duplex);
  if (spec.echo && duplex != Duplex::kHalf) {
    throw SetupError(fmt::format(
        "line '{}': a host hears itself on a half-duplex line only, and this one is full duplex",
        spec.name));
  }
  lines_.push_back(std::make_unique<NamedLine>(
      loop_, spec.name,
      LineSettings{
          .timing = spec.timing, .baud = spec.baud.value_or(port.baud), .parity = port.parity},
      LineOptions{.duplex = duplex, .echo = spec.echo, .chance = seed_.stream(spec.name)}));
}

void Bench::add_supply(const SupplySpec& spec, Integrator integrator) {
  for (const auto& other : supplies_) {
    if (other->name == spec.name) {
      throw SetupError(fmt::format("two supplies named '{}'", spec.name));
    }
  }
  if (spec.name.empty()) throw SetupError("a supply that drives share needs a name");
  supplies_.push_back(
      std::make_unique<NamedSupply>(NamedSupply{spec.name, DcBus(spec.link, integrator)}));
}

std::optional<DcBus> Bench::supply_of(const DriveSpec& spec) {
  if (spec.supply.empty()) return std::nullopt;
  return named(supplies_, "supply", spec.supply,
               [](const NamedSupply& s) -> auto& { return s.name; })
      .bus;
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
  drives_.push_back(
      std::make_unique<BenchDrive>(spec, BenchDrive::Surroundings{.loop = loop_,
                                                                  .lines = lines_of(spec, options),
                                                                  .supply = supply_of(spec),
                                                                  .seed = seed_,
                                                                  .integrator = options.integrator,
                                                                  .listener = std::move(listener),
                                                                  .notes = options.notes}));
  registry_.set_scope(spec.name);
  drives_.back()->register_signals(registry_);
}

// A line that is not there is the drive's mistake: the error says whose.
std::vector<SerialLine*> Bench::lines_of(const DriveSpec& spec, const BenchOptions& options) try {
  const std::vector<PortKind>& ports = find_drive(spec.kind).ports;
  if (spec.other_lines.size() >= ports.size()) {
    throw SetupError(fmt::format("{} lines for {}: it has {} ports", spec.other_lines.size() + 1,
                                 spec.kind, ports.size()));
  }
  std::vector<SerialLine*> lines;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const std::string_view name = line_at(spec, i, options.lines);
    lines.push_back(name.empty() ? nullptr : &line(name));
  }
  return lines;
} catch (const SetupError& error) {
  throw SetupError(fmt::format("drive '{}': {}", spec.name, error.what()));
}

BenchDrive& Bench::drive(std::string_view name) {
  return named(drives_, "drive", name,
               [](const BenchDrive& drive) -> auto& { return drive.name(); });
}

SerialLine& Bench::line(std::string_view name) {
  return named(lines_, "line", name, [](const NamedLine& line) -> auto& { return line.name; }).line;
}

std::string_view Bench::line_name(const SerialLine& line) const {
  const auto it =
      std::ranges::find_if(lines_, [&](const auto& named) { return &named->line == &line; });
  VIRTDRIVE_CHECK(it != lines_.end(), "a line of another bench");
  return (*it)->name;
}

std::unique_ptr<HostClient> Bench::host(BenchDrive& drive) {
  return drive.kind().make_host(std::make_unique<LineTransport>(loop_, drive.line()));
}

}  // namespace virtdrive
