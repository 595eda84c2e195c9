// The parameters of one motor channel as the firmware keeps them: wire value and unit code side by
// side, returned as they were written. The initialisers are the factory image: the preset of the
// Nanotec DB42S03, the motor of the protocol document's own example (5 V sense amplifiers, 24 V
// board).
//
// Numbers: MCU Motor Studio protocol 3.10, sections 4.2.12 and 5.1; where the document gives none,
// the maker's published firmware 1.x. The parameter table (devices/toshiba_mcu/table.h) has range,
// unit codes and source of each.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>

namespace virtdrive::toshiba_mcu {

struct UnitValue {
  std::int32_t value = 0;
  std::int8_t unit = 0;
  friend constexpr bool operator==(const UnitValue&, const UnitValue&) = default;
};

using Name = std::array<char, 20>;

struct ChannelSettings {
  // The motor.
  UnitValue pole_pairs{4};
  UnitValue direction{2};
  UnitValue max_angular_acceleration{300};
  UnitValue torque_factor{34, -3};
  UnitValue resistance{750, -3};
  UnitValue inductance{1050, -6};
  UnitValue speed_limit{350};
  UnitValue speed_change{25};
  UnitValue position_delay{200};
  UnitValue iq_start{1000, -3};
  UnitValue id_start{1400, -3};
  UnitValue iq_limit{1850, -3};
  UnitValue id_limit{1700, -3};
  Name motor_id{"Nanotec DB42S03"};

  // The encoder.
  UnitValue encoder{0};
  UnitValue encoder_usage{0};
  UnitValue encoder_resolution{2000};
  UnitValue encoder_min_position{0};
  UnitValue encoder_start_position{0};
  UnitValue encoder_max_position{-1};  // 0xFFFFFFFF: the field is unsigned, the wire's i32 is not
  UnitValue encoder_approach{30};
  UnitValue encoder_gear_factor{1};

  // The controllers.
  UnitValue pi_id_ki{200};
  UnitValue pi_id_kp{50};
  UnitValue pi_iq_ki{200};
  UnitValue pi_iq_kp{50};
  UnitValue position_ki{0};
  UnitValue position_kp{15};
  UnitValue speed_ki{200};
  UnitValue speed_kp{20};

  // The system.
  UnitValue pwm_frequency{12500};
  UnitValue shutdown_mode{2};
  UnitValue brake_time{2};
  UnitValue brake_percentage{100};
  UnitValue restart_mode{1};
  UnitValue stall_detect_value{600};
  UnitValue over_temperature{90};
  UnitValue can_id{0};
  UnitValue external_speed_control{0};
  UnitValue over_voltage{26};
  UnitValue under_voltage{18};
  UnitValue over_current{3000};
  UnitValue speed_reduction{95};

  // The power board.
  UnitValue dead_time{400};
  UnitValue bootstrap_delay{10};
  UnitValue current_sensitivity{316, -3};
  UnitValue voltage_sensitivity{91, -3};
  UnitValue current_gain{0};
  UnitValue measurement_type{3};
  UnitValue sensor_direction{0};
  UnitValue low_side_polarity{1};
  UnitValue high_side_polarity{1};
};

inline constexpr ChannelSettings kFactorySettings{};

/// Bits of FirmwareFeatures (5.1.53).
enum class Feature : std::uint8_t {
  kDso = 0,
  kLoadStatistic = 1,
  kTurnControl = 2,
  kTemperatureControl = 3,
  kHsDso = 4,
  kWritableBoardSettings = 5,
  kExternalSpeedControl = 6,
  kSoftwareVoltageDetection = 7,
  kMotorDisconnectDetection = 8,
  kSoftwareOvercurrentDetection = 9,
  kLoadDependentSpeedReduction = 10,
  kCan = 11,
  kStallDetect = 12,
  kMotionControl = 13,
  kDcLinkVoltage = 14,
  kMotorStage = 15,
  kDemo = 16,
  kTorqueControl = 17,
};

constexpr std::uint32_t features(std::initializer_list<Feature> list) {
  std::uint32_t bits = 0;
  for (const Feature feature : list) bits |= 1U << static_cast<unsigned>(feature);
  return bits;
}

/// What the image and its boards tell of themselves.
struct Identity {
  std::uint32_t feature_bits = features(
      {Feature::kDso, Feature::kLoadStatistic, Feature::kTurnControl, Feature::kTemperatureControl,
       Feature::kHsDso, Feature::kWritableBoardSettings, Feature::kExternalSpeedControl,
       Feature::kSoftwareVoltageDetection, Feature::kMotorDisconnectDetection,
       Feature::kSoftwareOvercurrentDetection, Feature::kLoadDependentSpeedReduction,
       Feature::kStallDetect, Feature::kMotionControl, Feature::kDcLinkVoltage,
       Feature::kMotorStage, Feature::kDemo, Feature::kTorqueControl});
  std::uint8_t board_revision = 1;
  std::uint8_t channels = 0x07;
  std::uint16_t dso_size = 320;  // int16 values
  std::uint8_t transfer_count = 8;
  Name board{"SIM-M4K"};
  Name power_board{"SIM-PWR"};
  std::uint8_t version_major = 3;
  std::uint8_t version_minor = 10;
};

inline constexpr Identity kIdentity{};

}  // namespace virtdrive::toshiba_mcu
