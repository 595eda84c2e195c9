#include "scenarios/drives/toshiba_mcu.h"

#include <fmt/format.h>
#include <memory>
#include <vector>

#include "core/check.h"
#include "devices/toshiba_mcu/device.h"
#include "scenarios/drives/toshiba_mcu_words.h"

namespace virtdrive {
namespace {

using namespace toshiba_mcu;

// A 24 V laboratory supply that cannot absorb, 0.1 Ohm with its leads, and the board's 1000 uF.
constexpr DcLinkParameters kSupply{.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3};

double rpm(const MotorChannel& channel, double electrical_hz) {
  return electrical_hz * 60 / channel.scaling().pole_pairs;
}

class ToshibaMcuDrive final : public Drive, private SerialReceiver {
 public:
  explicit ToshibaMcuDrive(const DriveContext& context)
      : context_(context), axes_(make_axes(context)), board_temperatures_degc_(axes_.size(), 25) {
    power_on();
  }

  SerialReceiver& receiver() override { return *this; }
  Axis& axis(std::size_t channel) override { return axes_[channel]; }
  WireCounters wire_counters() const override {
    return mcu_ ? counted_ + mcu_->device.counters() : counted_;
  }
  void power_off() override;
  void power_on() override;

  void register_signals(Registry& registry) override;
  void set_parameter(std::string_view assignment) override;
  std::string status() override;

 private:
  // All that a reset makes anew.
  struct Mcu {
    Mcu(const DriveContext& context, std::span<Axis* const> axes)
        : firmware(context.loop, axes, context.seed),
          device(context.loop, context.port, firmware, context.memory,
                 {.latency = context.ideal_line ? SimDuration{} : DeviceOptions{}.latency,
                  .lenient = context.lenient},
                 context.listener, context.notes) {}
    Firmware firmware;
    Device device;
  };

  static std::vector<Axis> make_axes(const DriveContext& context) {
    std::vector<Axis> axes;
    for (const Motor& motor : context.motors) {
      axes.emplace_back(
          AxisParameters{.motor = motor.electrical, .link = kSupply, .mechanics = motor.mechanics},
          context.integrator);
    }
    return axes;
  }
  void receive(std::uint8_t byte) override {
    if (mcu_) mcu_->device.receive(byte);
  }
  void register_channel(Registry& registry, std::size_t channel);

  DriveContext context_;
  std::vector<Axis> axes_;
  std::vector<double> board_temperatures_degc_;
  WireCounters counted_;      // before the last reset
  std::unique_ptr<Mcu> mcu_;  // none without power
};

void ToshibaMcuDrive::power_off() {
  counted_ = wire_counters();
  mcu_.reset();
  for (Axis& axis : axes_) {
    axis.advance_to(context_.loop.now());
    axis.set_bridge({.mode = Bridge::kOff});
  }
}

void ToshibaMcuDrive::power_on() {
  std::vector<Axis*> axes;
  for (Axis& axis : axes_) axes.push_back(&axis);
  mcu_ = std::make_unique<Mcu>(context_, axes);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    mcu_->firmware.board(i).set_temperature_degc(board_temperatures_degc_[i]);
  }
}

void ToshibaMcuDrive::set_parameter(std::string_view text) {
  const ToshibaMcuAssignment assignment = parse_toshiba_mcu_assignment(text);
  const ParameterRow& row = *assignment.row;
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    if (assignment.channel.value_or(channel) != channel) continue;
    const auto id = static_cast<std::uint8_t>(row.id);
    if (mcu_->device.parameters().write(static_cast<std::uint8_t>(channel), id, assignment.value) ==
        Outcome::kDone) {
      continue;
    }
    if (row.access == Access::kReadOnly || row.support == Support::kRejected) {
      throw SetupError(fmt::format("{}: {} cannot be written", text, row.name));
    }
    throw SetupError(fmt::format("{}: refused; {} is {} ... {}: {}", text, row.name,
                                 row.range.minimum, row.range.maximum, row.doc));
  }
}

std::string ToshibaMcuDrive::status() {
  if (!mcu_) return "no power";
  std::string text;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const MotorChannel& channel = mcu_->firmware.board(i).channel();
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
  for (std::size_t i = 0; i < axes_.size(); ++i) register_channel(registry, i);
}

void ToshibaMcuDrive::register_channel(Registry& registry, std::size_t index) {
  // Without power there is no program that could hold a value: it reads 0.
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                       double (*read)(const MotorChannel&)) {
    registry.add(Signal{
        fmt::format("drive{}.{}", index, quantity), std::move(unit), std::move(doc),
        [this, index, read] { return mcu_ ? read(mcu_->firmware.board(index).channel()) : 0; }});
  };
  using Channel = const MotorChannel&;
  add("stage", "",
      "0 Stop, 1 Bootstrap, 2 Brake, 3 ZeroCurrentMeasure, 4 Initposition, 5 Force, "
      "6 FOC, 7 Emergency",
      [](Channel c) { return static_cast<double>(c.stage()); });
  add("errors", "", "Error bits (MMS_ErrorState)", [](Channel c) { return double(c.errors()); });
  add("speed", "rpm", "Speed that the drive reports",
      [](Channel c) { return double(c.actual_rpm()); });
  add("speed_target", "rpm", "Target speed", [](Channel c) { return double(c.target_rpm()); });
  add("speed_command", "rpm", "Ramped speed command",
      [](Channel c) { return rpm(c, c.internals().command_hz); });
  add("speed_estimate", "rpm", "Speed of the position estimator",
      [](Channel c) { return rpm(c, c.internals().omega_hz); });
  add("angle", "deg", "Electrical angle of the drive's frame",
      [](Channel c) { return c.internals().theta_turns * 360; });
  add("current_d", "A", "Measured d current, in the drive's frame",
      [](Channel c) { return c.internals().id_a; });
  add("current_q", "A", "Measured q current, in the drive's frame",
      [](Channel c) { return c.internals().iq_a; });
  add("current_q_ref", "A", "Reference of the q current",
      [](Channel c) { return c.internals().iq_ref_a; });
  add("voltage_d", "V", "d voltage put out", [](Channel c) { return c.internals().vd_v; });
  add("voltage_q", "V", "q voltage put out", [](Channel c) { return c.internals().vq_v; });
  registry.add(
      Input{{fmt::format("board{}.temperature", index), "degC", "Temperature of the power board",
             [this, index] { return board_temperatures_degc_[index]; }},
            -40,
            150,
            [this, index](double degc) {
              board_temperatures_degc_[index] = degc;
              if (mcu_) mcu_->firmware.board(index).set_temperature_degc(degc);
            }});
}

}  // namespace

DriveKind toshiba_mcu_kind() {
  return {.name = kTable.name,
          .default_motor = "db42s03",
          .default_baud = 115200,
          .channels = kChannels,
          .default_channel = 1,
          .table = kTable,
          .make = [](const DriveContext& context) -> std::unique_ptr<Drive> {
            return std::make_unique<ToshibaMcuDrive>(context);
          },
          .make_host = make_toshiba_mcu_host};
}

}  // namespace virtdrive
