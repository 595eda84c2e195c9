#include "firmware_models/toshiba_mcu/oscilloscope.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <set>

#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

// Bits of selected_values (4.2.6).
constexpr unsigned kVa = 0, kVb = 1, kVc = 2, kId = 5, kIqRef = 8, kVdi = 11, kVqi = 12;
constexpr unsigned kTheta = 13, kOmega = 14, kSin = 16, kCos = 17, kSector = 18, kVdc = 19;
constexpr unsigned kIa = 20, kIb = 21, kIc = 22, kIalpha = 23, kIbeta = 24, kStage = 25;
constexpr unsigned kUser1 = 26;

constexpr std::uint32_t mask(std::initializer_list<unsigned> bits) {
  std::uint32_t all = 0;
  for (const unsigned bit : bits) all |= 1U << bit;
  return all;
}

using Values = std::vector<std::int16_t>;

// Everything that the scope can be asked for, until it refuses.
Values fetch(SnapshotScope& scope) {
  Values all;
  std::array<std::int16_t, SnapshotScope::kBlock> block{};
  while (scope.next_block(block) == Outcome::kDone) {
    all.insert(all.end(), block.begin(), block.end());
  }
  return all;
}

Outcome ask(SnapshotScope& scope) {
  std::array<std::int16_t, SnapshotScope::kBlock> block{};
  return scope.next_block(block);
}

class Scope : public testing::Test {
 protected:
  void run(std::int32_t rpm = 2000) { rig_.run_up(rpm); }
  SnapshotScope& scope() { return rig_.firmware.snapshot_scope(); }
  /// One signal alone, each period; 320 values.
  Values shot(unsigned bit, std::uint8_t spread = 0) {
    EXPECT_EQ(scope().arm({.motor = 1, .selected = 1U << bit, .spread = spread}), 20);
    rig_.run_for((spread + 1) * 321 * 80us);
    return fetch(scope());
  }
  Rig rig_;
};

// --- The example and the sizes -------------------------------------------------------------------

TEST_F(Scope, ThreeSignalsAreTwentyBlocksAsInTheExample) {
  EXPECT_EQ(scope().arm({.motor = 1, .selected = 7}), 20);
}

TEST_F(Scope, NoSignalAndMoreThanSixteenArmNothing) {
  EXPECT_EQ(scope().arm({.motor = 1, .selected = 0}), 0);
  EXPECT_EQ(ask(scope()), Outcome::kRefused);
  EXPECT_EQ(scope().arm({.motor = 1, .selected = 0x1FFFF}), 0);
  EXPECT_EQ(ask(scope()), Outcome::kRefused);
  EXPECT_EQ(scope().arm({.motor = 1, .selected = 0xFFFF}), 20);
}

TEST_F(Scope, HasNothingBeforeItIsArmedAndIsNeverReadyWhileTheMotorIsStopped) {
  EXPECT_EQ(ask(scope()), Outcome::kRefused);
  scope().arm({.motor = 1, .selected = 7});
  rig_.run_for(10s);
  EXPECT_EQ(ask(scope()), Outcome::kNotReady);
}

TEST_F(Scope, IsReadyAfterItsDepthAndRefusesAfterTheLastBlock) {
  run();
  scope().arm({.motor = 1, .selected = 7});
  rig_.run_for(105 * 80us);
  EXPECT_EQ(ask(scope()), Outcome::kNotReady);
  rig_.run_for(2 * 80us);
  EXPECT_EQ(fetch(scope()).size(), 320U);
  EXPECT_EQ(ask(scope()), Outcome::kRefused);
}

TEST_F(Scope, TheLastBlockGoesOnFromTheStartOfTheRing) {
  run();
  scope().arm({.motor = 1, .selected = mask({kVa, kVb, kVc})});
  rig_.run_for(110 * 80us);
  const Values values = fetch(scope());
  EXPECT_EQ(values[318], values[0]);
  EXPECT_EQ(values[319], values[1]);
}

TEST_F(Scope, OnlyTheChannelThatWasNamedIsLogged) {
  run();  // channel 1
  scope().arm({.motor = 0, .selected = 1});
  rig_.run_for(1s);
  EXPECT_EQ(ask(scope()), Outcome::kNotReady);
}

TEST_F(Scope, SpreadLogsEachSoManyAndFirstPeriod) {
  run();
  const Values fine = shot(kTheta);
  const Values coarse = shot(kTheta, 4);
  const auto step = [](const Values& v) {
    double sum = 0;
    for (std::size_t i = 1; i < 100; ++i) sum += (v[i] - v[i - 1] + 32768) % 32768;
    return sum / 99;
  };
  // 133.3 Hz at 12.5 kHz: 349.5 of 32768 a period.
  EXPECT_NEAR(step(fine), 349.5, 3);
  EXPECT_NEAR(step(coarse), 5 * 349.5, 15);
}

// --- Triggers ------------------------------------------------------------------------------------

TEST_F(Scope, LeftTriggersPutTheEdgeAtTheStart) {
  run();
  for (const std::uint8_t mode : {std::uint8_t{0}, std::uint8_t{1}}) {
    scope().arm({.motor = 1,
                 .selected = mask({kSin}),
                 .trigger_on = mask({kSin}),
                 .mode = mode,
                 .level = 16384});
    rig_.run_for(60ms);
    const Values v = fetch(scope());
    ASSERT_EQ(v.size(), 320U);
    EXPECT_NEAR(v[0], 16384, 2000);
    if (mode == 1) {
      EXPECT_GE(v[0], 16384);
      EXPECT_GT(v[5], v[0]);
    } else {
      EXPECT_LE(v[0], 16384);
      EXPECT_LT(v[5], v[0]);
    }
  }
}

TEST_F(Scope, CentredTriggersPutTheEdgeIntoTheMiddle) {
  run();
  for (const std::uint8_t mode : {std::uint8_t{2}, std::uint8_t{3}}) {
    scope().arm({.motor = 1,
                 .selected = mask({kSin}),
                 .trigger_on = mask({kSin}),
                 .mode = mode,
                 .level = -8000});
    rig_.run_for(80ms);
    const Values v = fetch(scope());
    ASSERT_EQ(v.size(), 320U);
    const bool rising = mode == 3;
    EXPECT_EQ(v[159] < v[160], rising);
    EXPECT_LE(std::min(v[159], v[160]), -8000);
    EXPECT_GE(std::max(v[159], v[160]), -8000);
    for (std::size_t i = 1; i < v.size(); ++i) {
      EXPECT_NE(v[i], 0) << "no place of the ring is left unwritten";
    }
  }
}

TEST_F(Scope, ATriggerThatNeverComesIsWaitedFor) {
  run();
  scope().arm({.motor = 1, .selected = 1, .trigger_on = mask({kVdc}), .mode = 1, .level = 32000});
  rig_.run_for(5s);
  EXPECT_EQ(ask(scope()), Outcome::kNotReady);
}

TEST_F(Scope, OfSeveralTriggerSignalsTheHighestCountsAndItNeedNotBeLogged) {
  run();
  scope().arm({.motor = 1,
               .selected = mask({kSin}),
               .trigger_on = mask({kVdc, kCos}) & ~mask({kVdc}),
               .mode = 1,
               .level = 0});
  rig_.run_for(80ms);
  const Values v = fetch(scope());
  ASSERT_FALSE(v.empty());
  EXPECT_LT(v[0], -32000) << "the cosine rises through 0 where the sine is -1";
}

TEST_F(Scope, AStartIsCaughtByItsStage) {
  scope().arm({.motor = 1,
               .selected = mask({kIa, kStage}),
               .trigger_on = mask({kStage}),
               .mode = 3,
               .level = 4});
  rig_.run_up(1000, 400ms);
  const Values v = fetch(scope());
  ASSERT_EQ(v.size(), 320U);
  EXPECT_EQ(v[2 * 79 + 1], 3);
  EXPECT_EQ(v[2 * 80 + 1], 4);
}

// --- Scales --------------------------------------------------------------------------------------

TEST_F(Scope, DutiesAreQ14AboutTheMiddle) {
  run();
  double sum = 0;
  for (const std::int16_t v : shot(kVa)) sum += v;
  EXPECT_NEAR(sum / 320, 8192, 400);
}

TEST_F(Scope, TheBusIsQ15OfVmax) {
  run();
  EXPECT_NEAR(shot(kVdc)[0], 24.0 / 54 * 32768, 100);
}

TEST_F(Scope, PhaseCurrentsSumUpToNothingAndAgreeWithAlphaAndBeta) {
  run();
  rig_.set_brake(0.02);
  rig_.run_for(1s);
  scope().arm({.motor = 1, .selected = mask({kIa, kIb, kIc, kIalpha, kIbeta})});
  rig_.run_for(65 * 80us);
  const Values v = fetch(scope());
  double peak = 0;
  for (std::size_t set = 0; set < 64; ++set) {
    const auto* i = &v[5 * set];
    EXPECT_NEAR(i[0] + i[1] + i[2], 0, 60);
    EXPECT_NEAR(i[3], (2 * i[0] - i[1] - i[2]) / 3.0, 1.5);
    EXPECT_NEAR(i[4], (i[1] - i[2]) / std::numbers::sqrt3, 1.5);
    peak = std::max(peak, std::hypot(i[3], i[4]));
  }
  // 23 mNm and the friction over 34 mNm/A: 0.7 A of a_max = 7.911 A.
  EXPECT_NEAR(peak, 0.70 / 7.911 * 32768, 250);
}

TEST_F(Scope, SpeedAngleAndItsSineFitTogether) {
  run();
  EXPECT_NEAR(shot(kOmega)[100], 2000 * 4 / 60.0 / 420 * 32768, 60);
  scope().arm({.motor = 1, .selected = mask({kTheta, kSin, kCos, kSector})});
  rig_.run_for(81 * 80us);
  const Values v = fetch(scope());
  for (std::size_t set = 0; set < 80; ++set) {
    const auto* s = &v[4 * set];
    EXPECT_GE(s[0], 0);
    const double angle = s[0] / 32768.0 * 2 * std::numbers::pi;
    EXPECT_NEAR(s[1], 32768 * std::sin(angle), 20);
    EXPECT_NEAR(s[2], 32768 * std::cos(angle), 20);
    EXPECT_EQ(s[3], s[0] * 12 / 32768);
  }
}

TEST_F(Scope, CurrentsAndVoltagesOfTheFrameAreQ15) {
  run();
  const LoopState& now = rig_.channel().internals();
  EXPECT_EQ(shot(kStage)[0], 6);
  EXPECT_NEAR(shot(kIqRef).back(), now.iq_ref_a / (2.5 / 0.316) * 32768, 60);
  EXPECT_NEAR(shot(kVqi).back(), now.vq_integral_v / 54 * 32768, 60);
  EXPECT_NEAR(shot(kVdi).back(), now.vd_integral_v / 54 * 32768, 60);
  EXPECT_NEAR(shot(kId).back(), 0, 60);
}

TEST_F(Scope, TheUserVariablesAreWhatTheirNamesSay) {
  run();
  EXPECT_NEAR(shot(kUser1)[0], 2000 * 4 / 60.0 / 420 * 32768, 5);
  EXPECT_NEAR(shot(kUser1 + 1)[0], rig_.channel().current_ma() / 7911.0 * 32768, 60);
  EXPECT_EQ(shot(kUser1 + 2)[0], 2000);
  EXPECT_NEAR(shot(kUser1 + 3)[0], 2000, 5);
  const std::int16_t counter = shot(kUser1 + 4)[319];
  EXPECT_NEAR(counter, rig_.channel().encoder().count() & 0xFFFF, 2);
  EXPECT_EQ(shot(kUser1 + 5)[0], 0);
}

TEST(ToshibaMcuScopeSignals, EachHasANameOfItsOwnAndADescription) {
  std::set<std::string_view> names;
  for (unsigned bit = 0; bit < kScopeSignals; ++bit) {
    names.insert(scope_signal_name(bit));
    EXPECT_FALSE(scope_signal_doc(bit).empty());
  }
  EXPECT_EQ(names.size(), kScopeSignals);
  EXPECT_EQ(scope_signal_name(kIa), "Ia");
}

// --- Stream --------------------------------------------------------------------------------------

TEST(ToshibaMcuStream, GivesASetEachPeriodWithItsNumberModuloTheFrequency) {
  Rig rig;
  rig.run_up(1000, 2s);
  std::vector<std::uint16_t> stamps;
  std::size_t width = 0;
  rig.firmware.stream_scope().set_sink(
      [&](std::uint16_t stamp, std::span<const std::int16_t> values) {
        stamps.push_back(stamp);
        width = values.size();
      });
  EXPECT_EQ(rig.firmware.stream_scope().enable(1, 0, 0), Outcome::kRefused);
  EXPECT_EQ(rig.firmware.stream_scope().enable(1, 0xFFFFFFFF, 0), Outcome::kDone);
  rig.run_for(1001ms);
  EXPECT_NEAR(double(stamps.size()), 12512, 2);
  EXPECT_EQ(width, 32U);
  EXPECT_EQ(stamps[0], 0);
  EXPECT_EQ(stamps[12499], 12499);
  EXPECT_EQ(stamps[12500], 0);
  rig.firmware.stream_scope().disable();
  stamps.clear();
  rig.run_for(100ms);
  EXPECT_TRUE(stamps.empty());
}

TEST(ToshibaMcuStream, SpreadLeavesPeriodsOutButCountsThem) {
  Rig rig;
  rig.run_up(1000, 2s);
  std::vector<std::uint16_t> stamps;
  rig.firmware.stream_scope().set_sink(
      [&](std::uint16_t stamp, std::span<const std::int16_t>) { stamps.push_back(stamp); });
  rig.firmware.stream_scope().enable(1, 1, 9);
  rig.run_for(10ms);
  ASSERT_GE(stamps.size(), 12U);
  EXPECT_EQ(stamps[1] - stamps[0], 10);
}

TEST(ToshibaMcuStream, StopsWithTheMotor) {
  Rig rig;
  int sets = 0;
  rig.firmware.stream_scope().set_sink(
      [&](std::uint16_t, std::span<const std::int16_t>) { ++sets; });
  rig.firmware.stream_scope().enable(1, 1, 0);
  rig.run_for(1s);
  EXPECT_EQ(sets, 0);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
