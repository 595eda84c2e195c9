// The servo as a host drives it, against the bench's motor.
#include <algorithm>
#include <cstdlib>
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

struct Flight {
  double time_s = 0;
  int error = 0, overshoot = 0, current = 0;
  double settled_s = 0;  // from the profile's end until within 10 counts
  int at_rest = 0;       // largest error in the last 20 ms
};

Flight fly(Rig& rig, std::int32_t target) {
  ServoAxis& axis = rig.axis();
  Flight flight;
  const int direction = target < axis.position() ? -1 : 1;
  axis.set_target(target);
  EXPECT_EQ(axis.go(), Result::kOk);
  const SimTime from = rig.loop.now();
  SimTime end = kNever;
  while (end == kNever || rig.loop.now() < end + 120ms) {
    rig.run_for(100us);
    const int off = (axis.position() - target) * direction;
    flight.error = std::max(flight.error, std::abs(axis.position_error()));
    flight.current = std::max(flight.current, axis.total_current());
    flight.overshoot = std::max(flight.overshoot, off);
    if (end == kNever && !axis.moving()) {
      end = rig.loop.now();
      flight.time_s = seconds(end - from);
    }
    if (end == kNever) continue;
    if (std::abs(off) > 10) flight.settled_s = seconds(rig.loop.now() - end);
    if (rig.loop.now() > end + 100ms) flight.at_rest = std::max(flight.at_rest, std::abs(off));
    if (seconds(rig.loop.now() - from) > 20) break;
  }
  return flight;
}

// Into the XML report (--gtest_output=xml): the figures of docs/validation.md.
template <class Value>
void report(const char* name, const Value& value) {
  testing::Test::RecordProperty(name, fmt::format("{}", value));
}

// Default VEL and ACC: 109.2 counts a cycle, 0.2185 counts a cycle squared.
double trapezoid_s(double counts, const Settings& s) {
  const double v = s.vel / 65536.0, a = s.acc / 65536.0;
  return (counts / v + v / a) * 50e-6 * s.ds;
}

// --- What the factory settings were chosen by, each figure with a margin of 1.5 -----------------

TEST(Gates, ATurnWithTheDefaults) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  const Flight flight = fly(rig, rig.axis().position() + kTurn);
  EXPECT_NEAR(flight.time_s, trapezoid_s(kTurn, rig.axis().settings()), 2e-4);
  EXPECT_LE(flight.error, 76 * 1.5);
  EXPECT_LE(flight.overshoot, 28 * 1.5);
  EXPECT_LE(flight.settled_s, 33e-3 * 1.5);
  EXPECT_LE(flight.at_rest, 3 * 1.5);
  report("error", flight.error);
  report("overshoot", flight.overshoot);
  report("settled_s", flight.settled_s);
  report("at_rest", flight.at_rest);
  report("time_s", flight.time_s);
}

TEST(Gates, TenTurnsInEachProfile) {
  for (const int profile : {0, 1, 2}) {
    Rig rig;
    rig.set(&Settings::pro, profile);
    rig.set(&Settings::ajerk, 500);
    rig.set(&Settings::djerk, 500);
    ASSERT_EQ(rig.ready(), Result::kOk);
    const std::int32_t target = rig.axis().position() + 10 * kTurn;
    const Flight flight = fly(rig, target);
    EXPECT_EQ(rig.axis().command_position(), target);
    EXPECT_NEAR(rig.axis().position(), target, 5);
    EXPECT_LE(flight.overshoot, 28 * 1.5);
    const double trapezoid = trapezoid_s(10 * kTurn, rig.axis().settings());
    if (profile == 0) {
      EXPECT_NEAR(flight.time_s, trapezoid, 2e-4);
    } else {
      EXPECT_GT(flight.time_s, trapezoid);
      EXPECT_LT(flight.time_s, 2 * trapezoid);
    }
    report(profile == 0 ? "trapezoid_s" : profile == 1 ? "spline_s" : "bezier_s", flight.time_s);
    report(profile == 0   ? "trapezoid_error"
           : profile == 1 ? "spline_error"
                          : "bezier_error",
           flight.error);
  }
}

TEST(Gates, ALoadStep) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.change_load({.external_torque_nm = 1.27});
  int dip = 0;
  double back_s = 0;
  const SimTime from = rig.loop.now();
  while (rig.loop.now() < from + 200ms) {
    rig.run_for(100us);
    dip = std::max(dip, std::abs(rig.axis().position_error()));
    if (std::abs(rig.axis().position_error()) > 10) back_s = seconds(rig.loop.now() - from);
  }
  EXPECT_LE(dip, 1310 * 1.5);
  EXPECT_GE(dip, 1310 / 1.5);
  EXPECT_LE(back_s, 54e-3 * 1.5);
  report("dip", dip);
  report("back_s", back_s);
}

TEST(Gates, AStepOfAHundredCounts) {
  Rig rig;
  rig.set(&Settings::vff, 0);
  rig.set(&Settings::vel, INT32_MAX);
  rig.set(&Settings::acc, INT32_MAX);
  rig.set(&Settings::dec, INT32_MAX);
  ASSERT_EQ(rig.ready(), Result::kOk);
  const std::int32_t from = rig.axis().position();
  rig.axis().set_target(from + 100);
  ASSERT_EQ(rig.axis().go(), Result::kOk);
  const SimTime start = rig.loop.now();
  double settled_s = 0;
  while (rig.loop.now() < start + 60ms) {
    rig.run_for(100us);
    if (std::abs(rig.axis().position() - from - 100) > 10) {
      settled_s = seconds(rig.loop.now() - start);
    }
  }
  EXPECT_GT(settled_s, 0);
  EXPECT_LE(settled_s, 12e-3 * 1.5);
  report("settled_s", settled_s);
}

TEST(Gates, ACurrentStep) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().off(), Result::kOk);
  Load locked;
  locked.locked = true;
  rig.change_load(locked);
  rig.run_for(10ms);
  // 4 A: 409 counts, 32 of the output each.
  ASSERT_EQ(rig.axis().set_output(409 * 32), Result::kOk);
  int top = 0;
  double rise_s = 0;
  const SimTime from = rig.loop.now();
  while (rig.loop.now() < from + 10ms) {
    rig.run_for(50us);
    const int iq = rig.axis().quadrature_current();
    if (rise_s == 0 && iq >= 368) rise_s = seconds(rig.loop.now() - from);
    top = std::max(top, iq);
  }
  EXPECT_LE(rise_s, 0.25e-3 * 1.5);
  EXPECT_GT(rise_s, 0);
  EXPECT_LE(top, 409 * (1 + 0.16 * 1.5));
  EXPECT_NEAR(rig.axis().quadrature_current(), 409, 4);
  EXPECT_NEAR(rig.plant().state().i_q_a, 4, 0.06);
  report("rise_s", rise_s);
  report("top", top);
}

TEST(Gates, AnAbortFromTheDefaultVelocity) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().jog(7158282), Result::kOk);
  rig.run_for(300ms);
  ASSERT_EQ(rig.axis().abort(), Result::kOk);
  int current = 0, overshoot = 0;
  const SimTime from = rig.loop.now();
  while (rig.loop.now() < from + 150ms) {
    rig.run_for(50us);
    current = std::max(current, std::abs(rig.axis().quadrature_current()));
    overshoot = std::max(overshoot, rig.axis().position() - rig.axis().command_position());
  }
  EXPECT_LE(current, 655 * 1.5);  // 6.4 A
  EXPECT_LE(overshoot, 800 * 1.5);
  report("current", current);
  report("overshoot", overshoot);
  EXPECT_NEAR(rig.axis().position_error(), 0, 10);
}

TEST(Gates, ThreeThousandRpm) {
  Rig rig;
  rig.set(&Settings::vel, 6 * 7158282);
  rig.set(&Settings::acc, 150'000);
  rig.set(&Settings::dec, 150'000);
  ASSERT_EQ(rig.ready(), Result::kOk);
  const Flight flight = fly(rig, rig.axis().position() + 30 * kTurn);
  EXPECT_LE(flight.error, 600 * 1.5);
  EXPECT_NEAR(rig.axis().position_error(), 0, 5);
  report("error", flight.error);
}

TEST(Gates, WithoutFeedForwardItLagsByVelocityOverGain) {
  Rig rig;
  rig.set(&Settings::vff, 0);
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().jog(7158282), Result::kOk);
  rig.run_for(500ms);
  EXPECT_NEAR(rig.axis().position_error(), 7158282.0 / 2000, 30);
  report("error", rig.axis().position_error());
}

// --- Motions -------------------------------------------------------------------------------------

TEST(Motion, IsRefusedInTheStatesThatForbidIt) {
  Rig rig;
  ServoAxis& axis = rig.axis();
  EXPECT_EQ(axis.status(), kMotionComplete);
  EXPECT_EQ(axis.home(), Result::kInvalidState);
  EXPECT_EQ(axis.go(), Result::kOk);  // only latches
  EXPECT_FALSE(axis.moving());
  EXPECT_EQ(axis.jog(65536), Result::kInvalidState);
  ASSERT_EQ(axis.on(), Result::kOk);
  rig.run_for(10ms);
  EXPECT_TRUE((axis.status() & kBusy) != 0);
  EXPECT_EQ(axis.go(), Result::kInvalidState);
  EXPECT_EQ(axis.set_output(100), Result::kInvalidState);
  EXPECT_EQ(axis.set(&Settings::etype, 1), Result::kInvalidState);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_EQ(axis.status(), kMotionComplete | kServoOn | kAmplifierOn | kPhased);
  rig.set(&Settings::pro, 3);
  EXPECT_EQ(axis.go(), Result::kInvalidState);  // no points
  rig.set(&Settings::pro, 1);
  axis.set_target(kTurn);
  EXPECT_EQ(axis.go(), Result::kOk);
  rig.run_for(20ms);
  EXPECT_EQ(axis.go(), Result::kInvalidState);  // a spline under way
  EXPECT_EQ(axis.init_pvt(50), Result::kInvalidState);
  EXPECT_EQ(axis.status() & kMotionComplete, 0);
}

TEST(Motion, GoOnTheFlyTakesANewTargetAndVelocity) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ServoAxis& axis = rig.axis();
  const std::int32_t start = axis.position();
  axis.set_target(start + 2 * kTurn);
  ASSERT_EQ(axis.go(), Result::kOk);
  rig.run_for(100ms);
  rig.set(&Settings::vel, 3'000'000);
  axis.set_target(start + kTurn);
  ASSERT_EQ(axis.go(), Result::kOk);
  rig.run_for(60ms);
  EXPECT_EQ(axis.command_velocity(), 3'000'000);
  EXPECT_GT(rig.run_to_end_of_motion(), 0);
  rig.run_for(100ms);
  EXPECT_NEAR(axis.position(), start + kTurn, 3);
}

TEST(Motion, ARelativeDistanceCountsFromTheActualPosition) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.axis().set_distance(5000);
  const std::int32_t start = rig.axis().position();
  ASSERT_EQ(rig.axis().go(), Result::kOk);
  EXPECT_EQ(rig.axis().target(), start + 5000);
  rig.run_to_end_of_motion();
  EXPECT_EQ(rig.axis().command_position(), start + 5000);
  rig.axis().set_target(start);
  EXPECT_EQ(rig.axis().distance(), 0);
}

TEST(Motion, JogsForwardsAndBackwardsUntilStopped) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ServoAxis& axis = rig.axis();
  ASSERT_EQ(axis.forward(), Result::kOk);
  rig.run_for(150ms);
  EXPECT_EQ(axis.command_velocity(), axis.settings().vel);
  EXPECT_NEAR(axis.velocity(), axis.settings().vel, 0.01 * axis.settings().vel);
  EXPECT_EQ(axis.velocity_counts(), axis.velocity() >> 16);
  ASSERT_EQ(axis.reverse(), Result::kOk);
  rig.run_for(200ms);
  EXPECT_EQ(axis.command_velocity(), -axis.settings().vel);
  ASSERT_EQ(axis.stop(), Result::kOk);
  EXPECT_NEAR(rig.run_to_end_of_motion(), 7158282.0 / 14317 * 1e-4, 3e-4);
}

TEST(Motion, PositionMayBeSetAtAnyTime) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ServoAxis& axis = rig.axis();
  axis.set_target(axis.position() + kTurn);
  ASSERT_EQ(axis.go(), Result::kOk);
  rig.run_for(80ms);
  const std::int32_t error = axis.position_error(), left = axis.target() - axis.position();
  ASSERT_EQ(axis.set_position(-500'000), Result::kOk);
  EXPECT_EQ(axis.position(), -500'000);
  EXPECT_EQ(axis.position_error(), error);
  EXPECT_EQ(axis.target() - axis.position(), left);
  const double angle = rig.angle_rad();
  EXPECT_GT(rig.run_to_end_of_motion(), 0);
  rig.run_for(60ms);
  EXPECT_NEAR(axis.position(), -500'000 + left, 3);
  EXPECT_NEAR((rig.angle_rad() - angle) / kTurnRad * kTurn, left, 5);
}

TEST(Motion, GainsAreTakenWithTheNextMotion) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  rig.set(&Settings::vff, 0);
  ASSERT_EQ(rig.axis().jog(65536 * 50), Result::kOk);
  rig.run_for(100ms);
  const int lag = rig.axis().position_error();
  EXPECT_NEAR(lag, 65536.0 * 50 / 2000, 20);
  rig.set(&Settings::kp, 4000);
  rig.run_for(50ms);
  EXPECT_NEAR(rig.axis().position_error(), lag, 20);
  ASSERT_EQ(rig.axis().jog(65536 * 50), Result::kOk);
  rig.run_for(50ms);
  EXPECT_NEAR(rig.axis().position_error(), lag / 2.0, 20);
}

TEST(Motion, ServoOffBrakesByShortingAndDisableCoasts) {
  double way[2];
  for (const bool braked : {false, true}) {
    Rig rig;
    ASSERT_EQ(rig.ready(), Result::kOk);
    ASSERT_EQ(rig.axis().jog(7158282), Result::kOk);
    rig.run_for(200ms);
    const double from = rig.angle_rad();
    ASSERT_EQ(braked ? rig.axis().off() : rig.axis().disable(), Result::kOk);
    EXPECT_EQ(rig.axis().amplifier_on(), braked);
    rig.run_to([&] { return rig.plant().state().speed_radps == 0; });
    way[braked ? 1 : 0] = rig.angle_rad() - from;
  }
  EXPECT_LT(way[1], way[0] / 10);
}

TEST(Motion, FollowsSetPointsOfACyclicMaster) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  const std::int32_t start = rig.axis().position();
  int lag = 0;
  for (int ms = 1; ms <= 500; ++ms) {
    const double x = kTurn / 2.0 * (1 - std::cos(kTurnRad * ms * 1e-3));
    ASSERT_EQ(rig.axis().follow(start + static_cast<std::int32_t>(x), 10), Result::kOk);
    rig.run_for(1ms);
    lag = std::max(lag, std::abs(rig.axis().position_error()));
  }
  EXPECT_LT(lag, 200);
  EXPECT_NEAR(rig.axis().position(), start + kTurn, 100);
  ASSERT_EQ(rig.axis().stop(), Result::kOk);
  EXPECT_GE(rig.run_to_end_of_motion(), 0);
}

// --- PVT -----------------------------------------------------------------------------------------

TEST(Streaming, KeepsTheServoOnASineOfFiveMillisecondPoints) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ServoAxis& axis = rig.axis();
  rig.set(&Settings::pro, 3);
  ASSERT_EQ(axis.set_position(0), Result::kOk);
  ASSERT_EQ(axis.init_pvt(50, 10), Result::kOk);
  EXPECT_TRUE((axis.status() & kPvtLow) != 0);
  constexpr double kRate = kTurnRad * 2e-4, kAmplitude = 30'000;
  const auto x = [](double cycle) { return kAmplitude * (1 - std::cos(kRate * cycle)); };
  int pushed = 0;
  const auto push = [&] {
    ++pushed;
    const double v = kAmplitude * kRate * std::sin(kRate * 50 * pushed);
    axis.set_pvt_position(static_cast<std::int32_t>(std::lround(x(50 * pushed))));
    return axis.push_pvt_velocity(static_cast<std::int32_t>(std::lround(v * 65536)));
  };
  for (int i = 0; i < 30; ++i) ASSERT_EQ(push(), Result::kOk);
  EXPECT_EQ(axis.status() & kPvtLow, 0);
  ASSERT_EQ(axis.go(), Result::kOk);
  double off = 0;
  int lag = 0;
  for (int cycle = 1; cycle < 5000; ++cycle) {
    rig.run_for(100us);
    if ((axis.status() & kPvtLow) != 0 && pushed < 100) {
      ASSERT_EQ(push(), Result::kOk);
    }
    off = std::max(off, std::fabs(axis.command_position() - x(cycle)));
    lag = std::max(lag, std::abs(axis.position_error()));
  }
  EXPECT_LE(off, 2);
  EXPECT_LT(lag, 150);
  EXPECT_EQ(axis.status() & kPvtStarved, 0);
}

TEST(Streaming, StarvedItBrakesAndTripsWhenTheMaskSaysSo) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ServoAxis& axis = rig.axis();
  rig.set(&Settings::pro, 3);
  rig.set(&Settings::errmask, kErrorEmpty);
  const std::int32_t start = axis.position();
  const PvtPoint points[] = {{start + 1250, 50 * 65536}, {start + 3750, 50 * 65536}};
  ASSERT_EQ(axis.push_pvt(points), Result::kOk);
  ASSERT_EQ(axis.init_pvt(50), Result::kOk);  // empties the queue
  EXPECT_EQ(axis.pvt_depth(), 0);
  ASSERT_EQ(axis.push_pvt(points), Result::kOk);
  ASSERT_EQ(axis.go(), Result::kOk);
  rig.run_for(12ms);
  EXPECT_TRUE((axis.status() & kPvtStarved) != 0);
  EXPECT_EQ(axis.errors() & kErrorEmpty, 0U);
  rig.run_for(5ms);
  EXPECT_TRUE((axis.errors() & kErrorEmpty) != 0);
  EXPECT_FALSE(axis.amplifier_on());
  EXPECT_EQ(axis.on(), Result::kInterlock);
  axis.reset_errors();
  EXPECT_EQ(axis.on(), Result::kOk);
}

// --- Gear ----------------------------------------------------------------------------------------

TEST(Gear, ThreeToTwoOverAHundredTurns) {
  Rig rig;
  rig.set(&Settings::type, 2, 0);
  rig.set(&Settings::gear_in, 3, 0);
  rig.set(&Settings::gear_out, 2, 0);
  for (const std::size_t i : {0U, 1U}) {
    rig.set(&Settings::vel, 3 * 7158282, i);
    rig.set(&Settings::acc, 60'000, i);
    rig.set(&Settings::dec, 60'000, i);
  }
  ASSERT_EQ(rig.axis(0).set_position(1000), Result::kOk);
  ASSERT_EQ(rig.ready(0), Result::kOk);
  rig.run_to([&] { return !rig.axis(1).busy(); });
  rig.run_for(20ms);
  ASSERT_TRUE(rig.axis(1).servo_on());
  EXPECT_NEAR(rig.axis(1).position(), rig.axis(0).position() * 1.5, 4);
  EXPECT_EQ(rig.axis(1).go(), Result::kInvalidState);
  EXPECT_EQ(rig.axis(1).home(), Result::kInvalidState);
  EXPECT_EQ(rig.axis(1).set_position(7), Result::kInvalidState);

  const double leader = rig.angle_rad(0), slave = rig.angle_rad(1);
  rig.axis(0).set_target(rig.axis(0).position() + 100 * kTurn);
  ASSERT_EQ(rig.axis(0).go(), Result::kOk);
  int apart = 0;
  while (rig.axis(0).moving()) {
    rig.run_for(10ms);
    apart = std::max(
        apart, std::abs(rig.axis(1).command_position() - rig.axis(0).command_position() * 3 / 2));
    EXPECT_TRUE(rig.axis(1).moving() || !rig.axis(0).moving());
  }
  EXPECT_LE(apart, 1);
  rig.run_for(100ms);
  EXPECT_NEAR((rig.angle_rad(0) - leader) / kTurnRad, 100, 1e-4);
  EXPECT_NEAR((rig.angle_rad(1) - slave) / kTurnRad, 150, 1e-4);
  ASSERT_EQ(rig.axis(0).off(), Result::kOk);
  EXPECT_FALSE(rig.axis(1).servo_on());
}

TEST(Gear, AWrittenPositionDoesNotMoveTheSlave) {
  Rig rig;
  rig.set(&Settings::type, 2, 1);  // axis 2 leads
  ASSERT_EQ(rig.ready(1), Result::kOk);
  rig.run_for(600ms);
  const double slave = rig.angle_rad(0);
  ASSERT_EQ(rig.axis(1).set_position(77'000), Result::kOk);
  rig.run_for(50ms);
  EXPECT_EQ(rig.axis(0).command_position(), rig.axis(1).command_position());
  EXPECT_NEAR(rig.angle_rad(0), slave, 1e-3);
}

// --- Outputs without servo -----------------------------------------------------------------------

TEST(OpenLoop, PcmodeDecidesWhatPwmIs) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().off(), Result::kOk);
  rig.set(&Settings::pcmode, 0);
  ASSERT_EQ(rig.axis().set_output(3277), Result::kOk);  // a tenth of 161.7 V
  // The speed at which the EMF, 5 * 0.0472 V s, takes it; what phasing and the delay of a period
  // are wrong about the angle weakens or strengthens the field by some percent.
  constexpr double kSpeed = 16.17 / (5 * 0.0472);
  rig.run_for(300ms);
  EXPECT_NEAR(rig.plant().state().speed_radps, kSpeed, 0.08 * kSpeed);
  rig.set(&Settings::pcmode, 2);
  rig.run_for(300ms);
  EXPECT_NEAR(rig.plant().state().speed_radps, kSpeed, 0.15 * kSpeed);
  ASSERT_EQ(rig.axis().set_output(-3277), Result::kOk);
  rig.run_for(300ms);
  EXPECT_NEAR(rig.plant().state().speed_radps, -kSpeed, 0.15 * kSpeed);
  rig.set(&Settings::pcmode, 1);  // now it is a current
  ASSERT_EQ(rig.axis().set_output(0), Result::kOk);
  rig.run_for(200ms);
  ASSERT_EQ(rig.axis().set_output(102 * 32), Result::kOk);
  rig.run_for(5ms);
  EXPECT_NEAR(rig.plant().state().i_q_a, 1, 0.1);
}

TEST(OpenLoop, TheHostTurnsAVectorOrSetsPhases) {
  Rig rig;
  rig.set(&Settings::pcmode, 3);
  ASSERT_EQ(rig.axis().enable(), Result::kOk);
  EXPECT_EQ(rig.axis().on(), Result::kOk);
  EXPECT_FALSE(rig.axis().servo_on());
  ASSERT_EQ(rig.axis().set_output(1966), Result::kOk);
  for (const int vector : {0, 1, 2, 3, 4, 5, 0, 1}) {
    rig.set(&Settings::pvector, vector);
    rig.run_for(300ms);
    EXPECT_NEAR(std::remainder(5 * rig.angle_rad() - vector * kTurnRad / 6, kTurnRad), 0, 0.03);
  }
  ASSERT_EQ(rig.axis().set_phase_output(0, 16384 + 600), Result::kOk);
  ASSERT_EQ(rig.axis().set_phase_output(1, 16384), Result::kOk);
  ASSERT_EQ(rig.axis().set_phase_output(2, 16384), Result::kOk);
  rig.run_for(300ms);
  EXPECT_EQ(rig.axis().phase_output(0), 16984);
  EXPECT_NEAR(std::remainder(5 * rig.angle_rad(), kTurnRad), 0, 0.03);
}

TEST(OpenLoop, UnphasedItCommutatesFromTheHalls) {
  Rig rig;
  ASSERT_EQ(rig.axis().enable(), Result::kOk);
  ASSERT_EQ(rig.axis().set_output(2000), Result::kOk);
  rig.run_for(500ms);
  EXPECT_EQ(rig.axis().status() & kPhased, 0);
  EXPECT_GT(rig.plant().state().speed_radps, 30);
}

TEST(BrushedMotor, IsPositionedByVoltage) {
  AxisParameters parameters;
  parameters.motor = brushed_dc(2.0, 2e-3, 0.1, 4);
  parameters.effects.commutator = true;
  parameters.mechanics = {.inertia_kgm2 = 5e-5, .coulomb_nm = 0.01};
  parameters.link = {.source_v = 48, .resistance_ohm = 0, .capacitance_f = 1e-3};
  Settings settings;
  settings.phases = 2;
  settings.ecpr = 131072;
  settings.vkp = 2;
  settings.vki = 0;
  settings.kp = 1500;
  settings.vel = 2'000'000;
  settings.acc = 5000;
  settings.dec = 5000;
  Rig rig(parameters, {}, {}, settings);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_TRUE(rig.axis().phased());
  EXPECT_GT(rig.move_to(rig.axis().position() + kTurn), 0);
  rig.run_for(300ms);
  EXPECT_NEAR(rig.angle_rad() / kTurnRad, 1, 0.02);
  rig.change_load({.external_torque_nm = 0.05});
  rig.run_for(300ms);
  EXPECT_NEAR(rig.angle_rad() / kTurnRad, 1, 0.05);
}

TEST(VoiceCoil, IsPositionedInALine) {
  const Motor motor = find_motor("voice-coil-20n");
  Hardware hardware;
  hardware.axis[0].incremental.lines = 1'570'796;  // a count is 1 um
  Settings settings;
  settings.phases = 2;
  settings.vkp = 100;
  settings.vki = 4;
  settings.kp = 1000;
  settings.vel = 2 * 65536;  // 20 mm/s
  settings.acc = settings.dec = 400;
  Rig rig({.motor = motor.electrical,
           .link = {.source_v = 24, .resistance_ohm = 0, .capacitance_f = 1e-3},
           .mechanics = motor.mechanics,
           .effects = motor.effects},
          {}, hardware, settings);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_NEAR(rig.move_to(3000), 0.15 + 0.0328, 2e-3);
  EXPECT_NEAR(rig.axis().position_error(), 0, 15);
  rig.run_for(200ms);
  EXPECT_NEAR(rig.angle_rad(), 3e-3, 3e-6);
}

TEST(Simulation, TheCommandIsTheActualPositionAndTheMotorStandsStill) {
  Rig rig;
  rig.set(&Settings::sim, 1);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_GT(rig.move_to(3 * kTurn), 0);
  EXPECT_EQ(rig.axis().position(), 3 * kTurn);
  EXPECT_EQ(rig.axis().position_error(), 0);
  EXPECT_EQ(rig.angle_rad(), 0);
}

TEST(Rest, AnAxisThatIsOffAndStillIsLookedAtOnceAMillisecond) {
  Rig rig;
  rig.run_for(100ms);
  const std::uint64_t before = rig.drive->slots();
  rig.run_for(1s);
  EXPECT_EQ(rig.drive->slots() - before, 1000U);
  // A load turns the shaft: it sees every count of it.
  rig.change_load({.external_torque_nm = -0.1});
  rig.run_for(200ms);
  EXPECT_GT(rig.axis().velocity(), 0);
  EXPECT_NEAR(rig.axis().position(), rig.angle_rad() / kTurnRad * kTurn,
              rig.axis().velocity() / 65536.0 + 2);
}

TEST(Rest, EqualRunsAreEqual) {
  double angles[2];
  for (double& angle : angles) {
    Rig rig;
    ASSERT_EQ(rig.ready(), Result::kOk);
    rig.move_to(20'000);
    angle = rig.angle_rad();
  }
  EXPECT_EQ(angles[0], angles[1]);
}

}  // namespace
}  // namespace virtdrive::rzt1
