#include "scenarios/scenario/player.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenarios/scenario/loader.h"

namespace virtdrive {
namespace {

ScenarioResult play_steps(const std::string& steps, const std::string& bench = "") {
  const std::string text = fmt::format(
      "virtdrive-scenario: 1\nbench:\n  drive: toshiba-mcu\n  load: {{inertia: 100 gcm2}}\n"
      "  set: {{MaxAngAcc: 1500}}\n{}steps:\n{}",
      bench, steps);
  return play(parse_scenario("test.yaml", text), 1);
}

std::string failure_of(const std::string& steps) {
  const ScenarioResult result = play_steps(steps);
  return result.failure ? one_line(*result.failure) : "passed";
}

constexpr const char* kRunning = R"(
  - start: 1500 rpm
  - wait: drive1.stage is FOC and motor1.speed > 1450 rpm
    within: 4 s
)";

TEST(Player, AHostRunsTheMotorAndTheBenchIsJudged) {
  const ScenarioResult result = play_steps(std::string(kRunning) + R"(
  - expect: motor1.speed = 1500 rpm +- 2 %
    within: 1 s
    for: 500 ms
  - stop
)");
  EXPECT_TRUE(result.passed()) << explain(result);
  EXPECT_EQ(result.steps.first().size(), 4U);
  EXPECT_GT(result.frames.first().size(), 5U);
  EXPECT_GT(result.history.whole().time_s.size(), 1000U);
}

TEST(Player, AFailureTellsPlaceMomentExpectationAndDistance) {
  const ScenarioResult result = play_steps("  - wait: 1 s\n  - expect: bus1.voltage > 30 V\n");
  ASSERT_FALSE(result.passed());
  EXPECT_EQ(result.failure->place, "test.yaml:8:5");
  EXPECT_EQ(result.failure->at, kSimStart + std::chrono::seconds(1));
  EXPECT_EQ(result.failure->off, "6 V too low");
  EXPECT_EQ(explain(result),
            "  test.yaml:8:5: expect bus1.voltage > 30 V\n"
            "    expected  bus1.voltage > 30 V\n"
            "    got       bus1.voltage 24 V at 1.000 s\n"
            "    off       6 V too low\n"
            "    at        1.000 s\n"
            "    again     virtdrive test test.yaml --seed 1\n");
}

TEST(Player, ExpectWaitsSettlesAndSeesABreak) {
  EXPECT_EQ(failure_of("  - apply: {supply1.voltage: 26 V}\n"
                       "  - expect: bus1.voltage > 25.9 V\n    within: 1 s\n    for: 1 s\n"),
            "passed");
  EXPECT_EQ(failure_of("  - apply: {board1.temperature: 50 degC}\n    for: 300 ms\n"
                       "  - expect: board1.temperature = 50 degC\n    for: 200 ms\n"),
            "passed");
  EXPECT_EQ(failure_of("  - apply: {board1.temperature: 50 degC}\n    for: 300 ms\n"
                       "  - expect: board1.temperature = 50 degC\n    for: 400 ms\n"),
            "expected board1.temperature = 50 degC for 400 ms, got board1.temperature 25 degC at "
            "0.300 s (25 degC too low)");
}

TEST(Player, AWatchEndsTheScenarioAtTheInstantItIsViolated) {
  const ScenarioResult result = play_steps(
      "  - always: board1.temperature < 40 degC\n"
      "  - ramp: {board1.temperature: 60 degC}\n    over: 1 s\n"
      "  - wait: 10 s\n");
  ASSERT_FALSE(result.passed());
  EXPECT_EQ(result.failure->place, "test.yaml:7:5");
  EXPECT_NEAR(seconds(result.failure->at), 15.0 / 35, 0.002);
}

TEST(Player, AWatchEndsWhereItsLabelBegins) {
  EXPECT_EQ(failure_of("  - never: board1.temperature > 40 degC\n    until: hot\n"
                       "  - wait: 100 ms\n"
                       "  - apply: {board1.temperature: 60 degC}\n    label: hot\n"
                       "  - wait: 100 ms\n"),
            "passed");
}

TEST(Player, AWatchInARepetitionEndsWithIt) {
  EXPECT_EQ(failure_of("  - repeat: 3\n    steps:\n"
                       "      - never: board1.temperature > 40 degC\n"
                       "      - wait: 100 ms\n"
                       "  - apply: {board1.temperature: 60 degC}\n"
                       "  - wait: 100 ms\n"),
            "passed");
}

TEST(Player, RepliesAreJudgedByKind) {
  EXPECT_EQ(failure_of("  - stop:\n    reply: refused\n"), "passed");
  EXPECT_EQ(failure_of("  - stop:\n    reply: error\n"), "passed");
  EXPECT_EQ(failure_of("  - stop:\n    reply: anything\n"), "passed");
  EXPECT_EQ(failure_of("  - stop\n"), "expected reply done, got StopMotor: refused with code -1");
  EXPECT_EQ(failure_of("  - stop:\n    reply: not_ready\n"),
            "expected reply not_ready, got StopMotor: refused with code -1");
  EXPECT_EQ(failure_of("  - power: off\n  - stop:\n    reply: none\n"), "passed");
  EXPECT_EQ(failure_of("  - set: {MaxAngAcc: 700}\n    reply: none\n"),
            "expected reply none, got done");
}

TEST(Player, RawBytesAreComparedByteForByte) {
  EXPECT_EQ(failure_of("  - raw: 11 14 00 6c 13\n    reply: 11 14 03 0a 0a 13\n"), "passed");
  EXPECT_EQ(failure_of("  - raw: 11 14 00 6c 13\n    reply: 11 14 ?? ?? ?? 13\n"), "passed");
  EXPECT_EQ(failure_of("  - raw: [11 14, 5 ms, 00 6c 13]\n    reply: 11 14 03 0a 0a 13\n"),
            "passed");
  EXPECT_EQ(failure_of("  - raw: 11 7f\n    reply: none\n"), "passed");
  EXPECT_EQ(failure_of("  - raw: 11 14 00 6c 13\n    reply: 11 14 03 0b 0a 13\n"),
            "expected 11 14 03 0b 0a 13, got 11 14 03 0a 0a 13 (byte 4 is the first that differs)");
  EXPECT_EQ(failure_of("  - raw: 11 7f\n    reply: 11 14\n"),
            "expected 11 14, got silence (0 of 2 bytes within 500 ms)");
  EXPECT_EQ(failure_of("  - raw: 11 14 00 6c 13\n    reply: none\n"),
            "expected silence for 100 ms, got 11");
}

TEST(Player, ReadingsAreComparedAndAwaited) {
  EXPECT_EQ(failure_of("  - read: DcLinkVoltage in 23 V ... 25 V\n"), "passed");
  EXPECT_EQ(failure_of("  - read: IqStart = 1 A\n"), "passed");
  EXPECT_EQ(failure_of("  - read: IqStart = 2 A +- 0.5 A\n"),
            "expected IqStart = 2 A +- 0.5 A, got 1000 mA (0.5 A too low)");
  EXPECT_EQ(failure_of("  - start: 1500 rpm\n  - read: MotorStage = 6\n    within: 3 s\n"),
            "passed");
}

TEST(Player, CallsNameTheFieldsOfRequestAndReply) {
  EXPECT_EQ(failure_of("  - call: GetFWVersion\n    reply: {major: 3, minor: \"> 9\"}\n"),
            "passed");
  EXPECT_EQ(failure_of("  - call: GetFWVersion\n    reply: {major: 4}\n"),
            "expected major 4, got major 3 (1 too low)");
}

TEST(Player, AStepWaitsForItsMoment) {
  const std::string armed =
      "  - apply: {board1.temperature: 50 degC}\n    when: motor1.speed > 1000 rpm\n"
      "    after: 20 ms\n";
  const ScenarioResult result = play_steps(armed + kRunning);
  EXPECT_TRUE(result.passed()) << explain(result);
  ASSERT_EQ(result.events.first().size(), 1U);
  EXPECT_EQ(result.events.first()[0].text, "board1.temperature 50 degC");
  EXPECT_EQ(failure_of(armed + "  - wait: 1 s\n"),
            "expected its moment to come before the end of the scenario, got it never came");
}

TEST(Player, AMilestoneCountsFramesWhileItsConditionHolds) {
  const std::string armed =
      "  - power: off\n    at: {request: SetOneMotorParameter, number: 2}\n"
      "    when: motor1.speed > 1200 rpm\n";
  const ScenarioResult result = play_steps(armed + kRunning +
                                           "  - set: {SpeedKp: 21 mA/Hz}\n"
                                           "  - set: {SpeedKp: 22 mA/Hz}\n    reply: none\n");
  EXPECT_TRUE(result.passed()) << explain(result);
}

TEST(Player, TheLastWordOnAnInputIsValid) {
  const ScenarioResult result = play_steps(
      "  - ramp: {board1.temperature: 100 degC}\n    over: 1 s\n    background: true\n"
      "  - wait: 500 ms\n"
      "  - apply: {board1.temperature: 30 degC}\n"
      "  - expect: board1.temperature = 30 degC\n    for: 2 s\n");
  EXPECT_TRUE(result.passed()) << explain(result);
}

TEST(Player, ProfilesGoThroughTheirPoints) {
  const std::string points = "    points: [[0 s, 30 degC], [1 s, 50 degC], [2 s, 40 degC]]\n";
  const ScenarioResult linear = play_steps(
      "  - profile: board1.temperature\n" + points + "    times: 2\n    background: true\n" +
      "  - wait: 500 ms\n  - expect: board1.temperature = 40 degC +- 0.1 degC\n"
      "  - wait: 2 s\n  - expect: board1.temperature = 40 degC +- 0.1 degC\n"
      "  - wait: 500 ms\n  - expect: board1.temperature = 50 degC +- 0.1 degC\n"
      "  - wait: 2 s\n  - expect: board1.temperature = 40 degC\n");
  EXPECT_TRUE(linear.passed()) << explain(linear);
  const ScenarioResult steps = play_steps(
      "  - profile: board1.temperature\n" + points + "    shape: steps\n    background: true\n" +
      "  - wait: 900 ms\n  - expect: board1.temperature = 30 degC\n"
      "  - wait: 200 ms\n  - expect: board1.temperature = 50 degC\n");
  EXPECT_TRUE(steps.passed()) << explain(steps);
}

TEST(Player, EqualSeedsGiveEqualResultsAndOthersDoNot) {
  const Scenario scenario = parse_scenario(
      "test.yaml",
      fmt::format("virtdrive-scenario: 1\nbench: {{drive: toshiba-mcu}}\nsteps:\n{}", kRunning));
  const auto speeds = [&](std::uint64_t seed) {
    return play(scenario, seed).history.whole().values;
  };
  EXPECT_EQ(speeds(1), speeds(1));
  EXPECT_NE(speeds(1), speeds(2));
}

TEST(Player, LongRunsAreKeptInABoundedMemory) {
  const ScenarioResult result =
      play_steps("  - repeat: 3000\n    steps:\n      - wait: 10 ms\n      - wait: 1 ms\n");
  EXPECT_TRUE(result.passed());
  EXPECT_LT(result.history.whole().time_s.size(), History::kMostRows);
  EXPECT_EQ(result.history.end().time_s.size(), History::kLastRows);
  EXPECT_NEAR(result.history.end().time_s.back(), 33, 1e-9);
  EXPECT_EQ(result.steps.left_out(), 6001 - 2 * Ends<StepResult>::kMost);
}

}  // namespace
}  // namespace virtdrive
