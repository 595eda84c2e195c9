#include "pty/uart.h"

#include <gtest/gtest.h>
#include <numeric>
#include <vector>

#include "pty/serial_line.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

Bytes counting(std::size_t count) {
  Bytes bytes(count);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

// The expected bytes were worked out on paper from the bit patterns.

/// Both ends frame alike.
std::vector<WireByte> resample(const Bytes& bytes, int from_baud, int to_baud,
                               LineSettings sender) {
  LineSettings listener = sender;
  sender.baud = from_baud;
  listener.baud = to_baud;
  return virtdrive::resample(bytes, sender, listener);
}

TEST(Resample, EqualRatesGiveTheBytesBackWhateverTheFraming) {
  for (const Parity parity : {Parity::kNone, Parity::kEven, Parity::kOdd}) {
    for (const int stop_bits : {1, 2}) {
      const LineSettings settings{.parity = parity, .stop_bits = stop_bits};
      const Bytes bytes = counting(256);
      const std::vector<WireByte> heard = resample(bytes, 9600, 9600, settings);
      ASSERT_EQ(heard.size(), 256U);
      for (std::size_t i = 0; i < 256; ++i) {
        EXPECT_EQ(heard[i].byte, bytes[i]);
        EXPECT_FALSE(heard[i].error);
      }
    }
  }
}

TEST(Resample, FourPercentAreStillUnderstoodAndSevenAreNot) {
  const Bytes bytes = counting(256);
  for (const int baud : {9216, 9984}) {
    const std::vector<WireByte> heard = resample(bytes, 9600, baud, {});
    ASSERT_EQ(heard.size(), 256U) << baud;
    for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(heard[i].byte, bytes[i]);
  }
  for (const int baud : {8928, 10272}) {
    Bytes heard;
    for (const WireByte& one : resample(bytes, 9600, baud, {})) heard.push_back(one.byte);
    EXPECT_NE(heard, bytes) << baud;
  }
}

WireByte heard(std::uint8_t byte, SimDuration begin, bool error = false) {
  const SimTime start = kSimStart + begin;
  return {.byte = byte, .begin = start, .end = start + 520'833ns, .error = error};
}

TEST(Resample, AReceiverTwiceAsFastHearsEachBitTwice) {
  // 0x55: 0 1 0 1 0 1 0 1 0 1 sent; 00 11 00 11 00 11 00 11 00 11 heard: a 0x66 with a low stop
  // bit, then from the next falling edge 0 0110011 1.
  EXPECT_EQ(resample(Bytes{0x55}, 9600, 19200, {}),
            (std::vector<WireByte>{heard(0x66, 0ns, true), heard(0xE6, 625'000ns)}));
  // 0xFF: the start bit is as long as a start bit and a zero.
  EXPECT_EQ(resample(Bytes{0xFF}, 9600, 19200, {}), std::vector<WireByte>{heard(0xFE, 0ns)});
  // 0x00: low for 18 of its bits.
  EXPECT_EQ(resample(Bytes{0x00}, 9600, 19200, {}),
            (std::vector<WireByte>{heard(0x00, 0ns, true)}));
}

TEST(Resample, ASlowReceiverHearsFewerBytes) {
  // Four bits of the sender in one of the receiver's.
  const std::vector<WireByte> heard = resample(counting(40), 38400, 9600, {});
  EXPECT_GT(heard.size(), 0U);
  EXPECT_LE(heard.size(), 11U);
}

TEST(Resample, AStartBitShorterThanHalfABitIsNoise) {
  EXPECT_TRUE(resample(Bytes{0xFF}, 115200, 9600, {}).empty());
}

TEST(Resample, AWrongParityBitIsAnError) {
  int errors = 0;
  for (const WireByte& one : resample(counting(256), 9600, 19200, {.parity = Parity::kEven})) {
    errors += one.error ? 1 : 0;
  }
  EXPECT_GT(errors, 0);
}

TEST(Resample, ALongBurstStaysCheapAndBounded) {
  const Bytes bytes(SerialLine::kMaxQueued, 0x55);
  EXPECT_LE(resample(bytes, 50, 4'000'000, {}).size(), bytes.size() * 5);
}

}  // namespace
}  // namespace virtdrive
