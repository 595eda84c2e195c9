#include "plant/position_sensors.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn = 2 * std::numbers::pi;

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

TEST(Hall, EachSensorHasItsPlace) {
  HallSensors hall;
  hall.placement_error_rad = {3 * kDegree, -5 * kDegree, 0};
  EXPECT_EQ(hall.bits(2 * kDegree) & 1, 0);
  EXPECT_EQ(hall.bits(4 * kDegree) & 1, 1);
  EXPECT_EQ(hall.bits(114 * kDegree) & 2, 0);
  EXPECT_EQ(hall.bits(116 * kDegree) & 2, 2);
  EXPECT_EQ(hall.bits(182 * kDegree) & 1, 1);
  EXPECT_EQ(hall.bits(184 * kDegree) & 1, 0);
}

TEST(Hall, ADeadSensorStaysWhereItIsAndMakesForbiddenStates) {
  HallSensors hall;
  hall.output[0] = HallSensors::Output::kStuckLow;
  int zeros = 0;
  for (int degrees = 0; degrees < 360; ++degrees) {
    const std::uint8_t bits = hall.bits((degrees + 0.5) * kDegree);
    EXPECT_EQ(bits, hall_bits((degrees + 0.5) * kDegree) & 6);
    zeros += bits == 0;
  }
  EXPECT_EQ(zeros, 60) << "a healthy one never reads 000";
  hall.output[0] = HallSensors::Output::kStuckHigh;
  EXPECT_EQ(hall.bits(200 * kDegree) & 1, 1);
}

TEST(Hall, EdgesOfTheWorkingSensorsAreCountedUpAndDown) {
  HallSensors hall;
  const auto per_turn = [&](std::uint8_t of) {
    const std::int64_t forwards = hall.edges(0.1 + kTurn, of) - hall.edges(0.1, of);
    EXPECT_EQ(hall.edges(0.1 - kTurn, of) - hall.edges(0.1, of), -forwards);
    return forwards;
  };
  EXPECT_EQ(per_turn(7), 6);
  EXPECT_EQ(per_turn(3), 4);
  hall.output[1] = HallSensors::Output::kStuckHigh;
  EXPECT_EQ(per_turn(7), 4);
  EXPECT_EQ(per_turn(3), 2);
}

TEST(EdgeCounter, MissesWhatItDoesNotHear) {
  EdgeCounter counter;
  counter.see(10);
  counter.see(17, false);
  EXPECT_EQ(counter.count(), 10);
  counter.see(15);
  EXPECT_EQ(counter.count(), 8);
}

TEST(Hall, NextEdgeIsWhereTheBitsChange) {
  HallSensors hall{.offset_rad = 0.1, .placement_error_rad = {0.05, -0.03, 0.01}};
  for (const bool forwards : {true, false}) {
    double angle = 0.7;
    for (int k = 0; k < 50; ++k) {
      const double edge = hall.next_edge_rad(angle, forwards).value();
      const double sense = forwards ? 1 : -1;
      ASSERT_GT((edge - angle) * sense, 0);
      EXPECT_EQ(hall.bits(edge - sense * 1e-9), hall.bits(angle + sense * 1e-9));
      EXPECT_NE(hall.bits(edge - sense * 1e-9), hall.bits(edge + sense * 1e-9));
      angle = edge;
    }
    EXPECT_NEAR(std::abs(angle - 0.7), 50 * kTurn / 6, kTurn / 6);
  }
  hall.output.fill(HallSensors::Output::kStuckHigh);
  EXPECT_FALSE(hall.next_edge_rad(0, true));
}

TEST(Encoder, TheIndexIsCapturedAtItsCountInBothDirections) {
  const Encoder encoder{.lines = 1000, .index_angle_rad = 90 * kDegree};
  EXPECT_FALSE(encoder.index_capture(10 * kDegree, 89.9 * kDegree));
  EXPECT_EQ(encoder.index_capture(89 * kDegree, 91 * kDegree), 1000);
  EXPECT_EQ(encoder.index_capture(91 * kDegree, 89 * kDegree), 1000);
  EXPECT_EQ(encoder.index_capture(0, 3 * kTurn), 1000 + 2 * 4000);
  EXPECT_EQ(encoder.index_capture(3 * kTurn, 0), 1000);
}

TEST(Encoder, MissedEdgesShowAtTheIndexAndASlippedDiscDoesNot) {
  Encoder encoder{.lines = 1000};
  encoder.missed_counts = 3;
  EXPECT_EQ(encoder.count(kTurn + 1e-6), 3997);
  EXPECT_EQ(encoder.index_capture(kTurn - 0.01, kTurn + 0.01), 3997);
  encoder.missed_counts = 0;
  encoder.slip_rad = 0.1 * kTurn;
  EXPECT_EQ(encoder.count(kTurn + 1e-6), 3600);
  EXPECT_FALSE(encoder.index_capture(kTurn - 0.01, kTurn + 0.01));
  EXPECT_EQ(encoder.index_capture(1.1 * kTurn - 0.01, 1.1 * kTurn + 0.01), 4000);
  encoder.index_dead = true;
  EXPECT_FALSE(encoder.index_capture(0, 5 * kTurn));
}

TEST(Encoder, TracksAreAQuarterLineApartAndTheIndexOneCountWide) {
  const Encoder encoder{.lines = 16, .index_angle_rad = kTurn / 4};
  const int sequence[] = {0, 1, 3, 2};  // BA: A rises first
  int high = 0;
  for (int k = -64; k < 64; ++k) {
    const std::uint8_t tracks = encoder.tracks((k + 0.5) * kTurn / 64);
    EXPECT_EQ(tracks & 3, sequence[k & 3]) << k;
    high += (tracks & 4) != 0;
    EXPECT_EQ((tracks & 4) != 0, k == 16 || k == -48) << k;
  }
  EXPECT_EQ(high, 2);
}

// RLS and Tamagawa style: 17 bits within a turn, 16 bits of turns.
TEST(AbsoluteEncoder, PositionAndTurns) {
  const AbsoluteEncoder encoder;
  EXPECT_EQ(encoder.read(0).position, 0U);
  EXPECT_EQ(encoder.read(0.25 * kTurn + 1e-9).position, 32768U);
  const auto reading = encoder.read(5.5 * kTurn + 1e-9);
  EXPECT_EQ(reading.position, 65536U);
  EXPECT_EQ(reading.turns, 5);
  EXPECT_TRUE(reading.crc_good);
  const auto below = encoder.read(-1e-9);
  EXPECT_EQ(below.position, 131071U);
  EXPECT_EQ(below.turns, -1);
  EXPECT_EQ(encoder.read(40000.5 * kTurn).turns, 40000 - 65536) << "16 bits wrap";
}

TEST(AbsoluteEncoder, ZeroDirectionAndWidthAreItsOwn) {
  const AbsoluteEncoder encoder{
      .single_turn_bits = 10, .multi_turn_bits = 0, .zero_rad = kTurn / 4, .reversed = true};
  EXPECT_EQ(encoder.read(kTurn / 4).position, 0U);
  EXPECT_EQ(encoder.read(0).position, 256U);
  EXPECT_EQ(encoder.read(10 * kTurn).turns, 0);
  const AbsoluteEncoder widest{.single_turn_bits = 32, .multi_turn_bits = 32};
  EXPECT_EQ(widest.read(-1e-12).position, 4294967295U);
  EXPECT_EQ(widest.read(-1e-12).turns, -1);
}

TEST(AbsoluteEncoder, FaultsAreFlags) {
  AbsoluteEncoder encoder;
  encoder.battery = AbsoluteEncoder::Battery::kLow;
  EXPECT_TRUE(encoder.read(3.5 * kTurn).battery_low);
  EXPECT_EQ(encoder.read(3.5 * kTurn).turns, 3);
  encoder.battery = AbsoluteEncoder::Battery::kLost;
  const auto lost = encoder.read(3.5 * kTurn);
  EXPECT_TRUE(lost.battery_low && lost.battery_lost);
  EXPECT_EQ(lost.turns, 0);
  EXPECT_EQ(lost.position, 65536U) << "within the turn it needs no battery";
  encoder.crc_fault = true;
  EXPECT_FALSE(encoder.read(0).crc_good);
}

}  // namespace
}  // namespace virtdrive
