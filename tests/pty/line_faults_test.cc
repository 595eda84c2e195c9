#include "pty/line_faults.h"

#include <algorithm>
#include <array>
#include <bit>
#include <gtest/gtest.h>

#include "tests/pty/line_stations.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

// 10 us a bit, 100 us a character.
constexpr LineSettings kLine{.baud = 100'000};
constexpr LineSettings kEven{.baud = 100'000, .parity = Parity::kEven};
constexpr LineDirection kToDevices = LineDirection::kToDevices;
constexpr LineDirection kToHost = LineDirection::kToHost;

LineOptions half(std::uint64_t seed = 1) {
  return {.duplex = Duplex::kHalf, .chance = RandomStream{seed}};
}

LineOptions full(std::uint64_t seed = 1) {
  return {.chance = RandomStream{seed}};
}

Bytes heard_with(const LineFaults& faults, const Bytes& said, const LineSettings& settings = kLine,
                 std::uint64_t seed = 1) {
  Stations bus(1, settings, full(seed));
  bus.line.set_faults(kToDevices, faults);
  bus.line.host_send(said);
  bus.run_for(10s);
  return bus.devices[0].bytes();
}

TEST(LineFaults, LostBytesAreMissingAndTheOthersComeAtTheirTime) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToDevices, {.lost = 0.25});
  bus.line.host_send(counting(4000));
  bus.run_for(10s);
  const auto& heard = bus.devices[0].heard;
  EXPECT_NEAR(static_cast<double>(heard.size()), 3000, 150);
  EXPECT_EQ(heard.size() + bus.line.counters().fault_lost, 4000U);
  for (const Heard& one : heard) {
    const auto place = (one.time - kSimStart) / 100us - 1;
    ASSERT_EQ(one.byte, static_cast<std::uint8_t>(place));
  }
}

TEST(LineFaults, AFlippedByteDiffersInOneBit) {
  const Bytes heard = heard_with({.flipped = 1}, Bytes(800, 0x5A));
  ASSERT_EQ(heard.size(), 800U);
  std::array<int, 8> flips{};
  for (const std::uint8_t byte : heard) {
    const unsigned changed = byte ^ 0x5AU;
    ASSERT_EQ(std::popcount(changed), 1);
    ++flips.at(static_cast<std::size_t>(std::countr_zero(changed)));
  }
  for (const int count : flips) EXPECT_NEAR(count, 100, 40);
}

TEST(LineFaults, ParityFindsEveryFlippedBit) {
  Stations bus(1, kEven, full());
  bus.record();
  bus.line.set_faults(kToDevices, {.flipped = 0.5});
  bus.line.host_send(Bytes(1000, 0x5A));
  bus.run_for(10s);
  const std::size_t flipped = bus.line.counters().fault_flipped;
  EXPECT_NEAR(static_cast<double>(flipped), 500, 80);
  EXPECT_EQ(bus.devices[0].bytes(), Bytes(1000 - flipped, 0x5A));
  EXPECT_EQ(std::ranges::count(bus.wire, true, &WireByte::error),
            static_cast<std::ptrdiff_t>(flipped));
}

TEST(LineFaults, ADuplicatedByteIsHeardTwiceAndTheRestLater) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToDevices, {.duplicated = 1});
  bus.line.host_send(Bytes{1, 2, 3});
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].bytes(), (Bytes{1, 1, 2, 2, 3, 3}));
  EXPECT_EQ(bus.devices[0].heard.back().time, kSimStart + 600us);
  EXPECT_EQ(bus.line.counters().fault_duplicated, 3U);
}

TEST(LineFaults, ADelayedByteBeginsLaterAndSoDoesWhatFollows) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToHost, {.delayed = 1, .delay = 3ms});
  const SimTime out = bus.line.device(0).send(Bytes{1, 2});
  EXPECT_EQ(out, kSimStart + 6200us);
  bus.run_for(1s);
  EXPECT_EQ(bus.host, (std::vector<Heard>{{1, kSimStart + 3100us}, {2, kSimStart + 6200us}}));
  EXPECT_EQ(bus.line.counters().fault_delayed, 2U);
}

TEST(LineFaults, ADirectionHasItsOwn) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(2, kLine, options);
    bus.line.set_faults(kToHost, {.lost = 1});
    bus.line.host_send(counting(5));
    bus.run_for(1s);
    EXPECT_EQ(bus.devices[1].bytes(), counting(5));
    bus.line.device(0).send(counting(5));
    bus.run_for(1s);
    EXPECT_TRUE(bus.host.empty());
    EXPECT_EQ(bus.devices[1].bytes(), counting(5));
    bus.line.set_faults(kToHost, {});
    bus.line.device(0).send(counting(5));
    bus.run_for(1s);
    EXPECT_EQ(bytes_of(bus.host), counting(5));
  }
}

TEST(LineFaults, TheSameSeedGivesTheSameFaults) {
  const LineFaults all{.lost = 0.1,
                       .flipped = 0.1,
                       .duplicated = 0.1,
                       .delayed = 0.1,
                       .delay = 1ms,
                       .noise_per_s = 100};
  EXPECT_EQ(heard_with(all, counting(300), kLine, 7), heard_with(all, counting(300), kLine, 7));
  EXPECT_NE(heard_with(all, counting(300), kLine, 7), heard_with(all, counting(300), kLine, 8));
}

TEST(LineFaults, NothingIsDrawnWhileTheyAreOff) {
  // What collides tells where the stream stands.
  const auto run = [](bool used) {
    Stations bus(2, kLine, half());
    if (used) {
      bus.line.set_faults(kToDevices, {.delay = 1ms});
      bus.line.host_send(counting(200));
      bus.run_for(1s);
    }
    bus.host.clear();
    bus.line.device(0).send(Bytes(50, 0x00));
    bus.line.device(1).send(Bytes(50, 0xFF));
    bus.run_for(1s);
    return bytes_of(bus.host);
  };
  EXPECT_EQ(run(false), run(true));
}

TEST(LineFaults, NoiseComesAtItsRateWhileNobodyTalks) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToDevices, {.noise_per_s = 50});
  bus.run_for(40s);
  EXPECT_NEAR(static_cast<double>(bus.devices[0].heard.size()), 2000, 150);
  EXPECT_EQ(bus.line.counters().noise, bus.devices[0].heard.size());
  EXPECT_TRUE(bus.host.empty());
  bus.line.set_faults(kToDevices, {});
  bus.devices[0].heard.clear();
  bus.run_for(40s);
  EXPECT_LE(bus.devices[0].heard.size(), 1U);  // one may have been under way
  EXPECT_EQ(bus.loop.next(), kNever);
}

TEST(LineFaults, NoiseLeavesFramesAloneUnlessOneBeginsInTheMiddleOfIt) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToDevices, {.noise_per_s = 1000});
  int whole = 0;
  for (int frame = 0; frame < 200; ++frame) {
    bus.devices[0].heard.clear();
    bus.line.host_send(counting(20));
    bus.run_for(2050us);
    const Bytes heard = bus.devices[0].bytes();
    if (!std::ranges::search(heard, counting(20)).empty()) ++whole;
    bus.run_for(5ms);
  }
  EXPECT_GT(whole, 150);
  EXPECT_LT(whole, 200);
}

TEST(LineFaults, ACutLineIsSilent) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(2, kLine, options);
    bus.line.set_faults(kToDevices, {.cut = true});
    bus.line.host_send(counting(10));
    bus.run_for(1s);
    EXPECT_TRUE(bus.devices[0].heard.empty());
    bus.line.device(0).send(counting(10));
    bus.run_for(1s);
    EXPECT_EQ(bytes_of(bus.host), counting(10));
    bus.line.set_faults(kToDevices, {});
    bus.devices[0].heard.clear();
    const SimTime start = bus.loop.now();
    bus.line.host_send(counting(1));
    bus.run_for(1s);
    EXPECT_EQ(bus.devices[0].heard, (std::vector<Heard>{{0, start + 100us}}));
  }
}

TEST(LineFaults, ALineThatIsCutInTheMiddleOfAByteStaysHighFromThere) {
  Stations bus(1, kLine, full());
  bus.line.host_send(Bytes{0x12, 0x00, 0x00});
  bus.run_for(100us + 45us);  // start bit, three zeros and half of the fourth
  bus.line.set_faults(kToDevices, {.cut = true});
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].bytes(), (Bytes{0x12, 0xF8}));
}

TEST(LineFaults, ALineThatIsMendedInTheMiddleOfABurstGivesGarbageFirst) {
  Stations bus(1, kLine, full());
  bus.line.set_faults(kToDevices, {.cut = true});
  bus.line.host_send(Bytes(5, 0x55));
  bus.run_for(245us);
  bus.line.set_faults(kToDevices, {});
  bus.run_for(1s);
  EXPECT_LE(bus.devices[0].heard.size(), 3U);
  EXPECT_GE(bus.devices[0].heard.size(), 2U);
}

TEST(LineFaults, ALineHeldLowIsHeardAsOneZeroByte) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(2, kLine, options);
    bus.record();
    bus.line.set_faults(kToDevices, {.stuck = LineStuck::kLow});
    bus.run_for(1s);
    for (const auto& device : bus.devices) EXPECT_EQ(device.bytes(), Bytes{0x00});
    ASSERT_EQ(bus.wire.size(), 1U);
    EXPECT_TRUE(bus.wire[0].error);
    EXPECT_EQ(bus.wire[0].talker, kNoTalker);
    bus.line.host_send(counting(10));
    bus.run_for(1s);
    EXPECT_EQ(bus.devices[0].bytes(), Bytes{0x00});
    EXPECT_EQ(bus.loop.next(), kNever);  // nothing is left to wait for

    bus.line.set_faults(kToDevices, {});
    bus.run_for(1ms);
    bus.devices[0].heard.clear();
    const SimTime start = bus.loop.now();
    bus.line.host_send(counting(1));
    bus.run_for(1s);
    EXPECT_EQ(bus.devices[0].heard, (std::vector<Heard>{{0, start + 100us}}));
  }
}

TEST(LineFaults, ALineHeldHighIsSilentAndATwoWireLineIsSoBothWays) {
  for (const bool two_wires : {false, true}) {
    Stations bus(2, kLine, two_wires ? half() : full());
    bus.line.set_faults(kToDevices, {.stuck = LineStuck::kHigh});
    bus.line.host_send(counting(10));
    bus.run_for(1s);
    EXPECT_TRUE(bus.devices[0].heard.empty());
    bus.line.device(0).send(counting(10));
    bus.run_for(1s);
    EXPECT_EQ(bytes_of(bus.host), two_wires ? Bytes{} : counting(10));
  }
}

TEST(LineFaults, OnAnIdealLineTheyHoldAsWell) {
  LineSettings ideal = kLine;
  ideal.timing = LineTiming::kIdeal;
  EXPECT_TRUE(heard_with({.cut = true}, counting(10), ideal).empty());
  EXPECT_TRUE(heard_with({.stuck = LineStuck::kHigh}, counting(10), ideal).empty());
  EXPECT_TRUE(heard_with({.lost = 1}, counting(10), ideal).empty());
  EXPECT_EQ(heard_with({.duplicated = 1}, Bytes{1, 2}, ideal), (Bytes{1, 1, 2, 2}));
}

TEST(LineFaultsDeathTest, AProbabilityAboveOneIsAProgrammersError) {
  EXPECT_DEATH(heard_with({.lost = 1.5}, {}), "probability 1.5");
}

}  // namespace
}  // namespace virtdrive
