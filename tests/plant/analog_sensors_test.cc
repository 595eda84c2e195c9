#include "plant/analog_sensors.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

RandomStream silent() {
  return RandomStream(1);
}

TEST(Adc, ACountBeginsAtItsStep) {
  const Adc adc{.bits = 12, .reference_v = 4.096};
  EXPECT_EQ(adc.counts(0), 0);
  EXPECT_EQ(adc.counts(0.000999), 0);
  EXPECT_EQ(adc.counts(0.001001), 1);
  EXPECT_EQ(adc.counts(2.0475), 2047);
  EXPECT_EQ(adc.counts(2.048), 2048);
}

TEST(Adc, ClipsAtBothEnds) {
  const Adc adc{.bits = 10, .reference_v = 5};
  EXPECT_EQ(adc.counts(-1), 0);
  EXPECT_EQ(adc.counts(5), 1023);
  EXPECT_EQ(adc.counts(1e12), 1023);
}

TEST(CurrentSensor, ReadsAroundMidScale) {
  RandomStream noise = silent();
  const CurrentSensor sensor{.adc = {.bits = 12, .reference_v = 5}, .volts_per_amp = 0.313};
  EXPECT_EQ(sensor.zero_counts(), 2048);
  EXPECT_EQ(sensor.counts(0, noise), 2048);
  // 1 A: 0.313 V of 5 V / 4096 each.
  EXPECT_EQ(sensor.counts(1, noise), 2048 + 256);
  EXPECT_EQ(sensor.counts(-1, noise), 2048 - 257);
  EXPECT_EQ(sensor.counts(20, noise), 4095);
  EXPECT_EQ(sensor.counts(-20, noise), 0);
}

TEST(CurrentSensor, HasOffsetAndGainErrors) {
  RandomStream noise = silent();
  CurrentSensor sensor{.adc = {.bits = 12, .reference_v = 4.096}, .volts_per_amp = 0.1};
  sensor.offset_a = 0.105;
  EXPECT_EQ(sensor.counts(0, noise), 2048 + 10);
  sensor.offset_a = 0;
  sensor.gain_error = 0.01;
  EXPECT_EQ(sensor.counts(10.0001, noise), 2048 + 1010);
  sensor.volts_per_amp = -0.1;  // an inverting amplifier
  EXPECT_EQ(sensor.counts(9.99, noise), 2048 - 1009);
}

TEST(CurrentSensor, BreaksByOffsetGainAndAtTheEndsOfItsRange) {
  CurrentSensor sensor{.volts_per_amp = 0.1};
  RandomStream none(1);
  const auto amps = [&](double current_a) {
    return (sensor.counts(current_a, none) - sensor.zero_counts()) * 3.3 / 4096 / 0.1;
  };
  sensor.fault = {.offset = 1, .gain = 0.5};
  EXPECT_NEAR(amps(2), 4, 0.01);
  sensor.fault = {.gain = -1};
  EXPECT_NEAR(amps(2), 0, 0.01);
  sensor.fault = {.stuck = SensorFault::Stuck::kLow};
  EXPECT_EQ(sensor.counts(2, none), 0);
  sensor.fault = {.stuck = SensorFault::Stuck::kHigh};
  EXPECT_EQ(sensor.counts(2, none), 4095);
}

TEST(CurrentSensor, NoiseIsRepeatableAndHasItsDeviation) {
  const CurrentSensor sensor{
      .adc = {.bits = 16, .reference_v = 4}, .volts_per_amp = 0.1, .noise_a = 0.2};
  RandomStream a = Seed{5}.stream("adc"), b = Seed{5}.stream("adc");
  double sum = 0, squares = 0;
  constexpr int kSamples = 20'000;
  for (int k = 0; k < kSamples; ++k) {
    const std::int32_t counts = sensor.counts(0, a);
    ASSERT_EQ(counts, sensor.counts(0, b));
    const double amps = (counts - 32768) * 4.0 / 65536 / 0.1;
    sum += amps;
    squares += amps * amps;
  }
  EXPECT_NEAR(sum / kSamples, 0, 5e-3);
  EXPECT_NEAR(std::sqrt(squares / kSamples), 0.2, 4e-3);
}

TEST(CurrentSensor, WithoutNoiseItDrawsNothing) {
  RandomStream noise(7), untouched(7);
  CurrentSensor{.volts_per_amp = 0.1}.counts(1, noise);
  EXPECT_EQ(noise.bits(), untouched.bits());
}

TEST(VoltageSensor, ReadsThroughItsDivider) {
  RandomStream noise = silent();
  const VoltageSensor sensor{.adc = {.bits = 12, .reference_v = 5}, .volts_per_volt = 0.091};
  EXPECT_EQ(sensor.counts(24, noise), static_cast<int>(24 * 0.091 / 5 * 4096));
  EXPECT_EQ(sensor.counts(100, noise), 4095);
}

TEST(VoltageSensor, HasOffsetAndGainErrors) {
  RandomStream noise = silent();
  VoltageSensor sensor{.adc = {.bits = 12, .reference_v = 4.096}, .volts_per_volt = 0.1};
  EXPECT_EQ(sensor.counts(24.0001, noise), 2400);
  sensor.offset_v = -0.5;
  EXPECT_EQ(sensor.counts(24.0001, noise), 2350);
  sensor.gain_error = 0.02;
  EXPECT_EQ(sensor.counts(20.5001, noise), 2040);
}

TEST(Adc, ADeadInputReadsOneValueUntilItIsRepaired) {
  RandomStream noise = silent();
  CurrentSensor sensor{.adc = {.bits = 12, .reference_v = 5}, .volts_per_amp = 0.313};
  sensor.adc.stuck_counts = 4095;
  EXPECT_EQ(sensor.counts(0, noise), 4095);
  sensor.adc.stuck_counts.reset();
  EXPECT_EQ(sensor.counts(0, noise), 2048);
}

// Murata NCP18XH103 (10 kOhm, B25/50 3380 K): its table gives 4.160 kOhm at 50 degC.
TEST(NtcSensor, FollowsTheDataSheet) {
  const NtcSensor ntc{.r25_ohm = 10e3, .beta_k = 3380};
  EXPECT_NEAR(ntc.resistance_ohm(25), 10e3, 1e-9);
  EXPECT_NEAR(ntc.resistance_ohm(50), 4160, 1);
  EXPECT_NEAR(ntc.resistance_ohm(0), 27.2e3, 0.04 * 27.2e3);  // B is no constant over this far
}

TEST(NtcSensor, DividesTheSupplyAndComesBackFromCounts) {
  NtcSensor ntc{.adc = {.bits = 12, .reference_v = 3.3}};
  EXPECT_NEAR(ntc.voltage_v(25), 1.65, 1e-12);
  EXPECT_EQ(ntc.counts(25), 2048);
  EXPECT_LT(ntc.counts(80), ntc.counts(25));
  for (double degc = -20; degc <= 120; degc += 5) {
    EXPECT_NEAR(ntc.temperature_degc(ntc.counts(degc)), degc, 0.2) << degc;
  }
  ntc.ntc_to_supply = true;
  EXPECT_GT(ntc.counts(80), ntc.counts(25));
  EXPECT_NEAR(ntc.temperature_degc(ntc.counts(60)), 60, 0.1);
}

TEST(NtcSensor, BrokenLeadsReadTheEnds) {
  NtcSensor ntc{.adc = {.bits = 12, .reference_v = 3.3}};
  ntc.fault = NtcSensor::Fault::kOpen;
  EXPECT_EQ(ntc.counts(25), 4095);
  ntc.fault = NtcSensor::Fault::kShorted;
  EXPECT_EQ(ntc.counts(25), 0);
  ntc.ntc_to_supply = true;
  EXPECT_EQ(ntc.counts(25), 4095);
}

TEST(UpperOn, PulsesLieAroundTheMiddleOfThePeriod) {
  const PhaseValues duty = {0.75, 0.5, 0.1};
  EXPECT_EQ(upper_on(duty, 0.5), 0b111);
  EXPECT_EQ(upper_on(duty, 0.44), 0b011);
  EXPECT_EQ(upper_on(duty, 0.7), 0b011);
  EXPECT_EQ(upper_on(duty, 0.2), 0b001);
  EXPECT_EQ(upper_on(duty, 0.1), 0b000);
  EXPECT_EQ(upper_on({1, 0, 0}, 0.001), 0b001);
  EXPECT_EQ(upper_on({1, 0, 0}, 0.5), 0b001);
}

// One shunt in the link sees a phase current or its negative in each active vector, and their
// average over the period is the power's share: sum of duty times current.
TEST(LinkCurrent, IsAPhaseCurrentInEachActiveVector) {
  const PhaseValues i = {3, -1, -2};
  EXPECT_EQ(link_current_a(i, 0b000), 0);
  EXPECT_EQ(link_current_a(i, 0b111), 0);
  EXPECT_EQ(link_current_a(i, 0b001), 3);
  EXPECT_EQ(link_current_a(i, 0b011), 2);  // -ic
  EXPECT_EQ(link_current_a(i, 0b110), -3);

  const PhaseValues duty = {0.7, 0.45, 0.3};
  constexpr int kSteps = 20'000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) sum += link_current_a(i, upper_on(duty, (k + 0.5) / kSteps));
  EXPECT_NEAR(sum / kSteps, 0.7 * 3 - 0.45 - 0.3 * 2, 1e-3);
}

TEST(LegShunt, SeesItsPhaseOnlyWhileTheLowerSwitchConducts) {
  const PhaseValues i = {3, -1, -2};
  EXPECT_EQ(leg_shunt_current_a(i, 0b101, 0), 3);
  EXPECT_EQ(leg_shunt_current_a(i, 0b101, 1), 0);
  EXPECT_EQ(leg_shunt_current_a(i, 0b101, 2), -2);
}

}  // namespace
}  // namespace virtdrive
