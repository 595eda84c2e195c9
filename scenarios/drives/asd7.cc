#include "scenarios/drives/asd7.h"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "core/check.h"
#include "devices/asd7/device.h"
#include "devices/asd7/size_table.h"
#include "devices/asd7/walk.h"
#include "devices/asd7_modbus/device.h"
#include "firmware_models/asd7/ac_drive.h"
#include "scenarios/drives/asd7_words.h"

namespace virtdrive {
namespace {

using namespace asd7;

constexpr int kBaud = 9600;

enum class Spoken : std::uint8_t { kOwn, kModbus };

Parameters factory_of(const Model& model, Spoken spoken) {
  Parameters factory = factory_parameters(model);
  if (spoken == Spoken::kModbus) factory.settings.number = asd7_modbus::kFactoryUnit;
  return factory;
}

Profile first_profile(const DriveContext& context) {
  Profile profile;
  if (context.ideal_line) profile.reply_time = profile.write_time = {};
  return profile;
}

std::unique_ptr<SerialReceiver> make_device(Spoken spoken, Station& station) {
  if (spoken == Spoken::kModbus) return std::make_unique<asd7_modbus::Device>(station);
  return std::make_unique<asd7::Device>(station);
}

class Asd7Drive final : public Drive {
 public:
  Asd7Drive(const DriveContext& context, const Model& model, Spoken spoken)
      : context_(context),
        model_(model),
        axis_({.motor = context.motors[0].electrical,
               .link = mains_link(model),
               .mechanics = context.motors[0].mechanics,
               .inverter = inverter_of(model),
               .effects = context.motors[0].effects},
              context.integrator),
        profile_(first_profile(context)),
        eeprom_(context.memory, factory_of(model, spoken)),
        drive_(context.loop, axis_, model, eeprom_.parameters().settings, eeprom_.kept(),
               context.seed),
        station_(context.loop, *context.ports[0], drive_, eeprom_, profile_, context.listener,
                 context.notes),
        device_(make_device(spoken, station_)) {
    if (context.supply) {
      throw SetupError("a 7-Series drive hangs on the mains, not on a supply that is shared");
    }
  }

  SerialReceiver& receiver(std::size_t) override { return *device_; }
  Axis& axis(std::size_t) override { return axis_; }
  WireCounters wire_counters() const override { return station_.counters(); }

  /// The mains are switched off: the program lives on what the link holds.
  void power_off() override { switch_mains(false); }
  void power_on() override { switch_mains(true); }

  void register_signals(Registry& registry) override;
  void set_parameter(std::string_view assignment) override;
  std::string status() override;

 private:
  void switch_mains(bool on) {
    axis_.advance_to(context_.loop.now());
    MainsInput mains = axis_.bus().mains();
    mains.connected.fill(on);
    axis_.bus().set_mains(mains);
  }
  void register_reports(Registry& registry);
  void register_terminals(Registry& registry);
  void register_panel(Registry& registry);
  void register_faults(Registry& registry);

  DriveContext context_;
  const Model& model_;
  Axis axis_;
  Profile profile_;
  Eeprom eeprom_;
  AcDrive drive_;
  Station station_;
  std::unique_ptr<SerialReceiver> device_;
  Trip injected_ = Trip::kNone;
  std::array<bool, 3> keys_{};  // pressed, by PanelKey
};

// --- Words ---------------------------------------------------------------------------------------

void Asd7Drive::set_parameter(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view value = equals < text.size() ? text.substr(equals + 1) : "";
  if (set_profile(profile_, text.substr(0, equals), value)) return;
  const Asd7Assignment assignment = parse_asd7_assignment(text);
  const ParameterRow& row = *assignment.row;
  if (row.support == Support::kRejected || row.access == Access::kReadOnly) {
    throw SetupError(fmt::format("{}: {} cannot be written: {}", text, row.name, row.doc));
  }
  const Registers::Answer answer =
      station_.registers().write(row.id, assignment.value, Keep::kEeprom);
  if (answer.error) {
    const Range range = station_.registers().range(row);
    throw SetupError(fmt::format("{}: refused; {} is {} ... {} {}: {}", text, row.name,
                                 static_cast<double>(range.minimum) * row.scale,
                                 static_cast<double>(range.maximum) * row.scale, row.unit,
                                 row.doc));
  }
  station_.take_line_settings();
}

std::string Asd7Drive::status() {
  if (!drive_.alive()) return "the CPU has no power, or is starting";
  const Monitor m = drive_.monitor();
  std::string text = drive_.tripped() ? fmt::format("trip {}", trip_name(drive_.trip()))
                     : (m.status & kStatusRunning) == 0 ? "stopped"
                     : m.reverse                        ? "reverse"
                                                        : "forward";
  text += fmt::format(" {:.2f} Hz {:.1f} A {:.0f} V", m.output_frequency / 100.0,
                      m.output_current / 1e4 * model_.rated_current_a, drive_.bus_v());
  if (drive_.alarms() != 0) text += fmt::format(" alarms {:04X}", drive_.alarms());
  return text;
}

// --- Signals and inputs --------------------------------------------------------------------------

void Asd7Drive::register_signals(Registry& registry) {
  register_reports(registry);
  register_terminals(registry);
  register_panel(registry);
  register_faults(registry);
}

void Asd7Drive::register_reports(Registry& registry) {
  const auto add = [&](std::string_view quantity, std::string unit, std::string doc, auto read) {
    registry.add(Signal{fmt::format("drive0.{}", quantity), std::move(unit), std::move(doc),
                        [read] { return static_cast<double>(read()); }});
  };
  const auto bits = [&](std::string_view quantity, std::string doc,
                        std::vector<std::string_view> words, auto read) {
    registry.add(Signal{fmt::format("drive0.{}", quantity), "", std::move(doc),
                        [read] { return static_cast<double>(read()); }, std::move(words), true});
  };
  add("output_frequency", "Hz", "Output frequency, signed", [this] { return drive_.output_hz(); });
  add("process_frequency", "Hz", "Frequency that the ramp goes to, after PI control",
      [this] { return drive_.process_frequency_hz(); });
  add("output_current", "A", "Output current that the drive reports, rms",
      [this] { return drive_.monitor().output_current / 1e4 * model_.rated_current_a; });
  add("output_voltage", "V", "Output voltage that the drive reports, rms between two lines",
      [this] { return drive_.monitor().output_voltage / 1e4 * model_.class_v; });
  add("torque", "%", "Torque that the drive estimates, of the motor's rated",
      [this] { return drive_.monitor().torque / 100.0; });
  add("output_power", "W", "Output power that the drive reports",
      [this] { return drive_.monitor().output_power * 10.0; });
  add("bus_voltage", "V", "Link voltage that the drive measures",
      [this] { return drive_.bus_v(); });
  add("motor_overload", "%", "Motor overload: 100 trips OL2",
      [this] { return drive_.monitor().motor_overload / 100.0; });
  add("inverter_overload", "%", "Inverter overload: 100 trips OL1",
      [this] { return drive_.monitor().inverter_overload / 100.0; });
  add("resistor_overload", "%", "Braking resistor overload: 100 trips OLr",
      [this] { return drive_.monitor().resistor_overload; });
  add("heat_sink", "degC", "Heat sink", [this] { return drive_.heat_sink_degc(); });
  add("run_hours", "h", "Cumulative run time", [this] { return drive_.run_hours(); });
  add("eeprom_writes", "", "Writes into the EEPROM so far",
      [this] { return drive_.memory().eeprom_writes; });
  add("command", "", "Command word FA00", [this] { return drive_.command(); });
  add("alive", "", "The CPU runs: it has power and is not starting",
      [this] { return drive_.alive(); });
  add("tripped", "", "Tripped, or waiting for a retry", [this] { return drive_.tripped(); });
  add("fault_relay", "", "FL relay", [this] { return drive_.fault_relay(); });
  bits("status", "Status word FD01",
       {"fault", "tripped", "alarm", "undervoltage", "motor2", "pi_off", "ramp2", "dc_braking",
        "jog", "reverse", "running", "coast", "emergency", "run_requested", "ready", "bit15"},
       [this] { return drive_.monitor().status; });
  bits("alarms", "Alarms FC91",
       {"over_current", "inverter_overload", "motor_overload", "heat_sink", "over_voltage",
        "under_voltage", "bit6", "low_current", "over_torque", "resistor_overload", "run_hours",
        "communication", "bit12", "bit13", "power_loss_stop", "lower_limit_stop"},
       [this] { return drive_.alarms(); });
  std::vector<std::string_view> trips = {"none"};
  for (const CodeRow& row : kTrips) {
    trips.resize(static_cast<std::size_t>(row.code), "-");
    trips.push_back(row.name);
  }
  registry.add(Signal{"drive0.trip", "", "Present trip FC90",
                      [this] { return static_cast<double>(drive_.trip()); }, std::move(trips)});
}

void Asd7Drive::register_terminals(Registry& registry) {
  const auto pin = [&](std::string_view name, std::string doc, auto&& at) {
    registry.add(Input{.signal = {fmt::format("terminal0.{}", name), "", std::move(doc),
                                  [this, at] {
                                    Terminals pins = drive_.terminals();
                                    return double(at(pins));
                                  }},
                       .minimum = 0,
                       .maximum = 1,
                       .write = [this, at](double value) {
                         Terminals pins = drive_.terminals();
                         at(pins) = value > 0;
                         drive_.set_terminals(pins);
                       }});
  };
  pin("f", "F: run forward", [](Terminals& t) -> bool& { return t.forward; });
  pin("r", "R: run reverse", [](Terminals& t) -> bool& { return t.reverse; });
  pin("st", "ST: standby; without it the motor coasts",
      [](Terminals& t) -> bool& { return t.standby; });
  pin("res", "RES: reset, on its edge", [](Terminals& t) -> bool& { return t.reset; });
  for (std::size_t i = 0; i < 4; ++i) {
    pin(fmt::format("s{}", i + 1), fmt::format("S{}: bit {} of the preset speed", i + 1, i),
        [i](Terminals& t) -> bool& { return t.preset[i]; });
  }
  pin("local", "Takes command and frequency away from the serial line",
      [](Terminals& t) -> bool& { return t.local; });
  const auto analog = [&](std::string_view name, std::string doc, std::uint16_t Terminals::* at) {
    registry.add(Input{.signal = {fmt::format("terminal0.{}", name), "%", std::move(doc),
                                  [this, at] { return drive_.terminals().*at / 100.0; }},
                       .minimum = 0,
                       .maximum = 100,
                       .write = [this, at](double percent) {
                         Terminals pins = drive_.terminals();
                         pins.*at = static_cast<std::uint16_t>(std::lround(percent * 100));
                         drive_.set_terminals(pins);
                       }});
  };
  analog("via", "Analog input VIA", &Terminals::via);
  analog("vib", "Analog input VIB", &Terminals::vib);
}

void Asd7Drive::register_panel(Registry& registry) {
  const auto key = [&](std::string_view name, std::string doc, PanelKey which) {
    const auto at = static_cast<std::size_t>(which);
    registry.add(Input{.signal = {fmt::format("panel0.{}", name), "", std::move(doc),
                                  [this, at] { return double(keys_[at]); }},
                       .minimum = 0,
                       .maximum = 1,
                       .write = [this, at, which](double pressed) {
                         if (pressed > 0 && !keys_[at]) drive_.press(which);
                         keys_[at] = pressed > 0;
                       }});
  };
  key("run", "RUN key; acts as it goes down", PanelKey::kRun);
  key("stop", "STOP key; twice within 1 s is an emergency stop", PanelKey::kStop);
  key("reset", "RESET key", PanelKey::kReset);
  registry.add(Input{.signal = {"panel0.frequency", "Hz", "Frequency set at the panel",
                                [this] { return drive_.panel_frequency() / 100.0; }},
                     .minimum = 0,
                     .maximum = 500,
                     .write = [this](double hz) {
                       const ParameterRow* row = protocol::find(kTable.parameters, 0xFA03);
                       const std::int64_t highest = station_.registers().range(*row).maximum;
                       drive_.set_panel_frequency(static_cast<std::uint16_t>(
                           std::min<std::int64_t>(std::lround(hz * 100), highest)));
                     }});
}

void Asd7Drive::register_faults(Registry& registry) {
  const auto add = [&](std::string name, std::string doc, auto there, auto put) {
    registry.add(Input{
        .signal = {std::move(name), "", std::move(doc), [there] { return there() ? 1.0 : 0.0; }},
        .minimum = 0,
        .maximum = 1,
        .write = [put](double value) { put(value > 0); },
        .fault = true});
  };
  const auto cause = [&](std::string name, std::string doc, Trip trip) {
    add(
        std::move(name), std::move(doc), [this, trip] { return injected_ == trip; },
        [this, trip](bool on) {
          if (!on && injected_ != trip) return;
          injected_ = on ? trip : Trip::kNone;
          drive_.inject(injected_);
        });
  };
  cause("bridge0.earth_fault", "A phase of the motor touches earth: EF2", Trip::kEf2);
  cause("bridge0.arm_shorted", "A device of the bridge is shorted: OCA at the start", Trip::kOca);
  cause("board.ram", "The RAM fails: Err2", Trip::kErr2);
  cause("board.rom", "The ROM fails: Err3", Trip::kErr3);
  cause("board.cpu", "The CPU fails: Err4", Trip::kErr4);
  cause("board.current_detector", "The current detector fails: Err7", Trip::kErr7);
  add(
      "motor0.thermistor", "The motor's thermistor is too hot: OH2",
      [this] { return drive_.terminals().thermistor; },
      [this](bool on) {
        Terminals pins = drive_.terminals();
        pins.thermistor = on;
        drive_.set_terminals(pins);
      });
  const auto eeprom = [&](std::string name, std::string doc, bool EepromFaults::* what) {
    add(
        std::move(name), std::move(doc), [this, what] { return eeprom_.faults.*what; },
        [this, what](bool on) { eeprom_.faults.*what = on; });
  };
  eeprom("eeprom.write_fails", "Nothing can be written into the EEPROM: EEP1 at the next W",
         &EepromFaults::write_fails);
  eeprom("eeprom.read_fails", "The EEPROM cannot be read: EEP2 at the next start",
         &EepromFaults::read_fails);
  eeprom("eeprom.damaged", "The EEPROM's data are damaged: EEP3 at the next start",
         &EepromFaults::damaged);
  registry.add(Input{.signal = {"board.ambient", "degC", "Air around the heat sink",
                                [this] { return drive_.ambient_degc(); }},
                     .minimum = -40,
                     .maximum = 150,
                     .write = [this](double degc) { drive_.set_ambient_degc(degc); }});
}

// An answer may be told to wait for two seconds (F805).
constexpr SimDuration kLongestWait = std::chrono::seconds(3);

// What the catalogue points to, of one size and one protocol.
struct Entry {
  Entry(const Model& its_model, Spoken its_protocol)
      : model(its_model),
        spoken(its_protocol),
        name(name_of(its_model, its_protocol)),
        protocol(its_protocol == Spoken::kModbus ? asd7_modbus::kTable : asd7::kTable),
        table(protocol, factory_of(its_model, its_protocol)) {}

  // The smallest one needs no size.
  static std::string name_of(const Model& model, Spoken spoken) {
    std::string name = "asd7";
    if (&model != &models().front()) name += fmt::format("-{}kw", model.name);
    return spoken == Spoken::kModbus ? name + "-modbus" : name;
  }

  const Model& model;
  Spoken spoken;
  std::string name;
  const ProtocolTable& protocol;
  SizeTable table;
};

}  // namespace

std::vector<DriveKind> asd7_kinds() {
  static const std::vector<std::unique_ptr<const Entry>> entries = [] {
    std::vector<std::unique_ptr<const Entry>> made;
    for (const Spoken spoken : {Spoken::kOwn, Spoken::kModbus}) {
      for (const Model& model : models()) {
        made.push_back(std::make_unique<const Entry>(model, spoken));
      }
    }
    return made;
  }();
  std::vector<DriveKind> kinds;
  for (const auto& entry : entries) {
    kinds.push_back(
        {.name = entry->name,
         .default_motor = entry->model.motor,
         .ports =
             {{.name = "rs485", .baud = kBaud, .duplex = Duplex::kHalf, .parity = Parity::kEven}},
         .channels = 1,
         .default_channel = 0,
         .table = entry->table.table(),
         .protocol = &entry->protocol,
         .make = [entry = entry.get()](const DriveContext& context) -> std::unique_ptr<Drive> {
           return std::make_unique<Asd7Drive>(context, entry->model, entry->spoken);
         },
         .make_host = entry->spoken == Spoken::kModbus ? make_asd7_modbus_host : make_asd7_host,
         .checked_patience = kLongestWait});
    if (entry->spoken == Spoken::kModbus) continue;
    kinds.back().make_dialect = [&table = entry->table] {
      return std::make_unique<WalkDialect>(table.table());
    };
  }
  return kinds;
}

}  // namespace virtdrive
