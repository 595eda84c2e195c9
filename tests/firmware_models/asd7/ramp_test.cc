#include "firmware_models/asd7/ramp.h"

#include <gtest/gtest.h>

#include "firmware_models/asd7/modulation.h"
#include "firmware_models/asd7/overload.h"
#include "firmware_models/asd7/pi_control.h"
#include "firmware_models/asd7/reference.h"

namespace virtdrive::asd7 {
namespace {

constexpr double kStep = 250e-6;

/// Seconds until it is there.
double time_to(Ramp& ramp, double target, const RampRate& rate) {
  int steps = 0;
  for (; ramp.hz() != target && steps < 1'000'000; ++steps) ramp.follow(target, rate, kStep);
  return steps * kStep;
}

TEST(Asd7Ramp, ALineTakesItsTimeAndEndsExactlyOnTheTarget) {
  Ramp ramp;
  const RampRate rate{.up_hz_per_s = 8, .down_hz_per_s = 4};
  EXPECT_NEAR(time_to(ramp, 60, rate), 7.5, 2 * kStep);
  EXPECT_EQ(ramp.hz(), 60);
  EXPECT_NEAR(time_to(ramp, 20, rate), 10, 2 * kStep);
}

TEST(Asd7Ramp, AnSShapeIsRoundAtItsEndsAndAsSteepBetween) {
  const RampRate s{.up_hz_per_s = 8,
                   .down_hz_per_s = 8,
                   .shape = RampShape::kS1,
                   .up_s = 10,
                   .down_s = 10,
                   .lower = 0.1,
                   .upper = 0.2};
  Ramp ramp;
  ramp.follow(60, s, kStep);
  EXPECT_LT(ramp.slope(), 0.01);
  double steepest = 0, at_end = 0;
  int steps = 1;
  for (; ramp.hz() != 60; ++steps) {
    ramp.follow(60, s, kStep);
    steepest = std::max(steepest, ramp.slope());
    if (ramp.hz() < 59.99) at_end = ramp.slope();
  }
  EXPECT_NEAR(steepest, 8, 1e-9);
  EXPECT_LT(at_end, 0.5);
  // Each end adds half of its share of the whole ramp's time.
  EXPECT_NEAR(steps * kStep, 7.5 + 0.5 + 1.0, 0.15);
}

TEST(Asd7Ramp, TheSecondSShapeIsSlowerAboveTheBaseFrequency) {
  RampRate rate{.up_hz_per_s = 8, .shape = RampShape::kS2, .up_s = 10, .base_hz = 60};
  Ramp ramp;
  ramp.put(60);
  const double s2 = time_to(ramp, 80, rate);
  rate.shape = RampShape::kS1;
  ramp.put(60);
  EXPECT_GT(s2, 1.2 * time_to(ramp, 80, rate));
}

TEST(Asd7VoltageCurve, FollowsItsKind) {
  VoltageCurve curve{.motor_v = 230, .base_hz = 60, .boost = 0.06};
  EXPECT_NEAR(curve.at(0), 13.8, 1e-9);
  EXPECT_NEAR(curve.at(30), 230 * 0.53, 1e-9);
  EXPECT_NEAR(curve.at(60), 230, 1e-9);
  EXPECT_NEAR(curve.at(80), 230, 1e-9);
  curve.kind = VoltsPerHertz::kVariableTorque;
  EXPECT_NEAR(curve.at(30), 230 * (0.06 + 0.94 * 0.25), 1e-9);
  curve.kind = VoltsPerHertz::kAutomaticBoost;
  curve.drop_v = 10;
  EXPECT_NEAR(curve.at(30), 125, 1e-9);
  EXPECT_NEAR(curve.at(60), 230, 1e-9);
}

TEST(Asd7Overload, TripsAtTheTimesOfTheCurve) {
  const auto time_to_full = [](double r, double t150) {
    Overload overload;
    double t = 0;
    for (; !overload.full() && t < 1000; t += 0.01) overload.step(r, t150, 0.01);
    return t;
  };
  EXPECT_NEAR(time_to_full(1.2, 60), 271, 1);
  EXPECT_NEAR(time_to_full(1.5, 60), 60, 0.1);
  EXPECT_NEAR(time_to_full(1.7, 60), 37, 0.5);
  EXPECT_NEAR(time_to_full(1.5, 300), 300, 0.1);
  EXPECT_GE(time_to_full(1.1, 60), 1000);
}

TEST(Asd7Overload, CoolsByTheSameLaw) {
  Overload overload;
  overload.step(1.5, 60, 30);
  EXPECT_NEAR(overload.level(), 0.5, 1e-12);
  overload.step(0, 60, 10);
  EXPECT_NEAR(overload.level(), 0.5 - 10 * 1.21 / (60 * 1.04), 1e-12);
  ResistorOverload resistor;
  resistor.step(200, 100, 5);
  EXPECT_NEAR(resistor.level(), 0.5, 1e-12);
}

TEST(Asd7PiControl, HoldsAtItsLimitsWithoutWindingUp) {
  PiControl pi;
  pi.start(0, 0);
  const PiControl::Gains gains{.proportional = 0.5, .integral_per_s = 1, .filter_s = 0};
  for (int i = 0; i < 100'000; ++i) pi.step(50, 10, gains, 1e-3);
  EXPECT_EQ(pi.step(50, 10, gains, 1e-3), 60);
  int steps = 0;
  while (pi.step(50, 60, gains, 1e-3) > 50 && steps < 20'000) ++steps;
  EXPECT_LT(steps, 1000);
}

// --- Who decides ---------------------------------------------------------------------------------

class Asd7Reference : public testing::Test {
 protected:
  Request request() { return request_of(asked_, settings_); }
  Asked asked_;
  Settings settings_;
};

TEST_F(Asd7Reference, WithoutPriorityTheLinesRunBitsAreKeptButIgnored) {
  asked_.command = kCommandRun | kCommandFrequencyPriority;
  asked_.frequency = 4000;
  EXPECT_FALSE(request().run);
  EXPECT_EQ(request().hz, 40) << "the frequency has a priority of its own";
  asked_.command |= kCommandPriority;
  EXPECT_TRUE(request().run);
  asked_.command = kCommandRun;
  settings_.command_source = static_cast<std::uint16_t>(CommandSource::kSerial);
  EXPECT_TRUE(request().run);
}

TEST_F(Asd7Reference, APresetSpeedGoesBeforeTheLinesFrequency) {
  settings_.preset_speeds[4] = 2500;
  asked_.command = 0xc400 | 5;
  asked_.frequency = 6000;
  EXPECT_EQ(request().hz, 25);
  EXPECT_EQ(request().frequency_source, kSourcePreset);
  asked_.command = 0xc400;
  EXPECT_EQ(request().hz, 60);
  asked_.command = 0xc500;
  EXPECT_EQ(request().hz, 5) << "jog";
}

TEST_F(Asd7Reference, TerminalsGiveRunDirectionAndPresets) {
  settings_.preset_speeds[2] = 1000;
  asked_.terminals.reverse = true;
  asked_.terminals.preset = {true, true, false, false};
  EXPECT_TRUE(request().run);
  EXPECT_TRUE(request().reverse);
  EXPECT_EQ(request().hz, 10);
  asked_.terminals.standby = false;
  EXPECT_TRUE(request().coast);
}

TEST_F(Asd7Reference, ForcedLocalTakesBothAway) {
  asked_.command = 0xc400;
  asked_.terminals.local = true;
  EXPECT_FALSE(request().run);
  EXPECT_EQ(request().command_source, CommandSource::kTerminals);
}

TEST_F(Asd7Reference, AnalogInputsFollowTheirTwoPoints) {
  settings_.frequency_source = static_cast<std::uint16_t>(FrequencySource::kVia);
  settings_.via_point1 = 2000;
  asked_.terminals.via = 6000;
  EXPECT_NEAR(request().hz, 30, 1e-9);
  asked_.terminals.via = 1000;
  EXPECT_EQ(request().hz, 0);
  settings_.source_switch = 1;
  settings_.frequency_source2 = static_cast<std::uint16_t>(FrequencySource::kPanel);
  asked_.panel_frequency = 1500;
  EXPECT_EQ(request().hz, 15);
}

TEST_F(Asd7Reference, StaysWithinItsLimitsAndOutOfJumps) {
  settings_.lower_limit = 1000;
  settings_.upper_limit = 5000;
  settings_.jumps[1] = {.frequency = 3000, .width = 400};
  EXPECT_EQ(limited_hz(5, settings_), 10);
  EXPECT_EQ(limited_hz(70, settings_), 50);
  EXPECT_EQ(limited_hz(31, settings_), 28);
  EXPECT_EQ(limited_hz(32, settings_), 32);
  EXPECT_EQ(limited_hz(28, settings_), 28);
}

}  // namespace
}  // namespace virtdrive::asd7
