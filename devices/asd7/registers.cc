#include "devices/asd7/registers.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "devices/protocol/binding.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Binding;
using namespace std::chrono_literals;

constexpr std::uint16_t kCmod = 0x0003, kFmod = 0x0004, kTyp = 0x0007, kFh = 0x0011, kUl = 0x0012,
                        kLl = 0x0013, kTimeOut = 0x0803, kTimeOutAction = 0x0804;
constexpr std::uint16_t kCommand = 0xFA00, kFrequency = 0xFA01, kPanelFrequency = 0xFA03,
                        kCommandRs485 = 0xFA04, kFrequencyRs485 = 0xFA05, kCommand2 = 0xFA20;
constexpr std::uint16_t kAlarm = 0, kTrip = 1;  // VF-S15's F804
constexpr SimDuration kInitialiseTime = 1s;     // of tYP (assumed)
constexpr std::int64_t kCpuVersion = 110;       // 1.10 (decided here)
constexpr std::int64_t kTenthsOfSeconds = 2;

// Refused with 0000 while the motor runs. FH is the manuals' own example; the others are recalled.
constexpr std::uint16_t kLockedWhileRunning[] = {kTyp, kFh, 0x0014, 0x0015, 0x0170};

// --- Monitors ------------------------------------------------------------------------------------

using FromMonitor = std::int64_t (*)(const Monitor&);
using FromDrive = std::int64_t (*)(const AcDrive&);

template <auto kMember>
std::int64_t monitored(const Monitor& m) {
  return m.*kMember;
}
template <std::size_t kNumber>
std::int64_t past_trip(const AcDrive& drive) {
  return drive.memory().past_trips[kNumber];
}

// The lower byte of FDxx and FExx.
constexpr auto kMonitors = std::to_array<Binding<FromMonitor>>({
    {0x00, monitored<&Monitor::output_frequency>},
    {0x01, monitored<&Monitor::status>},
    {0x02, monitored<&Monitor::frequency_command>},
    {0x03, monitored<&Monitor::output_current>},
    {0x04, monitored<&Monitor::input_voltage>},
    {0x05, monitored<&Monitor::output_voltage>},
    {0x06, monitored<&Monitor::input_terminals>},
    {0x07, monitored<&Monitor::output_terminals>},
    {0x15, monitored<&Monitor::compensated_frequency>},
    {0x16, monitored<&Monitor::estimated_speed>},
    {0x17, monitored<&Monitor::filtered_speed>},
    {0x18, monitored<&Monitor::torque>},
    {0x19, monitored<&Monitor::torque_command>},
    {0x20, monitored<&Monitor::torque_current>},
    {0x21, monitored<&Monitor::exciting_current>},
    {0x22, monitored<&Monitor::pi_feedback>},
    {0x23, monitored<&Monitor::motor_overload>},
    {0x24, monitored<&Monitor::inverter_overload>},
    {0x25, monitored<&Monitor::resistor_overload>},
    {0x26, monitored<&Monitor::motor_load>},
    {0x27, monitored<&Monitor::inverter_load>},
    {0x29, monitored<&Monitor::input_power>},
    {0x30, monitored<&Monitor::output_power>},
    {0x35, monitored<&Monitor::via>},
    {0x36, monitored<&Monitor::vib>},
    {0x45, monitored<&Monitor::command_source>},
    {0x46, monitored<&Monitor::frequency_source>},
    {0x58, monitored<&Monitor::operating_speed>},
});

constexpr auto kOfDrive = std::to_array<Binding<FromDrive>>({
    {kTyp, [](const AcDrive&) -> std::int64_t { return 0; }},
    {0x0999, [](const AcDrive&) -> std::int64_t { return kTenthsOfSeconds; }},
    {kCommand, [](const AcDrive& d) -> std::int64_t { return d.command(); }},
    {kFrequency, [](const AcDrive& d) -> std::int64_t { return d.frequency(); }},
    {kPanelFrequency, [](const AcDrive& d) -> std::int64_t { return d.panel_frequency(); }},
    {kCommandRs485, [](const AcDrive& d) -> std::int64_t { return d.command(); }},
    {kFrequencyRs485, [](const AcDrive& d) -> std::int64_t { return d.frequency(); }},
    {kCommand2, [](const AcDrive& d) -> std::int64_t { return d.command2(); }},
    {0xFB05, [](const AcDrive& d) -> std::int64_t { return d.model().capacity_code; }},
    {0xFC90, [](const AcDrive& d) { return static_cast<std::int64_t>(d.trip()); }},
    {0xFC91, [](const AcDrive& d) -> std::int64_t { return d.alarms(); }},
    {0xFE08, [](const AcDrive&) { return kCpuVersion; }},
    {0xFE10, past_trip<0>},
    {0xFE11, past_trip<1>},
    {0xFE12, past_trip<2>},
    {0xFE13, past_trip<3>},
    {0xFE14, [](const AcDrive& d) -> std::int64_t { return d.run_hours(); }},
    {0xFE70,
     [](const AcDrive& d) -> std::int64_t { return std::lround(d.model().rated_current_a * 10); }},
    {0xFE71, [](const AcDrive& d) -> std::int64_t { return std::lround(d.model().supply_v * 10); }},
    {0xFE73, [](const AcDrive&) { return kCpuVersion; }},
    {0xFE76, [](const AcDrive& d) { return static_cast<std::int64_t>(d.memory().input_kwh); }},
    {0xFE77, [](const AcDrive& d) { return static_cast<std::int64_t>(d.memory().output_kwh); }},
});

constexpr bool is_monitor(std::uint16_t number) {
  return number >= 0xFD00 && protocol::find(kOfDrive, number) == nullptr;
}

// A row that claims support has something behind it.
consteval bool each_row_is_bound() {
  for (const ParameterRow& row : kParameters) {
    if (row.support == Support::kRejected) continue;
    const bool kept = row.access == Access::kReadWrite && row.id < kCommand && row.id != kTyp;
    const bool monitor =
        is_monitor(row.id) &&
        protocol::find(kMonitors, static_cast<std::uint16_t>(row.id & 0xFF)) != nullptr;
    if (!kept && !monitor && protocol::find(kOfDrive, row.id) == nullptr) return false;
  }
  return true;
}
static_assert(each_row_is_bound());

bool is_locked(std::uint16_t number, const Settings& settings) {
  if (settings.command_lock != 0 && (number == kCmod || number == kFmod)) return true;
  return std::ranges::find(kLockedWhileRunning, number) != std::end(kLockedWhileRunning);
}

bool is_preset(std::uint16_t number) {
  return (number >= 0x0018 && number <= 0x0024) || (number >= 0x0287 && number <= 0x0294);
}

}  // namespace

Registers::Registers(const EventLoop& loop, AcDrive& drive, Eeprom& eeprom, const Profile& profile)
    : loop_(loop), drive_(drive), eeprom_(eeprom), profile_(profile), ram_(eeprom.parameters()) {}

void Registers::restore() {
  initialised_ = loop_.now();
  ram_ = eeprom_.parameters();
  hand_over();
}

void Registers::hand_over() {
  Settings settings = ram_.settings;
  if (profile_.time_out_actions == TimeOutActions::kMatrix) {
    settings.time_out_action = settings.time_out_action % 3 == 2 ? kTrip : kAlarm;
  }
  drive_.set_settings(settings);
}

// P9's matrix has none, alarm and trip for each of its two ports; this one is taken to count in the
// lower place.
bool Registers::minds_time_out() const {
  return profile_.time_out_actions == TimeOutActions::kThree ||
         ram_.settings.time_out_action % 3 != 0;
}

// --- Reading -------------------------------------------------------------------------------------

Registers::Answer Registers::read(std::uint16_t number) const {
  const ParameterRow* row = protocol::find(kTable.parameters, number);
  if (protocol::check_read(row) != protocol::Refusal::kNone) return {.error = Error::kNumber};
  Parameters ram = ram_;
  if (const std::uint16_t* place = place_of(ram, number)) return {.value = *place};
  if (const FromDrive* from = protocol::find(kOfDrive, number)) return {.value = (*from)(drive_)};
  return {.value = monitor_value(number)};
}

std::int64_t Registers::monitor_value(std::uint16_t number) const {
  const auto which = static_cast<std::uint16_t>(number & 0xFF);
  const bool held = number >= 0xFE00 && which < 0x35;
  const Monitor monitor = held ? drive_.frozen() : drive_.monitor();
  const std::int64_t value = (*protocol::find(kMonitors, which))(monitor);
  if (which == 0x00 || which == 0x02) {
    return profile_.signed_frequency && monitor.reverse ? -value : value;
  }
  return which == 0x01 ? status(monitor.status) : value;
}

std::int64_t Registers::status(std::uint16_t bits) const {
  if (!profile_.bit14_faulted) return bits;
  const bool faulted = (bits & kStatusTripped) != 0;
  return faulted ? bits | kStatusReady : bits & ~kStatusReady;
}

// --- Writing -------------------------------------------------------------------------------------

Range Registers::range(const ParameterRow& row) const {
  const Settings& s = ram_.settings;
  Range range = row.range;
  if (row.id == kUl || row.id == kFrequency || row.id == kFrequencyRs485) {
    range.maximum = s.maximum_frequency;
  } else if (row.id == kLl || row.id == kPanelFrequency) {
    range.maximum = s.upper_limit;
  } else if (is_preset(row.id)) {
    range.maximum = s.upper_limit;  // LL is kept to while it runs
  } else if (row.id == kTimeOut && profile_.time_out_unit < 1s) {
    range.maximum = 1000;  // VF-S15: 100.0 s
  } else if (row.id == kTimeOutAction && profile_.time_out_actions == TimeOutActions::kThree) {
    range.maximum = 2;
  }
  return range;
}

std::optional<Error> Registers::check(const ParameterRow& row, std::int64_t value) const {
  if (row.support == Support::kRejected) return Error::kNumber;
  if (row.access == Access::kReadOnly) return Error::kCannotExecute;
  if (!range(row).contains(value)) return Error::kRange;
  if (row.id == kTyp && value == 2) return Error::kRange;
  if (row.id >= kCommand) return std::nullopt;
  if (initialising()) return Error::kCannotExecute;
  if (drive_.running() && is_locked(row.id, ram_.settings)) return Error::kCannotExecute;
  return std::nullopt;
}

Registers::Answer Registers::write(std::uint16_t number, std::int64_t value, Keep keep) {
  const ParameterRow* row = protocol::find(kTable.parameters, number);
  if (row == nullptr) return {.error = Error::kNumber};
  if (const auto error = check(*row, value)) return {.error = error};
  if (number == kTyp) return initialise(value);
  return number >= kCommand ? write_volatile(*row, value) : write_parameter(*row, value, keep);
}

Registers::Answer Registers::write_parameter(const ParameterRow& row, std::int64_t value,
                                             Keep keep) {
  if (keep == Keep::kEeprom) {
    Parameters image = eeprom_.parameters();
    *place_of(image, row.id) = static_cast<std::uint16_t>(value);
    if (!eeprom_.write(image)) {
      drive_.eeprom_failed(Trip::kEep1);
      return {.error = Error::kCannotExecute};
    }
    drive_.count_eeprom_write();
  }
  *place_of(ram_, row.id) = static_cast<std::uint16_t>(value);
  hand_over();
  return {.value = value, .stored = keep == Keep::kEeprom};
}

Registers::Answer Registers::write_volatile(const ParameterRow& row, std::int64_t value) {
  const auto word = static_cast<std::uint16_t>(value);
  Answer answer{.value = value};
  if (row.id == kCommand || row.id == kCommandRs485) {
    answer.silent = drive_.set_command(word) != AcDrive::CommandResult::kTaken;
  } else if (row.id == kFrequency || row.id == kFrequencyRs485) {
    drive_.set_frequency(word);
  } else if (row.id == kPanelFrequency) {
    drive_.set_panel_frequency(word);
  } else {
    drive_.set_command2(word);
  }
  return answer;
}

Registers::Answer Registers::initialise(std::int64_t how) {
  if (how == 0) return {.value = how};
  if (!eeprom_.write(eeprom_.factory())) {
    drive_.eeprom_failed(Trip::kEep1);
    return {.error = Error::kCannotExecute};
  }
  drive_.count_eeprom_write();
  drive_.set_command(0);
  drive_.set_frequency(0);
  restore();
  initialised_ = loop_.now() + kInitialiseTime;
  return {.value = how, .stored = true};
}

}  // namespace virtdrive::asd7
