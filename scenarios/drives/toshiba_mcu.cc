#include "scenarios/drives/toshiba_mcu.h"

#include <fmt/format.h>
#include <memory>
#include <vector>

#include "core/check.h"
#include "devices/toshiba_mcu/device.h"
#include "devices/toshiba_mcu/walk.h"
#include "scenarios/drives/toshiba_mcu_words.h"
#include "scenarios/sensor_signals.h"

namespace virtdrive {
namespace {

using namespace toshiba_mcu;

// A 24 V laboratory supply that cannot absorb, 0.1 Ohm with its leads, and the board's 1000 uF.
constexpr DcLinkParameters kSupply{.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3};

// MOSFETs with their leads; assumed.
constexpr InverterParameters kBridge{.on_resistance_ohm = 0.01};

std::vector<std::string_view> stage_names() {
  std::vector<std::string_view> names;
  for (auto stage = Stage::kStop; stage <= Stage::kEmergency;
       stage = static_cast<Stage>(static_cast<int>(stage) + 1)) {
    names.push_back(name(stage));
  }
  return names;
}

// In the order of their bits, which have no gap.
std::vector<std::string_view> names_of(std::span<const CodeRow> bits) {
  std::vector<std::string_view> names;
  for (const CodeRow& bit : bits) names.push_back(bit.name);
  return names;
}

double rpm(const MotorChannel& channel, double electrical_hz) {
  return electrical_hz * 60 / channel.scaling().pole_pairs;
}

class Deaf final : public SerialReceiver {
  void receive(std::uint8_t) override {}
};

class ToshibaMcuDrive final : public Drive, private SerialReceiver {
 public:
  explicit ToshibaMcuDrive(const DriveContext& context)
      : context_(context), axes_(make_axes(context)), boards_(axes_.size()) {
    power_on();
  }

  /// At its second port, too: the firmware listens to nothing there.
  SerialReceiver& receiver(std::size_t port) override {
    return port == 0 ? static_cast<SerialReceiver&>(*this) : stream_input_;
  }
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
          device(context.loop, *context.ports[0], firmware, context.memory,
                 {.latency = context.ideal_line ? SimDuration{} : DeviceOptions{}.latency,
                  .lenient = context.lenient},
                 context.listener, context.notes, context.ports[1]) {}
    Firmware firmware;
    Device device;
  };

  // Three boards, each on a supply of its own unless the bench has them share one.
  static std::vector<Axis> make_axes(const DriveContext& context) {
    std::vector<Axis> axes;
    for (const Motor& motor : context.motors) {
      const AxisParameters parameters{.motor = motor.electrical,
                                      .link = kSupply,
                                      .mechanics = motor.mechanics,
                                      .inverter = kBridge,
                                      .effects = motor.effects};
      if (context.supply)
        axes.emplace_back(parameters, *context.supply);
      else
        axes.emplace_back(parameters, context.integrator);
    }
    return axes;
  }
  void receive(std::uint8_t byte) override {
    if (mcu_) mcu_->device.receive(byte);
  }
  void register_channel(Registry& registry, std::size_t channel);
  void register_board(Registry& registry, std::size_t channel);
  void register_sensors(Registry& registry, std::size_t channel);

  DriveContext context_;
  std::vector<Axis> axes_;
  std::vector<BoardInputs> boards_;  // what is around them outlives a reset
  Deaf stream_input_;
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
    mcu_->firmware.board(i).set_inputs(boards_[i]);
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
  const auto add = [&](std::string name, std::string doc,
                       std::uint64_t (HighSpeedStream::*count)() const) {
    registry.add(Signal{std::move(name), "", std::move(doc), [this, count] {
                          const HighSpeedStream* stream = mcu_ ? mcu_->device.stream() : nullptr;
                          return stream == nullptr ? 0 : double((stream->*count)());
                        }});
  };
  add("scope.frames", "Frames that the high-speed oscilloscope has sent", &HighSpeedStream::frames);
  add("scope.missed", "Frames that its line could not carry", &HighSpeedStream::missed);
}

void ToshibaMcuDrive::register_channel(Registry& registry, std::size_t index) {
  // Without power there is no program that could hold a value: it reads 0.
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                       double (*read)(const MotorChannel&),
                       std::vector<std::string_view> words = {}, bool bits = false) {
    registry.add(Signal{
        fmt::format("drive{}.{}", index, quantity), std::move(unit), std::move(doc),
        [this, index, read] { return mcu_ ? read(mcu_->firmware.board(index).channel()) : 0; },
        std::move(words), bits});
  };
  using Channel = const MotorChannel&;
  add(
      "stage", "",
      "0 Stop, 1 Bootstrap, 2 Brake, 3 ZeroCurrentMeasure, 4 Initposition, 5 Force, "
      "6 FOC, 7 Emergency",
      [](Channel c) { return static_cast<double>(c.stage()); }, stage_names());
  add(
      "errors", "", "Error bits (MMS_ErrorState)", [](Channel c) { return double(c.errors()); },
      names_of(kFaults), true);
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
  register_board(registry, index);
  register_sensors(registry, index);
}

void ToshibaMcuDrive::register_sensors(Registry& registry, std::size_t index) {
  BoardInputs& inputs = boards_[index];
  const auto changed = [this, index] {
    if (mcu_) mcu_->firmware.board(index).set_inputs(boards_[index]);
  };
  name_sensor(registry, fmt::format("hall{}", index), inputs.shaft.hall, changed);
  name_sensor(registry, fmt::format("encoder{}", index), inputs.shaft.encoder, changed);
  registry.add(Input{.signal = {fmt::format("encoder{}.magnet_lost", index), "",
                                "The magnetic encoder (AS5145H) stands still",
                                [&inputs] { return inputs.shaft.magnet_lost ? 1.0 : 0.0; }},
                     .minimum = 0,
                     .maximum = 1,
                     .write =
                         [&inputs, changed](double lost) {
                           inputs.shaft.magnet_lost = lost > 0;
                           changed();
                         },
                     .fault = true});
  for (std::size_t phase = 0; phase < 3; ++phase) {
    const char letter = static_cast<char>('a' + phase);
    name_sensor(registry, fmt::format("shunt{}.{}_", index, letter),
                fmt::format("Shunt of phase {}", letter), "A", 100, inputs.shunts[phase], changed);
  }
  name_sensor(registry, fmt::format("divider{}.", index), "Divider of the DC link", "V", 100,
              inputs.bus_divider, changed);
}

void ToshibaMcuDrive::register_board(Registry& registry, std::size_t index) {
  const auto read = [&](std::string_view quantity, std::string doc, auto value_of) {
    registry.add(Signal{fmt::format("drive{}.{}", index, quantity), "", std::move(doc),
                        [this, index, value_of] {
                          return mcu_ ? double(value_of(mcu_->firmware.board(index))) : 0;
                        }});
  };
  read("encoder", "Encoder counter", [](PowerBoard& board) { return board.encoder_count(); });
  read("turn_number", "Turns since DoTurn", [](PowerBoard& board) { return board.turn_number(); });
  read("position", "Absolute position of the linear axis",
       [](PowerBoard& board) { return board.absolute_position(); });

  const auto add = [&]<class Member>(std::string_view quantity, std::string unit, std::string doc,
                                     double minimum, double maximum, Member BoardInputs::* member,
                                     bool fault = false) {
    registry.add(Input{
        .signal = {fmt::format("board{}.{}", index, quantity), std::move(unit), std::move(doc),
                   [this, index, member] { return double(boards_[index].*member); }},
        .minimum = minimum,
        .maximum = maximum,
        .write =
            [this, index, member](double value) {
              boards_[index].*member = static_cast<Member>(value);
              if (mcu_) mcu_->firmware.board(index).set_inputs(boards_[index]);
            },
        .fault = fault});
  };
  add("temperature", "degC", "Temperature of the power board", -40, 150,
      &BoardInputs::temperature_degc);
  add("emergency", "", "The emergency pin is pulled", 0, 1, &BoardInputs::emergency, true);
  add("thermistor", "", "The thermistor: 1 its wire is broken, 2 it is shorted", 0, 2,
      &BoardInputs::thermistor, true);
  add("speed_voltage", "V", "Analogue input of the external speed control", 0, 5,
      &BoardInputs::speed_v);
  add("speed_pwm", "", "High share of the external speed control's PWM signal", 0, 1,
      &BoardInputs::speed_pwm);
  add("speed_servo", "us", "Servo pulse of the external speed control; 0: none comes", 0, 3000,
      &BoardInputs::speed_servo_us);
  add("speed_reverse", "", "Direction pin of the external speed control", 0, 1,
      &BoardInputs::speed_reverse);
}

}  // namespace

DriveKind toshiba_mcu_kind() {
  return {.name = kTable.name,
          .default_motor = "db42s03",
          .ports = {{.name = "host", .baud = 115200}, {.name = "scope", .baud = kStreamBaud}},
          .channels = kChannels,
          .default_channel = 1,
          .table = kTable,
          .make = [](const DriveContext& context) -> std::unique_ptr<Drive> {
            return std::make_unique<ToshibaMcuDrive>(context);
          },
          .make_host = make_toshiba_mcu_host,
          .make_dialect = [] { return std::make_unique<WalkDialect>(); }};
}

}  // namespace virtdrive
