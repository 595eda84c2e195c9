#include "pty/pty_endpoint.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <gtest/gtest.h>
#include <iterator>
#include <numeric>
#include <sys/ioctl.h>
#include <termios.h>

#include "pty/host_port.h"
#include "tests/pty/pumped_endpoint.h"
#include "tests/pty/temporary_folder.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

// Interrupt, XON, XOFF, line feed, carriage return, zero, all ones, end of file: what a terminal
// that is not raw would swallow, translate or act on.
const Bytes kDelicate = {0x03, 0x11, 0x13, 0x0A, 0x0D, 0x00, 0xFF, 0x04, 0x1A, 0x1C, 0x7F, 0x80};

/// A host that opens and sets nothing, as `cat` and `socat` do.
FileDescriptor open_host(const PumpedEndpoint& bench) {
  return FileDescriptor{
      ::open(bench.endpoint.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
}

void write_all(const FileDescriptor& host, const Bytes& bytes) {
  ASSERT_EQ(::write(host.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
}

Bytes read_some(const FileDescriptor& host) {
  Bytes bytes(65536);
  const ssize_t size = ::read(host.get(), bytes.data(), bytes.size());
  bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return bytes;
}

/// Reads until `count` bytes have come or the deadline is over.
Bytes read_bytes(PumpedEndpoint& bench, const FileDescriptor& host, std::size_t count) {
  Bytes bytes;
  bench.pump([&] {
    const Bytes part = read_some(host);
    bytes.insert(bytes.end(), part.begin(), part.end());
    return bytes.size() >= count;
  });
  return bytes;
}

bool attach(PumpedEndpoint& bench) {
  return bench.pump([&] { return bench.endpoint.attached(); });
}

bool detach(PumpedEndpoint& bench) {
  return bench.pump([&] { return !bench.endpoint.attached(); });
}

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all{"/proc/self/fd"};
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

termios settings_of(const FileDescriptor& host) {
  termios settings{};
  EXPECT_EQ(tcgetattr(host.get(), &settings), 0);
  return settings;
}

/// What pyserial does for parity='E': as cfmakeraw, with PARENB, CLOCAL and CREAD.
int ask_for_even_parity(const FileDescriptor& host, speed_t baud) {
  termios settings = settings_of(host);
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD | PARENB;
  settings.c_cc[VMIN] = 0;
  cfsetspeed(&settings, baud);
  return tcsetattr(host.get(), TCSANOW, &settings);
}

TEST(PtyEndpoint, EveryByteFromAHostPassesUnchangedAndIsNotEchoed) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  bytes.insert(bytes.end(), kDelicate.begin(), kDelicate.end());
  write_all(host, bytes);
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() >= bytes.size(); }));
  EXPECT_EQ(bench.heard, bytes);
  bench.say({0x5A});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{0x5A});  // nothing else came before it
}

TEST(PtyEndpoint, EveryByteFromTheDevicePassesUnchangedAndDoesNotComeBack) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  bytes.insert(bytes.end(), kDelicate.begin(), kDelicate.end());
  bench.say(bytes);
  EXPECT_EQ(read_bytes(bench, host, bytes.size()), bytes);
  write_all(host, {0x5A});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  EXPECT_EQ(bench.heard, Bytes{0x5A});
}

TEST(PtyEndpoint, ATerminalIsRawAndHasTheLinesBaudRateBeforeAnybodyComes) {
  const PumpedEndpoint bench{{.baud = 19200, .stop_bits = 2}};
  const FileDescriptor host = open_host(bench);
  const termios settings = settings_of(host);
  EXPECT_EQ(cfgetospeed(&settings), B19200);
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG | IEXTEN), 0U);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | ICRNL | INLCR | ISTRIP), 0U);
  EXPECT_EQ(settings.c_oflag & OPOST, 0U);
  EXPECT_NE(settings.c_cflag & CSTOPB, 0U);
  EXPECT_EQ(settings.c_cc[VMIN], 1);
}

TEST(PtyEndpoint, HostsComeAndGoTwoHundredTimesAndNothingIsLostOrLeaked) {
  PumpedEndpoint bench;
  const std::size_t descriptors = open_descriptors();
  for (int round = 0; round < 200; ++round) {
    const auto byte = static_cast<std::uint8_t>(round);
    {
      const FileDescriptor host = open_host(bench);
      write_all(host, {byte, byte});
      ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 2; })) << round;
      ASSERT_EQ(bench.heard, (Bytes{byte, byte}));
      bench.say({byte});
      ASSERT_EQ(read_bytes(bench, host, 1), Bytes{byte}) << round;
    }
    bench.heard.clear();
    ASSERT_TRUE(round % 2 != 0 || detach(bench)) << round;  // or the next comes at once
  }
  ASSERT_TRUE(detach(bench));
  EXPECT_EQ(open_descriptors(), descriptors);
  EXPECT_EQ(bench.endpoint.counters().attached, 200U);
  EXPECT_EQ(bench.endpoint.counters().unheard, 0U);
}

TEST(PtyEndpoint, AHostThatOnlyWritesAndClosesAtOnceIsHeard) {
  PumpedEndpoint bench;
  for (int round = 0; round < 20; ++round) {
    write_all(open_host(bench), kDelicate);  // echo ... > /dev/pts/N
  }
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 20 * kDelicate.size(); }));
  ASSERT_TRUE(detach(bench));
}

TEST(PtyEndpoint, WhatAHostLeftUnreadIsNotSeenByTheNext) {
  PumpedEndpoint bench;
  {
    const FileDescriptor first = open_host(bench);
    ASSERT_TRUE(attach(bench));
    bench.say({1, 2, 3});
    ASSERT_TRUE(PumpedEndpoint::readable(first.get()));
  }
  ASSERT_TRUE(detach(bench));
  const FileDescriptor second = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, second, 1), Bytes{4});
}

TEST(PtyEndpoint, WhatAHostLeftUnreadIsNotSeenByOneThatOpensFasterThanWeLook) {
  PumpedEndpoint bench;
  FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({1, 2, 3});
  ASSERT_TRUE(PumpedEndpoint::readable(host.get()));
  host.reset();
  host = open_host(bench);
  ASSERT_TRUE(bench.pump([&] { return bench.endpoint.counters().attached == 2; }));
  EXPECT_TRUE(bench.endpoint.attached());
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{4});
}

TEST(PtyEndpoint, WhatTheDeviceSaysWhileNobodyIsThereIsCountedAndGone) {
  PumpedEndpoint bench;
  bench.say({1, 2, 3});
  EXPECT_EQ(bench.endpoint.counters().unheard, 3U);
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{4});
}

TEST(PtyEndpoint, ASecondProgramDoesNotTakeTheFirstOnesReply) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({1, 2, 3});
  open_host(bench).reset();  // stty -F: opens and closes beside the first
  ASSERT_TRUE(PumpedEndpoint::readable(bench.endpoint.fd()));
  bench.endpoint.readable();
  bench.say({4});
  EXPECT_TRUE(bench.endpoint.attached());
  EXPECT_EQ(read_bytes(bench, host, 4), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(bench.endpoint.counters().attached, 1U);
}

TEST(PtyEndpoint, TheFirstOfTwoHostsThatCameTogetherMayGo) {
  PumpedEndpoint bench;
  FileDescriptor first = open_host(bench);
  FileDescriptor second = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({1, 2, 3});
  first.reset();
  ASSERT_TRUE(PumpedEndpoint::readable(bench.endpoint.fd()));
  bench.endpoint.readable();
  EXPECT_TRUE(bench.endpoint.attached());
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, second, 4), (Bytes{1, 2, 3, 4}));
  second.reset();
  EXPECT_TRUE(detach(bench));
}

TEST(PtyEndpoint, AHostThatWantsEvenParityConnectsAgainAndAgain) {
  PumpedEndpoint bench{{.baud = 9600, .parity = Parity::kEven}};
  for (int round = 0; round < 5; ++round) {
    FileDescriptor host = open_host(bench);
    ASSERT_EQ(ask_for_even_parity(host, B9600), 0) << round << " " << strerror(errno);
    ASSERT_TRUE(attach(bench));
    host.reset();
    ASSERT_TRUE(detach(bench));
  }
}

TEST(PtyEndpoint, AHostThatWantsEvenParityMayReopenAndReconfigureFasterThanWeLook) {
  PumpedEndpoint bench{{.timing = LineTiming::kIdeal, .baud = 9600, .parity = Parity::kEven}};
  for (int round = 0; round < 5; ++round) {
    const FileDescriptor host = open_host(bench);
    ASSERT_EQ(ask_for_even_parity(host, B9600), 0) << round << " " << strerror(errno);
    write_all(host, {1});
    ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
    ASSERT_EQ(ask_for_even_parity(host, B9600), 0) << round << " " << strerror(errno);
    write_all(host, {1});
    ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 2; }));
    bench.heard.clear();
  }
}

TEST(PtyEndpoint, SettingsGoBackToTheLinesOwnWhenTheLastHostHasGone) {
  PumpedEndpoint bench{{.baud = 115200}};
  {
    const FileDescriptor host = open_host(bench);
    termios settings = settings_of(host);
    settings.c_lflag |= ICANON | ECHO;
    settings.c_iflag |= IXON | ICRNL;
    cfsetspeed(&settings, B9600);
    ASSERT_EQ(tcsetattr(host.get(), TCSANOW, &settings), 0);
    ASSERT_TRUE(attach(bench));
  }
  ASSERT_TRUE(detach(bench));
  const FileDescriptor next = open_host(bench);
  const termios settings = settings_of(next);
  EXPECT_EQ(cfgetospeed(&settings), B115200);
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO), 0U);
  EXPECT_EQ(settings.c_iflag & (IXON | ICRNL), 0U);
}

TEST(PtyEndpoint, SettingsStayWhileASecondProgramLooksIn) {
  PumpedEndpoint bench{{.baud = 115200}};
  const FileDescriptor host = open_host(bench);
  termios settings = settings_of(host);
  cfsetspeed(&settings, B9600);
  ASSERT_EQ(tcsetattr(host.get(), TCSANOW, &settings), 0);
  ASSERT_TRUE(attach(bench));
  open_host(bench).reset();
  ASSERT_TRUE(PumpedEndpoint::readable(bench.endpoint.fd()));
  bench.endpoint.readable();
  settings = settings_of(host);
  EXPECT_EQ(cfgetospeed(&settings), B9600);
}

TEST(PtyEndpoint, AHostThatLeftItsLockOnDoesNotLockOutTheNext) {
  PumpedEndpoint bench;
  {
    const FileDescriptor host = open_host(bench);
    ASSERT_EQ(ioctl(host.get(), TIOCEXCL), 0);
    ASSERT_TRUE(attach(bench));
  }
  ASSERT_TRUE(detach(bench));
  // Root gets in anyway, so the flag itself is looked at.
  const FileDescriptor next = open_host(bench);
  int exclusive = 1;
  ASSERT_EQ(ioctl(next.get(), TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 0);
}

TEST(PtyEndpoint, AHostKeepsItsLockWhileItIsThere) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  FileDescriptor duplicate = open_host(bench);
  ASSERT_EQ(ioctl(host.get(), TIOCEXCL), 0);
  ASSERT_TRUE(attach(bench));
  duplicate.reset();
  ASSERT_TRUE(PumpedEndpoint::readable(bench.endpoint.fd()));
  bench.endpoint.readable();
  int exclusive = 0;
  ASSERT_EQ(ioctl(host.get(), TIOCGEXCL, &exclusive), 0);
  EXPECT_NE(exclusive, 0);
}

TEST(PtyEndpoint, SeesTheHostsBaudRateAlsoACustomOne) {
  for (const int baud : {115200, 9600, 250000, 1'250'000}) {
    PumpedEndpoint bench;
    HostPort host{bench.endpoint.path(), baud};
    host.write(Bytes{1});
    ASSERT_TRUE(bench.pump([&] { return bench.line.host().baud == baud; })) << baud;
  }
}

TEST(PtyEndpoint, SeesTheHostsStopBitsAndAChangeOfSettings) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  termios settings = settings_of(host);
  settings.c_cflag |= CSTOPB;
  cfsetspeed(&settings, B57600);
  ASSERT_EQ(tcsetattr(host.get(), TCSANOW, &settings), 0);
  write_all(host, {1});
  EXPECT_TRUE(bench.pump([&] { return bench.line.host() == HostSettings{57600, 2}; }));
  settings.c_cflag &= ~CSTOPB;
  cfsetspeed(&settings, B115200);
  ASSERT_EQ(tcsetattr(host.get(), TCSANOW, &settings), 0);
  write_all(host, {1});
  EXPECT_TRUE(bench.pump([&] { return bench.line.host() == HostSettings{115200, 1}; }));
}

TEST(PtyEndpoint, AHostAtTheWrongBaudRateGetsGarbageAndNoService) {
  PumpedEndpoint bench{{.timing = LineTiming::kIdeal, .baud = 19200}};
  HostPort host{bench.endpoint.path(), 9600};
  host.write(Bytes{0x55});
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 2; }));
  EXPECT_EQ(bench.heard, (Bytes{0x66, 0xE6}));
}

TEST(PtyEndpoint, AHostThatDoesNotFollowADrivesNewBaudRateGetsGarbage) {
  PumpedEndpoint bench{{.timing = LineTiming::kIdeal, .baud = 9600}};
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.line.device(0).set_baud(19200);
  write_all(host, {0x55});
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 2; }));
  EXPECT_EQ(bench.heard, (Bytes{0x66, 0xE6}));
}

TEST(PtyEndpoint, TheTerminalFollowsADrivesNewBaudRateWhileNobodyIsThere) {
  PumpedEndpoint bench{{.baud = 9600}};
  bench.line.device(0).set_baud(250000);
  bench.endpoint.flush();
  EXPECT_EQ(bench.line.host().baud, 250000);
  bench.line.device(0).set_baud(57600);
  bench.endpoint.flush();
  const FileDescriptor host = open_host(bench);
  const termios settings = settings_of(host);
  EXPECT_EQ(cfgetospeed(&settings), B57600);
}

TEST(PtyEndpoint, AHostThatNeverReadsLosesBytesAndHoldsNothingUp) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  constexpr std::size_t kSent = 200'000;
  const Bytes block(1000, 0x55);
  for (std::size_t sent = 0; sent < kSent; sent += block.size()) bench.say(block);
  const std::uint64_t overrun = bench.endpoint.counters().overrun;
  EXPECT_GT(overrun, kSent - 70'000);  // the kernel's queue and ours are bounded
  const Bytes rest = read_bytes(bench, host, kSent - overrun);
  EXPECT_EQ(rest.size(), kSent - overrun);
  bench.say({0xA5});  // it reads again: it is served
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{0xA5});
  EXPECT_EQ(bench.endpoint.counters().overrun, overrun);
}

TEST(PtyEndpoint, IsReadyAgainWhenAHostThatDidNotReadBegins) {
  PumpedEndpoint bench;
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  for (int i = 0; i < 100; ++i) bench.say(Bytes(1000, 0x55));
  ASSERT_TRUE(bench.pump([&] { return !bench.ready(); }));
  const std::uint64_t overrun = bench.endpoint.counters().overrun;
  std::size_t read = 0;
  bool ready = false;
  for (int look = 0; look < 1000 && !ready; ++look) {
    read += read_some(host).size();
    if (bench.ready(10)) bench.endpoint.readable();  // another program's terminal wakes us too
    ready = bench.ready();
  }
  EXPECT_TRUE(ready);
  EXPECT_LE(read, 100'000 - overrun - PtyEndpoint::kMaxPending);  // what the kernel held
}

TEST(PtyEndpoint, IsNotReadyWhileEnoughOfTheHostsBytesWaitToLeave) {
  PumpedEndpoint bench{{.baud = 115200}};
  const FileDescriptor host = open_host(bench);
  const Bytes bytes(PtyEndpoint::kMaxBacklog, 0x55);
  std::size_t written = 0;
  ASSERT_TRUE(bench.pump([&] {
    const ssize_t size = ::write(host.get(), bytes.data(), bytes.size());
    if (size > 0) written += static_cast<std::size_t>(size);
    return written > PtyEndpoint::kMaxBacklog &&
           bench.line.host_backlog() == PtyEndpoint::kMaxBacklog;
  }));
  ASSERT_TRUE(bench.pump([&] { return !bench.ready(); }));
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == written; }, 5ms));
}

TEST(PtyEndpoint, AHostThatClosesInTheMiddleOfAReplyHarmsNobody) {
  PumpedEndpoint bench{{.baud = 9600}};
  FileDescriptor host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.line.device(0).send(Bytes{1, 2, 3, 4, 5, 6});
  bench.loop.run_until(bench.loop.now() + bench.line.settings().time_of(3));
  bench.endpoint.flush();
  host.reset();
  ASSERT_TRUE(detach(bench));
  bench.loop.run_until(bench.loop.now() + 1s);
  bench.endpoint.flush();
  EXPECT_EQ(bench.endpoint.counters().unheard, 3U);
  host = open_host(bench);
  ASSERT_TRUE(attach(bench));
  bench.say({7});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{7});
}

TEST(PtyEndpoint, AHostThatWritesFasterThanTheLineWaitsAndLosesNothing) {
  PumpedEndpoint bench{{.baud = 115200}};
  const FileDescriptor host = open_host(bench);
  Bytes bytes(100'000);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  std::size_t written = 0;
  std::size_t backlog = 0;
  const auto write_on = [&] {
    const ssize_t size = ::write(host.get(), bytes.data() + written, bytes.size() - written);
    if (size > 0) written += static_cast<std::size_t>(size);
    backlog = std::max(backlog, bench.line.host_backlog());
    return bench.heard.size() == bytes.size();
  };
  ASSERT_TRUE(bench.pump(write_on, 5ms));
  EXPECT_EQ(bench.heard, bytes);
  EXPECT_LE(backlog, PtyEndpoint::kMaxBacklog);
  EXPECT_EQ(bench.line.counters().to_device_lost, 0U);
}

TEST(PtyEndpoint, AStableNameLeadsToTheTerminal) {
  const TemporaryFolder folder;
  EventLoop loop;
  SerialLine line{loop, {}};
  {
    const PtyEndpoint endpoint{line, folder / "drive"};
    EXPECT_EQ(endpoint.path(), folder / "drive");
    EXPECT_EQ(std::filesystem::read_symlink(endpoint.path()), endpoint.terminal());
    EXPECT_NO_THROW(HostPort(endpoint.path(), 115200));
  }
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "drive"));
}

}  // namespace
}  // namespace virtdrive
