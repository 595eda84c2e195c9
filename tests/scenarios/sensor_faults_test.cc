// What a broken sensor does to a drive: by the registry's names, in the drive's own words.
#include <cmath>
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "firmware_models/md/protections.h"
#include "firmware_models/toshiba_mcu/stage.h"
#include "scenarios/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

// --- Toshiba MCU ---------------------------------------------------------------------------------

class ToshibaMcuSensors : public testing::Test {
 protected:
  void run(int encoder, int usage, double rpm = 1500, std::vector<std::string> more = {}) {
    std::vector<std::string> set{fmt::format("1.Encoder={}", encoder),
                                 fmt::format("1.EncoderUsage={}", usage)};
    set.insert(set.end(), more.begin(), more.end());
    bench_ = std::make_unique<Bench>(BenchOptions{
        .drives = {{.kind = "toshiba-mcu", .load = "brake:5mNm,inertia:1e-5", .set = set}},
        .integrator = Integrator::kFast});
    bench_->host()->start_motor(1, rpm);
    bench_->run_for(4s);
    EXPECT_NEAR(read("motor1.speed"), rpm, 20);
  }
  double read(std::string_view name) { return bench_->read(name); }
  void inject(std::string_view fault, double severity = 1) {
    bench_->registry().inject(fault, severity);
  }
  bool tripped(toshiba_mcu::Fault fault) {
    return (static_cast<unsigned>(read("drive1.errors")) >> static_cast<unsigned>(fault) & 1U) != 0;
  }
  bool trips(toshiba_mcu::Fault fault, SimDuration within) {
    return bench_->run_until(bench_->loop().now() + within, [&] { return tripped(fault); });
  }

  std::unique_ptr<Bench> bench_;
};

TEST_F(ToshibaMcuSensors, ADeadHallSensorMakesTheSpeedAThirdTooSmallAndTheRotorRunsTooFast) {
  run(1, 1);
  inject("hall1.a_stuck", 2);
  bench_->run_for(4s);
  EXPECT_NEAR(read("drive1.speed"), 1500, 30);
  EXPECT_NEAR(read("motor1.speed"), 1500 * 1.5, 50);
  bench_->registry().clear_faults();
  bench_->run_for(4s);
  EXPECT_NEAR(read("motor1.speed"), 1500, 20);
}

TEST_F(ToshibaMcuSensors, AMisplacedHallSensorCostsNoCounts) {
  run(1, 1);
  inject("hall1.b_misplaced", 20);
  const double angle = read("motor1.angle"), count = read("drive1.encoder");
  bench_->run_for(2s);
  EXPECT_NEAR(read("drive1.encoder") - count, (read("motor1.angle") - angle) / 360 * 24, 2);
  EXPECT_NEAR(read("motor1.speed"), 1500, 30);
}

TEST_F(ToshibaMcuSensors, ABrokenEncoderCableIsAStall) {
  run(3, 1);
  const double count = read("drive1.encoder");
  inject("encoder1.cable_broken");
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kStall, 2s));
  EXPECT_EQ(read("drive1.encoder"), count);
  EXPECT_EQ(read("drive1.stage"), 0);
}

TEST_F(ToshibaMcuSensors, ALostIndexIsAStallWhereItIsAllThatIsCounted) {
  run(5, 1, 1500, {"1.EncoderResolution=1"});
  inject("encoder1.index_dead");
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kStall, 2s));
}

TEST_F(ToshibaMcuSensors, ALostMagnetIsAStallOfTheMagneticEncoder) {
  run(6, 1);
  inject("encoder1.magnet_lost");
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kStall, 2s));
}

TEST_F(ToshibaMcuSensors, ASlippedDiscAndMissedCountsMoveThePosition) {
  run(3, 0, 0);
  const double count = read("drive1.encoder");
  inject("encoder1.slip", 90);
  EXPECT_EQ(read("drive1.encoder"), count - 500);
  inject("encoder1.missed", 7);
  EXPECT_EQ(read("drive1.encoder"), count - 507);
  bench_->registry().clear_faults();
  EXPECT_EQ(read("drive1.encoder"), count);
}

TEST_F(ToshibaMcuSensors, AnOffsetThatComesWhileItRunsIsTakenForCurrentAndOneFromBeforeIsNot) {
  run(0, 0);
  const auto mean_of_phase_a = [&] {
    double sum = 0;
    const int kSamples = 4000;
    for (int i = 0; i < kSamples; ++i) {
      bench_->run_for(100us);
      sum += read("motor1.current_a");
    }
    return sum / kSamples;
  };
  EXPECT_NEAR(mean_of_phase_a(), 0, 0.01);
  inject("shunt1.a_offset", 0.15);
  bench_->run_for(200ms);
  // The controllers keep what they measure free of it, as well as they follow 100 Hz; two thirds of
  // it at the best, the rest goes into b and c.
  const double mean = mean_of_phase_a();
  EXPECT_GT(mean, -0.1);
  EXPECT_LT(mean, -0.03);

  bench_->host()->stop_motor(1);
  bench_->run_for(5s);
  bench_->host()->start_motor(1, 1500);  // measures its zero anew
  bench_->run_for(4s);
  EXPECT_NEAR(mean_of_phase_a(), 0, 0.01);
}

TEST_F(ToshibaMcuSensors, AGainErrorIsACurrentThatIsTooSmall) {
  run(0, 0);
  const double iq = read("drive1.current_q_ref");
  for (const char phase : {'a', 'b', 'c'}) inject(fmt::format("shunt1.{}_gain", phase), 0.5);
  bench_->run_for(1s);
  EXPECT_NEAR(read("drive1.current_q_ref") / iq, 1.5, 0.1);  // the torque has not changed
  EXPECT_NEAR(read("motor1.speed"), 1500, 20);
}

TEST_F(ToshibaMcuSensors, AConverterAtItsEndIsAnEmergency) {
  run(0, 0);
  inject("shunt1.b_stuck", 2);
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kEmergency, 1ms));
  EXPECT_EQ(read("drive1.stage"), 7);
}

TEST_F(ToshibaMcuSensors, ADividerThatReadsTooMuchOrTooLittleTripsItsLimits) {
  run(0, 0);
  inject("divider1.gain", 0.3);
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kSoftwareOverVoltage, 5ms));
  run(0, 0);
  inject("divider1.stuck", 1);
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kSoftwareUnderVoltage, 5ms));
}

TEST_F(ToshibaMcuSensors, ShortsTrip) {
  run(0, 0);
  inject("motor1.phases_shorted");
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kEmergency, 10ms));
  run(0, 0);
  inject("bridge1.upper_a_stuck", 2);
  EXPECT_TRUE(trips(toshiba_mcu::Fault::kSoftwareUnderVoltage, 10ms)) << "the supply is shorted";
}

// --- MD ------------------------------------------------------------------------------------------

class MdSensors : public testing::Test {
 protected:
  void run(double rpm, std::vector<std::string> set = {}, bool encoder = false) {
    bench_ = std::make_unique<Bench>(
        BenchOptions{.drives = {{.kind = "md400", .load = "brake:0.2Nm", .set = std::move(set)}},
                     .integrator = Integrator::kFast});
    if (encoder) bench_->set("encoder0.lines", 1000);
    bench_->host()->start_motor(0, rpm);
    bench_->run_for(4s);
    EXPECT_NEAR(read("motor0.speed"), rpm, 20);
  }
  double read(std::string_view name) { return bench_->read(name); }
  void inject(std::string_view fault, double severity = 1) {
    bench_->registry().inject(fault, severity);
  }
  bool has(std::string_view signal, int bits, SimDuration within) {
    return bench_->run_until(bench_->loop().now() + within,
                             [&] { return (static_cast<int>(read(signal)) & bits) == bits; });
  }
  double rpm_spread() {
    double least = 1e9, most = -1e9;
    for (int i = 0; i < 500; ++i) {
      bench_->run_for(1ms);
      least = std::min(least, read("drive0.speed"));
      most = std::max(most, read("drive0.speed"));
    }
    return most - least;
  }

  std::unique_ptr<Bench> bench_;
};

TEST_F(MdSensors, ADeadHallSensorIsFoundWhereItsForbiddenCodeLasts) {
  run(300);
  inject("hall0.b_stuck", 1);
  bench_->run_for(500ms);
  EXPECT_TRUE(has("drive0.status", md::kHallFail, 5s));
}

TEST_F(MdSensors, AMisplacedHallSensorMakesTheSpeedUneven) {
  run(300);
  const double even = rpm_spread();
  inject("hall0.b_misplaced", 15);
  EXPECT_LE(even, 10);
  EXPECT_GT(rpm_spread(), 50);
}

TEST_F(MdSensors, AnEncoderWhoseCableBreaksIsEncFail) {
  run(300, {"ENC_PPR=1000"}, true);
  inject("encoder0.cable_broken");
  EXPECT_TRUE(has("drive0.status2", md::kEncFail, 3s));
}

TEST_F(MdSensors, AShuntOutOfTrueIsTakenForCurrent) {
  run(300);
  const double before = read("drive0.current");
  inject("shunt0.offset", 3);
  bench_->run_for(200ms);
  EXPECT_NEAR(read("drive0.current"), before + 3, 0.5);
  inject("shunt0.stuck", 2);
  bench_->run_for(1s);
  EXPECT_GT(read("drive0.current"), 15);
  EXPECT_NEAR(read("motor0.speed"), 0, 1) << "the limiter cuts each period at once";
}

TEST_F(MdSensors, ShortedPhasesAreHeldByTheLimiter) {
  run(300);
  inject("motor0.phases_shorted");
  bench_->run_for(500ms);
  EXPECT_GT(read("drive0.current"), 5);
  EXPECT_NEAR(read("motor0.speed"), 0, 1);
}

}  // namespace
}  // namespace virtdrive
