// The 7-Series drives on a bench: their names, their words, their power.
#include <gtest/gtest.h>

#include "core/check.h"
#include "scenarios/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

std::string error_of(const std::string& set, const std::string& kind = "asd7") {
  try {
    const Bench bench({.drives = {{.kind = kind, .set = {set}}}});
  } catch (const SetupError& error) {
    return error.what();
  }
  return "accepted";
}

double read(const std::string& set, const std::string& parameter,
            const std::string& kind = "asd7") {
  Bench bench({.drives = {{.kind = kind, .set = {set}}}});
  return bench.host()->get(parameter).value;
}

TEST(Asd7Bench, AParameterIsSetByNameOrNumberInItsUnitOrAsAWord) {
  for (const char* set : {"ACC=5s", "ACC=5", "acc=5000ms", "0009=5s", "F009=0x32"}) {
    EXPECT_EQ(read(set, "ACC"), 5) << set;
  }
  EXPECT_EQ(read("F803=3s", "0803"), 3);
  EXPECT_EQ(read("ACC=5s", "00.ACC"), 5);
  EXPECT_EQ(read("Sr1=12.34Hz", "Sr1", "asd7-modbus"), 12.34);
}

TEST(Asd7Bench, WhatIsWrongInASettingIsSaid) {
  EXPECT_NE(error_of("ACCC=5s").find("did you mean ACC?"), std::string::npos);
  EXPECT_NE(error_of("ACC=5Hz").find("ACC is in s"), std::string::npos);
  EXPECT_NE(error_of("ACC=0.01s").find("counts in steps of 0.1 s"), std::string::npos);
  EXPECT_NE(error_of("FH=600Hz").find("refused; FH is 30 ... 500 Hz"), std::string::npos);
  EXPECT_NE(error_of("trip=0").find("cannot be written"), std::string::npos);
  EXPECT_NE(error_of("error_sum=sometimes").find("mirror"), std::string::npos);
  EXPECT_EQ(error_of("error_sum=always"), "accepted");
}

TEST(Asd7Bench, EachSizeAndProtocolTurnsItsMotor) {
  for (const char* kind : {"asd7", "asd7-4kw", "asd7-22kw", "asd7-modbus", "asd7-22kw-modbus"}) {
    Bench bench({.drives = {{.kind = kind, .set = {"ACC=3s"}}}, .integrator = Integrator::kFast});
    bench.host()->start_motor(0, -900);
    EXPECT_TRUE(bench.run_until(kSimStart + 4s, [&] { return bench.read("motor0.speed") < -850; }))
        << kind << " " << bench.drive().controller().status();
    EXPECT_LT(bench.read("drive0.output_frequency"), -28) << kind;
    EXPECT_NE(bench.drive().controller().status().find("reverse"), std::string::npos);
  }
}

TEST(Asd7Bench, ADipOfTheMainsAndALostPhaseHaveNames) {
  Bench bench({.drives = {{.kind = "asd7"}}, .integrator = Integrator::kFast});
  EXPECT_NEAR(bench.read("supply0.voltage"), 230, 1e-9);
  bench.set("supply0.voltage", 100);
  EXPECT_NEAR(bench.read("supply0.voltage"), 100, 1e-9);
  bench.registry().inject("supply0.phase_s_lost");
  EXPECT_EQ(bench.read("supply0.phase_s_lost"), 1);
  bench.registry().clear_faults();
  EXPECT_EQ(bench.read("supply0.phase_s_lost"), 0);
}

TEST(Asd7Bench, WithoutMainsTheCpuDiesAndComesBack) {
  Bench bench({.drives = {{.kind = "asd7"}}, .integrator = Integrator::kFast});
  bench.drive().power_off();
  bench.run_for(30s);
  EXPECT_EQ(bench.read("drive0.alive"), 0);
  bench.drive().power_on();
  EXPECT_TRUE(
      bench.run_until(bench.loop().now() + 5s, [&] { return bench.read("drive0.alive") > 0; }));
}

TEST(Asd7Bench, AKeyOfThePanelActsAsItGoesDown) {
  Bench bench({.drives = {{.kind = "asd7", .set = {"CMOD=1", "FMOD=0", "ACC=1s"}}},
               .integrator = Integrator::kFast});
  bench.set("panel0.frequency", 20);
  bench.set("panel0.run", 1);
  bench.run_for(1s);
  EXPECT_NEAR(bench.read("drive0.output_frequency"), 20, 0.01);
}

}  // namespace
}  // namespace virtdrive
