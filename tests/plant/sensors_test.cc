#include "plant/sensors.h"

#include <gtest/gtest.h>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn = 2 * std::numbers::pi;

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

TEST(Hall, GoesThroughItsSixStatesForwards) {
  const std::uint8_t sequence[] = {5, 1, 3, 2, 6, 4};
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(hall_bits((60 * k + 0.1) * kDegree), sequence[k % 6]) << k;
    EXPECT_EQ(hall_bits((60 * k + 59.9) * kDegree), sequence[k % 6]) << k;
  }
}

TEST(Hall, EachBitIsHighForHalfATurn) {
  for (double degrees = -359.5; degrees < 720; degrees += 1) {
    const auto in = [&](double from) {
      const double d = degrees - from;
      return d - 360 * std::floor(d / 360) < 180;
    };
    const std::uint8_t bits = hall_bits(degrees * kDegree);
    EXPECT_EQ(bits, in(0) + 2 * in(120) + 4 * in(240)) << degrees;
  }
}

TEST(Hall, AnOffsetTurnsThePattern) {
  EXPECT_EQ(hall_bits(95 * kDegree, 30 * kDegree), hall_bits(65 * kDegree));
  EXPECT_EQ(hall_bits(-1e-18), 4);  // just below a turn, though adding one rounds to it
}

TEST(Encoder, CountsFourEdgesALine) {
  const Encoder encoder{.lines = 500};
  EXPECT_EQ(encoder.count(0), 0);
  EXPECT_EQ(encoder.count(0.9 * kTurn / 2000), 0);
  EXPECT_EQ(encoder.count(1.1 * kTurn / 2000), 1);
  EXPECT_EQ(encoder.count(1e6 * kTurn + 0.001), 2'000'000'000);
}

TEST(Encoder, RoundsNegativeAnglesDown) {
  const Encoder encoder{.lines = 500};
  EXPECT_EQ(encoder.count(-1e-9), -1);
  EXPECT_EQ(encoder.count(-1.1 * kTurn / 2000), -2);
  EXPECT_EQ(encoder.index_count(-1e-9), -1);
  EXPECT_EQ(encoder.index_count(1e-9), 0);
  EXPECT_EQ(encoder.index_count(2.5 * kTurn), 2);
}

}  // namespace
}  // namespace virtdrive
