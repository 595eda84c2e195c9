#include "scenarios/host/drive_check.h"

#include <gtest/gtest.h>
#include <map>

#include "scenarios/bench.h"
#include "scenarios/host/parameter_dump.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using protocol::Allow;

/// A drive of a kind, and how often it heard each request.
struct Rig {
  explicit Rig(std::string_view kind)
      : bench({.drives = {{.kind = std::string(kind)}},
               .listener = [this](std::string_view, const WireEvent& event) {
                 if (event.kind != WireEvent::Kind::kRequest) return;
                 ++heard[std::string(event.text.substr(0, event.text.find(' ')))];
               }}) {
    bench.run_for(std::chrono::seconds(3));  // it has started
  }

  DriveCheck check(Allow allow) {
    const DriveKind& kind = bench.drive().kind();
    LineTransport transport(bench.loop(), bench.line());
    return check_drive(*kind.make_dialect(), transport,
                       [&] { return bench.loop().now() - kSimStart; },
                       {.channel = kind.checked_channel,
                        .allow = allow,
                        .patience = kind.checked_patience,
                        .silence = std::chrono::milliseconds(50)});
  }

  std::map<std::string, int> heard;
  Bench bench;
};

TEST(DriveCheck, OursKeepToTheirTablesAtEachLevel) {
  for (const std::string_view kind : {"toshiba-mcu", "md400t", "rzt1", "asd7"}) {
    std::size_t checks = 0;
    for (const Allow allow : {Allow::kReads, Allow::kWrites}) {
      const DriveCheck check = Rig(kind).check(allow);
      EXPECT_EQ(check.walk.failures(), 0U) << kind << '\n' << text(check);
      EXPECT_GT(check.walk.checks.size(), checks) << kind;
      checks = check.walk.checks.size();
    }
  }
}

TEST(DriveCheck, WithReadsOnlyNothingButReadingRequestsAreSent) {
  Rig rig("toshiba-mcu");
  rig.check(Allow::kReads);
  for (const auto& [request, times] : rig.heard) {
    EXPECT_TRUE(request.starts_with("Get")) << request << " was sent " << times << " times";
  }
  EXPECT_GT(rig.heard["GetOneMotorParameter"], 100);
}

TEST(DriveCheck, WithWritesSettingsAreLeftAsTheyWereAndNothingTurns) {
  for (const std::string_view kind : {"toshiba-mcu", "md400t", "rzt1", "asd7"}) {
    Rig rig(kind);
    const protocol::ProtocolTable& table = rig.bench.drive().kind().table;
    const ParameterDump before = dump_parameters(*rig.bench.host(), table);
    rig.check(Allow::kWrites);
    EXPECT_TRUE(differences(before, dump_parameters(*rig.bench.host(), table)).empty()) << kind;
    const std::size_t motor = rig.bench.drive().kind().default_channel;
    EXPECT_EQ(rig.bench.read("motor" + std::to_string(motor) + ".angle"), 0) << kind;
  }
}

TEST(DriveCheck, ADriveOnADamagedLineFailsAndIsGivenUp) {
  Rig rig("toshiba-mcu");
  rig.bench.set("line.to_host_flipped", 1);
  const DriveCheck check = rig.check(Allow::kReads);
  EXPECT_GT(check.walk.failures(), 50U);
  EXPECT_TRUE(check.walk.given_up);
  const std::string xml = check_junit(check, "toshiba-mcu");
  EXPECT_NE(xml.find("<failure message="), std::string::npos);
  EXPECT_NE(check_json(check, "toshiba-mcu").find("\"given_up\": true"), std::string::npos);
}

TEST(DriveCheck, LatenciesAreThoseOfTheLineAndTheDrive) {
  const Latencies latencies{{SimDuration{10}, SimDuration{20}, SimDuration{30}}};
  EXPECT_EQ(latencies.quantile(0), SimDuration{10});
  EXPECT_EQ(latencies.quantile(0.5), SimDuration{20});
  EXPECT_EQ(latencies.quantile(1), SimDuration{30});
  // A telegram of 8 bytes, 1 ms in the drive, and the first byte of the answer: 9 characters of
  // 86.8 us beside the latency.
  const DriveCheck check = Rig("toshiba-mcu").check(Allow::kReads);
  const double typical_ms =
      std::chrono::duration<double, std::milli>(check.latencies.quantile(0.5)).count();
  EXPECT_NEAR(typical_ms, 8 * 0.0868 + 1.0, 0.01);
}

}  // namespace
}  // namespace virtdrive
