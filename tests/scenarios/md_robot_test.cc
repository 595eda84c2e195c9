// A small robot in virtual time: two in-wheel motors of 20 poles on one MD200T and one battery, its
// host polling fifty times a second at 57600 baud.
#include <algorithm>
#include <array>
#include <gtest/gtest.h>

#include "devices/md485/client.h"
#include "scenarios/bench.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using namespace md485;

constexpr SimDuration kSlot = 20ms;
constexpr double kCountsPerTurn = 60;

const ParameterRow& row(std::uint16_t pid) {
  return *protocol::find(kTable.parameters, pid);
}
const CommandRow& command(std::uint16_t pid) {
  return *protocol::find(kTable.commands, pid);
}

struct Way {
  std::int64_t left, right;  // rpm
};
// Five seconds each: out, a curve, on the spot, back, a standstill and a creep.
constexpr std::array<Way, 12> kProgramme = {{{120, 120},
                                             {150, 60},
                                             {80, -80},
                                             {-100, -100},
                                             {0, 0},
                                             {12, 12},
                                             {200, 180},
                                             {-60, 90},
                                             {250, 250},
                                             {-250, -250},
                                             {40, -40},
                                             {0, 0}}};

TEST(MdRobot, SixtySecondsOfPollingLoseNoAnswerAndItsOdometryIsThePlants) {
  Bench bench({.drives = {{.kind = "md200t", .set = {"BAUDRATE=4", "INV_SIGN_CMD=1"}}},
               .integrator = Integrator::kFast});
  LineTransport transport(bench.loop(), bench.line());
  Client host(transport, {}, kSlot);
  ASSERT_EQ(bench.line().settings().baud, 57600);
  constexpr std::array<std::uint16_t, 5> kPids = {193, 194, 196, 200, 210};
  SimDuration slowest{};
  int answered = 0;
  const SimTime begin = bench.loop().now();
  for (int i = 0; i < 3000; ++i) {
    bench.run_until(begin + i * kSlot);
    const auto& [left, right] = kProgramme[static_cast<std::size_t>(i) / 250];
    if (i % 250 == 0) host.command(command(207), {1, left, 1, right, 0});
    const SimTime asked = bench.loop().now();
    host.read(row(kPids[static_cast<std::size_t>(i) % kPids.size()]));  // throws if none comes
    slowest = std::max(slowest, bench.loop().now() - asked);
    ++answered;
  }
  EXPECT_EQ(answered, 3000);
  // 24 bytes of PID 210, 2 ms, 7 bytes of the request; once in 250 behind a command of 13.
  EXPECT_LT(slowest, 10ms);
  RecordProperty("slowest_answer_us", static_cast<int>(slowest / 1us));
  bench.run_for(3s);
  const protocol::Values wheels = host.read(row(210));
  EXPECT_EQ(wheels[0], 0);
  EXPECT_EQ(wheels[4], 0);
  const double left_counts = -bench.read("motor0.angle") / 360 * kCountsPerTurn;
  const double right_counts = bench.read("motor1.angle") / 360 * kCountsPerTurn;
  EXPECT_NEAR(double(wheels[3]), left_counts, 1);
  EXPECT_NEAR(double(wheels[7]), right_counts, 1);
  EXPECT_EQ(bench.read("drive0.status"), 0);
  EXPECT_EQ(bench.read("drive1.status"), 0);
  EXPECT_EQ(bench.read("wire.bad_frames"), 0);
  EXPECT_EQ(bench.line().counters().collisions, 0U);
}

}  // namespace
}  // namespace virtdrive
