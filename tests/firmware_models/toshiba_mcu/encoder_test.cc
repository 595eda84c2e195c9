#include "firmware_models/toshiba_mcu/encoder.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

constexpr double kTurn = 2 * std::numbers::pi;

// --- The inputs ----------------------------------------------------------------------------------

TEST(ToshibaMcuEncoderInputs, CountPerTurnWhatTheirKindGives) {
  const auto per_turn = [](EncoderType type) {
    return ShaftSensors{}.edges(type, 10 * kTurn + 1e-9, 4) - ShaftSensors{}.edges(type, 1e-9, 4);
  };
  EXPECT_EQ(per_turn(EncoderType::kHallUvw), 10 * 24);
  EXPECT_EQ(per_turn(EncoderType::kHallUv), 10 * 16);
  EXPECT_EQ(per_turn(EncoderType::kAbz), 10 * 2000);
  EXPECT_EQ(per_turn(EncoderType::kAb), 10 * 2000);
  EXPECT_EQ(per_turn(EncoderType::kSinglePulse), 10);
  EXPECT_EQ(per_turn(EncoderType::kAs5145h), 10 * 4096);
}

TEST(ToshibaMcuEncoderInputs, TwoHallSensorsChangeAtTheirOwnAngles) {
  const auto edges = [](double degrees) {
    return ShaftSensors{}.edges(EncoderType::kHallUv, degrees / 360 * kTurn, 1);
  };
  EXPECT_EQ(edges(119) - edges(1), 0);
  EXPECT_EQ(edges(121) - edges(119), 1) << "V rises";
  EXPECT_EQ(edges(181) - edges(179), 1) << "U falls";
  EXPECT_EQ(edges(299) - edges(181), 0);
  EXPECT_EQ(edges(301) - edges(299), 1) << "V falls";
  EXPECT_EQ(edges(361) - edges(359), 1) << "U rises";
  EXPECT_EQ(edges(1) - edges(-1), 1) << "and so it is below 0";
}

TEST(ToshibaMcuEncoderInputs, CountDownBackwards) {
  for (const EncoderType type : {EncoderType::kHallUvw, EncoderType::kHallUv, EncoderType::kAbz,
                                 EncoderType::kSinglePulse, EncoderType::kAs5145h}) {
    std::int64_t last = ShaftSensors{}.edges(type, 0.1, 4);
    for (double angle = 0.1; angle > -20; angle -= 0.01) {
      const std::int64_t now = ShaftSensors{}.edges(type, angle, 4);
      EXPECT_LE(now, last);
      last = now;
    }
    EXPECT_LT(last, 0);
  }
}

// --- The counter on a running motor --------------------------------------------------------------

class EncoderKind : public testing::TestWithParam<int> {
 protected:
  EncoderKind() { rig_.change(&ChannelSettings::encoder, {GetParam()}); }
  double plant_turns() {
    rig_.speed_rpm();  // brings the axis to now
    return rig_.axis_of().state().angle_rad / kTurn;
  }
  Rig rig_;
};

TEST_P(EncoderKind, CountsTheTurnsThatTheRotorMakes) {
  if (GetParam() == 5) rig_.change(&ChannelSettings::encoder_resolution, {1});
  for (const std::int32_t rpm : {1500, -1500}) {
    rig_.board().set_speed_rpm(rpm);
    rig_.board().start();
    rig_.run_for(2s);
    const std::int32_t from = rig_.board().encoder_count();
    const std::int32_t turns_from = rig_.board().turn_number();
    const double plant_from = plant_turns();
    rig_.run_for(2s);
    const double turns = plant_turns() - plant_from;
    EXPECT_GT(std::abs(turns), 45);
    const double counted = rig_.board().encoder_count() - from;
    EXPECT_NEAR(counted / rig_.channel().encoder().counts_per_turn(), turns, 1.0);
    EXPECT_NEAR(rig_.board().turn_number() - turns_from, turns, 2.0);
    rig_.board().stop();
    rig_.run_to(Stage::kStop);
  }
}

TEST_P(EncoderKind, MeasuresTheSpeedForTheHost) {
  if (GetParam() == 5) rig_.change(&ChannelSettings::encoder_resolution, {1});
  rig_.change(&ChannelSettings::encoder_usage, {1});
  for (const std::int32_t rpm : {2000, -1000}) {
    rig_.board().set_speed_rpm(rpm);
    rig_.board().start();
    rig_.run_for(6s);
    EXPECT_EQ(rig_.channel().stage(), Stage::kFoc);
    EXPECT_NEAR(rig_.speed_rpm(), rpm, 10);
    EXPECT_NEAR(rig_.channel().actual_rpm(), rpm, 30);
    EXPECT_EQ(rig_.channel().errors(), 0U);
    rig_.board().stop();
    rig_.run_to(Stage::kStop);
  }
}

std::string kind_name(const testing::TestParamInfo<int>& kind) {
  constexpr const char* kNames[] = {"None", "HallUvw",     "HallUv", "Abz",
                                    "Ab",   "SinglePulse", "As5145h"};
  return kNames[kind.param];
}

INSTANTIATE_TEST_SUITE_P(ToshibaMcu, EncoderKind, testing::Range(0, 7), kind_name);

TEST(ToshibaMcuEncoder, CountsWhileTheShaftCoastsWithTheDriveOff) {
  Rig rig;
  rig.change(&ChannelSettings::encoder, {3});
  rig.change(&ChannelSettings::shutdown_mode, {0});
  rig.run_up(2000);
  const std::int32_t at_stop = rig.board().encoder_count();
  rig.board().stop();
  rig.run_for(2s);
  EXPECT_EQ(rig.speed_rpm(), 0);
  EXPECT_GT(rig.board().encoder_count(), at_stop + 1000);
}

TEST(ToshibaMcuEncoder, AnotherTypeGoesOnFromTheCountThatWas) {
  Rig rig;
  rig.change(&ChannelSettings::encoder, {3});
  rig.run_up(1000, 3s);
  rig.change(&ChannelSettings::shutdown_mode, {0});
  rig.board().stop();
  rig.run_for(3s);
  const std::int32_t count = rig.board().encoder_count();
  EXPECT_GT(count, 1000);
  rig.change(&ChannelSettings::encoder, {6});
  EXPECT_EQ(rig.board().encoder_count(), count);
}

TEST(ToshibaMcuEncoder, AWrongResolutionFoolsTheDriveAsItWouldOnADesk) {
  Rig rig;
  rig.change(&ChannelSettings::encoder, {3});
  rig.change(&ChannelSettings::encoder_resolution, {1000});
  rig.run_up(1000, 4s);
  const std::int32_t from = rig.board().turn_number();
  const double plant_from = rig.axis_of().state().angle_rad;
  rig.run_for(3s);
  rig.speed_rpm();
  const double turns = (rig.axis_of().state().angle_rad - plant_from) / kTurn;
  EXPECT_NEAR(rig.board().turn_number() - from, 2 * turns, 3);
}

TEST(ToshibaMcuEncoder, ABlockedRotorShowsAtOnceAndIsAStall) {
  Rig rig;
  rig.change(&ChannelSettings::encoder, {1});
  rig.change(&ChannelSettings::encoder_usage, {1});
  rig.change(&ChannelSettings::over_current, {0});
  rig.change(&ChannelSettings::restart_mode, {0});
  rig.run_up(1000, 4s);
  rig.set_brake(1);
  rig.run_for(100ms);
  EXPECT_LT(std::abs(rig.channel().actual_rpm()), 150);
  EXPECT_LE(rig.run_to(Stage::kStop, 1s), 300ms);
  EXPECT_EQ(rig.channel().errors(), bit(Fault::kStall));
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
