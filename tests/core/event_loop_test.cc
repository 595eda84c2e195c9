#include "core/event_loop.h"

#include <gtest/gtest.h>
#include <string>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

TEST(EventLoop, RunsTheEventsOfOneInstantInTheWrittenOrderOfPhases) {
  EventLoop loop;
  std::string order;
  std::vector<Wakeup> wakeups;
  // Registered backwards, so that only the phase can put them right.
  const std::pair<Phase, char> phases[] = {{Phase::kRecord, 'r'},
                                           {Phase::kControl, 'c'},
                                           {Phase::kDevice, 'd'},
                                           {Phase::kBytes, 'b'},
                                           {Phase::kScenario, 's'}};
  for (const auto& [phase, letter] : phases) {
    wakeups.push_back(loop.add(phase, [&order, letter = letter] { order += letter; }));
  }
  for (Wakeup& wakeup : wakeups) wakeup.at(kSimStart + 1ms);
  loop.run_until(kSimStart + 1ms);
  EXPECT_EQ(order, "sbdcr");
}

TEST(EventLoop, BreaksTiesByOrderOfRegistration) {
  EventLoop loop;
  std::string order;
  Wakeup a = loop.add(Phase::kControl, [&] { order += 'a'; });
  Wakeup b = loop.add(Phase::kControl, [&] { order += 'b'; });
  Wakeup c = loop.add(Phase::kControl, [&] { order += 'c'; });
  c.at(kSimStart + 1us);
  a.at(kSimStart + 1us);
  b.at(kSimStart + 1us);
  loop.run_until(kSimStart + 1us);
  EXPECT_EQ(order, "abc");
}

TEST(EventLoop, AByteScheduledForThisInstantStillComesBeforeTheControlStep) {
  EventLoop loop;
  std::string order;
  Wakeup bytes = loop.add(Phase::kBytes, [&] { order += 'b'; });
  Wakeup control = loop.add(Phase::kControl, [&] { order += 'c'; });
  control.at(kSimStart + 5us);
  loop.run_before(kSimStart + 5us);
  EXPECT_EQ(loop.now(), kSimStart + 5us);
  bytes.at(loop.now());  // as an endpoint does
  loop.run_until(kSimStart + 5us);
  EXPECT_EQ(order, "bc");
}

TEST(EventLoop, JumpsToTheEndWhenNothingIsDue) {
  EventLoop loop;
  loop.run_until(kSimStart + 1h);
  EXPECT_EQ(loop.now(), kSimStart + 1h);
  EXPECT_EQ(loop.next(), kNever);
  EXPECT_EQ(loop.events(), 0U);
}

TEST(EventLoop, ANewTimeReplacesTheOldOne) {
  EventLoop loop;
  int runs = 0;
  Wakeup wakeup = loop.add(Phase::kDevice, [&] { ++runs; });
  wakeup.at(kSimStart + 1ms);
  wakeup.at(kSimStart + 3ms);
  EXPECT_EQ(wakeup.due(), kSimStart + 3ms);
  loop.run_until(kSimStart + 2ms);
  EXPECT_EQ(runs, 0);
  loop.run_until(kSimStart + 3ms);
  EXPECT_EQ(runs, 1);
}

TEST(EventLoop, ACancelledOrDestroyedWakeupNeverRuns) {
  EventLoop loop;
  int runs = 0;
  Wakeup cancelled = loop.add(Phase::kDevice, [&] { ++runs; });
  cancelled.at(kSimStart + 1ms);
  cancelled.cancel();
  {
    Wakeup destroyed = loop.add(Phase::kDevice, [&] { ++runs; });
    destroyed.at(kSimStart + 1ms);
  }
  loop.run_until(kSimStart + 2ms);
  EXPECT_EQ(runs, 0);
}

TEST(EventLoop, ACallbackMayRegisterAndDestroyComponentsAndItself) {
  EventLoop loop;
  std::string order;
  Wakeup child;
  Wakeup self;
  self = loop.add(Phase::kDevice, [&] {
    order += 's';
    child = loop.add(Phase::kDevice, [&] { order += 'k'; });
    child.at(loop.now());
    self = Wakeup{};
    order += 'S';
  });
  self.at(kSimStart + 1ms);
  loop.run_until(kSimStart + 1ms);
  EXPECT_EQ(order, "sSk");
}

TEST(EventLoop, AnIntervalIsKeptExactlyOverAnHour) {
  EventLoop loop;
  std::uint64_t ticks = 0;
  Wakeup tick;
  tick = loop.add(Phase::kControl, [&] {
    ++ticks;
    tick.at(loop.now() + 1ms);
  });
  tick.at(kSimStart + 1ms);
  loop.run_until(kSimStart + 1h);
  EXPECT_EQ(ticks, 3'600'000U);
}

TEST(EventLoop, StopEndsTheRunAfterTheCallbackAndTheNextRunGoesOn) {
  EventLoop loop;
  int runs = 0;
  Wakeup a = loop.add(Phase::kDevice, [&] {
    ++runs;
    loop.stop();
  });
  Wakeup b = loop.add(Phase::kDevice, [&] { ++runs; });
  a.at(kSimStart + 1ms);
  b.at(kSimStart + 2ms);
  loop.run_until(kSimStart + 10ms);
  EXPECT_EQ(runs, 1);
  EXPECT_EQ(loop.now(), kSimStart + 1ms);
  loop.run_until(kSimStart + 10ms);
  EXPECT_EQ(runs, 2);
}

TEST(EventLoop, RunsUntilAConditionHolds) {
  EventLoop loop;
  int ticks = 0;
  Wakeup tick;
  tick = loop.add(Phase::kControl, [&] {
    ++ticks;
    tick.at(loop.now() + 1ms);
  });
  tick.at(kSimStart + 1ms);
  EXPECT_TRUE(loop.run_until(kSimStart + 1s, [&] { return ticks == 7; }));
  EXPECT_EQ(loop.now(), kSimStart + 7ms);
  EXPECT_FALSE(loop.run_until(kSimStart + 10ms, [&] { return ticks == 100; }));
  EXPECT_EQ(loop.now(), kSimStart + 10ms);
}

TEST(EventLoop, TellsTheNextEventThatAHostCouldNotice) {
  EventLoop loop;
  Wakeup control = loop.add(Phase::kControl, [] {});
  Wakeup device = loop.add(Phase::kDevice, [] {});
  control.at(kSimStart + 80us);
  device.at(kSimStart + 1ms);
  EXPECT_EQ(loop.next(), kSimStart + 80us);
  EXPECT_EQ(loop.next(Phase::kDevice), kSimStart + 1ms);
}

TEST(EventLoop, TwoLoopsLiveSideBySide) {
  EventLoop a;
  EventLoop b;
  int runs = 0;
  Wakeup wakeup = a.add(Phase::kDevice, [&] { ++runs; });
  wakeup.at(kSimStart + 1ms);
  b.run_until(kSimStart + 1s);
  EXPECT_EQ(runs, 0);
  EXPECT_EQ(a.now(), kSimStart);
}

TEST(EventLoopDeathTest, AWakeupInThePastIsAProgrammersError) {
  EventLoop loop;
  Wakeup wakeup = loop.add(Phase::kDevice, [] {});
  loop.run_until(kSimStart + 1ms);
  EXPECT_DEATH(wakeup.at(kSimStart), "a wake-up in the past: 0 ns, now 1000000 ns");
}

}  // namespace
}  // namespace virtdrive
