#include "tests/pty/line_stations.h"

#include <gtest/gtest.h>
#include <set>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

// 10 us a bit, 100 us a character.
constexpr LineSettings kLine{.baud = 100'000};
constexpr SimDuration kCharacter = 100us;

LineOptions half(std::uint64_t seed = 1) {
  return {.duplex = Duplex::kHalf, .chance = RandomStream{seed}};
}

LineOptions full() {
  return {};
}

SimTime at(SimDuration since_start) {
  return kSimStart + since_start;
}

std::vector<Heard> on_time(const Bytes& bytes, SimTime start) {
  std::vector<Heard> result;
  for (const std::uint8_t byte : bytes) result.push_back({byte, start += kCharacter});
  return result;
}

// --- Who hears whom ------------------------------------------------------------------------------

TEST(Stations, EveryDeviceHearsTheHostAtTheSameInstant) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(32, kLine, options);
    bus.line.host_send(counting(50));
    bus.run_for(1s);
    for (const auto& device : bus.devices) {
      ASSERT_EQ(device.heard, on_time(counting(50), kSimStart));
    }
    EXPECT_TRUE(bus.host.empty());
    EXPECT_EQ(bus.line.counters().to_device, 32U * 50U);
  }
}

TEST(Stations, OnTwoWiresEverybodyButTheTalkerHearsADevice) {
  Stations bus(3, kLine, half());
  EXPECT_EQ(bus.line.device(1).send(counting(5)), at(5 * kCharacter));
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].heard, on_time(counting(5), kSimStart));
  EXPECT_TRUE(bus.devices[1].heard.empty());
  EXPECT_EQ(bus.devices[2].heard, on_time(counting(5), kSimStart));
  EXPECT_EQ(bus.host, on_time(counting(5), kSimStart));
}

TEST(Stations, OnFourWiresOnlyTheHostHearsADevice) {
  Stations bus(3, kLine, full());
  bus.line.device(1).send(counting(5));
  bus.run_for(1s);
  for (const auto& device : bus.devices) EXPECT_TRUE(device.heard.empty());
  EXPECT_EQ(bus.host, on_time(counting(5), kSimStart));
}

TEST(Stations, AHostWithEchoHearsItselfOnTime) {
  LineOptions options = half();
  options.echo = true;
  Stations bus(2, kLine, options);
  bus.line.host_send(counting(3));
  bus.run_for(1ms);
  EXPECT_EQ(bus.host, on_time(counting(3), kSimStart));
  EXPECT_EQ(bus.devices[1].bytes(), counting(3));
}

TEST(StationsDeathTest, AnEchoNeedsTwoWires) {
  EXPECT_DEATH(Stations(1, kLine, {.echo = true}), "echo");
}

TEST(Stations, AnAnswerThatBeginsAsTheRequestEndsDoesNotCollide) {
  Stations bus(2, kLine, half());
  bus.line.host_send(counting(4));
  bus.loop.run_until(at(4 * kCharacter));
  bus.line.device(0).send(counting(6));
  bus.run_for(1s);
  EXPECT_EQ(bus.host, on_time(counting(6), at(4 * kCharacter)));
  EXPECT_EQ(bus.devices[1].bytes().size(), 10U);
  EXPECT_EQ(bus.line.counters().collisions, 0U);
}

TEST(Stations, ADeviceAtOtherSettingsHearsGarbageAndTheOthersDoNotNotice) {
  Stations bus(2, kLine, half());
  bus.line.device(1).set_baud(50'000);
  bus.line.host_send(counting(20));
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].heard, on_time(counting(20), kSimStart));
  EXPECT_FALSE(bus.devices[1].heard.empty());
  EXPECT_NE(bus.devices[1].bytes(), counting(20));
  EXPECT_EQ(bus.line.counters().garbled, 20U);

  bus.line.device(1).set_baud(100'000);
  bus.devices[1].heard.clear();
  const SimTime start = bus.loop.now();
  bus.line.host_send(counting(20));
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[1].heard, on_time(counting(20), start));
}

TEST(Stations, WhoChangesItsRateInTheMiddleOfABurstFindsBackAfterIt) {
  Stations bus(2, kLine, half());
  bus.line.host_send(Bytes(20, 0x41));
  bus.run_for(550us);
  bus.line.device(0).set_baud(9600);
  bus.run_for(400us);
  bus.line.device(0).set_baud(100'000);
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[1].bytes(), Bytes(20, 0x41));
  EXPECT_NE(bus.devices[0].bytes(), Bytes(20, 0x41));
  bus.devices[0].heard.clear();
  const SimTime start = bus.loop.now();
  bus.line.host_send(counting(3));
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].heard, on_time(counting(3), start));
}

// --- Power ---------------------------------------------------------------------------------------

TEST(Stations, APoweredOffDeviceHearsAndSaysNothing) {
  Stations bus(2, kLine, half());
  bus.line.device(0).detach();
  EXPECT_FALSE(bus.line.device(0).attached());
  EXPECT_EQ(bus.line.device(0).send(counting(3)), kSimStart);
  bus.line.host_send(counting(3));
  bus.run_for(1s);
  EXPECT_TRUE(bus.devices[0].heard.empty());
  EXPECT_TRUE(bus.host.empty());
  EXPECT_EQ(bus.devices[1].bytes(), counting(3));
}

TEST(Stations, PowerThatFailsCutsWhatADeviceSaysOffInTheMiddleOfACharacter) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(2, kLine, options);
    bus.line.device(0).send(Bytes{0x11, 0x00, 0x22, 0x33});
    // The start bit and three data bits of the second character, and half of the next one.
    bus.run_for(kCharacter + 45us);
    bus.line.device(0).detach();
    bus.run_for(1s);
    EXPECT_EQ(bytes_of(bus.host), (Bytes{0x11, 0xF8}));
    EXPECT_EQ(bus.host[1].time, at(2 * kCharacter));
  }
}

TEST(Stations, PowerThatComesInTheMiddleOfACharacterGivesGarbageAndThenService) {
  Stations bus(2, kLine, half());
  bus.line.device(0).detach();
  bus.line.host_send(Bytes{0x0F, 0xFF});
  bus.run_for(65us);  // in the second low data bit; 0000 are still to come, then 1
  bus.line.device(0).attach(bus.devices[0]);
  bus.run_for(1s);
  EXPECT_NE(bus.devices[0].bytes(), (Bytes{0x0F, 0xFF}));
  EXPECT_EQ(bus.devices[1].bytes(), (Bytes{0x0F, 0xFF}));
  bus.devices[0].heard.clear();
  bus.line.host_send(counting(9));
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].bytes(), counting(9));
}

TEST(Stations, ADeviceMayLoseItsPowerWhileItHears) {
  class Fuse final : public SerialReceiver {
   public:
    explicit Fuse(LineEnd& end) : end_(end) {}
    void receive(std::uint8_t) override {
      ++heard;
      end_.send(Bytes{1, 2, 3});
      end_.detach();
    }
    int heard = 0;

   private:
    LineEnd& end_;
  };
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(2, kLine, options);
    Fuse fuse(bus.line.device(0));
    bus.line.device(0).attach(fuse);
    bus.line.host_send(counting(3));
    bus.run_for(1s);
    EXPECT_EQ(fuse.heard, 1);
    EXPECT_TRUE(bus.host.empty());
    bus.line.host_send(counting(3));
    bus.run_for(1s);
    EXPECT_EQ(bus.devices[1].bytes().size(), 6U);
  }
}

// --- Collisions ----------------------------------------------------------------------------------

TEST(Stations, WhereTwoSayTheSameAtTheSameTimeItIsHeardUnharmed) {
  Stations bus(3, kLine, half());
  bus.line.device(0).send(counting(10));
  bus.line.device(1).send(counting(10));
  bus.run_for(1s);
  EXPECT_EQ(bytes_of(bus.host), counting(10));
  EXPECT_EQ(bus.devices[2].bytes(), counting(10));
  EXPECT_TRUE(bus.devices[0].heard.empty());
  EXPECT_EQ(bus.line.counters().collisions, 1U);
}

TEST(Stations, OnlyTheBitsInWhichTwoDifferAreUndecided) {
  // 0xF0 against 0xF3 from the same instant: bits 0 and 1 differ.
  std::set<std::uint8_t> seen;
  for (std::uint64_t seed = 1; seed <= 64; ++seed) {
    Stations bus(3, kLine, half(seed));
    bus.line.device(0).send(Bytes{0xF0});
    bus.line.device(1).send(Bytes{0xF3});
    bus.run_for(1ms);
    ASSERT_EQ(bus.host.size(), 1U);
    EXPECT_EQ(bus.host, bus.devices[2].heard);  // the wires have one level
    seen.insert(bus.host[0].byte);
  }
  EXPECT_EQ(seen, (std::set<std::uint8_t>{0xF0, 0xF1, 0xF2, 0xF3}));
}

TEST(Stations, OfThreeTheMajorityDecides) {
  Stations bus(4, kLine, half());
  bus.line.device(0).send(Bytes{0b1100'1010});
  bus.line.device(1).send(Bytes{0b1010'1100});
  bus.line.device(2).send(Bytes{0b0110'1001});
  bus.run_for(1ms);
  EXPECT_EQ(bytes_of(bus.host), (Bytes{0b1110'1000}));
  EXPECT_EQ(bus.devices[3].bytes(), (Bytes{0b1110'1000}));
  EXPECT_EQ(bus.line.counters().collisions, 2U);
}

TEST(Stations, AnAnswerThatStartsLaterGarblesOnlyWhatItOverlaps) {
  Stations bus(3, kLine, half());
  bus.line.device(0).send(Bytes(10, 0x55));
  bus.run_for(525us);
  bus.line.device(1).send(Bytes(2, 0x33));
  bus.run_for(1s);
  ASSERT_GE(bus.host.size(), 6U);
  const std::vector<Heard> before(bus.host.begin(), bus.host.begin() + 5);
  EXPECT_EQ(before, on_time(Bytes(5, 0x55), kSimStart));
  EXPECT_NE(bytes_of(bus.host), Bytes(10, 0x55));
  EXPECT_EQ(bus.host, bus.devices[2].heard);

  const std::size_t first = bus.host.size();
  const SimTime start = bus.loop.now();
  bus.line.device(1).send(counting(4));
  bus.run_for(1s);
  EXPECT_EQ(
      std::vector<Heard>(bus.host.begin() + static_cast<std::ptrdiff_t>(first), bus.host.end()),
      on_time(counting(4), start));
}

TEST(Stations, WhoStopsTalkingHearsTheRestOfTheOther) {
  Stations bus(2, kLine, half());
  bus.line.device(0).send(Bytes{0xFF});
  bus.line.device(1).send(Bytes{0xFF, 0x12, 0x34});
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].bytes(), (Bytes{0x12, 0x34}));
  EXPECT_TRUE(bus.devices[1].heard.empty());
}

TEST(Stations, AHostThatTalksOverAnAnswerSpoilsItAndHearsNothingMeanwhile) {
  Stations bus(2, kLine, half());
  bus.line.device(0).send(counting(10));
  bus.run_for(2 * kCharacter + 30us);
  bus.line.host_send(Bytes(8, 0xAA));
  bus.run_for(1s);
  EXPECT_EQ(bytes_of(bus.host), counting(2));
  EXPECT_NE(bus.devices[1].bytes(), counting(10));
  EXPECT_EQ(bus.line.counters().collisions, 1U);
}

TEST(Stations, AHostWithEchoHearsTheCollisionAsTheOthersDo) {
  LineOptions options = half();
  options.echo = true;
  Stations bus(2, kLine, options);
  bus.line.device(0).send(counting(10));
  bus.run_for(2 * kCharacter + 30us);
  bus.line.host_send(Bytes(3, 0xAA));
  bus.run_for(1s);
  EXPECT_EQ(bus.host, bus.devices[1].heard);
}

TEST(Stations, OnFourWiresTheHostMayTalkOverAnAnswerButTwoDevicesMayNot) {
  Stations bus(2, kLine, full());
  bus.line.device(0).send(counting(10));
  bus.line.host_send(Bytes(8, 0xAA));
  bus.run_for(1s);
  EXPECT_EQ(bytes_of(bus.host), counting(10));
  EXPECT_EQ(bus.devices[0].bytes(), Bytes(8, 0xAA));
  EXPECT_EQ(bus.line.counters().collisions, 0U);
  bus.host.clear();
  bus.line.device(0).send(counting(10));
  bus.run_for(30us);
  bus.line.device(1).send(counting(10));
  bus.run_for(1s);
  EXPECT_NE(bytes_of(bus.host), counting(10));
  EXPECT_EQ(bus.line.counters().collisions, 1U);
}

TEST(Stations, ACollisionIsTheSameForTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    Stations bus(8, kLine, half(seed));
    for (std::size_t i = 0; i < 8; ++i) {
      bus.line.device(i).send(counting(40 + i));
      bus.run_for(33us);
    }
    bus.run_for(1s);
    return bus.host;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(Stations, AnIdealLineKnowsNoCollision) {
  LineSettings ideal = kLine;
  ideal.timing = LineTiming::kIdeal;
  Stations bus(2, ideal, half());
  bus.line.device(0).send(counting(3));
  bus.line.device(1).send(counting(3));
  bus.line.host_send(counting(3));
  bus.loop.run_until(kSimStart);
  EXPECT_EQ(bus.host.size(), 6U);
  EXPECT_EQ(bus.devices[0].bytes().size(), 6U);
  EXPECT_EQ(bus.line.counters().collisions, 0U);
}

// --- The tap -------------------------------------------------------------------------------------

TEST(Stations, ATapTellsEachByteOnceWithItsTalkerAndItsTime) {
  for (const LineOptions& options : {half(), full()}) {
    Stations bus(4, kLine, options);
    bus.record();
    bus.line.host_send(counting(2));
    bus.run_for(1ms);
    bus.line.device(2).send(Bytes{0x77});
    bus.run_for(1s);
    EXPECT_EQ(bus.wire,
              (std::vector<WireByte>{
                  {.byte = 0, .begin = at(0us), .end = at(100us), .talker = kHostTalker},
                  {.byte = 1, .begin = at(100us), .end = at(200us), .talker = kHostTalker},
                  {.byte = 0x77, .begin = at(1000us), .end = at(1100us), .talker = 2}}));
    bus.line.on_wire(nullptr);
    bus.line.host_send(counting(2));
    bus.run_for(1s);
    EXPECT_EQ(bus.wire.size(), 3U);
  }
}

TEST(Stations, ATapMarksWhatCollidedAndOnlyThat) {
  Stations bus(2, kLine, half());
  bus.record();
  bus.line.device(0).send(Bytes(4, 0x55));
  bus.run_for(kCharacter + 50us);
  bus.line.device(1).send(Bytes{0x55});
  bus.run_for(1s);
  ASSERT_GE(bus.wire.size(), 3U);
  EXPECT_FALSE(bus.wire.front().collided);
  EXPECT_TRUE(bus.wire[1].collided);
  EXPECT_FALSE(bus.wire.back().collided);
}

TEST(Stations, ATapChangesNothing) {
  const auto run = [](bool record) {
    Stations bus(4, kLine, half());
    if (record) bus.record();
    bus.line.device(3).set_baud(57'600);
    for (std::size_t i = 0; i < 3; ++i) {
      bus.line.device(i).send(counting(10));
      bus.run_for(77us);
    }
    bus.run_for(1s);
    bus.line.host_send(counting(10));
    bus.run_for(1s);
    return std::tuple(bus.host, bus.devices[0].heard, bus.devices[3].heard,
                      bus.line.counters().garbled);
  };
  EXPECT_EQ(run(false), run(true));
}

// --- Break ---------------------------------------------------------------------------------------

TEST(Stations, ABreakIsHeardAsOneZeroByteAndWhatFollowsIsUnharmed) {
  Stations bus(1, kLine, half());
  bus.record();
  bus.line.host_send(Bytes{0x41});
  bus.line.host_break(5ms);
  bus.line.host_send(Bytes{0x42});
  bus.run_for(1s);
  EXPECT_EQ(bus.devices[0].bytes(), (Bytes{0x41, 0x00, 0x42}));
  EXPECT_EQ(bus.devices[0].heard[2].time, at(100us + 5ms + 10us + 100us));
  ASSERT_EQ(bus.wire.size(), 3U);
  EXPECT_TRUE(bus.wire[1].error);
}

}  // namespace
}  // namespace virtdrive
