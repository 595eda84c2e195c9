#include <algorithm>
#include <fmt/format.h>

#include "devices/protocol/document.h"
#include "scenarios/cli/commands.h"

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
    fmt::print("{:<14} {}\n", kind.name, kind.table.title);
    fmt::print("{:<14} motor {}, {} baud\n", "", kind.default_motor, kind.default_baud);
  }
  return kExitOk;
}

int list_motors() {
  for (const Motor& motor : motor_library()) {
    fmt::print("{:<14} {}\n", motor.name, motor.description);
    const PmsmParameters& e = motor.electrical;
    fmt::print(
        "{:<14} {} V, {} A, {} pole pairs, R {} Ohm, Ld {} mH, Lq {} mH, psi {} mWb, J {} kg m2\n",
        "", motor.rated_voltage_v, e.rated_current_a, e.pole_pairs, e.resistance_ohm,
        e.inductance_d_h * 1e3, e.inductance_q_h * 1e3, e.flux_wb * 1e3,
        motor.mechanics.inertia_kgm2);
    fmt::print("{:<14} source: {}\n", "", motor.source);
    if (!motor.assumed.empty()) fmt::print("{:<14} assumed: {}\n", "", motor.assumed);
  }
  return kExitOk;
}

int list_signals(const std::string& drive) {
  const Bench bench({.drives = {{.kind = drive}}});
  for (const Signal& signal : bench.registry().signals()) {
    fmt::print("{:<22} {:<13} {:<6} {}\n", signal.name, signal.unit,
               kind_of(signal, bench.registry()), signal.doc);
  }
  return kExitOk;
}

int list_parameters(const std::string& drive) {
  constexpr std::string_view kRow = "{:<4} {:<26} {:<4} {:<25} {:<14} {:<26} {}\n";
  const protocol::ProtocolTable& table = find_drive(drive).table;
  fmt::print(kRow, "id", "name", "", "range", "factory", "unit", "support");
  for (const protocol::ParameterRow& row : table.parameters) {
    fmt::print(kRow, fmt::format("{:02X}", row.id), row.name, word(row.access), range(row),
               factory(row), units(row), word(row.support));
  }
  return kExitOk;
}

int document_drive(const std::string& drive) {
  fmt::print("{}", protocol::document(find_drive(drive).table));
  return kExitOk;
}

}  // namespace virtdrive
