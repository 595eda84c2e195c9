#include "devices/md485/walk.h"

#include <gtest/gtest.h>

#include "tests/devices/md485/line_rig.h"

namespace virtdrive::md485 {
namespace {

using namespace std::chrono_literals;

constexpr protocol::WalkOptions kOptions{
    .channel = 1, .patience = 100ms, .silence = 15ms, .pause = 4ms, .most_failures = 10'000};

void walks_clean(std::string_view model, Profile profile) {
  LineRig rig(model, profile);
  const WalkDialect dialect(rig.table);
  const protocol::WalkReport report = walk(dialect, rig, kOptions);
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_GT(report.checks.size(), 3000U);
  EXPECT_EQ(report.skipped,
            (std::vector<std::string>{"parameter 85 PID_ID", "parameter 95 PID_RETURN_TYPE"}));
}

TEST(Md485Walk, ASingleControllerAnswersEveryRowAsTheTableSays) {
  walks_clean("md400", Profile::kToday);
}

TEST(Md485Walk, ADualControllerAnswersEveryRowAsTheTableSays) {
  walks_clean("md200t", Profile::kToday);
}

TEST(Md485Walk, AStrictControllerKnowsTheDocumentAndNothingElse) {
  walks_clean("md750t", Profile::kStrict);
}

}  // namespace
}  // namespace virtdrive::md485
