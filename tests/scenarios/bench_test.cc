#include "scenarios/bench.h"

#include <gtest/gtest.h>

#include "core/check.h"
#include "devices/toshiba_mcu/client.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

double read(Bench& bench, std::string_view signal) {
  return bench.registry().signal(signal).read();
}

void start(Bench& bench, double rpm) {
  LineTransport host(bench.loop(), bench.line());
  bench.drive().start_motor(host, 1, rpm);
}

TEST(Bench, AHostOnTheLineRunsTheMotorAndSignalsTellOfIt) {
  Bench bench({.drive = "toshiba-mcu", .integrator = Integrator::kFast});
  start(bench, 2000);
  bench.loop().run_until(kSimStart + 4s);
  EXPECT_NEAR(read(bench, "motor1.speed"), 2000, 10);
  EXPECT_NEAR(read(bench, "drive1.speed"), 2000, 10);
  EXPECT_EQ(read(bench, "drive1.stage"), 6);
  EXPECT_NEAR(read(bench, "motor1.torque"), 0.004, 0.001);
  EXPECT_NEAR(read(bench, "bus1.voltage"), 24, 0.1);
  EXPECT_EQ(read(bench, "motor0.speed"), 0);
}

TEST(Bench, ALoadStepsAtItsTime) {
  Bench bench({.drive = "toshiba-mcu", .load = "brake:20mNm@4s", .integrator = Integrator::kFast});
  start(bench, 2000);
  bench.loop().run_until(kSimStart + 3999ms);
  EXPECT_NEAR(read(bench, "load1.torque"), 0, 1e-9);
  const double before = read(bench, "motor1.current_q");
  bench.loop().run_until(kSimStart + 5s);
  EXPECT_NEAR(read(bench, "load1.torque"), 0.02, 1e-9);
  EXPECT_NEAR(read(bench, "motor1.current_q") - before, 0.02 / 0.034, 0.03);
}

TEST(Bench, InputsMoveWhatTheyName) {
  Bench bench({.drive = "toshiba-mcu"});
  bench.loop().run_until(kSimStart + 1ms);
  bench.registry().set("supply1.voltage", 26);
  bench.registry().set("load1.brake_torque", 0.1);
  bench.registry().set("board1.temperature", 60);
  bench.loop().run_until(kSimStart + 100ms);
  EXPECT_NEAR(read(bench, "bus1.voltage"), 26, 1e-3);
  EXPECT_EQ(read(bench, "supply1.voltage"), 26);
  EXPECT_EQ(read(bench, "load1.brake_torque"), 0.1);
  EXPECT_EQ(read(bench, "board1.temperature"), 60);
  EXPECT_THROW(bench.registry().set("load1.brake_torque", -1), SetupError);
}

TEST(Bench, EqualSeedsGiveEqualRunsAndTwoBenchesLiveSideBySide) {
  Bench a({.drive = "toshiba-mcu", .seed = 7});
  Bench b({.drive = "toshiba-mcu", .seed = 7});
  Bench other({.drive = "toshiba-mcu", .seed = 8});
  for (Bench* bench : {&a, &b, &other}) start(*bench, 1000);
  for (int i = 1; i <= 100; ++i) {  // in turns, so that anything shared would show
    for (Bench* bench : {&a, &b, &other}) bench->loop().run_until(kSimStart + i * 20ms);
  }
  for (const Signal& signal : a.registry().signals()) {
    EXPECT_EQ(signal.read(), read(b, signal.name)) << signal.name;
  }
  EXPECT_NE(read(a, "motor1.angle"), read(other, "motor1.angle"));
}

TEST(Bench, TheReplysLastByteIsExactAt115200Baud) {
  Bench bench({.drive = "toshiba-mcu"});
  std::vector<SimTime> heard;
  bench.line().on_host_byte([&](std::uint8_t, SimTime t) { heard.push_back(t); });
  const std::uint8_t version[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
  bench.line().host_send(version);
  bench.loop().run_until(kSimStart + 10ms);
  ASSERT_EQ(heard.size(), 6U);
  // Five characters in, 1 ms, six characters out; ten bits a character.
  const SimDuration request{5 * 10 * 1'000'000'000LL / 115200};
  const SimDuration reply{6 * 10 * 1'000'000'000LL / 115200};
  EXPECT_EQ(heard.back(), kSimStart + request + 1ms + reply);
}

TEST(Bench, OnAnIdealLineTheAnswerComesAtTheSameInstant) {
  Bench bench({.drive = "toshiba-mcu", .line = LineTiming::kIdeal});
  bench.loop().run_until(kSimStart + 5ms);
  LineTransport transport(bench.loop(), bench.line());
  toshiba_mcu::Client client(transport);
  EXPECT_EQ(client.version(), "3.10");
  EXPECT_EQ(bench.loop().now(), kSimStart + 5ms);
}

TEST(Bench, BothIntegratorsAgreeOnARun) {
  const auto speed = [](Integrator integrator) {
    Bench bench({.drive = "toshiba-mcu", .integrator = integrator});
    start(bench, 1500);
    bench.loop().run_until(kSimStart + 3s);
    return read(bench, "motor1.speed");
  };
  EXPECT_NEAR(speed(Integrator::kDefault), speed(Integrator::kFast), 3);
}

TEST(Client, TellsARefusalASilenceAndADamagedAnswerApart) {
  Bench bench({.drive = "toshiba-mcu"});
  LineTransport transport(bench.loop(), bench.line());
  toshiba_mcu::Client client(transport);
  const auto error_of = [&](auto&& act) -> std::string {
    try {
      act();
    } catch (const toshiba_mcu::ClientError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(error_of([&] { client.stop_motor(1); }), "StopMotor: refused with code -1");
  EXPECT_EQ(error_of([&] { client.get(1, "Speed"); }),
            "GetOneMotorParameter: refused with code -1");
  bench.line().set_baud(9600);
  bench.line().set_host({.baud = 115200});
  EXPECT_EQ(error_of([&] { client.version(); }), "GetFWVersion: the drive does not answer");
}

}  // namespace
}  // namespace virtdrive
