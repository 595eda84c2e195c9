#include "scenarios/host/parameter_dump.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "core/check.h"
#include "scenarios/bench.h"

namespace virtdrive {
namespace {

class ParameterDumpTest : public testing::TestWithParam<const char*> {
 protected:
  ParameterDump dump(Bench& bench) {
    return dump_parameters(*bench.host(), bench.drive().kind().table);
  }
};

std::string written(const std::string& text) {
  const std::string path = testing::TempDir() + "/virtdrive_dump_test.yaml";
  std::ofstream(path) << text;
  return path;
}

TEST_P(ParameterDumpTest, IsReadBackAsItWasWritten) {
  Bench bench({.drives = {{.kind = GetParam()}}});
  const ParameterDump first = dump(bench);
  EXPECT_GT(first.settings.size(), 20U);
  EXPECT_TRUE(first.untold.empty()) << first.untold.front();
  const ParameterDump again = read_dump(written(to_yaml(first)));
  EXPECT_EQ(again.protocol, first.protocol);
  EXPECT_EQ(again.settings, first.settings);
}

TEST_P(ParameterDumpTest, GivesADriveBackWhatAnotherOneHas) {
  Bench bench({.drives = {{.kind = GetParam()}}});
  const ParameterDump before = dump(bench);
  const std::string name = bench.drive().kind().table.name == "md485" ? "PID_POSI_SS" : "MaxAngAcc";
  bench.host()->set(name + "=411");
  const std::vector<SettingDifference> found = differences(before, dump(bench));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].name, name);
  EXPECT_TRUE(found[0].second->starts_with("411")) << *found[0].second;

  const Restored restored = restore_parameters(*bench.host(), before);
  EXPECT_EQ(restored.written.size(), 1U);
  EXPECT_EQ(restored.unchanged, before.settings.size() - 1);
  EXPECT_TRUE(restored.unwritten.empty());
  EXPECT_TRUE(differences(before, dump(bench)).empty());
}

INSTANTIATE_TEST_SUITE_P(Drives, ParameterDumpTest, testing::Values("toshiba-mcu", "md400t"),
                         [](const auto& drive) {
                           std::string name = drive.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(ParameterDump, OfADriveThatIsOffIsAnError) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  bench.drive().power_off();
  const auto host = bench.host();
  EXPECT_THROW(dump_parameters(*host, bench.drive().kind().table), DriveSilent);
}

TEST(ParameterDump, SaysWhatCouldNotBeWritten) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  const Restored restored =
      restore_parameters(*host, {.protocol = "toshiba-mcu", .settings = {{"PolePairs", "200"}}});
  ASSERT_EQ(restored.unwritten.size(), 1U);
  EXPECT_TRUE(restored.unwritten[0].starts_with("PolePairs=200: ")) << restored.unwritten[0];
}

TEST(ParameterDump, FilesThatAreNoneAreRefusedWithTheirPlace) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      read_dump(written(text));
    } catch (const SetupError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("virtdrive-dump: 2\nprotocol: a\nsettings: {}\n").find(":1:17: expected 1"),
            std::string::npos);
  EXPECT_NE(message("virtdrive-dump: 1\nprotocol: a\nsettings: 3\n").find(":3:"),
            std::string::npos);
  EXPECT_NE(message("virtdrive-dump: 1\nsettings: {}\n").find("protocol"), std::string::npos);
}

TEST(ParameterDump, TellsOfSettingsThatOnlyOneHas) {
  const auto found = differences({.protocol = "p", .settings = {{"a", "1"}, {"b", "2"}}},
                                 {.protocol = "p", .settings = {{"b", "2"}, {"c", "3"}}});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].second, std::nullopt);
  EXPECT_EQ(found[1].first, std::nullopt);
}

}  // namespace
}  // namespace virtdrive
