// The scenarios that come with virtdrive, and the words of their language.
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scenarios/scenario/gallery.h"
#include "scenarios/scenario/language.h"
#include "scenarios/scenario/loader.h"
#include "scenarios/scenario/schema.h"
#include "scenarios/scenario/suite.h"

namespace virtdrive {
namespace {

const std::string kRoot = VIRTDRIVE_SOURCE_DIR;

std::string contents(const std::string& path) {
  std::ifstream stream(kRoot + "/" + path);
  EXPECT_TRUE(stream) << path;
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(Library, EveryScenarioButTheLongOnesPasses) {
  const auto scenarios = find_scenarios({kRoot + "/scenarios/library"});
  const auto results = play_all(choose_cases(scenarios, {}), 0, nullptr);
  EXPECT_GE(results.size(), 12U);
  for (const ScenarioResult& result : results) EXPECT_TRUE(result.passed()) << explain(result);
}

TEST(Library, EveryScenarioSaysWhatItShows) {
  for (const auto& scenario : find_scenarios({kRoot + "/scenarios/library"})) {
    EXPECT_FALSE(scenario->about.empty()) << scenario->file;
    EXPECT_FALSE(scenario->tags.empty()) << scenario->file;
  }
}

// To refresh: ./dev docs
TEST(Library, TheGalleryIsUpToDate) {
  EXPECT_TRUE(contents("docs/gallery.md") ==
              gallery(find_scenarios({kRoot + "/scenarios/library"})));
}

// To refresh: ./dev docs
TEST(Schema, TheFileIsUpToDate) {
  EXPECT_TRUE(contents("scenarios/library/scenario.schema.json") == scenario_schema());
}

TEST(Language, ThePageTellsOfEveryWord) {
  const std::string page = contents("docs/scenarios.md");
  const auto told = [&](const std::vector<language::Key>& keys) {
    for (const language::Key& key : keys) {
      EXPECT_NE(page.find(fmt::format("`{}", key.name)), std::string::npos) << key.name;
    }
  };
  for (const language::Verb& verb : language::verbs()) {
    EXPECT_NE(page.find(fmt::format("`{}`", verb.name)), std::string::npos) << verb.name;
    told(verb.keys);
  }
  told(language::step_keys());
  told(language::trigger_keys());
  told(language::file_keys());
  told(language::bench_keys());
  told(language::drive_keys());
  told(language::line_keys());
  told(language::record_keys());
  told(language::milestone_keys());
}

TEST(Language, ThePagesFirstExampleIsAScenarioThatPasses) {
  const std::string page = contents("docs/scenarios.md");
  const std::string mark = "```yaml\n";
  const std::size_t begin = page.find(mark) + mark.size();
  const std::string text = page.substr(begin, page.find("```", begin) - begin);
  const ScenarioResult result = play(parse_scenario("scenarios.md", text), 1);
  EXPECT_TRUE(result.passed()) << explain(result);
}

TEST(Schema, KnowsTheVerbsTheDrivesAndTheirParameters) {
  const auto schema = nlohmann::json::parse(scenario_schema());
  const auto& defs = schema["$defs"];
  const auto& kinds = defs["steps"]["items"]["anyOf"];
  EXPECT_EQ(kinds.size(), language::verbs().size() + 1);
  EXPECT_EQ(defs["bench"]["properties"]["drive"]["enum"][0], "toshiba-mcu");
  EXPECT_TRUE(defs["parameters"]["properties"].contains("MaxAngAcc"));
}

}  // namespace
}  // namespace virtdrive
