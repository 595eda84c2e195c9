#include "devices/slcan/adapter.h"

#include <gtest/gtest.h>
#include <string>

namespace virtdrive::slcan {
namespace {

using namespace std::chrono_literals;

struct Controller final : CanPort {
  void open(int its_bit_rate, bool its_listen_only) override {
    bit_rate = its_bit_rate;
    listen_only = its_listen_only;
  }
  void close() override { bit_rate = 0; }
  bool send(const CanFrame& frame) override {
    if (full) return false;
    sent.push_back(frame);
    return true;
  }
  CanState state() const override { return now; }
  int bit_rate = 0;
  bool listen_only = false;
  bool full = false;
  std::vector<CanFrame> sent;
  CanState now;
};

struct Terminal final : SerialPort {
  SimTime send(std::span<const std::uint8_t> bytes) override {
    said.append(bytes.begin(), bytes.end());
    return {};
  }
  std::string said;
};

struct SlcanTest : testing::Test {
  /// What the adapter says to a line, with \r and \a.
  std::string say(std::string_view line) {
    terminal.said.clear();
    for (const char c : line) adapter.receive(static_cast<std::uint8_t>(c));
    adapter.receive(std::uint8_t{'\r'});
    return terminal.said;
  }
  std::string hear(const CanFrame& frame) {
    terminal.said.clear();
    adapter.receive(frame);
    return terminal.said;
  }
  EventLoop loop;
  Terminal terminal;
  Controller can;
  Adapter adapter{loop, terminal, can};
};

constexpr CanFrame kFrame{.id = 0xB7AC01, .extended = true, .length = 3, .data = {0x82, 0xE8, 3}};

TEST_F(SlcanTest, ItOpensAtTheBitRateThatWasSet) {
  EXPECT_EQ(say("O"), "\a");  // none is set
  EXPECT_EQ(say("S2"), "\r");
  EXPECT_EQ(say("O"), "\r");
  EXPECT_EQ(can.bit_rate, 50'000);
  EXPECT_EQ(say("O"), "\a");   // open already
  EXPECT_EQ(say("S5"), "\a");  // only when closed
  EXPECT_EQ(say("C"), "\r");
  EXPECT_EQ(can.bit_rate, 0);
  EXPECT_EQ(say("C"), "\a");
}

TEST_F(SlcanTest, EachBitRateHasItsNumber) {
  const int rates[] = {10'000,  20'000,  50'000,  100'000,  125'000,
                       250'000, 500'000, 800'000, 1'000'000};
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(say("S" + std::to_string(i)), "\r");
    say("O");
    EXPECT_EQ(can.bit_rate, rates[i]);
    say("C");
  }
  EXPECT_EQ(say("S9"), "\a");
}

// The maker's table of BTR0 and BTR1 for the same rates.
TEST_F(SlcanTest, ABitRateMayBeGivenByItsRegisters) {
  EXPECT_EQ(bit_rate_of(0x311C), 10'000);
  EXPECT_EQ(bit_rate_of(0x091C), 50'000);
  EXPECT_EQ(bit_rate_of(0x031C), 125'000);
  EXPECT_EQ(bit_rate_of(0x001C), 500'000);
  EXPECT_EQ(bit_rate_of(0x0014), 1'000'000);
  EXPECT_EQ(say("s031C"), "\r");
  say("O");
  EXPECT_EQ(can.bit_rate, 125'000);
}

TEST_F(SlcanTest, FramesOfAllKindsAreSent) {
  say("S2");
  EXPECT_EQ(say("T00B7AC01382E803"), "\a");  // closed
  say("O");
  EXPECT_EQ(say("T00B7AC01382E803"), "Z\r");
  EXPECT_EQ(say("t1232aBcD"), "z\r");
  EXPECT_EQ(say("r1238"), "z\r");
  EXPECT_EQ(say("R1FFFFFFF0"), "Z\r");
  ASSERT_EQ(can.sent.size(), 4U);
  EXPECT_EQ(can.sent[0], kFrame);
  EXPECT_EQ(can.sent[1], (CanFrame{.id = 0x123, .length = 2, .data = {0xAB, 0xCD}}));
  EXPECT_EQ(can.sent[2], (CanFrame{.id = 0x123, .remote = true, .length = 8}));
  EXPECT_EQ(can.sent[3], (CanFrame{.id = 0x1FFFFFFF, .extended = true, .remote = true}));
  can.full = true;
  EXPECT_EQ(say("t1230"), "\a");
}

TEST_F(SlcanTest, WhatIsNoLineIsRefused) {
  say("S2");
  say("O");
  for (const char* line :
       {"", "Q", "t", "t12", "t123", "t1239", "t8000", "T200000000", "t1231", "t12310",
        "t123100112", "t12g0", "Tx0B7AC010", "F0", "V1", "T00B7AC018001122334455667788"}) {
    EXPECT_EQ(say(line), "\a") << line;
  }
  EXPECT_TRUE(can.sent.empty());
  EXPECT_EQ(say("t1230"), "z\r");
}

TEST_F(SlcanTest, WhatOthersSayComesByItselfWhileItIsOpen) {
  EXPECT_EQ(hear(kFrame), "");
  say("S2");
  say("L");
  EXPECT_TRUE(can.listen_only);
  EXPECT_EQ(hear(kFrame), "T00B7AC01382E803\r");
  EXPECT_EQ(hear({.id = 0x7F, .remote = true, .length = 2}), "r07F2\r");
  EXPECT_EQ(say("t1230"), "\a");  // it only listens
}

TEST_F(SlcanTest, FramesMayCarryTheTime) {
  EXPECT_EQ(say("Z1"), "\r");
  say("S2");
  say("O");
  loop.run_until(kSimStart + 61'234ms);
  EXPECT_EQ(hear({.id = 1}), "t001004D2\r");
  EXPECT_EQ(say("Z0"), "\a");
}

TEST_F(SlcanTest, AFilterLetsPassWhatItsCodeAndMaskSay) {
  EXPECT_EQ(say("M0000B560"), "\r");
  EXPECT_EQ(say("mFFFF000F"), "\r");  // the first filter takes all
  say("S2");
  say("O");
  EXPECT_NE(hear({.id = 1}), "");
  const AcceptanceFilter second{.code = 0x24600000, .mask = 0x001FFFF0 & 0x001F0000};
  EXPECT_FALSE(second.passes({.id = 0x124}));
  const AcceptanceFilter one{.code = 0x2460'2460, .mask = 0x000F'000F};
  EXPECT_TRUE(one.passes({.id = 0x123}));
  EXPECT_FALSE(one.passes({.id = 0x124}));
  const AcceptanceFilter wide{.code = 0x05BD'05BD, .mask = 0};
  EXPECT_TRUE(wide.passes({.id = 0xB7AC01, .extended = true}));
  EXPECT_FALSE(wide.passes({.id = 0xB8AC01, .extended = true}));
}

TEST_F(SlcanTest, ItTellsItsVersionAndTheStateOfItsController) {
  EXPECT_EQ(say("V"), "V1013\r");
  EXPECT_EQ(say("N").size(), 6U);
  EXPECT_EQ(say("F"), "\a");
  say("S2");
  say("O");
  EXPECT_EQ(say("F"), "F00\r");
  can.now.transmit_errors = 128;
  EXPECT_EQ(say("F"), "F24\r");
  can.now.bus_off = true;
  EXPECT_EQ(say("F"), "FA4\r");
}

}  // namespace
}  // namespace virtdrive::slcan
