#include "devices/asd7/eeprom.h"

#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "devices/asd7/table.h"
#include "devices/protocol/binding.h"
#include "devices/protocol/payload.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Binding;
using Place = std::uint16_t& (*)(Parameters&);
using S = Settings;

template <std::uint16_t S::* kMember>
std::uint16_t& of(Parameters& p) {
  return p.settings.*kMember;
}
template <std::size_t kNumber>
std::uint16_t& preset(Parameters& p) {
  return p.settings.preset_speeds[kNumber - 1];
}
template <std::size_t kJump, std::uint16_t SpeedJump::* kMember>
std::uint16_t& jump(Parameters& p) {
  return p.settings.jumps[kJump].*kMember;
}
template <std::size_t kRow>
std::uint16_t& stored(Parameters& p) {
  return p.stored[kRow];
}

// clang-format off
constexpr auto kPlaces = std::to_array<Binding<Place>>({
    {0x0000, of<&S::auto_acceleration>}, {0x0001, stored<0>},
    {0x0003, of<&S::command_source>}, {0x0004, of<&S::frequency_source>},
    {0x0005, stored<1>}, {0x0006, stored<2>},
    {0x0008, of<&S::panel_reverse>}, {0x0009, of<&S::acceleration1>}, {0x0010, of<&S::deceleration1>},
    {0x0011, of<&S::maximum_frequency>}, {0x0012, of<&S::upper_limit>}, {0x0013, of<&S::lower_limit>},
    {0x0014, of<&S::base_frequency1>}, {0x0015, of<&S::volts_per_hertz>},
    {0x0016, of<&S::torque_boost1>}, {0x0017, of<&S::motor_guard>},
    {0x0018, preset<1>}, {0x0019, preset<2>}, {0x0020, preset<3>}, {0x0021, preset<4>},
    {0x0022, preset<5>}, {0x0023, preset<6>}, {0x0024, preset<7>},
    {0x0170, of<&S::base_frequency2>}, {0x0172, of<&S::torque_boost2>},
    {0x0173, of<&S::motor_protection2>}, {0x0185, of<&S::stall_level2>},
    {0x0200, of<&S::source_switch>},
    {0x0201, of<&S::via_point1>}, {0x0202, of<&S::via_frequency1>},
    {0x0203, of<&S::via_point2>}, {0x0204, of<&S::via_frequency2>},
    {0x0207, of<&S::frequency_source2>},
    {0x0210, of<&S::vib_point1>}, {0x0211, of<&S::vib_frequency1>},
    {0x0212, of<&S::vib_point2>}, {0x0213, of<&S::vib_frequency2>},
    {0x0240, of<&S::start_frequency>}, {0x0250, of<&S::dc_brake_frequency>},
    {0x0251, of<&S::dc_brake_current>}, {0x0252, of<&S::dc_brake_time>},
    {0x0256, of<&S::lower_limit_stop>}, {0x0260, of<&S::jog_frequency>},
    {0x0270, jump<0, &SpeedJump::frequency>}, {0x0271, jump<0, &SpeedJump::width>},
    {0x0272, jump<1, &SpeedJump::frequency>}, {0x0273, jump<1, &SpeedJump::width>},
    {0x0274, jump<2, &SpeedJump::frequency>}, {0x0275, jump<2, &SpeedJump::width>},
    {0x0287, preset<8>}, {0x0288, preset<9>}, {0x0289, preset<10>}, {0x0290, preset<11>},
    {0x0291, preset<12>}, {0x0292, preset<13>}, {0x0293, preset<14>}, {0x0294, preset<15>},
    {0x0300, of<&S::carrier>}, {0x0301, of<&S::flying_start>}, {0x0302, of<&S::ride_through>},
    {0x0303, of<&S::retries>}, {0x0304, of<&S::braking_resistor>}, {0x0305, of<&S::overvoltage_limit>},
    {0x0307, of<&S::supply_correction>}, {0x0308, of<&S::resistor_ohm>}, {0x0309, of<&S::resistor_power>},
    {0x0360, of<&S::pi_control>}, {0x0361, of<&S::pi_filter>},
    {0x0362, of<&S::pi_proportional>}, {0x0363, of<&S::pi_integral>},
    {0x0401, of<&S::slip_gain>}, {0x0402, of<&S::boost_gain>}, {0x0415, of<&S::rated_current>},
    {0x0416, of<&S::no_load_current>}, {0x0417, of<&S::rated_rpm>},
    {0x0500, of<&S::acceleration2>}, {0x0501, of<&S::deceleration2>},
    {0x0502, of<&S::ramp_shape1>}, {0x0503, of<&S::ramp_shape2>}, {0x0505, of<&S::ramp_switch>},
    {0x0506, of<&S::s_lower>}, {0x0507, of<&S::s_upper>},
    {0x0600, of<&S::motor_protection1>}, {0x0601, of<&S::stall_level1>}, {0x0602, of<&S::keep_trip>},
    {0x0603, of<&S::emergency_stop>}, {0x0604, of<&S::emergency_brake_time>},
    {0x0605, of<&S::output_phase_guard>}, {0x0606, of<&S::derating_frequency>},
    {0x0607, of<&S::motor_overload_time>}, {0x0608, of<&S::input_phase_guard>},
    {0x0610, of<&S::low_current_trip>}, {0x0611, of<&S::low_current>}, {0x0612, of<&S::low_current_time>},
    {0x0615, of<&S::over_torque_trip>}, {0x0616, of<&S::over_torque>}, {0x0618, of<&S::over_torque_time>},
    {0x0621, of<&S::run_hours_alarm>}, {0x0627, of<&S::undervoltage_trip>},
    {0x0736, of<&S::command_lock>},
    {0x0800, of<&S::baud>}, {0x0801, of<&S::parity>}, {0x0802, of<&S::number>},
    {0x0803, of<&S::time_out>}, {0x0804, of<&S::time_out_action>}, {0x0805, of<&S::wait_time>},
    {0x0806, of<&S::inter_drive>},
    {0x0811, of<&S::point1>}, {0x0812, of<&S::point1_frequency>},
    {0x0813, of<&S::point2>}, {0x0814, of<&S::point2_frequency>}, {0x0880, of<&S::note>},
});
// clang-format on

constexpr std::uint16_t kTyp = 0x0007;
constexpr std::uint16_t kFirstVolatile = 0xFA00;

// Every row that a host may write and that is kept has a place, and no other.
consteval bool each_row_has_its_place() {
  std::size_t at = 0;
  for (const ParameterRow& row : kParameters) {
    const bool kept = row.access == Access::kReadWrite && row.support != Support::kRejected &&
                      row.id != kTyp && row.id < kFirstVolatile;
    if (!kept) continue;
    if (at == kPlaces.size() || kPlaces[at++].id != row.id) return false;
  }
  return at == kPlaces.size();
}
static_assert(each_row_has_its_place());

// --- The image -----------------------------------------------------------------------------------

constexpr std::string_view kParameterBlock = "parameters";
constexpr std::string_view kMemoryBlock = "memory";
constexpr auto kOrder = protocol::ByteOrder::kBigEndian;

void put(std::vector<std::uint8_t>& out, WireType type, std::int64_t value) {
  out.resize(out.size() + protocol::width(type));
  protocol::store(std::span(out).last(protocol::width(type)), type, kOrder, value);
}

std::int64_t take(std::span<const std::uint8_t>& bytes, WireType type) {
  const std::int64_t value = protocol::load(bytes.first(protocol::width(type)), type, kOrder);
  bytes = bytes.subspan(protocol::width(type));
  return value;
}

// Number and value, pair by pair.
std::vector<std::uint8_t> image_of(Parameters parameters) {
  std::vector<std::uint8_t> image;
  for (const auto& place : kPlaces) {
    put(image, WireType::kU16, place.id);
    put(image, WireType::kU16, place.target(parameters));
  }
  return image;
}

// False if anything in the image is not as a drive leaves it.
bool read_image(std::span<const std::uint8_t> image, Parameters& parameters) {
  if (image.size() != 4 * kPlaces.size()) return false;
  for (const auto& place : kPlaces) {
    const auto number = static_cast<std::uint16_t>(take(image, WireType::kU16));
    const std::int64_t value = take(image, WireType::kU16);
    const ParameterRow* row = protocol::find(kTable.parameters, number);
    if (number != place.id || !row->range.contains(value)) return false;
    place.target(parameters) = static_cast<std::uint16_t>(value);
  }
  return true;
}

constexpr double kKilowattHour = 1000;  // kept to a watt-hour

std::vector<std::uint8_t> image_of(const Memory& kept) {
  std::vector<std::uint8_t> image(kept.past_trips.begin(), kept.past_trips.end());
  put(image, WireType::kU8, kept.kept_trip);
  put(image, WireType::kU32, static_cast<std::int64_t>(kept.run_seconds & 0xFFFFFFFF));
  put(image, WireType::kU32, static_cast<std::int64_t>(kept.input_kwh * kKilowattHour));
  put(image, WireType::kU32, static_cast<std::int64_t>(kept.output_kwh * kKilowattHour));
  put(image, WireType::kU32, kept.eeprom_writes);
  return image;
}

bool read_image(std::span<const std::uint8_t> image, Memory& kept) {
  if (image.size() != kept.past_trips.size() + 1 + 4 * 4) return false;
  for (std::uint8_t& trip : kept.past_trips) {
    trip = static_cast<std::uint8_t>(take(image, WireType::kU8));
  }
  kept.kept_trip = static_cast<std::uint8_t>(take(image, WireType::kU8));
  kept.run_seconds = static_cast<std::uint64_t>(take(image, WireType::kU32));
  kept.input_kwh = static_cast<double>(take(image, WireType::kU32)) / kKilowattHour;
  kept.output_kwh = static_cast<double>(take(image, WireType::kU32)) / kKilowattHour;
  kept.eeprom_writes = static_cast<std::uint32_t>(take(image, WireType::kU32));
  return true;
}

}  // namespace

Parameters factory_parameters(const Model& model) {
  return {.settings = default_settings(model)};
}

std::uint16_t* place_of(Parameters& parameters, std::uint16_t number) {
  const Place* place = protocol::find(kPlaces, number);
  return place == nullptr ? nullptr : &(*place)(parameters);
}

Eeprom::Eeprom(NonVolatileMemory& memory, const Parameters& factory)
    : memory_(memory), factory_(factory) {
  load();
}

Trip Eeprom::load() {
  parameters_ = factory_;
  if (faults.read_fails) return Trip::kEep2;
  Memory kept;
  if (const auto image = memory_.read(kMemoryBlock); image && read_image(*image, kept)) {
    kept_ = kept;
  }
  const auto image = memory_.read(kParameterBlock);
  if (!image && !faults.damaged) return Trip::kNone;  // as it left the factory
  Parameters read;
  if (faults.damaged || !read_image(*image, read)) return Trip::kEep3;
  parameters_ = read;
  return Trip::kNone;
}

bool Eeprom::write(const Parameters& parameters) {
  if (faults.write_fails || !memory_.write(kParameterBlock, image_of(parameters))) return false;
  parameters_ = parameters;
  return true;
}

bool Eeprom::keep(const Memory& kept) {
  if (faults.write_fails || !memory_.write(kMemoryBlock, image_of(kept))) return false;
  kept_ = kept;
  return true;
}

}  // namespace virtdrive::asd7
