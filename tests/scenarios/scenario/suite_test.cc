#include "scenarios/scenario/suite.h"

#include <gtest/gtest.h>
#include <set>

#include "core/check.h"
#include "scenarios/report/junit.h"
#include "scenarios/report/test_json.h"
#include "scenarios/report/test_report.h"
#include "scenarios/scenario/loader.h"

namespace virtdrive {
namespace {

std::shared_ptr<const Scenario> scenario(const std::string& name, const std::string& rest = "") {
  return std::make_shared<const Scenario>(parse_scenario(
      "folder/" + name + ".yaml",
      "virtdrive-scenario: 1\n" + rest +
          "bench: {drive: toshiba-mcu}\nsteps:\n  - wait: 10 ms\n  - read: ResetStatus = 1\n"));
}

TEST(Suite, ChoosesByPatternTagAndLength) {
  const std::vector all = {scenario("apple"), scenario("pear", "tags: [fruit]\n"),
                           scenario("day", "tags: [long]\nname: A <day>\n")};
  EXPECT_EQ(choose_cases(all, {}).size(), 2U);
  EXPECT_EQ(choose_cases(all, {.with_long = true}).size(), 3U);
  EXPECT_EQ(choose_cases(all, {.pattern = "fruit"}).front().scenario->name, "pear");
  EXPECT_EQ(choose_cases(all, {.pattern = "folder/app"}).size(), 1U);
  EXPECT_TRUE(choose_cases(all, {.pattern = "cherry"}).empty());
}

TEST(Suite, SeedsAndRepetitionsFollowOneAnother) {
  const std::vector all = {scenario("apple", "seed: 7\n")};
  EXPECT_EQ(choose_cases(all, {}).front().seed, 7U);
  const auto cases = choose_cases(all, {.seed = 100, .repeat = 3});
  ASSERT_EQ(cases.size(), 3U);
  EXPECT_EQ(cases[2].seed, 102U);
}

TEST(Suite, ShardsPartTheCases) {
  const std::vector all = {scenario("a"), scenario("b"), scenario("c")};
  std::multiset<std::string> seen;
  for (std::size_t shard = 1; shard <= 4; ++shard) {
    for (const Case& one : choose_cases(all, {.repeat = 3, .shard = shard, .shards = 4})) {
      seen.insert(one.scenario->name + std::to_string(one.seed));
    }
  }
  EXPECT_EQ(seen,
            (std::multiset<std::string>{"a1", "a2", "a3", "b1", "b2", "b3", "c1", "c2", "c3"}));
}

TEST(Suite, ResultsAreTheSameWhateverTheNumberOfJobs) {
  const auto cases = choose_cases({scenario("a"), scenario("b")}, {.repeat = 3});
  std::vector<std::size_t> told;
  const auto listener = [&](std::size_t i, const ScenarioResult& result) {
    told.push_back(i);
    EXPECT_FALSE(result.frames.first().empty());
  };
  const auto alone = play_all(cases, 1, listener);
  const auto together = play_all(cases, 4, listener);
  EXPECT_EQ(told, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(test_json(alone), test_json(together));
  EXPECT_EQ(junit(alone), junit(together));
  EXPECT_EQ(totals(alone).passed, 6U);
}

ScenarioResult failed() {
  return play(parse_scenario("folder/f.yaml",
                             "virtdrive-scenario: 1\nname: A <b> & c\nbench: {drive: toshiba-mcu}\n"
                             "steps:\n  - start: 500 rpm\n  - inject: line.to_drives_lost\n"
                             "    for: 1 ms\n  - wait: 2 s\n  - expect: bus1.voltage > 30 V\n"),
              1);
}

TEST(TestReport, ACasesPageHasItsFailureStepsFramesAndPlots) {
  const std::string page = case_page(failed());
  for (const std::string part :
       {"A &lt;b&gt; &amp; c", "badge failed", " V too low", "folder/f.yaml:9:5",
        "virtdrive test folder/f.yaml --seed 1", "The last 1 s before it failed", "Step by step",
        "start motor 1 at 500 rpm", "StartMotor motor_nr=1", "<svg"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(page, case_page(failed()));
}

TEST(Junit, TellsFailuresAndEscapesWhatXmlCannotHold) {
  ScenarioResult result = failed();
  result.failure->got += "\x01";
  const std::string text = junit({result});
  EXPECT_NE(text.find("tests=\"1\" failures=\"1\""), std::string::npos);
  EXPECT_NE(text.find("A &lt;b&gt; &amp; c (seed 1)"), std::string::npos);
  EXPECT_EQ(text.find('\x01'), std::string::npos);
}

}  // namespace
}  // namespace virtdrive
