#include "pty/can_bus.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr int kRate = 50'000;
constexpr SimDuration kBit = 20us;

CanFrame standard(std::uint32_t id, std::initializer_list<std::uint8_t> bytes = {}) {
  CanFrame frame = extended_frame(id, std::vector<std::uint8_t>(bytes));
  frame.extended = false;
  return frame;
}
CanFrame extended(std::uint32_t id, std::initializer_list<std::uint8_t> bytes = {}) {
  return extended_frame(id, std::vector<std::uint8_t>(bytes));
}

struct Station final : CanReceiver {
  Station(EventLoop& its_loop, CanBus& bus, int bit_rate = kRate, bool listen_only = false)
      : loop(its_loop), node(bus.add_node()) {
    node.attach(*this);
    node.open(bit_rate, listen_only);
  }
  void receive(const CanFrame& frame) override {
    heard.push_back(frame);
    times.push_back(loop.now());
  }
  EventLoop& loop;
  CanNode& node;
  std::vector<CanFrame> heard;
  std::vector<SimTime> times;
};

struct CanBusTest : testing::Test {
  EventLoop loop;
  CanBus bus{loop};
  void run(SimDuration time = 100ms) { loop.run_until(loop.now() + time); }
};

// 44 bits (64 extended), eight a byte, the gap of three, and at most a stuff bit for each four bits
// that may be stuffed (34 and eight a byte; 54).
TEST(CanFrame, ItsBitsIncludeStuffBits) {
  EXPECT_EQ(can_frame_bits(standard(0x555, {0x55, 0x55})), 44 + 16 + 3 + 1);
  EXPECT_EQ(can_frame_bits(standard(0x123, {1, 2, 3})), 44 + 24 + 3 + 4);
  // Dominant bits up to the length, 19 of them with the stuffing of the first five and then four.
  const int zeros = can_frame_bits(standard(0, {}));
  EXPECT_GT(zeros, 44 + 3 + 3);
  EXPECT_LE(zeros, 44 + 3 + 34 / 4);
  const int longest = can_frame_bits(standard(0, {0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_GT(longest, 44 + 64 + 3 + 15);
  EXPECT_LE(longest, 44 + 64 + 3 + (34 + 64) / 4);
  EXPECT_LE(can_frame_bits(extended(0, {})), 64 + 3 + 54 / 4);
}

TEST_F(CanBusTest, AFrameIsHeardByAllOthersWhenItsBitsHavePassed) {
  Station a(loop, bus), b(loop, bus), c(loop, bus);
  const CanFrame frame = extended(0xB7AC01, {0x82, 0xE8, 0x03});
  EXPECT_TRUE(a.node.send(frame));
  run();
  EXPECT_TRUE(a.heard.empty());
  ASSERT_EQ(b.heard, std::vector{frame});
  EXPECT_EQ(c.heard, std::vector{frame});
  EXPECT_EQ(b.times[0] - kSimStart, can_frame_bits(frame) * kBit);
  EXPECT_EQ(bus.counters().frames, 1U);
}

TEST_F(CanBusTest, TheLowestIdentifierGoesFirstAndNoneIsLost) {
  Station a(loop, bus), b(loop, bus), c(loop, bus);
  a.node.send(standard(0x100));
  a.node.send(extended(0x100 << 18));
  b.node.send(standard(0x200));
  b.node.send(standard(0x080));
  run();
  ASSERT_EQ(c.heard.size(), 4U);
  EXPECT_EQ(c.heard[0], standard(0x100));  // 0x080 stood behind 0x200
  EXPECT_EQ(c.heard[1], extended(0x100 << 18));
  EXPECT_EQ(c.heard[2], standard(0x200));
  EXPECT_EQ(c.heard[3], standard(0x080));
}

TEST_F(CanBusTest, AStandardFrameBeatsTheExtendedOneWithItsFirstBitsAndDataBeatRemote) {
  Station a(loop, bus), b(loop, bus), c(loop, bus), d(loop, bus);
  CanFrame remote = standard(0x123);
  remote.remote = true;
  a.node.send(extended(0x123 << 18));
  b.node.send(remote);
  c.node.send(standard(0x123));
  run();
  EXPECT_EQ(d.heard, (std::vector{standard(0x123), remote, extended(0x123 << 18)}));
}

TEST_F(CanBusTest, WhatNobodyTakesIsSentAgainUntilSomebodyIsThere) {
  Station a(loop, bus);
  a.node.send(standard(1));
  run(1s);
  EXPECT_EQ(bus.counters().frames, 0U);
  EXPECT_GT(bus.counters().errors, 100U);
  EXPECT_TRUE(a.node.state().passive());
  EXPECT_FALSE(a.node.state().bus_off);  // an acknowledge is all that was missing
  Station b(loop, bus);
  run(10ms);
  EXPECT_EQ(b.heard, std::vector{standard(1)});
}

TEST_F(CanBusTest, AListenerTakesNothing) {
  Station a(loop, bus), listener(loop, bus, kRate, true);
  a.node.send(standard(1));
  run();
  EXPECT_TRUE(listener.heard.empty());
  EXPECT_FALSE(listener.node.send(standard(2)));
  Station b(loop, bus);
  run();
  EXPECT_EQ(listener.heard.size(), 1U);
}

TEST_F(CanBusTest, EqualFramesAtOnceAreOneAndDifferentOnesAnErrorForBoth) {
  Station a(loop, bus), b(loop, bus), c(loop, bus);
  a.node.send(standard(1, {7}));
  b.node.send(standard(1, {7}));
  run(10ms);
  EXPECT_EQ(c.heard.size(), 1U);
  a.node.send(standard(1, {7}));
  b.node.send(standard(1, {8}));
  run(1s);
  EXPECT_EQ(c.heard.size(), 1U);
  EXPECT_TRUE(a.node.state().bus_off);
  EXPECT_TRUE(b.node.state().bus_off);
  EXPECT_FALSE(a.node.send(standard(2)));
  a.node.open(kRate, false);  // from the beginning
  EXPECT_TRUE(a.node.send(standard(2)));
  run(10ms);
  EXPECT_EQ(c.heard.back(), standard(2));
}

TEST_F(CanBusTest, WhoHasAnotherBitRateDestroysFramesUntilItIsErrorPassive) {
  Station a(loop, bus), b(loop, bus), wrong(loop, bus, 125'000);
  a.node.send(standard(1));
  run(1s);
  EXPECT_EQ(b.heard.size(), 1U);
  EXPECT_TRUE(wrong.heard.empty());
  EXPECT_TRUE(wrong.node.state().passive());
  EXPECT_GE(bus.counters().errors, 16U);
}

TEST_F(CanBusTest, ACutWireAndAClosedNodeHearNothing) {
  Station a(loop, bus), b(loop, bus), c(loop, bus);
  c.node.close();
  bus.set_cut(true);
  a.node.send(standard(1));
  run(10ms);
  EXPECT_TRUE(b.heard.empty());
  bus.set_cut(false);
  run(10ms);
  EXPECT_EQ(b.heard.size(), 1U);
  EXPECT_TRUE(c.heard.empty());
  a.node.send(standard(1));
  a.node.close();
  run(10ms);
  EXPECT_EQ(b.heard.size(), 1U);
}

TEST_F(CanBusTest, AQueueHoldsThirtyTwo) {
  Station a(loop, bus), b(loop, bus);
  int taken = 0;
  for (std::uint32_t i = 0; i < 40; ++i) taken += a.node.send(standard(i));
  EXPECT_EQ(taken, 32);
  run(1s);
  EXPECT_EQ(b.heard.size(), 32U);
}

}  // namespace
}  // namespace virtdrive
