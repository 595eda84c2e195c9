#include "scenarios/drives/rzt1.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <memory>
#include <numbers>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/rzt1/device.h"
#include "devices/rzt1/walk.h"
#include "scenarios/drives/rzt1_words.h"
#include "scenarios/sensor_signals.h"

namespace virtdrive {
namespace {

using namespace rzt1;

// Both inverters hang on one bus, taken as ideal: what the motors give back it takes.
constexpr DcLinkParameters kLink{.source_v = 280, .resistance_ohm = 0, .capacitance_f = 470e-6};

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kPins = 4;  // inputs of an axis

// Which channels the motor's phases U, V, W are wired to, in the order of PMAP.
constexpr std::array<std::array<int, 3>, 6> kWirings = {
    {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}, {1, 0, 2}, {2, 0, 1}, {2, 1, 0}}};

// From bit 0 on; bits between them that mean nothing have names, too.
std::vector<std::string_view> bit_names(std::span<const CodeRow> bits) {
  std::vector<std::string_view> names(static_cast<std::size_t>(bits.back().code) + 1, "unused");
  for (const CodeRow& bit : bits) names[static_cast<std::size_t>(bit.code)] = bit.name;
  return names;
}

// --- Options -------------------------------------------------------------------------------------

/// What the document leaves open, or says twice: --set NAME=VALUE.
struct Options {
  DeviceOptions device;
  FirmwareOptions firmware;
};

std::size_t choice(std::string_view text, std::string_view value,
                   std::initializer_list<std::string_view> words) {
  const auto it = std::ranges::find(words, value);
  if (it == words.end()) {
    throw SetupError(
        fmt::format("{}: {}", text, unknown_name("choice", value, {words.begin(), words.end()})));
  }
  return static_cast<std::size_t>(it - words.begin());
}

double turns(std::string_view text, std::string_view value) {
  double number = 0;
  const char* const last = value.data() + value.size();
  const auto [end, error] = std::from_chars(value.data(), last, number);
  if (error != std::errc{} || end != last || !(number > 0 && number <= 10000)) {
    throw SetupError(fmt::format("{}: expected a number of turns, above 0", text));
  }
  return number;
}

struct OptionRow {
  std::string_view name;
  void (*set)(Options&, std::string_view text, std::string_view value);
};

constexpr OptionRow kOptions[] = {
    {"status_bytes",
     [](Options& o, std::string_view text, std::string_view value) {
       o.device.format.status_bytes = 1 + choice(text, value, {"1", "2"});
     }},
    {"trace_layout",
     [](Options& o, std::string_view text, std::string_view value) {
       o.device.format.raw_trace = choice(text, value, {"counted", "raw"}) == 1;
     }},
    {"prompt_axis",
     [](Options& o, std::string_view text, std::string_view value) {
       o.device.prompt_axis = choice(text, value, {"off", "on"}) == 1;
     }},
    {"group_master",
     [](Options& o, std::string_view text, std::string_view value) {
       o.device.group_master = static_cast<std::uint32_t>(choice(text, value, {"none", "1", "2"}));
     }},
    {"gear",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.gear_inverted = choice(text, value, {"document", "successor"}) == 1;
     }},
    {"error_time",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.error_time_ms = choice(text, value, {"cycles", "ms"}) == 1;
     }},
    {"absolute_encoders",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.absolute_on_both = choice(text, value, {"axis2", "both"}) == 1;
     }},
    {"homing",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.homing.literal = choice(text, value, {"turns", "literal"}) == 1;
     }},
    {"homing_index_turns",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.homing.index_turns = turns(text, value);
     }},
    {"homing_switch_turns",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.homing.switch_turns = turns(text, value);
     }},
    {"homing_stop_turns",
     [](Options& o, std::string_view text, std::string_view value) {
       o.firmware.homing.stop_turns = turns(text, value);
     }},
};

// --- The board -----------------------------------------------------------------------------------

class Rzt1Drive final : public Drive {
 public:
  explicit Rzt1Drive(const DriveContext& context) : context_(context), axes_(make_axes(context)) {
    for (std::size_t i = 0; i < kConsoles; ++i) consoles_[i].emplace(*this, i);
    options_.device.lenient = context.lenient;
    if (context.ideal_line) options_.device.latency = {};
    power_on();
  }

  SerialReceiver& receiver(std::size_t port) override { return *consoles_[port]; }
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
    Board(const DriveContext& context, std::span<Axis* const> axes,
          std::span<SerialPort* const> ports, Hardware& hardware, const Options& options)
        : servo(context.loop, axes,
                {stored_settings(0, context.memory, context.notes),
                 stored_settings(1, context.memory, context.notes)},
                hardware, context.seed, options.firmware),
          device(context.loop, ports, servo, context.memory, options.device,
                 context.loop.now() == kSimStart ? SimDuration{} : options.device.boot_time,
                 context.listener, context.notes) {}
    ServoDrive servo;
    Device device;
  };

  // One console's pins on its line. With S2-8 ON the transceiver is the RS-232 one: what hangs on a
  // line with others, which has to be RS-422, is not connected.
  class Console final : public SerialReceiver, public SerialPort {
   public:
    Console(Rzt1Drive& drive, std::size_t number)
        : drive_(drive), line_(drive.context_.ports[number]), number_(number) {}
    bool wired() const { return line_ != nullptr; }
    void receive(std::uint8_t byte) override {
      if (drive_.board_ && connected()) drive_.board_->device.console(number_).receive(byte);
    }
    SimTime send(std::span<const std::uint8_t> bytes) override {
      return connected() ? line_->send(bytes) : drive_.context_.loop.now();
    }
    void set_baud(int baud) override { line_->set_baud(baud); }

   private:
    bool connected() {
      if (!drive_.hardware_.dip_rs232 || !line_->shared()) return true;
      if (!told_ && drive_.context_.notes) {
        drive_.context_.notes(
            "S2-8 is ON, RS-232: the board is not on the RS-422 line that it shares; "
            "board.s2_8 = 0 connects it");
      }
      told_ = true;
      return false;
    }

    Rzt1Drive& drive_;
    LineEnd* line_;
    std::size_t number_;
    bool told_ = false;
  };

  static std::vector<Axis> make_axes(const DriveContext& context) {
    const DcBus bus = context.supply.value_or(DcBus(kLink, context.integrator));
    std::vector<Axis> axes;
    for (const Motor& motor : context.motors) {
      axes.emplace_back(AxisParameters{.motor = motor.electrical,
                                       .link = kLink,
                                       .mechanics = motor.mechanics,
                                       .effects = motor.effects},
                        bus);
    }
    return axes;
  }
  bool set_option(std::string_view text, std::string_view name, std::string_view value);
  void write(std::string_view assignment);
  void surroundings_changed() {
    if (board_) board_->servo.hardware_changed();
  }
  void register_axis(Registry& registry, std::size_t number);
  void register_recorder(Registry& registry);
  void register_sensors(Registry& registry, std::size_t number);
  void register_pins(Registry& registry, std::size_t number);
  void register_switches(Registry& registry);
  template <class Get, class Set>
  void add_input(Registry& registry, std::string name, std::string unit, std::string doc,
                 double minimum, double maximum, Get get, Set set, bool fault = false);

  DriveContext context_;
  std::vector<Axis> axes_;
  Hardware hardware_;
  Options options_;
  std::vector<std::string> written_;  // at the start, for a board that is made anew
  std::array<std::optional<Console>, kConsoles> consoles_;
  WireCounters counted_;          // before the last power cycle
  std::unique_ptr<Board> board_;  // none without power
};

// --- Power ---------------------------------------------------------------------------------------

void Rzt1Drive::power_off() {
  counted_ = wire_counters();
  board_.reset();
  for (Axis& axis : axes_) {
    axis.advance_to(context_.loop.now());
    axis.set_bridge({.mode = Bridge::kOff});
  }
}

void Rzt1Drive::power_on() {
  std::vector<Axis*> axes;
  for (Axis& axis : axes_) axes.push_back(&axis);
  std::vector<SerialPort*> ports;
  for (auto& console : consoles_) ports.push_back(console->wired() ? &*console : nullptr);
  for (SerialPort* const port : ports) {
    if (port != nullptr) port->set_baud(kBootBaud);
  }
  board_ = std::make_unique<Board>(context_, axes, ports, hardware_, options_);
}

// --- Words ---------------------------------------------------------------------------------------

bool Rzt1Drive::set_option(std::string_view text, std::string_view name, std::string_view value) {
  const auto option = std::ranges::find(kOptions, name, &OptionRow::name);
  if (option == std::end(kOptions)) return false;
  option->set(options_, text, value);
  power_off();
  power_on();
  for (const std::string& assignment : written_) write(assignment);
  return true;
}

void Rzt1Drive::set_parameter(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  if (equals < text.size() && set_option(text, name, text.substr(equals + 1))) return;
  write(text);
  written_.emplace_back(text);
}

// Without an axis: both, but for their addresses.
void Rzt1Drive::write(std::string_view text) {
  const Rzt1Assignment assignment = parse_rzt1_assignment(text);
  const ParameterRow& row = *assignment.row;
  const auto number = assignment.name.number;
  if (number && *number > ServoDrive::kAxes) {
    throw SetupError(fmt::format("{}: axis {} is not 1 or 2", text, *number));
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (number && *number != i + 1) continue;
    const Status status = board_->device.variables().write(i, row, assignment.value);
    if (status == Status::kOk) continue;
    if (status == Status::kReadOnly) {
      throw SetupError(fmt::format("{}: {} cannot be written", text, row.name));
    }
    throw SetupError(fmt::format("{}: refused on axis {}; {} is {} ... {}: {}", text, i + 1,
                                 row.name, row.range.minimum, row.range.maximum, row.doc));
  }
}

std::string Rzt1Drive::status() {
  if (!board_) return "no power";
  std::string text;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const ServoAxis& axis = board_->servo.axis(i);
    const unsigned status = axis.status();
    if ((status & (kServoOn | kAmplifierOn)) == 0 && axis.errors() == 0) continue;
    text += fmt::format("{}axis{} {} {:+d} counts, error {:+d}, TC {}", text.empty() ? "" : " | ",
                        i + 1,
                        axis.busy()       ? "searching"
                        : axis.moving()   ? "moving"
                        : axis.servo_on() ? "holding"
                                          : "servo off",
                        axis.position(), axis.position_error(), axis.total_current());
    for (const CodeRow& fault : kFaults) {
      if ((axis.errors() >> fault.code & 1) != 0) text += fmt::format(" {}!", fault.name);
    }
  }
  return text.empty() ? "both servos off" : text;
}

// --- Signals and inputs --------------------------------------------------------------------------

void Rzt1Drive::register_signals(Registry& registry) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    register_axis(registry, i);
    register_pins(registry, i);
    register_sensors(registry, i);
  }
  register_recorder(registry);
  register_switches(registry);
}

void Rzt1Drive::register_axis(Registry& registry, std::size_t number) {
  // Without power there is no program that could hold a value: it reads 0.
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc,
                       double (*read)(const ServoAxis&), std::vector<std::string_view> words = {},
                       bool bits = false) {
    registry.add(
        Signal{fmt::format("drive{}.{}", number, quantity), std::move(unit), std::move(doc),
               [this, number, read] { return board_ ? read(board_->servo.axis(number)) : 0; },
               std::move(words), bits});
  };
  using Whole = const ServoAxis&;
  // Counts a loop cycle to turns a minute.
  static constexpr auto rpm = [](Whole axis, std::int32_t velocity) {
    const Settings& its = axis.settings();
    return velocity / 65536.0 / (its.ds * 50e-6) / its.ecpr * 60;
  };
  add(
      "status", "", "Status word (STA)", [](Whole a) { return double(a.status()); },
      bit_names(kStatusBits), true);
  add(
      "errors", "", "Errors since ERESET (EQUERY)", [](Whole a) { return double(a.errors()); },
      bit_names(kFaults), true);
  add("profile", "", "State of the profile generator (6.4)",
      [](Whole a) { return static_cast<double>(a.profile_state()); },
      {"idle", "accelerating", "decelerating", "constant", "streaming"});
  add("homing", "", "State of the homing (figure 7.2)",
      [](Whole a) { return static_cast<double>(a.homing_state()); },
      {"idle", "finding_hard_stop", "finding_switch", "finding_index", "at_hard_stop", "at_switch",
       "at_index", "moving_home", "done", "failed"});
  add("position", "counts", "Actual position (POS)", [](Whole a) { return double(a.position()); });
  add("command", "counts", "Command position",
      [](Whole a) { return double(a.command_position()); });
  add("error", "counts", "Position error (ERR)",
      [](Whole a) { return double(a.position_error()); });
  add("speed", "rpm", "Measured speed", [](Whole a) { return rpm(a, a.velocity()); });
  add("speed_command", "rpm", "Commanded speed",
      [](Whole a) { return rpm(a, a.command_velocity()); });
  add("output", "", "Output of the regulators, 32767 is all",
      [](Whole a) { return double(a.regulator_output()); });
  add("current_d", "counts", "Direct current (IDM)",
      [](Whole a) { return double(a.direct_current()); });
  add("current_q", "counts", "Quadrature current (IQM)",
      [](Whole a) { return double(a.quadrature_current()); });
  add("total_current", "counts", "Total current (TC)",
      [](Whole a) { return double(a.total_current()); });
  add("phase_angle", "counts", "Flux angle (PANGLE)",
      [](Whole a) { return double(a.phase_angle()); });
  add("halls", "", "Hall code", [](Whole a) { return double(a.halls()); });
  add("pvt", "", "Points in the PVT FIFO", [](Whole a) { return double(a.pvt_depth()); });
  add("i2t", "", "Integral of the I2t watch", [](Whole a) { return double(a.i2t()); });
}

void Rzt1Drive::register_recorder(Registry& registry) {
  const auto add = [&](std::string name, std::string doc, double (*read)(const ServoDrive&),
                       std::vector<std::string_view> words = {}) {
    registry.add(Signal{std::move(name), "", std::move(doc),
                        [this, read] { return board_ ? read(board_->servo) : 0; },
                        std::move(words)});
  };
  using Whole = const ServoDrive&;
  add("recorder.mode", "State of the recorder (TMODE)",
      [](Whole s) { return static_cast<double>(s.recorder().mode()); },
      {"idle", "armed", "until_full", "ring"});
  add("recorder.samples", "Samples that the recorder holds",
      [](Whole s) { return double(s.recorder().sample_count()); });
  add("board.out1", "Output P4-2 (OUT1)", [](Whole s) { return s.output(0) ? 1.0 : 0.0; });
  add("board.out2", "Output P4-3 (OUT2)", [](Whole s) { return s.output(1) ? 1.0 : 0.0; });
}

template <class Get, class Set>
void Rzt1Drive::add_input(Registry& registry, std::string name, std::string unit, std::string doc,
                          double minimum, double maximum, Get get, Set set, bool fault) {
  registry.add(Input{.signal = {std::move(name), std::move(unit), std::move(doc),
                                [get] { return static_cast<double>(get()); }},
                     .minimum = minimum,
                     .maximum = maximum,
                     .write =
                         [this, set](double value) {
                           set(value);
                           surroundings_changed();
                         },
                     .fault = fault});
}

void Rzt1Drive::register_pins(Registry& registry, std::size_t number) {
  AxisHardware& its = hardware_.axis[number];
  for (std::size_t pin = 0; pin < kPins; ++pin) {
    const auto mask = static_cast<std::uint8_t>(1U << pin);
    add_input(
        registry, fmt::format("pins{}.inp{}", number, kPins * number + pin + 1), "",
        fmt::format("Input INP{}, port P3-{}", kPins * number + pin + 1, kPins * number + pin + 2),
        0, 1, [&its, mask] { return (its.input_pins & mask) != 0 ? 1 : 0; },
        [&its, mask](double value) {
          its.input_pins =
              static_cast<std::uint8_t>(value > 0 ? its.input_pins | mask : its.input_pins & ~mask);
        });
  }
  add_input(
      registry, fmt::format("home_switch{}.input", number), "",
      "Input of the axis that a switch on the shaft's way works on, 1 to 4; 0: there is none", 0,
      kPins, [&its] { return its.home_switch.input; },
      [&its](double value) { its.home_switch.input = static_cast<int>(value); });
  add_input(
      registry, fmt::format("home_switch{}.from", number), "deg", "Angle where the switch closes",
      -1e6, 1e6, [&its] { return its.home_switch.from_rad / kDegree; },
      [&its](double value) { its.home_switch.from_rad = value * kDegree; });
  add_input(
      registry, fmt::format("home_switch{}.to", number), "deg", "Angle where it opens", -1e6, 1e6,
      [&its] { return its.home_switch.to_rad / kDegree; },
      [&its](double value) { its.home_switch.to_rad = value * kDegree; });
  add_input(
      registry, fmt::format("board{}.temperature", number), "degC", "Temperature of the inverter",
      -40, 200, [&its] { return its.inverter_degc; },
      [&its](double value) { its.inverter_degc = value; });
  add_input(
      registry, fmt::format("board{}.amplifier_fault", number), "", "The inverter reports a fault",
      0, 1, [&its] { return its.amplifier_fault ? 1 : 0; },
      [&its](double value) { its.amplifier_fault = value > 0; }, true);
}

void Rzt1Drive::register_sensors(Registry& registry, std::size_t number) {
  using Plug = AxisHardware::HallPlug;
  AxisHardware& its = hardware_.axis[number];
  add_input(
      registry, fmt::format("encoder{}.lines", number), "",
      "Lines of the incremental encoder, four counts each", 1, 1e6,
      [&its] { return its.incremental.lines; },
      [&its](double value) { its.incremental.lines = static_cast<std::int32_t>(value); });
  add_input(
      registry, fmt::format("encoder{}.index", number), "deg", "Angle of the index mark", -360, 360,
      [&its] { return its.incremental.index_angle_rad / kDegree; },
      [&its](double value) { its.incremental.index_angle_rad = value * kDegree; });
  const auto changed = [this, &its] {
    its.incremental_cut = its.incremental.cable_broken;
    surroundings_changed();
  };
  name_sensor(registry, fmt::format("encoder{}", number), its.incremental, changed);
  name_sensor(registry, fmt::format("hall{}", number), its.halls, changed);
  name_sensor(registry, fmt::format("absolute{}", number), its.absolute.sensor, changed);
  add_input(
      registry, fmt::format("absolute{}.silent", number), "",
      "The absolute encoder answers no more", 0, 1, [&its] { return its.absolute.silent ? 1 : 0; },
      [&its](double value) { its.absolute.silent = value > 0; }, true);
  add_input(
      registry, fmt::format("hall{}.plug", number), "",
      "Where the Hall sensors are: 0 nowhere, 1 at the encoder's connector, 2 at P5", 0, 2,
      [&its] { return static_cast<int>(its.hall_plug); },
      [&its](double value) { its.hall_plug = static_cast<Plug>(static_cast<int>(value)); });
  add_input(
      registry, fmt::format("motor{}.wiring", number), "",
      "How the motor's phases are wired, numbered as PMAP", 0, 5,
      [&its] { return std::ranges::find(kWirings, its.wiring) - kWirings.begin(); },
      [&its](double value) { its.wiring = kWirings[static_cast<std::size_t>(value)]; });
}

void Rzt1Drive::register_switches(Registry& registry) {
  for (std::size_t i = 0; i < ServoDrive::kAxes; ++i) {
    bool& on = hardware_.dip_halls_at_encoder[i];
    add_input(
        registry, fmt::format("board.s2_{}", i + 1), "",
        fmt::format("DIP switch S2-{}: 1 ON, the Halls of axis {} at the encoder's connector; 0 P5",
                    i + 1, i + 1),
        0, 1, [&on] { return on ? 1 : 0; }, [&on](double value) { on = value > 0; });
  }
  bool& rs232 = hardware_.dip_rs232;
  add_input(
      registry, "board.s2_8", "", "DIP switch S2-8: 1 ON, RS-232; 0 OFF, RS-422", 0, 1,
      [&rs232] { return rs232 ? 1 : 0; }, [&rs232](double value) { rs232 = value > 0; });
}

}  // namespace

DriveKind rzt1_kind() {
  return {.name = kTable.name,
          .default_motor = "servo-400w",
          .ports = {{.name = "con0", .baud = kBootBaud},
                    {.name = "con1", .baud = kBootBaud},
                    {.name = "con2", .baud = kBootBaud}},
          .channels = ServoDrive::kAxes,
          .default_channel = 0,
          .table = kTable,
          .make = [](const DriveContext& context) -> std::unique_ptr<Drive> {
            return std::make_unique<Rzt1Drive>(context);
          },
          .make_host = make_rzt1_host,
          .make_dialect = [] { return std::make_unique<PacketDialect>(); }};
}

}  // namespace virtdrive
