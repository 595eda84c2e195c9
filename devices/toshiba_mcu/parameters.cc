#include "devices/toshiba_mcu/parameters.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "devices/protocol/binding.h"
#include "devices/protocol/payload.h"
#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {
namespace {

using protocol::Binding;
using protocol::Refusal;

// What may stand behind a row.
using Setting = UnitValue ChannelSettings::*;
using Text = Name ChannelSettings::*;
using ReadText = const Name& (*)();
using ReadSystem = std::int32_t (*)(Firmware&);
using ReadChannel = std::int32_t (*)(PowerBoard&);
using WriteChannel = void (*)(PowerBoard&, std::int32_t);
using Target = std::variant<Setting, Text, ReadText, ReadSystem, ReadChannel, WriteChannel>;

template <auto Value>
constexpr ReadSystem kConstant = [](Firmware&) -> std::int32_t { return Value; };

constexpr ReadText kBoardName = []() -> const Name& { return kIdentity.board; };
constexpr ReadText kPowerBoardName = []() -> const Name& { return kIdentity.power_board; };

constexpr ReadSystem kResetStatus = [](Firmware& f) { return f.take_reset_status(); };
constexpr ReadSystem kTemperature = [](Firmware& f) {
  return static_cast<std::int32_t>(std::lround(f.board(0).temperature_degc()));
};
constexpr ReadChannel kErrorState = [](PowerBoard& b) {
  return static_cast<std::int32_t>(b.channel().errors());
};
constexpr ReadChannel kDcLinkVoltage = [](PowerBoard& b) {
  return static_cast<std::int32_t>(std::lround(b.bus_v() * 10));
};
constexpr ReadChannel kMotorStage = [](PowerBoard& b) {
  return static_cast<std::int32_t>(b.channel().stage());
};
constexpr ReadSystem kSystemLoad = [](Firmware& f) -> std::int32_t {
  return f.system_load_percent();
};
constexpr ReadChannel kTurnNumber = [](PowerBoard& b) { return b.turn_number(); };
constexpr WriteChannel kSetTorque = [](PowerBoard& b, std::int32_t mnm) { b.set_torque_mnm(mnm); };
constexpr WriteChannel kSetSpeed = [](PowerBoard& b, std::int32_t rpm) { b.set_speed_rpm(rpm); };

using S = ChannelSettings;

constexpr auto kBindings = std::to_array<Binding<Target>>({
    {0x10, &S::pole_pairs},
    {0x11, &S::direction},
    {0x12, &S::max_angular_acceleration},
    {0x13, &S::torque_factor},
    {0x14, &S::resistance},
    {0x15, &S::inductance},
    {0x16, &S::speed_limit},
    {0x17, &S::speed_change},
    {0x18, &S::position_delay},
    {0x19, &S::iq_start},
    {0x1A, &S::id_start},
    {0x1B, &S::iq_limit},
    {0x1C, &S::id_limit},
    {0x1D, &S::motor_id},
    {0x30, &S::encoder},
    {0x31, &S::encoder_usage},
    {0x32, &S::encoder_resolution},
    {0x33, &S::encoder_min_position},
    {0x34, &S::encoder_start_position},
    {0x35, &S::encoder_max_position},
    {0x36, &S::encoder_approach},
    {0x37, &S::encoder_gear_factor},
    {0x40, &S::pi_id_ki},
    {0x41, &S::pi_id_kp},
    {0x42, &S::pi_iq_ki},
    {0x43, &S::pi_iq_kp},
    {0x44, &S::position_ki},
    {0x45, &S::position_kp},
    {0x46, &S::speed_ki},
    {0x47, &S::speed_kp},
    {0x50, &S::pwm_frequency},
    {0x51, &S::shutdown_mode},
    {0x52, &S::brake_time},
    {0x53, &S::brake_percentage},
    {0x54, &S::restart_mode},
    {0x55, &S::stall_detect_value},
    {0x56, &S::over_temperature},
    {0x57, &S::can_id},
    {0x58, &S::external_speed_control},
    {0x59, &S::over_voltage},
    {0x5A, &S::under_voltage},
    {0x5B, &S::over_current},
    {0x5C, &S::speed_reduction},
    {0x70, &S::dead_time},
    {0x71, &S::bootstrap_delay},
    {0x72, &S::current_sensitivity},
    {0x73, &S::voltage_sensitivity},
    {0x74, &S::current_gain},
    {0x75, &S::measurement_type},
    {0x76, &S::sensor_direction},
    {0x77, &S::low_side_polarity},
    {0x78, &S::high_side_polarity},
    {0x90, kConstant<static_cast<std::int32_t>(kIdentity.feature_bits)>},
    {0x91, kConstant<kIdentity.board_revision>},
    {0x92, kConstant<kIdentity.channels>},
    {0x93, kConstant<kIdentity.dso_size>},
    {0x94, kConstant<kIdentity.transfer_count>},
    {0x95, kBoardName},
    {0x96, kPowerBoardName},
    {0x97, kPowerBoardName},
    {0x98, kPowerBoardName},
    {0xB0, kConstant<kVersionWord>},
    {0xB1, kResetStatus},
    {0xB2, kSystemLoad},
    {0xE0, kTemperature},
    {0xE1, kErrorState},
    {0xE2, kDcLinkVoltage},
    {0xE3, kMotorStage},
    {0xE4, kTurnNumber},
    {0xE5, kSetSpeed},
    {0xE6, kSetTorque},
});
static_assert(protocol::covers(kTable.parameters, kBindings),
              "a parameter that is not rejected has nothing behind it, or the reverse");

// Four bytes of a name lie little-endian in a value; bytes beyond its end are 0.
std::int32_t text_at(const Name& name, std::size_t offset) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4 && offset + i < name.size(); ++i) {
    word |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(name[offset + i])) << (8 * i);
  }
  return static_cast<std::int32_t>(word);
}

bool write_text_at(Name& name, std::size_t offset, std::int32_t value) {
  if (offset + 4 > name.size()) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    name[offset + i] = static_cast<char>(static_cast<std::uint32_t>(value) >> (8 * i));
  }
  return true;
}

// Settings that tell of the boards are kept per channel, and asked of the system they are those of
// channel 0 (5.1); writes go to channels.
bool is_board_or_system_setting(std::uint8_t id) {
  return (id >= 0x50 && id <= 0x5C) || (id >= 0x70 && id <= 0x78);
}

constexpr std::uint8_t kSpeedChangeId = 0x17;
constexpr std::uint8_t kDeadtimeId = 0x70;
constexpr std::uint8_t kTorqueId = 0xE6;

// SpeedChange reaches up to one Hz above SpeedLimit, whatever their units (5.1.8).
bool speed_change_fits(const ChannelSettings& settings) {
  const double pole_pairs = settings.pole_pairs.value;
  return electrical_hz(settings.speed_change, pole_pairs) <=
         electrical_hz(settings.speed_limit, pole_pairs) + 1;
}

UnitValue stored_form(const ParameterRow& row, UnitValue value) {
  if (row.units.empty()) value.unit = 0;
  if (row.id == kDeadtimeId) value.value = (value.value + 50) / 100 * 100;  // steps of 100 ns
  return value;
}

// A channel's settings as they lie in the memory: firmware version, then {id, unit, value} of each
// setting and {id, text} of each name, then the CRC of all that.
std::string block_name(std::size_t channel) {
  return fmt::format("channel{}", channel);
}

std::vector<std::uint8_t> to_block(const ChannelSettings& settings) {
  std::vector<std::uint8_t> block = {kIdentity.version_major, kIdentity.version_minor};
  for (const Binding<Target>& binding : kBindings) {
    const auto id = static_cast<std::uint8_t>(binding.id);
    if (const Setting* setting = std::get_if<Setting>(&binding.target)) {
      const UnitValue& value = settings.**setting;
      protocol::pack(kSetEntry, kTable.framing.order, {id, value.unit, value.value}, block);
    } else if (const Text* text = std::get_if<Text>(&binding.target)) {
      block.push_back(id);
      for (const char c : settings.**text) block.push_back(static_cast<std::uint8_t>(c));
    }
  }
  block.push_back(crc8(0, block));
  return block;
}

std::optional<ChannelSettings> from_block(std::span<const std::uint8_t> block) {
  ChannelSettings settings;
  if (block.size() != to_block(settings).size()) return std::nullopt;
  if (block[0] != kIdentity.version_major || block[1] != kIdentity.version_minor ||
      crc8(0, block.first(block.size() - 1)) != block.back()) {
    return std::nullopt;
  }
  block = block.subspan(2);
  for (const Binding<Target>& binding : kBindings) {
    if (const Setting* setting = std::get_if<Setting>(&binding.target)) {
      const auto entry = block.first(protocol::width(kSetEntry));
      const auto values = protocol::unpack(kSetEntry, kTable.framing.order, entry);
      UnitValue& value = settings.**setting;
      value = {static_cast<std::int32_t>(values[2]), static_cast<std::int8_t>(values[1])};
      const ParameterRow* row = protocol::find(kTable.parameters, binding.id);
      if (values[0] != binding.id ||
          protocol::check_write(row, value.value, value.unit) != Refusal::kNone) {
        return std::nullopt;
      }
      block = block.subspan(entry.size());
    } else if (const Text* text = std::get_if<Text>(&binding.target)) {
      Name& name = settings.**text;
      if (block[0] != binding.id) return std::nullopt;
      std::ranges::transform(block.subspan(1, name.size()), name.begin(),
                             [](std::uint8_t byte) { return static_cast<char>(byte); });
      block = block.subspan(1 + name.size());
    }
  }
  return settings;
}

template <class... Visitors>
struct Overload : Visitors... {
  using Visitors::operator()...;
};

}  // namespace

Outcome Parameters::read(std::uint8_t motor_nr, std::uint8_t id, std::uint8_t offset,
                         UnitValue& result) {
  const bool system = motor_nr == kAllMotors;
  if (!system && motor_nr >= firmware_.channels()) return Outcome::kRefused;
  if (protocol::check_read(protocol::find(kTable.parameters, id)) != Refusal::kNone) {
    return Outcome::kRefused;
  }
  const std::size_t channel = system ? 0 : motor_nr;
  const bool of_channel = !system || is_board_or_system_setting(id);
  const auto number = [&](std::int32_t value) {
    result = {value, 0};
    return Outcome::kDone;
  };
  return std::visit(
      Overload{
          [&](Setting setting) {
            if (!of_channel) return Outcome::kRefused;
            result = firmware_.board(channel).channel().settings().*setting;
            return Outcome::kDone;
          },
          [&](Text text) {
            if (!of_channel) return Outcome::kRefused;
            return number(text_at(firmware_.board(channel).channel().settings().*text, offset));
          },
          [&](ReadText text) { return number(text_at(text(), offset)); },
          [&](ReadSystem get) { return number(get(firmware_)); },
          [&](ReadChannel get) {
            return of_channel ? number(get(firmware_.board(channel))) : Outcome::kRefused;
          },
          [](WriteChannel) { return Outcome::kRefused; },
      },
      *protocol::find(kBindings, id));
}

Outcome Parameters::write(std::uint8_t motor_nr, std::uint8_t id, UnitValue value) {
  if (motor_nr >= firmware_.channels()) return Outcome::kRefused;
  const ParameterRow* row = protocol::find(kTable.parameters, id);
  if (protocol::check_write(row, value.value, value.unit) != Refusal::kNone) {
    return Outcome::kRefused;
  }
  PowerBoard& board = firmware_.board(motor_nr);
  ChannelSettings settings = board.channel().settings();
  return std::visit(Overload{
                        [&](Setting setting) {
                          settings.*setting = stored_form(*row, value);
                          if (id == kSpeedChangeId && !speed_change_fits(settings))
                            return Outcome::kRefused;
                          board.set_settings(settings);
                          return Outcome::kDone;
                        },
                        [&](Text text) {
                          const auto offset = static_cast<std::uint8_t>(value.unit);
                          if (!write_text_at(settings.*text, offset, value.value))
                            return Outcome::kRefused;
                          board.set_settings(settings);
                          return Outcome::kDone;
                        },
                        [&](WriteChannel set) {
                          if (id == kTorqueId && value.value > board.channel().torque_limit_mnm()) {
                            return Outcome::kRefused;
                          }
                          set(board, value.value);
                          return Outcome::kDone;
                        },
                        [](auto) { return Outcome::kRefused; },
                    },
                    *protocol::find(kBindings, id));
}

bool Parameters::store(std::size_t channel) {
  return memory_.write(block_name(channel),
                       to_block(firmware_.board(channel).channel().settings()));
}

void Parameters::restore() {
  for (std::size_t channel = 0; channel < firmware_.channels(); ++channel) {
    const auto block = memory_.read(block_name(channel));
    const auto settings = block ? from_block(*block) : std::nullopt;
    firmware_.board(channel).set_settings(settings.value_or(kFactorySettings));
  }
}

}  // namespace virtdrive::toshiba_mcu
