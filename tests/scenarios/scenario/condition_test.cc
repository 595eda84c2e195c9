#include "scenarios/scenario/condition.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

class ConditionTest : public testing::Test {
 protected:
  ConditionTest() {
    registry_.add(Signal{"motor1.speed", "rpm", "", [this] { return speed; }});
    registry_.add(Signal{"bus1.voltage", "V", "", [this] { return volts; }});
    registry_.add(
        Signal{"drive1.stage", "", "", [this] { return stage; }, {"Stop", "Force", "FOC"}});
    registry_.add(
        Signal{"drive1.errors", "", "", [this] { return errors; }, {"Hot", "Stall"}, true});
  }

  bool met(std::string_view text) {
    return LiveCondition(parse_condition(text, registry_), registry_).met();
  }
  LiveCondition live(std::string_view text) {
    return {parse_condition(text, registry_), registry_};
  }
  std::pair<std::size_t, std::string> error(std::string_view text) {
    try {
      parse_condition(text, registry_);
    } catch (const LanguageError& error) {
      return {error.at(), error.what()};
    }
    return {0, "accepted"};
  }

  double speed = 1000, volts = 24, stage = 2, errors = 2;
  Registry registry_;
};

TEST_F(ConditionTest, ComparesInAnyUnitOfTheSameKind) {
  EXPECT_TRUE(met("motor1.speed > 999 rpm"));
  EXPECT_FALSE(met("motor1.speed > 1000 rpm"));
  EXPECT_TRUE(met("motor1.speed >= 1000 rpm"));
  EXPECT_TRUE(met("motor1.speed<1001rpm"));
  EXPECT_TRUE(met("motor1.speed above 104 rad/s"));
  EXPECT_FALSE(met("motor1.speed above 105 rad/s"));
  EXPECT_TRUE(met("bus1.voltage = 24000 mV"));
  EXPECT_TRUE(met("bus1.voltage != 23 V"));
}

TEST_F(ConditionTest, ATolerenceIsAValueOrAShare) {
  speed = 1020;
  EXPECT_TRUE(met("motor1.speed = 1000 rpm +- 20 rpm"));
  EXPECT_TRUE(met("motor1.speed = 1000 rpm +- 2 %"));
  EXPECT_FALSE(met("motor1.speed = 1000 rpm +- 1.9 %"));
  EXPECT_TRUE(met("motor1.speed != 1000 rpm +- 10 rpm"));
  speed = -1020;
  EXPECT_TRUE(met("motor1.speed = -1000 rpm +- 2 %"));
  EXPECT_TRUE(met("abs(motor1.speed) = 1000 rpm +- 2 %"));
}

TEST_F(ConditionTest, RangesStatesAndBits) {
  EXPECT_TRUE(met("bus1.voltage in 24 V ... 25 V"));
  EXPECT_FALSE(met("bus1.voltage in 24.1 V ... 25 V"));
  EXPECT_TRUE(met("drive1.stage is FOC"));
  EXPECT_TRUE(met("drive1.stage is not Stop"));
  EXPECT_TRUE(met("drive1.stage = 2"));
  EXPECT_TRUE(met("drive1.errors has Stall"));
  EXPECT_TRUE(met("drive1.errors has not Hot"));
  EXPECT_TRUE(met("drive1.errors is Stall"));
  errors = 3;
  EXPECT_FALSE(met("drive1.errors is Stall"));
}

TEST_F(ConditionTest, AndBindsStrongerThanOr) {
  EXPECT_TRUE(met("drive1.stage is FOC and motor1.speed > 1 rpm or bus1.voltage > 99 V"));
  EXPECT_TRUE(met("bus1.voltage > 99 V or drive1.stage is FOC and motor1.speed > 1 rpm"));
  EXPECT_FALSE(met("drive1.stage is FOC and motor1.speed < 1 rpm or bus1.voltage > 99 V"));
}

TEST_F(ConditionTest, SaysWhatItSawAndHowFarOff) {
  const LiveCondition condition = live("motor1.speed = 1200 rpm +- 5 % and drive1.stage is FOC");
  EXPECT_EQ(condition.values(), "motor1.speed 1000 rpm, drive1.stage FOC (2)");
  EXPECT_EQ(condition.shortfall(), "140 rpm too low");
  EXPECT_EQ(live("bus1.voltage < 20 V").shortfall(), "4 V too high");
  EXPECT_EQ(live("drive1.stage is Stop").shortfall(), "");
  EXPECT_EQ(live("drive1.errors = 0").values(), "drive1.errors Stall (2)");
  stage = 7;
  EXPECT_EQ(live("drive1.stage is FOC").values(), "drive1.stage 7");
}

TEST_F(ConditionTest, AnErrorHasItsPlaceInTheText) {
  using Error = std::pair<std::size_t, std::string>;
  EXPECT_EQ(error("motor1.speed > 1 V").first, 15U);
  EXPECT_EQ(error("motor1.speed > 1"), Error(15, "'1' needs a unit: rpm or rad/s"));
  EXPECT_EQ(error("bus1.voltage > 1 V and motor1.sped > 1 rpm").first, 23U);
  EXPECT_EQ(error("").second, "expected a condition: SIGNAL > VALUE");
}

}  // namespace
}  // namespace virtdrive
