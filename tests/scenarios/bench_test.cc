#include "scenarios/bench.h"

#include <gtest/gtest.h>

#include "core/check.h"
#include "devices/toshiba_mcu/client.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

void start(Bench& bench, double rpm) {
  bench.host()->start_motor(1, rpm);
}

TEST(Bench, AHostOnTheLineRunsTheMotorAndSignalsTellOfIt) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .integrator = Integrator::kFast});
  start(bench, 2000);
  bench.run_until(kSimStart + 4s);
  EXPECT_NEAR(bench.read("motor1.speed"), 2000, 10);
  EXPECT_NEAR(bench.read("drive1.speed"), 2000, 10);
  EXPECT_EQ(bench.read("drive1.stage"), 6);
  EXPECT_NEAR(bench.read("motor1.torque"), 0.004, 0.001);
  EXPECT_NEAR(bench.read("bus1.voltage"), 24, 0.1);
  EXPECT_EQ(bench.read("motor0.speed"), 0);
}

TEST(Bench, ALoadStepsAtItsTime) {
  Bench bench({.drives = {{.kind = "toshiba-mcu", .load = "brake:20mNm@4s"}},
               .integrator = Integrator::kFast});
  start(bench, 2000);
  bench.run_until(kSimStart + 3999ms);
  EXPECT_NEAR(bench.read("load1.torque"), 0, 1e-9);
  const double before = bench.read("motor1.current_q");
  bench.run_until(kSimStart + 5s);
  EXPECT_NEAR(bench.read("load1.torque"), 0.02, 1e-9);
  EXPECT_NEAR(bench.read("motor1.current_q") - before, 0.02 / 0.034, 0.03);
}

TEST(Bench, InputsMoveWhatTheyName) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  bench.run_until(kSimStart + 1ms);
  bench.set("supply1.voltage", 26);
  bench.set("load1.brake_torque", 0.1);
  bench.set("board1.temperature", 60);
  bench.run_until(kSimStart + 100ms);
  EXPECT_NEAR(bench.read("bus1.voltage"), 26, 1e-3);
  EXPECT_EQ(bench.read("supply1.voltage"), 26);
  EXPECT_EQ(bench.read("load1.brake_torque"), 0.1);
  EXPECT_EQ(bench.read("board1.temperature"), 60);
  EXPECT_THROW(bench.set("load1.brake_torque", -1), SetupError);
}

TEST(Bench, EqualSeedsGiveEqualRunsAndTwoBenchesLiveSideBySide) {
  Bench a({.drives = {{.kind = "toshiba-mcu"}}, .seed = 7});
  Bench b({.drives = {{.kind = "toshiba-mcu"}}, .seed = 7});
  Bench other({.drives = {{.kind = "toshiba-mcu"}}, .seed = 8});
  for (Bench* bench : {&a, &b, &other}) start(*bench, 1000);
  for (int i = 1; i <= 100; ++i) {  // in turns, so that anything shared would show
    for (Bench* bench : {&a, &b, &other}) bench->run_until(kSimStart + i * 20ms);
  }
  for (const Signal& signal : a.registry().signals()) {
    EXPECT_EQ(signal.read(), b.read(signal.name)) << signal.name;
  }
  EXPECT_NE(a.read("motor1.angle"), other.read("motor1.angle"));
}

TEST(Bench, TheReplysLastByteIsExactAt115200Baud) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  std::vector<SimTime> heard;
  bench.line().on_host_byte([&](std::uint8_t, SimTime t) { heard.push_back(t); });
  const std::uint8_t version[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
  bench.line().host_send(version);
  bench.run_until(kSimStart + 10ms);
  ASSERT_EQ(heard.size(), 6U);
  // Five characters in, 1 ms, six characters out; ten bits a character.
  const SimDuration request{5 * 10 * 1'000'000'000LL / 115200};
  const SimDuration reply{6 * 10 * 1'000'000'000LL / 115200};
  EXPECT_EQ(heard.back(), kSimStart + request + 1ms + reply);
}

TEST(Bench, OnAnIdealLineTheAnswerComesAtTheSameInstant) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .lines = {{.timing = LineTiming::kIdeal}}});
  bench.run_until(kSimStart + 5ms);
  LineTransport transport(bench.loop(), bench.line());
  toshiba_mcu::Client client(transport);
  EXPECT_EQ(client.version(), "3.10");
  EXPECT_EQ(bench.loop().now(), kSimStart + 5ms);
}

TEST(Bench, BothIntegratorsAgreeOnARun) {
  const auto speed = [](Integrator integrator) {
    Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .integrator = integrator});
    start(bench, 1500);
    bench.run_until(kSimStart + 3s);
    return bench.read("motor1.speed");
  };
  EXPECT_NEAR(speed(Integrator::kDefault), speed(Integrator::kFast), 3);
}

BenchOptions two_drives() {
  return {.drives = {{.kind = "toshiba-mcu", .name = "left", .line = "a"},
                     {.kind = "toshiba-mcu", .name = "right", .line = "b", .motors = {"dr38312"}}},
          .lines = {{.name = "a"}, {.name = "b", .baud = 9600}},
          .integrator = Integrator::kFast};
}

TEST(Bench, SeveralDrivesHaveTheirNamesLinesMotorsAndNoise) {
  Bench bench(two_drives());
  bench.host(bench.drive("left"))->start_motor(1, 1000);
  bench.run_for(3s);
  EXPECT_NEAR(bench.read("left.motor1.speed"), 1000, 10);
  EXPECT_EQ(bench.read("right.motor1.speed"), 0);
  EXPECT_EQ(bench.drive("right").motor(0).name, "dr38312");
  EXPECT_EQ(bench.line("b").settings().baud, 9600);
  EXPECT_EQ(&bench.drive("left").line(), &bench.line("a"));
  EXPECT_GT(bench.line("a").counters().to_device, 0U);
  EXPECT_EQ(bench.line("b").counters().to_device, 0U);
}

TEST(Bench, RefusesWhatDoesNotFitTogether) {
  const auto error_of = [](const BenchOptions& options) -> std::string {
    try {
      const Bench bench(options);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "accepted";
  };
  const DriveSpec drive{.kind = "toshiba-mcu"};
  DriveSpec lost = drive, two_motors = drive;
  lost.line = "lime";
  lost.name = "second";
  two_motors.motors = {"db42s03", "db42s03"};
  EXPECT_EQ(error_of({}), "a bench needs a drive");
  EXPECT_EQ(error_of({.drives = {drive, drive}}), "two drives named ''");
  EXPECT_EQ(error_of({.drives = {drive}, .lines = {{}, {}}}), "two lines named 'line'");
  EXPECT_EQ(error_of({.drives = {drive}, .lines = {{}, {.name = "b"}}}), "no drive is on line 'b'");
  EXPECT_EQ(error_of({.drives = {drive, lost}}),
            "drive 'second': unknown line 'lime'; did you mean line? (known: line)");
  EXPECT_EQ(error_of({.drives = {drive}, .lines = {{.echo = true}}}),
            "line 'line': a host hears itself on a half-duplex line only, and this one is full "
            "duplex");
  DriveSpec unfed = drive;
  unfed.supply = "pack";
  EXPECT_EQ(error_of({.drives = {unfed}, .supplies = {{"pact", {}}}}),
            "unknown supply 'pack'; did you mean pact? (known: pact)");
  DriveSpec three_ports = drive;
  three_ports.other_lines = {"line", "line"};
  EXPECT_EQ(error_of({.drives = {three_ports}}),
            "drive '': 3 lines for toshiba-mcu: it has 2 ports");
  EXPECT_EQ(error_of({.drives = {two_motors}}),
            "2 motors for toshiba-mcu: it has 3 channels; name one, or one each");
}

TEST(Bench, DrivesShareALineAndTalkOverEachOther) {
  const DriveSpec drive{.kind = "toshiba-mcu"};
  DriveSpec other = drive;
  other.name = "other";
  Bench bench({.drives = {drive, other}, .lines = {{.duplex = Duplex::kHalf}}});
  std::size_t heard = 0;
  bench.line().on_host_byte([&](std::uint8_t, SimTime) { ++heard; });
  const std::uint8_t version[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
  bench.line().host_send(version);
  bench.run_for(10ms);
  EXPECT_EQ(bench.read("line.collisions"), 1);
  EXPECT_GT(heard, 0U);  // what became of two answers
  bench.drive("other").power_off();
  EXPECT_EQ(bench.host()->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
}

TEST(Bench, AHostOnTwoWiresMayHearItself) {
  Bench bench(
      {.drives = {{.kind = "toshiba-mcu"}}, .lines = {{.duplex = Duplex::kHalf, .echo = true}}});
  std::vector<std::uint8_t> heard;
  bench.line().on_host_byte([&](std::uint8_t byte, SimTime) { heard.push_back(byte); });
  const std::uint8_t version[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
  bench.line().host_send(version);
  bench.run_for(10ms);
  ASSERT_EQ(heard.size(), 11U);
  EXPECT_TRUE(std::equal(std::begin(version), std::end(version), heard.begin()));
}

TEST(Bench, ASecondPortHasALineOfItsOwn) {
  Bench bench({.drives = {{.kind = "toshiba-mcu", .other_lines = {"scope"}}},
               .lines = {{}, {.name = "scope"}}});
  std::size_t heard = 0;
  bench.line("scope").on_host_byte([&](std::uint8_t, SimTime) { ++heard; });
  EXPECT_EQ(bench.line("scope").settings().baud, 5'000'000);
  start(bench, 1000);
  bench.host()->call("ConfigureHsDSO", {1, 1, 7, 0});  // three signals, each PWM period
  bench.run_for(100ms);
  EXPECT_GT(bench.read("scope.frames"), 1000);
  EXPECT_EQ(bench.read("scope.missed"), 0);
  EXPECT_NEAR(double(heard), bench.read("scope.frames") * 11, 11);
}

TEST(Bench, DrivesShareASupply) {
  Bench bench({.drives = {{.kind = "toshiba-mcu", .name = "left", .line = "a", .supply = "pack"},
                          {.kind = "toshiba-mcu", .name = "right", .line = "b", .supply = "pack"}},
               .lines = {{.name = "a"}, {.name = "b"}},
               .supplies = {{"pack", {.source_v = 24, .resistance_ohm = 2}}},
               .integrator = Integrator::kFast});
  EXPECT_NEAR(bench.read("right.bus0.voltage"), 24, 1e-9);
  bench.host(bench.drive("left"))->start_motor(1, 2000);
  bench.set("left.load1.brake_torque", 0.02);
  bench.run_for(4s);
  EXPECT_LT(bench.read("right.bus0.voltage"), 23.9);  // pulled down by the other's motor
  EXPECT_EQ(bench.read("right.bus0.voltage"), bench.read("left.bus1.voltage"));
  EXPECT_NEAR(bench.read("right.bus0.current"), (24 - bench.read("right.bus0.voltage")) / 2, 1e-6);
  bench.set("pack.voltage", 20);
  EXPECT_EQ(bench.read("left.supply2.voltage"), 20);
}

TEST(Bench, ALostPhaseHasItsName) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .integrator = Integrator::kFast});
  start(bench, 2000);
  bench.run_for(3s);
  bench.registry().inject("motor1.phase_b_open");
  bench.run_for(100ms);
  EXPECT_NEAR(bench.read("motor1.current_b"), 0, 1e-6);
  bench.registry().clear_faults();
  EXPECT_EQ(bench.read("motor1.phase_b_open"), 0);
  bench.registry().inject("load1.locked");
  bench.run_for(500ms);
  EXPECT_EQ(bench.read("motor1.speed"), 0);
}

TEST(Bench, LineFaultsHaveNames) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  bench.registry().inject("line.to_host_cut");
  EXPECT_THROW(host->call("GetFWVersion", {0}), ClientError);
  bench.registry().clear("line.to_host_cut");
  EXPECT_EQ(host->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
  bench.registry().inject("line.to_drives_lost", 1);
  EXPECT_THROW(host->call("GetFWVersion", {0}), ClientError);
  bench.registry().clear_faults();
  const SimTime before = bench.loop().now();
  EXPECT_EQ(host->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
  const SimDuration usual = bench.loop().now() - before;
  bench.set("line.to_drives_delay", 0.01);
  bench.registry().inject("line.to_drives_delayed");
  EXPECT_EQ(host->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
  // Five bytes, each 10 ms late; a character time is rounded to 1 ns anew after each gap.
  EXPECT_NEAR(seconds(bench.loop().now() - before), seconds(2 * usual + 5 * 10ms), 1e-8);
}

TEST(Bench, RunsUntilAConditionHoldsOrTheTimeIsOver) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}, .integrator = Integrator::kFast});
  start(bench, 2000);
  EXPECT_TRUE(bench.run_until(kSimStart + 5s, [&] { return bench.read("motor1.speed") >= 1500; }));
  EXPECT_NEAR(bench.read("motor1.speed"), 1500, 2);
  EXPECT_LT(bench.loop().now(), kSimStart + 4s);
  const SimTime limit = bench.loop().now() + 1s;
  EXPECT_FALSE(bench.run_until(limit, [&] { return bench.read("motor1.speed") > 9000; }));
  EXPECT_EQ(bench.loop().now(), limit);
}

TEST(BenchDrive, WithoutPowerItIsSilentAndItsRotorTurnsOn) {
  Bench bench({.drives = {{.kind = "toshiba-mcu", .load = "inertia:2000gcm2"}},
               .integrator = Integrator::kFast});
  start(bench, 1500);
  bench.run_until(kSimStart + 4s);
  const auto host = bench.host();
  host->set("1.MaxAngAcc=800");
  bench.drive().power_off();
  EXPECT_FALSE(bench.drive().powered());
  EXPECT_THROW(host->get("1.MaxAngAcc"), ClientError);
  bench.run_for(100ms);
  EXPECT_EQ(bench.read("drive1.stage"), 0);
  EXPECT_NEAR(bench.read("motor1.current_q"), 0, 1e-6);
  EXPECT_GT(bench.read("motor1.speed"), 1000);

  bench.drive().power_on();
  EXPECT_EQ(host->get("1.MaxAngAcc").value, 300);  // what was in RAM only is gone
  EXPECT_EQ(bench.read("drive1.speed_target"), 0);
  EXPECT_GT(bench.read("motor1.speed"), 500);
}

TEST(BenchDrive, WhatItStoredOutlivesAPowerCycle) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  host->set("1.MaxAngAcc=800");
  host->call("StoreParameters", {1});
  host->set("1.MaxAngAcc=900");
  bench.drive().power_off();
  bench.run_for(1s);
  bench.drive().power_on();
  EXPECT_EQ(host->get("1.MaxAngAcc").value, 800);
}

TEST(BenchDrive, AResetLosesWhatWasNotStoredAndIsTold) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  EXPECT_EQ(host->get("ResetStatus").value, 1);
  EXPECT_EQ(host->get("ResetStatus").value, 0);
  bench.set("board1.temperature", 60);
  bench.drive().reset();
  EXPECT_EQ(host->get("ResetStatus").value, 1);
  EXPECT_EQ(bench.read("board1.temperature"), 60);  // the world around it does not start anew
}

TEST(BenchDrive, AResetCutsOffWhatItWasSaying) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  std::size_t heard = 0;
  bench.line().on_host_byte([&](std::uint8_t, SimTime) { ++heard; });
  const std::uint8_t version[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
  bench.line().host_send(version);
  ASSERT_TRUE(bench.run_until(kSimStart + 10ms, [&] { return heard == 2; }));
  bench.drive().reset();
  bench.run_for(10ms);
  EXPECT_LT(heard, 6U);
  EXPECT_EQ(bench.host()->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
}

TEST(HostClient, SpeaksTheWordsOfTheProtocol) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  host->set("2.IqStart=1200mA");
  EXPECT_EQ(host->get("2.IqStart").value, 1200);
  EXPECT_EQ(host->get("2.IqStart").unit, "mA");
  EXPECT_EQ(host->call("GetFWVersion", {0}), (protocol::Values{3, 10}));
  EXPECT_THROW(host->call("GetFWVersions", {0}), SetupError);
  EXPECT_THROW(host->get("3.IqStart"), SetupError);
  EXPECT_THROW(host->set("IqStart=-1mA"), ClientError);
}

TEST(Client, TellsARefusalASilenceAndADamagedAnswerApart) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  LineTransport transport(bench.loop(), bench.line());
  toshiba_mcu::Client client(transport);
  const auto error_of = [&](auto&& act) -> std::string {
    try {
      act();
    } catch (const ClientError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(error_of([&] { client.stop_motor(1); }), "StopMotor: refused with code -1");
  EXPECT_EQ(error_of([&] { client.get(1, "Speed"); }),
            "GetOneMotorParameter: refused with code -1");
  bench.line().device(0).set_baud(9600);
  bench.line().set_host({.baud = 115200});
  EXPECT_EQ(error_of([&] { client.version(); }), "GetFWVersion: the drive does not answer");
}

}  // namespace
}  // namespace virtdrive
