#include "devices/rzt1/walk.h"

#include <gtest/gtest.h>

#include "tests/devices/rzt1/line_rig.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

constexpr protocol::WalkOptions kOptions{
    .patience = 5ms, .silence = 1ms, .pause = 500us, .most_failures = 200};

TEST(Rzt1Walk, EveryPacketFunctionAndVariableIsAnsweredAsTheTableSays) {
  LineRig rig;
  const protocol::WalkReport report = walk(PacketDialect(), rig.wire(), kOptions);
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_GT(report.checks.size(), 1500U);
  EXPECT_EQ(report.skipped,
            (std::vector<std::string>{
                "command 58 RESET", "command 5F HOME", "parameter 39 U", "parameter 3A V",
                "parameter 3B W", "parameter 49 TMODE", "parameter 4D TIMER", "parameter 75 ETYPE",
                "parameter 76 EID", "parameter 78 EDATA", "parameter 7B ADDR"}));
}

TEST(Rzt1Walk, EveryFunctionAndVariableIsKnownInLines) {
  LineRig rig;
  const protocol::WalkReport report = walk(LineDialect(), rig.wire(1), kOptions);
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_GT(report.checks.size(), 1500U);
  EXPECT_EQ(report.skipped,
            (std::vector<std::string>{
                "command 58 RESET", "command 5F HOME", "parameter 39 U", "parameter 3A V",
                "parameter 3B W", "parameter 49 TMODE", "parameter 4D TIMER", "parameter 61 VER",
                "parameter 75 ETYPE", "parameter 76 EID", "parameter 78 EDATA"}));
}

}  // namespace
}  // namespace virtdrive::rzt1
