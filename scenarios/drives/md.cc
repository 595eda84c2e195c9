#include "scenarios/drives/md.h"

#include <algorithm>
#include <array>
#include <deque>
#include <fmt/format.h>
#include <memory>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/md485/device.h"
#include "devices/md485/walk.h"
#include "firmware_models/md/controller.h"
#include "scenarios/drives/md_words.h"
#include "scenarios/sensor_signals.h"

namespace virtdrive {
namespace {

using namespace md485;
using md::Controller;
using md::MotorChannel;
using md::Terminals;

// DC models hang on a battery, taken as ideal: what the motors give back it takes. AC models hang
// behind a rectifier, which takes nothing back, and have a chopper with a resistor of 100 Ohm.
DcLinkParameters link_of(const md::Model& model) {
  DcLinkParameters link{
      .source_v = model.bus_v, .resistance_ohm = 0, .capacitance_f = model.capacitance_f};
  if (!model.ac) return link;
  link.resistance_ohm = 1;
  link.chopper = {.on_v = 390,
                  .off_v = 380,
                  .resistance_ohm = 100,
                  .heat_capacity_j_per_k = 200,
                  .ambient_k_per_w = 0.5};
  return link;
}

// MOSFETs with their leads and body diodes; assumed.
constexpr InverterParameters kBridge{.on_resistance_ohm = 0.01, .diode_v = 0.7};

class MdDrive final : public Drive, private CanReceiver {
 public:
  MdDrive(const DriveContext& context, const md::Model& model)
      : context_(context),
        model_(model),
        axes_(make_axes(context, model)),
        pins_(axes_.size()),
        sensors_(axes_.size()),
        baud_code_(model.baud_code) {
    for (std::size_t port = 0; port < context_.ports.size(); ++port)
      ears_.emplace_back(*this, port);
    if (context_.can != nullptr) context_.can->attach(*this);
    power_on();
  }

  SerialReceiver& receiver(std::size_t port) override { return ears_[port]; }
  Axis& axis(std::size_t channel) override { return axes_[channel]; }
  WireCounters wire_counters() const override {
    return board_ ? counted_ + board_->device.counters() : counted_;
  }
  void power_off() override;
  void power_on() override;

  void register_signals(Registry& registry) override;
  void set_parameter(std::string_view assignment) override;
  std::string status() override;

 private:
  // All that a power cycle makes anew.
  struct Board {
    Board(const DriveContext& context, std::span<Axis* const> axes, const md::Model& model,
          Profile profile)
        : table(model, profile),
          controller(context.loop, axes, model,
                     stored_settings(model, context.memory, context.notes), context.seed),
          device(context.loop, *context.ports[0], controller, table, context.memory,
                 {.latency = context.ideal_line ? SimDuration{} : DeviceOptions{}.latency},
                 context.listener, context.notes) {
      receivers.push_back(&device);
      for (LineEnd* const port : std::span(context.ports).subspan(1)) {
        receivers.push_back(port != nullptr ? &device.add_serial(*port) : nullptr);
      }
      if (context.can != nullptr) can = &device.add_can(*context.can);
    }
    ModelTable table;
    Controller controller;
    Device device;
    std::vector<SerialReceiver*> receivers;  // one a port
    CanReceiver* can = nullptr;
  };

  // A serial port's receiver: there without power, and deaf then.
  class Ear final : public SerialReceiver {
   public:
    Ear(MdDrive& drive, std::size_t port) : drive_(drive), port_(port) {}
    void receive(std::uint8_t byte) override {
      if (drive_.board_) drive_.board_->receivers[port_]->receive(byte);
    }

   private:
    MdDrive& drive_;
    std::size_t port_;
  };

  // Two motors share one link.
  static std::vector<Axis> make_axes(const DriveContext& context, const md::Model& model) {
    const DcBus bus = context.supply.value_or(DcBus(link_of(model), context.integrator));
    std::vector<Axis> axes;
    for (const Motor& motor : context.motors) {
      axes.emplace_back(AxisParameters{.motor = motor.electrical,
                                       .link = link_of(model),
                                       .mechanics = motor.mechanics,
                                       .inverter = kBridge,
                                       .effects = motor.effects},
                        bus);
    }
    return axes;
  }
  void receive(const CanFrame& frame) override {
    if (board_) board_->can->receive(frame);
  }
  void follow_baud();
  void apply_surroundings();
  void register_motor(Registry& registry, std::size_t number);
  void register_terminals(Registry& registry, std::size_t number);
  void register_board(Registry& registry);

  DriveContext context_;
  const md::Model& model_;
  std::vector<Axis> axes_;
  Profile profile_ = Profile::kToday;
  md::TerminalControl terminal_control_ = md::TerminalControl::kSpeed;
  // What hangs on the board, whether it has power or not.
  std::vector<Terminals> pins_;
  std::vector<md::StageSensors> sensors_;
  double ambient_degc_ = 25;
  std::int32_t baud_code_;        // that the line is set to
  WireCounters counted_;          // before the last power cycle
  std::deque<Ear> ears_;          // one a port
  std::unique_ptr<Board> board_;  // none without power
};

// --- Power ---------------------------------------------------------------------------------------

void MdDrive::power_off() {
  counted_ = wire_counters();
  if (board_) board_->controller.set_clutch(false);
  if (context_.can != nullptr) context_.can->close();
  board_.reset();
  for (Axis& axis : axes_) {
    axis.advance_to(context_.loop.now());
    axis.set_bridge({.mode = Bridge::kOff});
  }
}

void MdDrive::power_on() {
  std::vector<Axis*> axes;
  for (Axis& axis : axes_) axes.push_back(&axis);
  board_ = std::make_unique<Board>(context_, axes, model_, profile_);
  apply_surroundings();
  follow_baud();
}

// A baud rate that was written counts from the next power-up on (p. 12); so does the CAN bit rate
// (assumed).
void MdDrive::follow_baud() {
  const md::Settings& settings = board_->controller.settings();
  if (context_.can != nullptr) context_.can->open(md::can_bit_rate(settings.can_bitrate), false);
  const std::int32_t code = settings.baud_code;
  if (code == baud_code_) return;
  baud_code_ = code;
  context_.ports[0]->set_baud(md::baud(code));
}

void MdDrive::apply_surroundings() {
  if (!board_) return;
  Controller& controller = board_->controller;
  controller.set_terminal_control(terminal_control_);
  controller.set_ambient_degc(ambient_degc_);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    controller.terminals(i) = pins_[i];
    controller.stage(i).set_sensors(sensors_[i]);
  }
}

// --- Words ---------------------------------------------------------------------------------------

void MdDrive::set_parameter(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  const std::string_view value = equals < text.size() ? text.substr(equals + 1) : "";
  if (name == "profile") {
    profile_ = parse_profile(value);
    power_off();
    power_on();
    return;
  }
  if (name == "terminal_control") {
    if (value != "speed" && value != "position") {
      throw SetupError(unknown_name("terminal control", value, {"speed", "position"}));
    }
    terminal_control_ =
        value == "speed" ? md::TerminalControl::kSpeed : md::TerminalControl::kPosition;
    apply_surroundings();
    return;
  }
  const MdAssignment assignment = parse_md_assignment(text);
  const auto pid = static_cast<std::uint8_t>(assignment.row->id);
  const ParameterRow* row = board_->table.parameter(pid);
  if (row == nullptr || row->access == Access::kReadOnly) {
    throw SetupError(
        fmt::format("{}: {} cannot be written on {}", text, assignment.row->name, model_.name));
  }
  const std::size_t at = is_checked(pid) ? 1 : 0;
  const bool one_number = row->fields.empty();
  if ((one_number && !row->range.contains(assignment.values[at])) ||
      !board_->device.parameters().write(pid, assignment.values)) {
    throw SetupError(fmt::format("{}: refused; {} is {} ... {}: {}", text, row->name,
                                 row->range.minimum, row->range.maximum, row->doc));
  }
  follow_baud();
}

std::string MdDrive::status() {
  if (!board_) return "no power";
  constexpr std::string_view kTypes[] = {"off", "speed", "position", "open loop", "torque"};
  std::string text;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const MotorChannel& motor = board_->controller.motor(i);
    if (motor.type() == md::ControlType::kOff && !motor.alarmed() && motor.rpm() == 0) continue;
    text += fmt::format("{}motor{} {} {:+5d} rpm {:.1f} A {:+d} counts", text.empty() ? "" : " | ",
                        i, kTypes[static_cast<std::size_t>(motor.type())], motor.rpm(),
                        motor.current_a(), motor.position());
    for (const CodeRow& fault : kFaults) {
      if ((motor.status() >> fault.code & 1) != 0) text += fmt::format(" {}!", fault.name);
    }
  }
  return text.empty() ? "all motors stopped" : text;
}

// --- Signals and inputs --------------------------------------------------------------------------

void MdDrive::register_signals(Registry& registry) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    register_motor(registry, i);
    register_terminals(registry, i);
  }
  register_board(registry);
}

void MdDrive::register_motor(Registry& registry, std::size_t number) {
  // Without power there is no program that could hold a value: it reads 0.
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                       double (*read)(const MotorChannel&)) {
    registry.add(Signal{
        fmt::format("drive{}.{}", number, quantity), std::move(unit), std::move(doc),
        [this, number, read] { return board_ ? read(board_->controller.motor(number)) : 0; }});
  };
  using Channel = const MotorChannel&;
  add("control_type", "", "0 off, 1 speed, 2 position, 3 open loop, 4 torque",
      [](Channel c) { return static_cast<double>(c.type()); });
  add("status", "", "Status bits (PID 34)", [](Channel c) { return double(c.status()); });
  add("status2", "", "Second status byte", [](Channel c) { return double(c.status2()); });
  add("speed", "rpm", "Speed that the controller reports",
      [](Channel c) { return double(c.rpm()); });
  add("speed_reference", "rpm", "Ramped reference",
      [](Channel c) { return double(c.reference_rpm()); });
  add("output", "", "Output, 1023 is full duty",
      [](Channel c) { return double(c.output_counts()); });
  add("current", "A", "Current that the controller reports",
      [](Channel c) { return c.current_a(); });
  add("position", "counts", "Position that the controller reports",
      [](Channel c) { return double(c.position()); });
  add("position_target", "counts", "Target of the move under way",
      [](Channel c) { return double(c.target_position()); });

  md::StageSensors& sensors = sensors_[number];
  const auto changed = [this] { apply_surroundings(); };
  name_sensor(registry, fmt::format("hall{}", number), sensors.hall, changed);
  name_sensor(registry, fmt::format("shunt{}.", number), "Shunt in the link", "A", 1000,
              sensors.shunt, changed);
  if (!model_.encoder) return;
  name_sensor(registry, fmt::format("encoder{}", number), sensors.encoder, changed);
  registry.add(Input{.signal = {fmt::format("encoder{}.lines", number), "",
                                "Lines of the encoder on the shaft; 0: there is none",
                                [&sensors] { return double(sensors.encoder.lines); }},
                     .minimum = 0,
                     .maximum = 65535,
                     .write = [&sensors, changed](double lines) {
                       sensors.encoder.lines = static_cast<std::int32_t>(lines);
                       changed();
                     }});
}

void MdDrive::register_terminals(Registry& registry, std::size_t number) {
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc, double maximum,
                       auto Terminals::* pin) {
    registry.add(Input{
        .signal = {fmt::format("terminal{}.{}", number, quantity), std::move(unit), std::move(doc),
                   [this, number, pin] { return double(pins_[number].*pin); }},
        .minimum = 0,
        .maximum = maximum,
        .write = [this, number, pin](double value) {
          auto& target = pins_[number].*pin;
          target = static_cast<std::remove_reference_t<decltype(target)>>(value);
          apply_surroundings();
        }});
  };
  add("int_speed", "", "INT_SPEED, pin 2: 1 is connected to ground", 1, &Terminals::int_speed);
  add("alarm_reset", "", "ALARM_RESET: 1 is connected to ground", 1, &Terminals::alarm_reset);
  add("dir", "", "DIR (CW/CCW), pin 6: 1 is connected to ground, CW", 1, &Terminals::cw);
  add("run", "", "RUN/BRAKE, pin 7: 1 is connected to ground, RUN", 1, &Terminals::run);
  add("start", "", "START/STOP, pin 8: 1 is connected to ground, START", 1, &Terminals::start);
  add("speed_voltage", "V", "Speed input, pin 10", 5, &Terminals::speed_v);
  add("speed_pwm", "", "Duty at pin 10 in place of a voltage; 0: the voltage", 1,
      &Terminals::pwm_duty);
  if (model_.pulse) {
    add("pulse_frequency", "Hz", "Pulses at PULSE_IN", 1e6, &Terminals::pulse_hz);
  }
  if (model_.rc) {
    add("rc_pulse", "ms", "RC servo pulse at PULSE_IN; 0: none come", 10, &Terminals::rc_ms);
  }
  add("volume", "", "Internal speed volume", 1, &Terminals::volume);
  add("slow_start_volume", "", "SLOW_START volume", 1, &Terminals::slow_start_volume);
  add("slow_down_volume", "", "SLOW_DOWN volume", 1, &Terminals::slow_down_volume);
}

void MdDrive::register_board(Registry& registry) {
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                       double (*read)(const Controller&)) {
    registry.add(Signal{fmt::format("board.{}", quantity), std::move(unit), std::move(doc),
                        [this, read] { return board_ ? read(board_->controller) : 0; }});
  };
  using Whole = const Controller&;
  add("temperature", "degC", "Heat sink", [](Whole c) { return c.heat_sink_degc(); });
  add("fan", "", "Fan output", [](Whole c) { return double(c.fan()); });
  if (model_.clutch) {
    add("clutch", "", "Clutch output: 1 the mechanical brake holds",
        [](Whole c) { return double(c.clutch()); });
  }
  add("alarm_output", "", "ALARM output", [](Whole c) { return double(c.alarm_output()); });
  registry.add(Input{.signal = {"board.ambient", "degC", "Air around the heat sink",
                                [this] { return ambient_degc_; }},
                     .minimum = -40,
                     .maximum = 150,
                     .write = [this](double degc) {
                       ambient_degc_ = degc;
                       apply_surroundings();
                     }});
}

// The TTL port's baud rate is fixed (p. 5); a CAN adapter's is any.
std::vector<PortKind> ports_of(const md::Model& model) {
  std::vector<PortKind> ports = {
      {.name = "rs485", .baud = md::baud(model.baud_code), .duplex = Duplex::kHalf}};
  if (model.ttl232) ports.push_back({.name = "ttl232", .baud = 9600, .protocol = kTable.name});
  if (model.can) ports.push_back({.name = "can", .baud = 115200, .can = true});
  return ports;
}

}  // namespace

std::vector<DriveKind> md_kinds() {
  // A model's own rows, for lists and documents.
  static const std::vector<std::unique_ptr<const ModelTable>> tables = [] {
    std::vector<std::unique_ptr<const ModelTable>> made;
    for (const md::Model& model : md::models()) {
      made.push_back(std::make_unique<const ModelTable>(model, Profile::kToday));
    }
    return made;
  }();
  std::vector<DriveKind> kinds;
  for (const auto& table : tables) {
    const md::Model& model = table->model();
    kinds.push_back(
        {.name = model.name,
         .default_motor = model.motor,
         .ports = ports_of(model),
         .channels = model.motors,
         .default_channel = 0,
         .table = table->table(),
         .protocol = &kTable,
         .make = [&model](const DriveContext& context) -> std::unique_ptr<Drive> {
           return std::make_unique<MdDrive>(context, model);
         },
         .make_host = make_md_host,
         .make_dialect = [&made = *table] { return std::make_unique<WalkDialect>(made); }});
  }
  return kinds;
}

}  // namespace virtdrive
