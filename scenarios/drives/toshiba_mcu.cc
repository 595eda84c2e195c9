#include "scenarios/drives/toshiba_mcu.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/toshiba_mcu/client.h"
#include "devices/toshiba_mcu/device.h"

namespace virtdrive {
namespace {

using namespace toshiba_mcu;

// A 24 V laboratory supply that cannot absorb, 0.1 Ohm with its leads, and the board's 1000 uF.
constexpr DcLinkParameters kSupply{.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3};

struct Assignment {
  std::optional<std::size_t> channel;
  const ParameterRow* row;
  UnitValue value;
};

const ParameterRow& row_named(std::string_view text, std::string_view name) {
  const auto same = [&](const ParameterRow& row) { return edit_distance(row.name, name) == 0; };
  const auto it = std::ranges::find_if(kTable.parameters, same);
  if (it != kTable.parameters.end()) return *it;
  std::vector<std::string_view> names;
  for (const ParameterRow& row : kTable.parameters) names.push_back(row.name);
  throw SetupError(
      fmt::format("--set {}: {}; 'virtdrive list parameters toshiba-mcu' shows them all", text,
                  unknown_name("parameter", name, names)));
}

std::int8_t unit_labelled(std::string_view text, const ParameterRow& row, std::string_view label) {
  if (label.empty()) return row.factory.unit;
  std::vector<std::string_view> labels;
  for (const UnitCode& unit : row.units) {
    if (edit_distance(unit.label, label) == 0) return unit.code;
    labels.push_back(unit.label);
  }
  if (labels.empty() && edit_distance(row.unit, label) == 0 && !row.unit.empty()) return 0;
  if (labels.empty()) labels.push_back(row.unit.empty() ? "none" : row.unit);
  throw SetupError(fmt::format("--set {}: {}", text,
                               unknown_name(fmt::format("unit of {}", row.name), label, labels)));
}

// [CHANNEL.]NAME=NUMBER[UNIT]
Assignment parse_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    throw SetupError(fmt::format("--set {}: expected [CHANNEL.]NAME=VALUE[UNIT]", text));
  }
  std::string_view name = text.substr(0, equals);
  Assignment assignment{};
  if (const std::size_t dot = name.find('.'); dot != std::string_view::npos) {
    std::size_t channel = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + dot, channel);
    if (error != std::errc{} || end != name.data() + dot || channel >= kChannels) {
      throw SetupError(fmt::format("--set {}: channel '{}' is not 0 ... {}", text,
                                   name.substr(0, dot), kChannels - 1));
    }
    assignment.channel = channel;
    name.remove_prefix(dot + 1);
  }
  assignment.row = &row_named(text, name);
  const std::string_view value = text.substr(equals + 1);
  const char* const value_end = value.data() + value.size();
  const auto [end, error] = std::from_chars(value.data(), value_end, assignment.value.value);
  if (error != std::errc{}) {
    throw SetupError(
        fmt::format("--set {}: '{}' is not a whole number within 32 bits", text, value));
  }
  assignment.value.unit = unit_labelled(text, *assignment.row, std::string_view(end, value_end));
  return assignment;
}

class ToshibaMcuDrive final : public Drive {
 public:
  explicit ToshibaMcuDrive(const DriveContext& context)
      : axes_(make_axes(context)),
        firmware_(context.loop, pointers(), context.seed),
        device_(context.loop, context.port, firmware_, context.memory,
                {.latency = context.ideal_line ? SimDuration{} : DeviceOptions{}.latency,
                 .lenient = context.lenient},
                context.listener, context.notes) {}

  SerialReceiver& receiver() override { return device_; }
  std::size_t channels() const override { return axes_.size(); }
  Axis& axis(std::size_t channel) override { return axes_[channel]; }
  const WireCounters& wire_counters() const override { return device_.counters(); }

  void register_signals(Registry& registry) override;
  void set_parameter(std::string_view assignment) override;
  void start_motor(HostTransport& transport, std::size_t channel, double rpm) override;
  std::string status() override;

 private:
  static std::vector<Axis> make_axes(const DriveContext& context) {
    std::vector<Axis> axes;
    for (std::size_t i = 0; i < kChannels; ++i) {
      axes.emplace_back(AxisParameters{.motor = context.motor.electrical,
                                       .link = kSupply,
                                       .mechanics = context.motor.mechanics},
                        context.integrator);
    }
    return axes;
  }
  std::vector<Axis*> pointers() {
    std::vector<Axis*> list;
    for (Axis& axis : axes_) list.push_back(&axis);
    return list;
  }

  std::vector<Axis> axes_;
  Firmware firmware_;
  Device device_;
};

void ToshibaMcuDrive::set_parameter(std::string_view text) {
  const Assignment assignment = parse_assignment(text);
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    if (assignment.channel.value_or(channel) != channel) continue;
    const auto id = static_cast<std::uint8_t>(assignment.row->id);
    if (device_.parameters().write(static_cast<std::uint8_t>(channel), id, assignment.value) ==
        Outcome::kDone) {
      continue;
    }
    const ParameterRow& row = *assignment.row;
    if (row.access == Access::kReadOnly || row.support == Support::kRejected) {
      throw SetupError(fmt::format("--set {}: {} cannot be written", text, row.name));
    }
    throw SetupError(fmt::format("--set {}: refused; {} is {} ... {}: {}", text, row.name,
                                 row.range.minimum, row.range.maximum, row.doc));
  }
}

void ToshibaMcuDrive::start_motor(HostTransport& transport, std::size_t channel, double rpm) {
  Client client(transport);
  const auto motor_nr = static_cast<std::uint8_t>(channel);
  try {
    client.set(motor_nr, "Speed", {static_cast<std::int32_t>(rpm), 0});
    client.start_motor(motor_nr);
  } catch (const ClientError& error) {
    throw SetupError(fmt::format("--start: {}", error.what()));
  }
}

std::string ToshibaMcuDrive::status() {
  std::string text;
  for (std::size_t i = 0; i < channels(); ++i) {
    const MotorChannel& channel = firmware_.board(i).channel();
    if (channel.stage() == Stage::kStop && channel.errors() == 0) continue;
    const MotorChannel::Internals& now = channel.internals();
    text += fmt::format("{}motor{} {} {:+5d} rpm {:+.2f} A {:+.1f} mNm {:.1f} V",
                        text.empty() ? "" : " | ", i, name(channel.stage()), channel.actual_rpm(),
                        now.iq_a, axes_[i].torque_nm() * 1e3, axes_[i].state().bus_v);
    for (const CodeRow& fault : kFaults) {
      if ((channel.errors() >> fault.code & 1) != 0) text += fmt::format(" {}!", fault.name);
    }
  }
  return text.empty() ? "all motors stopped" : text;
}

void ToshibaMcuDrive::register_signals(Registry& registry) {
  for (std::size_t i = 0; i < channels(); ++i) {
    PowerBoard& board = firmware_.board(i);
    const MotorChannel& channel = board.channel();
    const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                         std::function<double()> read) {
      registry.add(Signal{fmt::format("drive{}.{}", i, quantity), std::move(unit), std::move(doc),
                          std::move(read)});
    };
    const MotorChannel::Internals& now = channel.internals();
    const Scaling& scaling = channel.scaling();
    add("stage", "",
        "0 Stop, 1 Bootstrap, 2 Brake, 3 ZeroCurrentMeasure, 4 Initposition, 5 Force, "
        "6 FOC, 7 Emergency",
        [&channel] { return static_cast<double>(channel.stage()); });
    add("errors", "", "Error bits (MMS_ErrorState)",
        [&channel] { return double(channel.errors()); });
    add("speed", "rpm", "Speed that the drive reports",
        [&channel] { return double(channel.actual_rpm()); });
    add("speed_target", "rpm", "Target speed", [&channel] { return double(channel.target_rpm()); });
    add("speed_command", "rpm", "Ramped speed command",
        [&now, &scaling] { return now.command_hz * 60 / scaling.pole_pairs; });
    add("speed_estimate", "rpm", "Speed of the position estimator",
        [&now, &scaling] { return now.omega_hz * 60 / scaling.pole_pairs; });
    add("angle", "deg", "Electrical angle of the drive's frame",
        [&now] { return now.theta_turns * 360; });
    add("current_d", "A", "Measured d current, in the drive's frame", [&now] { return now.id_a; });
    add("current_q", "A", "Measured q current, in the drive's frame", [&now] { return now.iq_a; });
    add("current_q_ref", "A", "Reference of the q current", [&now] { return now.iq_ref_a; });
    add("voltage_d", "V", "d voltage put out", [&now] { return now.vd_v; });
    add("voltage_q", "V", "q voltage put out", [&now] { return now.vq_v; });
    registry.add(
        Input{{fmt::format("board{}.temperature", i), "degC", "Temperature of the power board",
               [&board] { return board.temperature_degc(); }},
              -40,
              150,
              [&board](double degc) { board.set_temperature_degc(degc); }});
  }
}

}  // namespace

DriveKind toshiba_mcu_kind() {
  return {.name = kTable.name,
          .default_motor = "db42s03",
          .default_baud = 115200,
          .default_channel = 1,
          .table = kTable,
          .make = [](const DriveContext& context) -> std::unique_ptr<Drive> {
            return std::make_unique<ToshibaMcuDrive>(context);
          }};
}

}  // namespace virtdrive
