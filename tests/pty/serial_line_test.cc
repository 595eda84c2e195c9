#include "pty/serial_line.h"

#include <gtest/gtest.h>
#include <numeric>
#include <vector>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

struct Heard {
  std::uint8_t byte;
  SimTime time;
};

class Recorder final : public SerialReceiver {
 public:
  explicit Recorder(EventLoop& loop) : loop_(loop) {}
  void receive(std::uint8_t byte) override { heard.push_back({byte, loop_.now()}); }

  Bytes bytes() const {
    Bytes result;
    for (const Heard& one : heard) result.push_back(one.byte);
    return result;
  }

  std::vector<Heard> heard;

 private:
  EventLoop& loop_;
};

/// A line with somebody who listens at each end.
struct Wire {
  explicit Wire(const LineSettings& settings = {}) : line(loop, settings) {
    line.add_device().attach(device);
    line.on_host_byte([this](std::uint8_t byte, SimTime time) { host.push_back({byte, time}); });
  }
  Bytes host_bytes() const {
    Bytes result;
    for (const Heard& one : host) result.push_back(one.byte);
    return result;
  }

  EventLoop loop;
  SerialLine line;
  Recorder device{loop};
  std::vector<Heard> host;
};

Bytes counting(std::size_t count) {
  Bytes bytes(count);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

SimTime at_ns(std::int64_t ns) {
  return kSimStart + SimDuration{ns};
}

TEST(LineSettings, ACharacterHasTenOrElevenBitTimes) {
  EXPECT_EQ((LineSettings{.baud = 115200}.character_time()), 86'805ns);
  EXPECT_EQ((LineSettings{.baud = 9600}.character_time()), 1'041'666ns);
  EXPECT_EQ((LineSettings{.baud = 9600, .parity = Parity::kEven}.character_time()), 1'145'833ns);
  EXPECT_EQ((LineSettings{.baud = 9600, .stop_bits = 2}.character_time()), 1'145'833ns);
  EXPECT_EQ((LineSettings{.baud = 9600, .data_bits = 7}.character_time()), 937'500ns);
  EXPECT_EQ((LineSettings{.timing = LineTiming::kIdeal}.character_time()), 0ns);
}

TEST(SerialLine, CharactersOfABurstToTheDeviceArriveExactlyWithoutAddedRounding) {
  Wire wire;
  wire.loop.run_until(kSimStart + 3ms);
  wire.line.host_send(counting(1000));
  wire.loop.run_until(kSimStart + 1s);
  ASSERT_EQ(wire.device.bytes(), counting(1000));
  for (std::int64_t n = 0; n < 1000; ++n) {
    ASSERT_EQ(wire.device.heard[n].time, at_ns(3'000'000 + (n + 1) * 10'000'000'000 / 115200)) << n;
  }
}

TEST(SerialLine, CharactersOfABurstToTheHostArriveExactlyAndSendSaysWhen) {
  Wire wire{{.baud = 9600, .parity = Parity::kEven}};
  wire.loop.run_until(kSimStart + 1ms);
  const SimTime out = wire.line.device(0).send(counting(7));
  EXPECT_EQ(out, at_ns(1'000'000 + 7 * 11'000'000'000 / 9600));
  wire.loop.run_until(kSimStart + 1s);
  ASSERT_EQ(wire.host_bytes(), counting(7));
  for (std::int64_t n = 0; n < 7; ++n) {
    EXPECT_EQ(wire.host[n].time, at_ns(1'000'000 + (n + 1) * 11'000'000'000 / 9600));
  }
  EXPECT_EQ(wire.host.back().time, out);
}

TEST(SerialLine, BytesSentWhileOthersLeaveContinueTheBurstAndItsArithmetic) {
  Wire wire;
  wire.line.host_send(counting(3));
  wire.loop.run_until(kSimStart + 100us);  // in the middle of the second character
  wire.line.host_send(counting(2));
  wire.loop.run_until(kSimStart + 1s);
  ASSERT_EQ(wire.device.heard.size(), 5U);
  EXPECT_EQ(wire.device.heard[4].time, at_ns(5 * 10'000'000'000 / 115200));
}

TEST(SerialLine, ALineThatIsNeverIdleKeepsExactTimeForAMinute) {
  Wire wire{{.baud = 115200}};
  const Bytes block(11'520, 0x55);  // one second of line time
  for (int second = 0; second < 60; ++second) {
    wire.line.host_send(block);
    wire.loop.run_until(kSimStart + std::chrono::seconds{second + 1});
    ASSERT_EQ(wire.device.heard.back().time, kSimStart + std::chrono::seconds{second + 1});
    wire.device.heard.clear();
  }
  EXPECT_EQ(wire.line.counters().to_device, 60U * 11'520U);
}

TEST(SerialLine, IsFullDuplex) {
  Wire wire;
  wire.line.host_send(counting(2));
  wire.line.device(0).send(counting(2));
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.device.heard[1].time, wire.host[1].time);
}

TEST(SerialLine, AnIdealLineDeliversAtTheSameInstantInBothDirections) {
  Wire wire{{.timing = LineTiming::kIdeal}};
  wire.loop.run_until(kSimStart + 5us);
  wire.line.host_send(counting(300));
  EXPECT_EQ(wire.line.device(0).send(counting(4)), kSimStart + 5us);
  wire.loop.run_until(kSimStart + 5us);
  EXPECT_EQ(wire.device.bytes(), counting(300));
  EXPECT_EQ(wire.host_bytes(), counting(4));
  EXPECT_EQ(wire.device.heard.back().time, kSimStart + 5us);
}

TEST(SerialLine, BytesAreHeardBeforeDevicesWakeAtTheSameInstant) {
  Wire wire;
  std::size_t heard_at_wakeup = 0;
  Wakeup wakeup =
      wire.loop.add(Phase::kDevice, [&] { heard_at_wakeup = wire.device.heard.size(); });
  wire.line.host_send(counting(1));
  wakeup.at(kSimStart + LineSettings{}.character_time());
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(heard_at_wakeup, 1U);
}

TEST(SerialLine, ADeviceMayAnswerFromWithinReceive) {
  class Echo final : public SerialReceiver {
   public:
    explicit Echo(SerialPort& port) : port_(port) {}
    void receive(std::uint8_t byte) override { port_.send(std::span(&byte, 1)); }

   private:
    SerialPort& port_;
  };
  Wire wire;
  Echo echo{wire.line.device(0)};
  wire.line.device(0).attach(echo);
  wire.line.host_send(counting(10));
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.host_bytes(), counting(10));
  EXPECT_EQ(wire.host[0].time, at_ns(2 * 86'805));
}

TEST(SerialLine, DropsAndCountsWhatTheQueuesCannotHold) {
  Wire wire;
  const Bytes many(SerialLine::kMaxQueued + 10, 0x55);
  wire.line.host_send(many);
  const SimTime out = wire.line.device(0).send(many);
  EXPECT_EQ(wire.line.host_backlog(), SerialLine::kMaxQueued);
  EXPECT_EQ(out, kSimStart + LineSettings{}.time_of(SerialLine::kMaxQueued));
  wire.loop.run_until(kSimStart + 1h);
  EXPECT_EQ(wire.device.heard.size(), SerialLine::kMaxQueued);
  EXPECT_EQ(wire.host.size(), SerialLine::kMaxQueued);
  EXPECT_EQ(wire.line.counters().to_device_lost, 10U);
  EXPECT_EQ(wire.line.counters().to_host_lost, 10U);
}

TEST(SerialLine, ANewBaudRateHoldsForWhatIsSentFromThenOn) {
  Wire wire{{.baud = 115200}};
  const SimTime old_rate = wire.line.device(0).send(counting(2));
  wire.line.set_host({.baud = 115200});
  wire.line.device(0).set_baud(9600);
  EXPECT_EQ(wire.line.device(0).send(counting(2)),
            old_rate + LineSettings{.baud = 9600}.time_of(2));
  wire.loop.run_until(old_rate);
  wire.line.set_host({.baud = 9600});
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.host_bytes(), (Bytes{0, 1, 0, 1}));
  EXPECT_NEAR(static_cast<double>((wire.host[1].time - old_rate).count()), 0, 1);  // sampled
}

TEST(SerialLine, AHostThreePercentOffIsServed) {
  Wire wire{{.baud = 115200}};
  wire.line.set_host({.baud = 112000});
  wire.line.host_send(counting(200));
  wire.line.device(0).send(counting(200));
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.device.bytes(), counting(200));
  EXPECT_EQ(wire.host_bytes(), counting(200));
  EXPECT_EQ(wire.line.counters().garbled, 0U);
}

TEST(SerialLine, AHostAtAnotherBaudRateGivesAndGetsGarbageInItsOwnTime) {
  Wire wire{{.baud = 19200}};
  wire.line.set_host({.baud = 9600});
  wire.line.host_send(Bytes{0x55});
  wire.line.device(0).send(Bytes{0x0F, 0xA5});
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.device.bytes(), (Bytes{0x66, 0xE6}));
  ASSERT_EQ(wire.device.heard.size(), 2U);
  EXPECT_EQ(wire.device.heard[0].time, at_ns(10'000'000'000 / 19200));
  EXPECT_NE(wire.host_bytes(), (Bytes{0x0F, 0xA5}));
  EXPECT_EQ(wire.line.counters().garbled, 3U);
}

TEST(SerialLine, AHostWithTwoStopBitsIsUnderstoodAndSlower) {
  Wire wire{{.baud = 9600}};
  wire.line.set_host({.baud = 9600, .stop_bits = 2});
  wire.line.host_send(counting(3));
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.device.bytes(), counting(3));
  EXPECT_EQ(wire.device.heard[2].time, at_ns(3 * 11'000'000'000 / 9600));
}

TEST(SerialLine, ADriveThatChecksParityHearsNothingOfTheOpposite) {
  Wire wire{{.baud = 9600, .parity = Parity::kEven}};
  wire.line.set_host({.parity = Parity::kOdd});
  wire.line.host_send(counting(256));
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_TRUE(wire.device.bytes().empty());
  EXPECT_EQ(wire.line.counters().garbled, 256U);
}

TEST(SerialLine, AParityBitIsTheEighthDataBitOfAHostThatExpectsNone) {
  Wire wire{{.baud = 9600, .data_bits = 7, .parity = Parity::kEven}};
  wire.line.set_host({.data_bits = 8, .parity = Parity::kNone});
  wire.line.device(0).send(Bytes{0x41, 0x43});  // two ones, three ones
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.host_bytes(), (Bytes{0x41, 0xC3}));
}

TEST(SerialLine, AHostWithTooFewDataBitsLosesTheTopOne) {
  Wire wire{{.baud = 9600}};
  wire.line.set_host({.data_bits = 7});
  wire.line.device(0).send(Bytes{0xC1});
  wire.loop.run_until(kSimStart + 1s);
  EXPECT_EQ(wire.host_bytes(), Bytes{0x41});
}

TEST(SerialLine, WhatALiveHostSentCanBeReplayedToTheSameNanosecond) {
  struct Call {
    Bytes bytes;
    HostSettings host;
    SimTime time;
  };
  std::vector<Call> calls;
  Wire live;
  live.line.on_host_send(
      [&](std::span<const std::uint8_t> bytes, const HostSettings& host, SimTime time) {
        calls.push_back({Bytes(bytes.begin(), bytes.end()), host, time});
      });
  live.loop.run_until(kSimStart + 1'234'567ns);
  live.line.host_send(counting(20));
  live.line.set_host({.baud = 9600});
  live.loop.run_until(kSimStart + 2'000'003ns);
  live.line.host_send(counting(5));
  live.loop.run_until(kSimStart + 1s);

  Wire replay;
  for (const Call& call : calls) {
    replay.loop.run_before(call.time);
    replay.line.set_host(call.host);
    replay.line.host_send(call.bytes);
  }
  replay.loop.run_until(kSimStart + 1s);
  ASSERT_EQ(replay.device.heard.size(), live.device.heard.size());
  for (std::size_t i = 0; i < live.device.heard.size(); ++i) {
    EXPECT_EQ(replay.device.heard[i].byte, live.device.heard[i].byte);
    EXPECT_EQ(replay.device.heard[i].time, live.device.heard[i].time);
  }
}

TEST(SerialLineDeathTest, ABaudRateOfZeroIsAProgrammersError) {
  EventLoop loop;
  EXPECT_DEATH((SerialLine{loop, {.baud = 0}}), "a line of 0 baud");
}

}  // namespace
}  // namespace virtdrive
