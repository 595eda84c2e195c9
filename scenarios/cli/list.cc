#include <fmt/format.h>

#include "scenarios/cli/commands.h"

namespace virtdrive {
namespace {

std::string_view word(protocol::Access access) {
  switch (access) {
    case protocol::Access::kReadOnly:
      return "R";
    case protocol::Access::kWriteOnly:
      return "W";
    default:
      return "R/W";
  }
}

std::string_view word(protocol::Support support) {
  switch (support) {
    case protocol::Support::kStored:
      return "stored";
    case protocol::Support::kRejected:
      return "rejected";
    default:
      return "";
  }
}

std::string units(const protocol::ParameterRow& row) {
  if (row.units.empty()) return std::string(row.unit);
  std::string text;
  for (const protocol::UnitCode& unit : row.units) {
    text += fmt::format("{}{}", text.empty() ? "" : "|", unit.label);
  }
  return text;
}

std::string factory(const protocol::ParameterRow& row) {
  if (row.type == protocol::WireType::kText || row.access == protocol::Access::kWriteOnly)
    return "";
  for (const protocol::UnitCode& unit : row.units) {
    if (unit.code == row.factory.unit) return fmt::format("{}{}", row.factory.value, unit.label);
  }
  return fmt::format("{}", row.factory.value);
}

}  // namespace

int list_drives() {
  for (const DriveKind& kind : drive_catalogue()) {
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
  const Bench bench({.drive = drive});
  for (const Signal& signal : bench.registry().signals()) {
    const auto& inputs = bench.registry().inputs();
    const bool input = std::ranges::any_of(
        inputs, [&](const Input& candidate) { return candidate.signal.name == signal.name; });
    fmt::print("{:<22} {:<13} {} {}\n", signal.name, signal.unit, input ? "input " : "signal",
               signal.doc);
  }
  return kExitOk;
}

int list_parameters(const std::string& drive) {
  const protocol::ProtocolTable& table = find_drive(drive).table;
  fmt::print("{:<4} {:<26} {:<4} {:<25} {:<12} {:<26} {}\n", "id", "name", "", "range", "factory",
             "unit", "");
  for (const protocol::ParameterRow& row : table.parameters) {
    const std::string range = row.type == protocol::WireType::kText
                                  ? fmt::format("text, {} bytes", row.count)
                                  : fmt::format("{} ... {}", row.range.minimum, row.range.maximum);
    fmt::print("{:02X}   {:<26} {:<4} {:<25} {:<12} {:<26} {}\n", row.id, row.name,
               word(row.access), range, factory(row), units(row), word(row.support));
  }
  return kExitOk;
}

}  // namespace virtdrive
