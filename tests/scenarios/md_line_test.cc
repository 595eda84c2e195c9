// Several MD controllers on one RS-485 line.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "devices/md485/client.h"
#include "scenarios/bench.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using namespace md485;

const ParameterRow& row(std::uint16_t pid) {
  return *protocol::find(kTable.parameters, pid);
}
const CommandRow& command(std::uint16_t pid) {
  return *protocol::find(kTable.commands, pid);
}

DriveSpec controller(std::string kind, std::string name, int id) {
  return {.kind = std::move(kind), .name = std::move(name), .set = {fmt::format("ID={}", id)}};
}

TEST(MdLine, FourControllersArePolledInTurnAndHearOnlyWhatIsTheirs) {
  Bench bench({.drives = {controller("md400", "a", 1), controller("md200", "b", 2),
                          controller("md100", "c", 3), controller("md750", "d", 4)},
               .integrator = Integrator::kFast});
  LineTransport transport(bench.loop(), bench.line());
  Client host(transport);
  for (std::uint8_t id = 1; id <= 4; ++id) {
    host.set_id(id);
    host.command(command(130), {200 * id});
  }
  for (int round = 0; round < 40; ++round) {
    for (std::uint8_t id = 1; id <= 4; ++id) {
      host.set_id(id);
      EXPECT_EQ(host.read(row(133))[0], id);
    }
  }
  for (std::uint8_t id = 1; id <= 4; ++id) {
    host.set_id(id);
    EXPECT_NEAR(double(host.read(row(138))[0]), 200.0 * id, 15) << int{id};
  }
  EXPECT_EQ(bench.line().counters().collisions, 0U);
  // A command to two of them: each takes the half that names it (p. 31).
  host.set_id(kAllControllers);
  host.command(command(207), {1, -300, 4, 0, 2});
  bench.run_for(3s);
  EXPECT_NEAR(bench.read("a.motor0.speed"), -300, 15);
  EXPECT_NEAR(bench.read("b.motor0.speed"), 400, 15);
  EXPECT_NEAR(bench.read("d.motor0.speed"), 0, 1);
}

TEST(MdLine, TwoControllersWithOneIdMakeGarbage) {
  Bench bench({.drives = {controller("md400", "a", 1), controller("md200", "b", 2),
                          controller("md500s", "thief", 1)},
               .integrator = Integrator::kFast});
  LineTransport transport(bench.loop(), bench.line());
  Client host(transport, {.id = 1}, 100ms);
  EXPECT_THROW(host.read(row(205)), ClientError);
  EXPECT_GT(bench.line().counters().collisions, 0U);
  host.set_id(2);
  EXPECT_EQ(host.read(row(133))[0], 2);
}

TEST(MdLine, APowerCycleForgetsWhatIsNotInTheFlash) {
  Bench bench(
      {.drives = {{.kind = "md400", .set = {"BAUDRATE=4"}}}, .integrator = Integrator::kFast});
  auto host = bench.host();
  EXPECT_EQ(bench.line().settings().baud, 57600);
  host->set("PID_MAX_RPM=1000");
  host->set("PID_COM_TAR_SPEED=300");
  host->start_motor(0, 500);
  bench.run_for(2s);
  EXPECT_NEAR(bench.read("motor0.speed"), 500, 15);
  bench.drive().power_off();
  bench.run_for(3s);
  EXPECT_NEAR(bench.read("motor0.speed"), 0, 1);
  bench.drive().power_on();
  bench.run_for(100ms);
  EXPECT_EQ(host->get("MAX_RPM").value, 1000);
  EXPECT_EQ(host->get("COM_TAR_SPEED").value, 0);
  EXPECT_EQ(host->get("MAIN_DATA.position").value, 0);
}

TEST(MdServoLock, ComesToRestWhateverTheRotorsAngleAtTheStop) {
  for (int i = 0; i < 8; ++i) {
    Bench bench({.drives = {{.kind = "md200t"}}, .integrator = Integrator::kFast});
    LineTransport transport(bench.loop(), bench.line());
    Client host(transport);
    host.command(command(207), {1, -120, 1, 80, 0});
    bench.run_for(1s + i * 11ms);
    host.command(command(207), {1, 0, 1, 0, 0});
    bench.run_for(3s);
    const double angle = bench.read("motor0.angle");
    bench.run_for(1s);
    EXPECT_NEAR(bench.read("motor0.angle"), angle, 0.1) << i;
    EXPECT_EQ(bench.read("drive0.speed"), 0) << i;
    EXPECT_EQ(bench.read("drive1.speed"), 0) << i;
    EXPECT_EQ(bench.read("drive0.control_type"), 1) << i;  // held, not let go
  }
}

TEST(MdLine, WrongWordsAreNamed) {
  const auto refused = [](const char* assignment, const char* part) {
    try {
      Bench bench({.drives = {{.kind = "md400", .set = {assignment}}}});
      ADD_FAILURE() << assignment;
    } catch (const SetupError& error) {
      EXPECT_NE(std::string_view(error.what()).find(part), std::string_view::npos) << error.what();
    }
  };
  refused("MAX_RMP=100", "MAX_RPM");
  refused("MAX_RPM=0", "1 ... 32767");
  refused("VERSION=3", "cannot be written");
  refused("GAIN=1,2", "3 numbers");
  refused("profile=4.3", "4.4-strict");
}

}  // namespace
}  // namespace virtdrive
