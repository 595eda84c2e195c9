#include "pty/pacer.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr WallTime kStart{1000s};

TEST(Pacer, SimulatedTimeFollowsTheWallClockAtTheRate) {
  EXPECT_EQ(Pacer(1, kSimStart + 5s, kStart).sim_at(kStart + 1'234'567ns),
            kSimStart + 5s + 1'234'567ns);
  EXPECT_EQ(Pacer(0.1, kSimStart, kStart).sim_at(kStart + 1s), kSimStart + 100ms);
  EXPECT_EQ(Pacer(10, kSimStart, kStart).sim_at(kStart + 1s), kSimStart + 10s);
  EXPECT_EQ(Pacer(10, kSimStart, kStart).wall_at(kSimStart + 1s), kStart + 100ms);
}

TEST(Pacer, AnInstantIsReachedWhenItsWallTimeHasCome) {
  for (const double rate : {0.1, 0.3, 1.0, 7.0}) {
    const Pacer pacer{rate, kSimStart, kStart};
    for (std::int64_t ns = 1; ns < 1'000'000'000'000; ns = ns * 3 + 1) {
      const SimTime sim = kSimStart + SimDuration{ns};
      const SimDuration early = sim - pacer.sim_at(pacer.wall_at(sim));
      EXPECT_LE(early, 1ns) << rate << " " << ns;  // then the runner just looks once more
    }
  }
}

TEST(Pacer, NeverNeverComes) {
  EXPECT_EQ(Pacer(1, kSimStart, kStart).wall_at(kNever), WallTime::max());
  EXPECT_EQ(Pacer(1e-6, kSimStart, kStart).wall_at(kNever), WallTime::max());
}

TEST(Pacer, ASmallLagIsMeasuredAndCaughtUpWith) {
  Pacer pacer{1, kSimStart, kStart};
  pacer.resume(kSimStart + 1ms, kStart + 3ms);
  pacer.resume(kSimStart + 3ms, kStart + 3ms);
  EXPECT_EQ(pacer.report().max_lag, 2ms);
  EXPECT_EQ(pacer.report().overruns, 0U);
  EXPECT_EQ(pacer.sim_at(kStart + 3ms), kSimStart + 3ms);
}

TEST(Pacer, BeingWokenEarlyIsNoLag) {
  Pacer pacer{1, kSimStart, kStart};
  pacer.resume(kSimStart + 10ms, kStart + 1ms);
  EXPECT_EQ(pacer.report().max_lag, 0ms);
}

TEST(Pacer, ALagOverTenMillisecondsIsOneOverrunUntilItIsCaughtUp) {
  Pacer pacer{1, kSimStart, kStart};
  pacer.resume(kSimStart, kStart + 10ms);
  EXPECT_EQ(pacer.report().overruns, 0U);
  pacer.resume(kSimStart + 1ms, kStart + 12ms);
  pacer.resume(kSimStart + 2ms, kStart + 20ms);
  EXPECT_EQ(pacer.report().overruns, 1U);
  pacer.resume(kSimStart + 20ms, kStart + 21ms);
  pacer.resume(kSimStart + 21ms, kStart + 40ms);
  EXPECT_EQ(pacer.report().overruns, 2U);
  EXPECT_EQ(pacer.report().max_lag, 19ms);
  EXPECT_EQ(pacer.report().slips, 0U);
  EXPECT_EQ(pacer.sim_at(kStart + 40ms), kSimStart + 40ms);  // runs flat out
}

TEST(Pacer, ALagOverFiftyMillisecondsIsGivenUpAndCounted) {
  Pacer pacer{1, kSimStart, kStart};
  pacer.resume(kSimStart + 5ms, kStart + 55ms);
  EXPECT_EQ(pacer.report().slips, 0U);
  pacer.resume(kSimStart + 5ms, kStart + 56ms);
  EXPECT_EQ(pacer.report().slips, 1U);
  EXPECT_EQ(pacer.report().slipped, 51ms);
  EXPECT_EQ(pacer.report().overruns, 1U);
  EXPECT_EQ(pacer.sim_at(kStart + 56ms), kSimStart + 5ms);
  EXPECT_EQ(pacer.sim_at(kStart + 60ms), kSimStart + 9ms);
  pacer.resume(kSimStart + 9ms, kStart + 160ms);  // late again: counted again
  EXPECT_EQ(pacer.report().slips, 2U);
  EXPECT_EQ(pacer.report().slipped, 151ms);
  EXPECT_EQ(pacer.report().overruns, 2U);
  EXPECT_EQ(pacer.report().max_lag, 100ms);
}

TEST(Pacer, LagIsMeasuredByTheWallClockWhateverTheRate) {
  Pacer slow{0.1, kSimStart, kStart};
  slow.resume(kSimStart + 1ms, kStart + 21ms);  // was due after 10 ms
  EXPECT_EQ(slow.report().max_lag, 11ms);
  EXPECT_EQ(slow.report().overruns, 1U);
}

TEST(Pacer, TheRateChangesWithoutAJumpAndStandsStillAtNought) {
  Pacer pacer{1, kSimStart, kStart};
  pacer.set_rate(10, kSimStart + 20ms, kStart + 20ms);
  EXPECT_EQ(pacer.sim_at(kStart + 30ms), kSimStart + 120ms);
  pacer.set_rate(0, kSimStart + 120ms, kStart + 30ms);
  EXPECT_EQ(pacer.sim_at(kStart + 10s), kSimStart + 120ms);
  EXPECT_EQ(pacer.wall_at(kSimStart + 121ms), WallTime::max());
  pacer.resume(kSimStart + 120ms, kStart + 10s);
  EXPECT_EQ(pacer.report().overruns, 0U);
  pacer.set_rate(1, kSimStart + 120ms, kStart + 10s);
  EXPECT_EQ(pacer.sim_at(kStart + 10s + 5ms), kSimStart + 125ms);
}

TEST(PacerDeathTest, ARateOfNothingIsAProgrammersError) {
  EXPECT_DEATH(Pacer(0, kSimStart, kStart), "a pacing rate of 0");
}

}  // namespace
}  // namespace virtdrive
