#include <algorithm>
#include <fmt/format.h>

#include "devices/protocol/document.h"
#include "scenarios/cli/commands.h"
#include "scenarios/scenario/gallery.h"

namespace virtdrive {

namespace {

std::string_view kind_of(const Signal& signal, const Registry& registry) {
  const auto it = std::ranges::find(registry.inputs(), signal.name,
                                    [](const Input& input) { return input.signal.name; });
  return it == registry.inputs().end() ? "signal" : it->fault ? "fault" : "input";
}

}  // namespace

int list_drives(bool names_only) {
  for (const DriveKind& kind : drive_catalogue()) {
    if (names_only) {
      fmt::print("{}\n", kind.name);
      continue;
    }
    fmt::print("{:<17} {}\n", kind.name, kind.table.title);
    const PortKind& port = kind.ports.front();
    fmt::print("{:<17} motor {}, {} baud{}\n", "", kind.default_motor, port.baud,
               port.parity == Parity::kEven ? ", even parity" : "");
  }
  return kExitOk;
}

int list_motors() {
  constexpr std::string_view kRow = "{:<15} {:<10} {:>6} {:>6} {:>6} {:>6}  {}\n";
  constexpr std::size_t kSourceWidth = 72;
  const auto or_none = [](double value) { return value > 0 ? fmt::format("{:.4g}", value) : "-"; };
  fmt::print(kRow, "name", "kind", "V", "A", "W", "rpm", "what and source");
  for (const Motor& motor : motor_library()) {
    const MotorRating& rated = motor.rating;
    fmt::print(kRow, motor.name, kind_name(motor.kind), or_none(rated.voltage_v),
               or_none(rated.current_a), or_none(rated_power_w(rated)), or_none(rated.speed_rpm),
               motor.description);
    const bool cut = motor.source.size() > kSourceWidth;
    fmt::print(kRow, "", "", "", "", "", "",
               motor.source.substr(0, kSourceWidth) + (cut ? " ..." : ""));
  }
  fmt::print("\n'virtdrive motor NAME' tells all of one; --motor takes a name or a file's path.\n");
  return kExitOk;
}

int list_signals(const std::string& drive) {
  const Bench bench({.drives = {{.kind = drive}}});
  for (const Signal& signal : bench.registry().signals()) {
    fmt::print("{:<24} {:<13} {:<6} {}\n", signal.name, signal.unit,
               kind_of(signal, bench.registry()), signal.doc);
  }
  return kExitOk;
}

int list_parameters(const std::string& drive) {
  constexpr std::string_view kRow = "{:<4} {:<26} {:<4} {:<25} {:<17} {:<26} {}\n";
  const protocol::ProtocolTable& table = find_drive(drive).table;
  fmt::print(kRow, "id", "name", "", "range", "factory", "unit", "support");
  for (const protocol::ParameterRow& row : table.parameters) {
    fmt::print(kRow, fmt::format("{:02X}", row.id), row.name, word(row.access), range(row),
               factory(row), units(row), word(row.support));
  }
  return kExitOk;
}

int document_drive(const std::string& drive) {
  const DriveKind& kind = find_drive(drive);
  fmt::print("{}", protocol::document(kind.protocol != nullptr ? *kind.protocol : kind.table));
  return kExitOk;
}

int document_scenarios(const std::vector<std::string>& paths) {
  fmt::print("{}", gallery(find_scenarios(paths)));
  return kExitOk;
}

}  // namespace virtdrive
