#include "pty/serial_device_endpoint.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <numeric>
#include <optional>
#include <sys/ioctl.h>
#include <termios.h>

#include "core/check.h"
#include "tests/pty/pumped_endpoint.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;
using Bench = Pumped<SerialDeviceEndpoint>;

constexpr LineSettings kIdeal{.timing = LineTiming::kIdeal};

/// A pseudo-terminal stands in for an adapter: its master is the far end of the wire.
struct Wire {
  Wire() : far_end(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    grantpt(far_end.get());
    unlockpt(far_end.get());
    std::array<char, 128> name{};
    ptsname_r(far_end.get(), name.data(), name.size());
    path = name.data();
    keeper = FileDescriptor{::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
  }

  termios settings() const {
    termios found{};
    tcgetattr(keeper.get(), &found);
    return found;
  }
  void unplug() {
    keeper.reset();
    far_end.reset();
  }
  void write(const Bytes& bytes) const {
    ASSERT_EQ(::write(far_end.get(), bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
  }

  FileDescriptor far_end;
  FileDescriptor keeper;  // the settings live as long as somebody has the slave open
  std::string path;
};

Bytes read_bytes(Bench& bench, const Wire& wire, std::size_t count) {
  Bytes bytes;
  bench.pump([&] {
    Bytes part(65536);
    const ssize_t size = ::read(wire.far_end.get(), part.data(), part.size());
    if (size > 0) bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    return bytes.size() >= count;
  });
  return bytes;
}

std::string error_of(const std::string& path, const LineSettings& settings = {}) {
  EventLoop loop;
  SerialLine line{loop, settings};
  try {
    const SerialDeviceEndpoint endpoint{line, path};
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(SerialDeviceEndpoint, EveryByteValuePassesUnchangedBothWays) {
  const Wire wire;
  Bench bench{kIdeal, wire.path};
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  wire.write(bytes);
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() >= 256; }));
  EXPECT_EQ(bench.heard, bytes);
  bench.say(bytes);
  EXPECT_EQ(read_bytes(bench, wire, 256), bytes);
}

TEST(SerialDeviceEndpoint, ThePortIsSetAsTheLineIsAndGetsItsOwnSettingsBack) {
  const Wire wire;
  termios before = wire.settings();
  before.c_lflag |= ICANON | ECHO;
  cfsetspeed(&before, B4800);
  ASSERT_EQ(tcsetattr(wire.keeper.get(), TCSANOW, &before), 0);
  {
    const Bench bench{{.baud = 57600, .stop_bits = 2}, wire.path};
    const termios during = wire.settings();
    EXPECT_EQ(cfgetospeed(&during), B57600);
    EXPECT_NE(during.c_cflag & CSTOPB, 0U);
    EXPECT_EQ(during.c_lflag & (ICANON | ECHO | ISIG), 0U);
  }
  const termios after = wire.settings();
  EXPECT_EQ(cfgetospeed(&after), B4800);
  EXPECT_EQ(after.c_lflag, before.c_lflag);
  EXPECT_EQ(after.c_iflag, before.c_iflag);
  EXPECT_EQ(after.c_cflag, before.c_cflag);
}

TEST(SerialDeviceEndpoint, FollowsTheDrivesNewBaudRate) {
  const Wire wire;
  Bench bench{kIdeal, wire.path};
  bench.line.device(0).set_baud(9600);
  bench.say({1});
  EXPECT_EQ(read_bytes(bench, wire, 1), Bytes{1});
  const termios now = wire.settings();
  EXPECT_EQ(cfgetospeed(&now), B9600);
}

TEST(SerialDeviceEndpoint, HasThePortForItselfAndLeavesItOpenToOthersAfterwards) {
  const Wire wire;
  int exclusive = 0;
  {
    const Bench bench{kIdeal, wire.path};
    ASSERT_EQ(ioctl(wire.keeper.get(), TIOCGEXCL, &exclusive), 0);
    EXPECT_NE(exclusive, 0);
    EXPECT_EQ(error_of(wire.path), "cannot use the serial port '" + wire.path +
                                       "': another program has it; close that one");
    ASSERT_EQ(ioctl(wire.keeper.get(), TIOCGEXCL, &exclusive), 0);
    EXPECT_NE(exclusive, 0);  // who was turned away did not open it to others
  }
  ASSERT_EQ(ioctl(wire.keeper.get(), TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 0);
  EXPECT_EQ(error_of(wire.path), "");
}

TEST(SerialDeviceEndpoint, SaysWhatIsWrongWithAPort) {
  EXPECT_NE(error_of("/nowhere/ttyUSB0").find("is the adapter plugged in?"), std::string::npos);
  EXPECT_NE(error_of("/dev/null").find("not a serial port"), std::string::npos);
}

TEST(SerialDeviceEndpoint, SaysThatAPortCannotBeSetAsTheDriveNeedsIt) {
  const Wire wire;  // a pseudo-terminal has no parity
  const termios before = wire.settings();
  EXPECT_EQ(error_of(wire.path, {.baud = 9600, .parity = Parity::kEven}),
            "cannot use the serial port '" + wire.path +
                "': the drive needs 9600 baud 8E1, and the port offers 9600 baud 8N1; take another "
                "adapter");
  const termios after = wire.settings();
  EXPECT_EQ(cfgetospeed(&after), cfgetospeed(&before));  // as it was found
}

TEST(SerialDeviceEndpoint, SaysThatThePortWasUnplugged) {
  Wire wire;
  Bench bench{kIdeal, wire.path};
  EXPECT_TRUE(bench.endpoint.alive());
  wire.unplug();
  ASSERT_TRUE(bench.ready(5000));
  try {
    bench.endpoint.readable();
    FAIL() << "nothing was said";
  } catch (const SetupError& error) {
    EXPECT_EQ(error.what(), "the serial port '" + wire.path +
                                "' is gone; plug the adapter in again and start anew");
  }
  EXPECT_FALSE(bench.endpoint.alive());
  EXPECT_FALSE(bench.ready());
  bench.say({1});  // harms nobody
}

TEST(SerialDeviceEndpoint, WhatThePortDoesNotTakeIsLostAndHoldsNothingUp) {
  const Wire wire;
  Bench bench{kIdeal, wire.path};
  constexpr std::size_t kSent = 200'000;
  const Bytes block(1000, 0x55);
  for (std::size_t sent = 0; sent < kSent; sent += block.size()) bench.say(block);
  const std::uint64_t overrun = bench.endpoint.counters().overrun;
  EXPECT_GT(overrun, kSent / 2);
  EXPECT_EQ(read_bytes(bench, wire, kSent - overrun).size(), kSent - overrun);
  bench.say({0xA5});
  EXPECT_EQ(read_bytes(bench, wire, 1), Bytes{0xA5});
}

TEST(SerialDeviceEndpoint, BytesArriveSpacedByTheLineAndMoreWaitInThePort) {
  const Wire wire;
  Bench bench{{.baud = 115200}, wire.path};
  Bytes bytes(20'000);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  std::size_t written = 0;
  std::size_t backlog = 0;
  ASSERT_TRUE(bench.pump(
      [&] {
        const ssize_t size =
            ::write(wire.far_end.get(), bytes.data() + written, bytes.size() - written);
        if (size > 0) written += static_cast<std::size_t>(size);
        backlog = std::max(backlog, bench.line.host_backlog());
        return bench.heard.size() == bytes.size();
      },
      5ms));
  EXPECT_EQ(bench.heard, bytes);
  EXPECT_LE(backlog, SerialDeviceEndpoint::kMaxBacklog);
}

}  // namespace
}  // namespace virtdrive
