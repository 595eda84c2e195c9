#include "firmware_models/rzt1/profile.h"

#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <vector>

#include "core/random.h"

namespace virtdrive::rzt1 {
namespace {

constexpr MotionLimits kDefault{.velocity = 7158282, .acceleration = 14317, .deceleration = 14317};
constexpr double kOne = 65536;

struct Course {
  int cycles = 0;
  double top_velocity = 0, top_acceleration = 0;  // counts per cycle (squared)
  bool monotonous = true;
};

// Until it is idle; position is where the velocity says within rounding.
Course run(Profile& profile, int direction = 1, int patience = 1'000'000) {
  Course result;
  std::int32_t before = profile.position();
  while (profile.state() != ProfileState::kIdle && result.cycles < patience) {
    profile.step();
    ++result.cycles;
    result.top_velocity = std::max(result.top_velocity, std::abs(profile.velocity() / kOne));
    result.top_acceleration =
        std::max(result.top_acceleration, std::abs(profile.acceleration() / kOne));
    if ((profile.position() - before) * direction < 0) result.monotonous = false;
    before = profile.position();
  }
  return result;
}

double top_speed(double distance, const MotionLimits& limits) {
  const double v = static_cast<double>(limits.velocity) / kOne;
  const double a = static_cast<double>(limits.acceleration) / kOne;
  const double d = static_cast<double>(limits.deceleration) / kOne;
  return std::min(v, std::sqrt(2 * distance / (1 / a + 1 / d)));
}

double closed_form_cycles(double distance, const MotionLimits& limits) {
  const double top = top_speed(distance, limits);
  const double a = static_cast<double>(limits.acceleration) / kOne;
  const double d = static_cast<double>(limits.deceleration) / kOne;
  return distance / top + top / (2 * a) + top / (2 * d);
}

TEST(Trapezoid, ArrivesExactlyAndWithinACycleOfTheClosedForm) {
  RandomStream random(7);
  for (int i = 0; i < 300; ++i) {
    const MotionLimits limits{
        .velocity = static_cast<std::int64_t>(std::exp(6 + 12 * random.uniform())),
        .acceleration = static_cast<std::int64_t>(std::exp(6 + 8 * random.uniform())),
        .deceleration = static_cast<std::int64_t>(std::exp(6 + 8 * random.uniform()))};
    const auto from = static_cast<std::int32_t>(2e6 * (random.uniform() - 0.5));
    const auto way = static_cast<std::int32_t>(std::exp(11 * random.uniform()));
    const int direction = random.uniform() < 0.5 ? -1 : 1;
    const double expected = closed_form_cycles(way, limits);
    if (expected > 200'000) continue;
    Profile profile;
    profile.hold(from);
    profile.move(from + direction * way, limits, ProfileKind::kTrapezoid);
    const Course result = run(profile, direction);
    EXPECT_EQ(profile.position(), from + direction * way);
    EXPECT_EQ(profile.velocity(), 0);
    EXPECT_TRUE(result.monotonous);
    // A velocity that is reached within a cycle costs up to half of one at each end.
    const bool coarse = static_cast<double>(std::max(limits.acceleration, limits.deceleration)) >
                        top_speed(way, limits) * kOne / 8;
    EXPECT_NEAR(result.cycles, expected, coarse ? 2 : 1)
        << way << " V " << limits.velocity << " A " << limits.acceleration << " D "
        << limits.deceleration;
    EXPECT_LE(result.top_velocity, static_cast<double>(limits.velocity) / kOne);
  }
}

TEST(Trapezoid, IsChangedUnderWay) {
  for (const std::int32_t second : {400'000, 60'000, 20'000, -100'000}) {
    Profile profile;
    profile.hold(0);
    profile.move(200'000, kDefault, ProfileKind::kTrapezoid);
    for (int i = 0; i < 800; ++i) profile.step();
    ASSERT_GT(profile.velocity(), 0);
    profile.move(second, kDefault, ProfileKind::kTrapezoid);
    const Course result = run(profile);
    EXPECT_EQ(profile.position(), second);
    EXPECT_LE(result.top_acceleration, static_cast<double>(kDefault.deceleration) / kOne + 1e-9);
  }
}

TEST(Trapezoid, SlowsDownToALowerVelocity) {
  Profile profile;
  profile.hold(0);
  profile.move(500'000, kDefault, ProfileKind::kTrapezoid);
  for (int i = 0; i < 600; ++i) profile.step();
  MotionLimits slower = kDefault;
  slower.velocity /= 4;
  profile.move(500'000, slower, ProfileKind::kTrapezoid);
  for (int i = 0; i < 600; ++i) profile.step();
  EXPECT_EQ(profile.velocity(), slower.velocity);
  run(profile);
  EXPECT_EQ(profile.position(), 500'000);
}

TEST(Trapezoid, StatesFollowEachOther) {
  Profile profile;
  profile.hold(0);
  profile.move(131'072, kDefault, ProfileKind::kTrapezoid);
  std::vector<ProfileState> seen;
  while (profile.state() != ProfileState::kIdle) {
    profile.step();
    if (seen.empty() || seen.back() != profile.state()) seen.push_back(profile.state());
  }
  using enum ProfileState;
  EXPECT_EQ(seen, (std::vector{kAccelerating, kConstant, kDecelerating, kIdle}));
}

TEST(Trapezoid, CrossesTheEndOf32Bits) {
  Profile profile;
  profile.hold(INT32_MAX - 1000);
  profile.jog(65536 * 10, {.velocity = 65536 * 10, .acceleration = 65536, .deceleration = 65536});
  for (int i = 0; i < 500; ++i) profile.step();
  EXPECT_LT(profile.position(), 0);
  profile.stop(65536);
  run(profile);
  EXPECT_LT(profile.position(), 0);
}

TEST(Stop, EndsWithTheDecelerationOrThirtyTwoTimesIt) {
  for (const int factor : {1, 32}) {
    Profile profile;
    profile.hold(0);
    profile.move(1'000'000, kDefault, ProfileKind::kTrapezoid);
    for (int i = 0; i < 1000; ++i) profile.step();
    const double v = profile.velocity() / kOne, from = profile.position();
    profile.stop(factor * kDefault.deceleration);
    const Course result = run(profile);
    const double d = factor * 14317 / kOne;
    EXPECT_NEAR(result.cycles, v / d, 2);
    EXPECT_NEAR(profile.position() - from, v * v / (2 * d), 2);
    EXPECT_LE(result.top_acceleration, d + 1e-9);
  }
}

TEST(Jog, RunsUntilToldOtherwiseAndTurnsRound) {
  Profile profile;
  profile.hold(0);
  profile.jog(655360, kDefault);
  for (int i = 0; i < 200; ++i) profile.step();
  EXPECT_EQ(profile.velocity(), 655360);
  EXPECT_EQ(profile.state(), ProfileState::kConstant);
  profile.jog(-327680, kDefault);
  for (int i = 0; i < 200; ++i) profile.step();
  EXPECT_EQ(profile.velocity(), -327680);
  profile.jog(0, kDefault);
  run(profile, -1);
  EXPECT_EQ(profile.velocity(), 0);
  EXPECT_EQ(profile.state(), ProfileState::kIdle);
}

TEST(Blends, ArriveExactlyWithinTheLimits) {
  for (const ProfileKind kind : {ProfileKind::kSpline, ProfileKind::kBezier}) {
    for (const int jerk : {0, 300, 1000}) {
      for (const std::int32_t way : {1'310'720, 131'072, 5'000, 7, -40'000}) {
        MotionLimits limits = kDefault;
        limits.deceleration = 9000;
        limits.acceleration_jerk = jerk;
        limits.deceleration_jerk = jerk / 2;
        Profile profile;
        profile.hold(1000);
        profile.move(1000 + way, limits, kind);
        const Course result = run(profile, way < 0 ? -1 : 1);
        EXPECT_EQ(profile.position(), 1000 + way);
        EXPECT_TRUE(result.monotonous);
        EXPECT_LE(result.top_velocity, static_cast<double>(limits.velocity) / kOne + 1e-3);
        EXPECT_LE(result.top_acceleration, static_cast<double>(limits.acceleration) / kOne + 1e-3);
        const double trapezoid = closed_form_cycles(std::abs(way), limits);
        EXPECT_GE(result.cycles, trapezoid - 1);
        EXPECT_LE(result.cycles, 2 * trapezoid + 2);
      }
    }
  }
}

TEST(Blends, OfABezierWithoutJerkAreTheTrapezoid) {
  Profile straight, bezier;
  straight.hold(0);
  bezier.hold(0);
  straight.move(300'000, kDefault, ProfileKind::kTrapezoid);
  bezier.move(300'000, kDefault, ProfileKind::kBezier);
  while (straight.state() != ProfileState::kIdle) {
    straight.step();
    bezier.step();
    ASSERT_NEAR(straight.position(), bezier.position(), 2);
  }
}

TEST(Pvt, KeepsToTheHermiteCurveOfASine) {
  // 5 ms points at 100 us: 50 cycles a segment, half a turn of amplitude at 2 Hz.
  constexpr int kCycles = 50;
  constexpr double kAmplitude = 65536, kRate = 2 * M_PI * 2e-4;
  const auto x = [](double cycle) { return kAmplitude * (1 - std::cos(kRate * cycle)); };
  const auto v = [](double cycle) { return kAmplitude * kRate * std::sin(kRate * cycle); };
  Profile profile;
  profile.hold(0);
  std::vector<PvtPoint> points;
  int pushed = 0;
  const auto push = [&] {
    ++pushed;
    const PvtPoint point{static_cast<std::int32_t>(std::lround(x(pushed * kCycles))),
                         static_cast<std::int32_t>(std::lround(v(pushed * kCycles) * kOne))};
    points.push_back(point);
    return profile.push({&point, 1});
  };
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(push());
  profile.stream(kCycles, kDefault);
  PvtPoint before{};
  for (int cycle = 1; cycle <= 100 * kCycles; ++cycle) {
    if (profile.pvt_depth() < 10 && pushed < 100) {
      ASSERT_TRUE(push());
    }
    profile.step();
    const int segment = (cycle - 1) / kCycles;
    if (segment > 0) before = points[static_cast<std::size_t>(segment - 1)];
    const PvtPoint& after = points[static_cast<std::size_t>(segment)];
    const double s = (cycle - segment * kCycles) / static_cast<double>(kCycles);
    const double hermite = before.position * (1 + 2 * s) * (1 - s) * (1 - s) +
                           after.position * s * s * (3 - 2 * s) +
                           kCycles * (before.velocity / kOne * s * (1 - s) * (1 - s) -
                                      after.velocity / kOne * s * s * (1 - s));
    ASSERT_NEAR(profile.position(), hermite, 1) << cycle;
    ASSERT_NEAR(profile.position(), x(cycle), 2) << cycle;
  }
  EXPECT_FALSE(profile.starved());
}

TEST(Pvt, StarvedUnderWayBrakesAndCounts) {
  Profile profile;
  profile.hold(0);
  const PvtPoint points[] = {{500, 20 * 65536}, {1500, 20 * 65536}};
  ASSERT_TRUE(profile.push(points));
  profile.stream(50, kDefault);
  for (int i = 0; i < 100; ++i) profile.step();
  EXPECT_EQ(profile.position(), 1500);
  EXPECT_FALSE(profile.starved());
  profile.step();
  EXPECT_TRUE(profile.starved());
  const int first = profile.position();
  const Course result = run(profile);
  EXPECT_NEAR(profile.position() - first, 20 * 20 / (2 * 14317 / kOne), 25);
  EXPECT_NEAR(profile.empty_cycles(), result.cycles, 2);
  EXPECT_EQ(profile.state(), ProfileState::kIdle);
}

TEST(Pvt, EndsWithoutStarvingAtAPointOfNoVelocity) {
  Profile profile;
  profile.hold(100);
  const PvtPoint points[] = {{600, 10 * 65536}, {1100, 0}};
  ASSERT_TRUE(profile.push(points));
  profile.stream(50, kDefault);
  run(profile);
  EXPECT_EQ(profile.position(), 1100);
  EXPECT_FALSE(profile.starved());
}

TEST(Pvt, HoldsAHundredPointsAndShiftsThem) {
  Profile profile;
  profile.hold(0);
  const std::vector<PvtPoint> many(100, PvtPoint{5000, 0});
  EXPECT_TRUE(profile.push(many));
  EXPECT_FALSE(profile.push({many.data(), 1}));
  EXPECT_EQ(profile.pvt_depth(), 100);
  profile.shift(250);
  profile.stream(10, kDefault);
  for (int i = 0; i < 10; ++i) profile.step();
  EXPECT_EQ(profile.position(), 5250);
}

TEST(Follow, GoesStraightWithinTheCyclesGiven) {
  Profile profile;
  profile.hold(0);
  profile.follow(1000, 10);
  for (int i = 1; i <= 10; ++i) {
    profile.step();
    EXPECT_NEAR(profile.position(), 100 * i, 1);
  }
  EXPECT_EQ(profile.position(), 1000);
  profile.step();
  EXPECT_EQ(profile.velocity(), 0);
  profile.follow(500, 1);
  profile.step();
  EXPECT_EQ(profile.position(), 500);
}

}  // namespace
}  // namespace virtdrive::rzt1
