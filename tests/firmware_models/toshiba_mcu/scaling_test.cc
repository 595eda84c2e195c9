#include "firmware_models/toshiba_mcu/scaling.h"

#include <gtest/gtest.h>
#include <numbers>

namespace virtdrive::toshiba_mcu {
namespace {

TEST(ToshibaMcuScaling, FullScalesFollowTheSenseAmplifiers) {
  const Scaling c = scale(kFactorySettings);
  EXPECT_NEAR(c.full_scale_a, 7.911, 0.001);  // 2.5 V at 316 mV/A
  EXPECT_EQ(c.full_scale_v, 54);              // 5 V at 91 mV/V, whole volts
  EXPECT_EQ(c.full_scale_hz, 420);            // 350 Hz and a fifth
}

TEST(ToshibaMcuScaling, CurrentGainsAreRegistersOfVoltsPerAmpere) {
  const Scaling c = scale(kFactorySettings);
  EXPECT_NEAR(c.iq_kp, 0.0104, 0.0001);  // V/A for raw 50
  EXPECT_NEAR(c.iq_ki * 12500, 521, 1);  // V/As for raw 200
}

TEST(ToshibaMcuScaling, AccelerationUnits) {
  const auto hz_per_s = [](std::int32_t value, std::int8_t unit) {
    ChannelSettings s = kFactorySettings;
    s.max_angular_acceleration = {value, unit};
    return scale(s).acceleration_hz_per_s;
  };
  EXPECT_DOUBLE_EQ(hz_per_s(300, 0), 300 / (2 * std::numbers::pi));
  EXPECT_DOUBLE_EQ(hz_per_s(300, 1), 300);
  EXPECT_DOUBLE_EQ(hz_per_s(300, 2), 20);  // rpm/s at 4 pole pairs
  EXPECT_DOUBLE_EQ(hz_per_s(3600, 3), 4);  // rpm/min
}

TEST(ToshibaMcuScaling, DecimalUnitsGiveTheSameQuantity) {
  ChannelSettings s = kFactorySettings;
  s.resistance = {750'000, -6};
  s.iq_start = {1, 0};
  EXPECT_NEAR(scale(s).resistance_ohm, 0.75, 1e-12);
  EXPECT_NEAR(scale(s).iq_start_a, 1, 1e-12);
  s.iq_start = {2000, -3};  // above IqLimit: limited, not refused
  EXPECT_NEAR(scale(s).iq_start_a, 1.85, 1e-12);
}

TEST(ToshibaMcuScaling, SpeedInRpmIsMechanical) {
  EXPECT_DOUBLE_EQ(electrical_hz({2000, 1}, 4), 2000 * 4 / 60.0);
  EXPECT_DOUBLE_EQ(electrical_hz({350, 0}, 4), 350);
}

TEST(ToshibaMcuScaling, ZeroesInTheSettingsDivideNothing) {
  ChannelSettings s = kFactorySettings;
  s.current_sensitivity.value = s.voltage_sensitivity.value = s.pwm_frequency.value = 0;
  const Scaling c = scale(s);
  EXPECT_EQ(c.pwm_period, SimDuration{});
  EXPECT_EQ(c.current_a_per_count, 0);
  EXPECT_EQ(c.iq_kp, 0);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
