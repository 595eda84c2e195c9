#include "pty/tcp_endpoint.h"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <gtest/gtest.h>
#include <iterator>
#include <netinet/in.h>
#include <numeric>
#include <random>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <utility>

#include "core/check.h"
#include "pty/runner.h"
#include "tests/pty/pumped_endpoint.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr LineSettings kIdeal{.timing = LineTiming::kIdeal};
const std::string kAnyPort = "0";

// RFC 854 and RFC 2217.
constexpr std::uint8_t kSe = 240;
constexpr std::uint8_t kSb = 250;
constexpr std::uint8_t kWill = 251;
constexpr std::uint8_t kWont = 252;
constexpr std::uint8_t kDo = 253;
constexpr std::uint8_t kDont = 254;
constexpr std::uint8_t kIac = 255;
constexpr std::uint8_t kComPort = 44;

const Bytes kOffers = {kIac, kWill, 0, kIac, kDo, 0, kIac, kWill, 3, kIac, kDo, 3};

Bytes all_values() {
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

/// A COM-PORT subnegotiation; `value` as it stands on the wire.
Bytes com_port(std::uint8_t code, const Bytes& value) {
  Bytes bytes = {kIac, kSb, kComPort, code};
  bytes.insert(bytes.end(), value.begin(), value.end());
  bytes.insert(bytes.end(), {kIac, kSe});
  return bytes;
}

struct Bench final : Pumped<TcpEndpoint> {
  explicit Bench(TcpMode mode, const LineSettings& settings = kIdeal)
      : Pumped(settings, kAnyPort, mode) {}

  void receive(std::uint8_t byte) override {
    Pumped::receive(byte);
    if (echoes) line.device(0).send(std::span(&byte, 1));
  }

  std::uint16_t port() const {
    return static_cast<std::uint16_t>(
        std::stoi(endpoint.address().substr(endpoint.address().rfind(':') + 1)));
  }

  bool echoes = false;  // the device sends back what it hears
};

FileDescriptor connect_to(const Bench& bench, int receive_buffer = 0) {
  FileDescriptor host{socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  if (receive_buffer != 0) {
    setsockopt(host.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(bench.port());
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(host.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return host;
}

FileDescriptor attach(Bench& bench, int receive_buffer = 0) {
  const std::uint64_t before = bench.endpoint.counters().attached;
  FileDescriptor host = connect_to(bench, receive_buffer);
  EXPECT_TRUE(bench.pump([&] { return bench.endpoint.counters().attached == before + 1; }));
  return host;
}

void send_all(const FileDescriptor& host, const Bytes& bytes) {
  ASSERT_EQ(send(host.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(bytes.size()));
}

/// Reads until `count` bytes have come or the deadline is over.
Bytes read_bytes(Bench& bench, const FileDescriptor& host, std::size_t count) {
  Bytes bytes;
  bench.pump([&] {
    Bytes part(65536);
    const ssize_t size = recv(host.get(), part.data(), part.size(), MSG_DONTWAIT);
    if (size > 0) bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    return bytes.size() >= count;
  });
  return bytes;
}

/// The other end has closed the connection.
bool closed(Bench& bench, const FileDescriptor& host) {
  return bench.pump([&] {
    std::uint8_t byte = 0;
    const ssize_t size = recv(host.get(), &byte, 1, MSG_DONTWAIT);
    return size == 0 || (size < 0 && errno != EAGAIN);
  });
}

/// A client closes so that the other end sees a reset.
void reset_connection(FileDescriptor& host) {
  const linger at_once{1, 0};
  setsockopt(host.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  host.reset();
}

std::string error_of(const std::string& address) {
  EventLoop loop;
  SerialLine line{loop, {}};
  try {
    const TcpEndpoint endpoint{line, address, TcpMode::kRaw};
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(TcpEndpoint, EveryByteValuePassesUnchangedBothWays) {
  Bench bench{TcpMode::kRaw};
  const FileDescriptor host = attach(bench);
  send_all(host, all_values());
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() >= 256; }));
  EXPECT_EQ(bench.heard, all_values());
  bench.say(all_values());
  EXPECT_EQ(read_bytes(bench, host, 256), all_values());
}

TEST(TcpEndpoint, ListensOnTheLoopbackInterfaceUnlessToldOtherwise) {
  EventLoop loop;
  SerialLine line{loop, {}};
  for (const char* address : {"0", ":0", "127.0.0.1:0"}) {
    const TcpEndpoint endpoint{line, address, TcpMode::kRaw};
    EXPECT_TRUE(endpoint.address().starts_with("127.0.0.1:")) << endpoint.address();
    EXPECT_FALSE(endpoint.address().ends_with(":0"));
  }
  const TcpEndpoint everywhere{line, "0.0.0.0:0", TcpMode::kRaw};
  EXPECT_TRUE(everywhere.address().starts_with("0.0.0.0:"));
}

TEST(TcpEndpoint, TakesAnIpv6AddressInBrackets) {
  const FileDescriptor probe{socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  sockaddr_in6 loopback{};
  loopback.sin6_family = AF_INET6;
  loopback.sin6_addr = in6addr_loopback;
  if (!probe || bind(probe.get(), reinterpret_cast<sockaddr*>(&loopback), sizeof loopback) != 0) {
    GTEST_SKIP() << "no IPv6 here";
  }
  EventLoop loop;
  SerialLine line{loop, {}};
  const TcpEndpoint endpoint{line, "[::1]:0", TcpMode::kRaw};
  EXPECT_TRUE(endpoint.address().starts_with("[::1]:")) << endpoint.address();
}

TEST(TcpEndpoint, SaysWhatIsWrongWithAnAddress) {
  for (const char* address : {"", "x", "127.0.0.1", "127.0.0.1:", "127.0.0.1:70000", "::1:0",
                              "127.0.0.1:-1", "127.0.0.1:1x"}) {
    EXPECT_NE(error_of(address).find("expected HOST:PORT"), std::string::npos) << address;
  }
  // TEST-NET-1 of RFC 5737: nobody's.
  EXPECT_NE(error_of("192.0.2.1:0").find("no such address"), std::string::npos);
}

TEST(TcpEndpoint, SaysThatAPortIsInUse) {
  const Bench bench{TcpMode::kRaw};
  EXPECT_EQ(error_of(bench.endpoint.address()),
            "cannot listen at '" + bench.endpoint.address() +
                "': another program has this port; stop it, choose another port, or 0 for any "
                "free one");
}

TEST(TcpEndpoint, ListensAtTheSamePortAgainAtOnce) {
  EventLoop loop;
  SerialLine line{loop, {}};
  std::string address;
  {
    Bench bench{TcpMode::kRaw};
    address = bench.endpoint.address();
    const FileDescriptor host = attach(bench);
  }
  EXPECT_EQ(error_of(address), "");
}

TEST(TcpEndpoint, ASecondClientIsRefusedAndTheFirstStaysServed) {
  Bench bench{TcpMode::kRaw};
  const FileDescriptor first = attach(bench);
  const FileDescriptor second = connect_to(bench);
  EXPECT_TRUE(closed(bench, second));
  EXPECT_EQ(bench.endpoint.counters().refused, 1U);
  send_all(first, {1});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  bench.say({2});
  EXPECT_EQ(read_bytes(bench, first, 1), Bytes{2});
}

TEST(TcpEndpoint, ClientsComeAndGoTwoHundredTimes) {
  Bench bench{TcpMode::kRaw};
  const auto descriptors = [] {
    const std::filesystem::directory_iterator all{"/proc/self/fd"};
    return std::distance(begin(all), end(all));
  };
  {
    attach(bench);
  }
  ASSERT_TRUE(bench.pump([&] { return !bench.endpoint.attached(); }));
  const auto before = descriptors();
  for (int round = 0; round < 200; ++round) {
    const auto byte = static_cast<std::uint8_t>(round);
    FileDescriptor host = attach(bench);
    send_all(host, {byte});
    ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); })) << round;
    EXPECT_EQ(bench.heard, Bytes{byte});
    bench.heard.clear();
    bench.say({byte});
    if (round % 2 == 0) {
      ASSERT_EQ(read_bytes(bench, host, 1), Bytes{byte}) << round;
    } else {
      reset_connection(host);
    }
    host.reset();
    ASSERT_TRUE(bench.pump([&] { return !bench.endpoint.attached(); })) << round;
  }
  EXPECT_LE(descriptors(), before);
  EXPECT_EQ(bench.endpoint.counters().refused, 0U);
}

TEST(TcpEndpoint, AClientThatWritesAndClosesAtOnceIsHeard) {
  Bench bench{TcpMode::kRaw};
  for (std::size_t round = 1; round <= 20; ++round) {
    send_all(connect_to(bench), all_values());
    ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == round * 256; })) << round;
  }
}

TEST(TcpEndpoint, AHalfClosedClientStillHearsTheDriveAndTheNextTakesItsPlace) {
  Bench bench{TcpMode::kRaw};
  const FileDescriptor first = attach(bench);
  send_all(first, {1});
  shutdown(first.get(), SHUT_WR);
  ASSERT_TRUE(bench.pump([&] { return !bench.endpoint.attached(); }));
  EXPECT_FALSE(bench.ready());  // it does not wake the runner for ever
  bench.say({2});
  EXPECT_EQ(read_bytes(bench, first, 1), Bytes{2});
  const FileDescriptor second = attach(bench);
  EXPECT_TRUE(closed(bench, first));
  bench.say({3});
  EXPECT_EQ(read_bytes(bench, second, 1), Bytes{3});
  EXPECT_EQ(bench.endpoint.counters().refused, 0U);
}

TEST(TcpEndpoint, WhatTheDeviceSaysWhileNobodyIsThereIsCountedAndGone) {
  Bench bench{TcpMode::kRaw};
  bench.say({1, 2, 3});
  EXPECT_EQ(bench.endpoint.counters().unheard, 3U);
  const FileDescriptor host = attach(bench);
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{4});
}

TEST(TcpEndpoint, AClientThatNeverReadsLosesBytesAndHoldsNothingUp) {
  Bench bench{TcpMode::kRaw};
  const FileDescriptor host = attach(bench, 4096);
  constexpr std::size_t kSent = 1'000'000;
  const Bytes block(1000, 0x55);
  for (std::size_t sent = 0; sent < kSent; sent += block.size()) bench.say(block);
  const std::uint64_t overrun = bench.endpoint.counters().overrun;
  EXPECT_GT(overrun, kSent / 2);
  EXPECT_EQ(read_bytes(bench, host, kSent - overrun).size(), kSent - overrun);
  bench.say({0xA5});  // it reads again: it is served
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{0xA5});
}

TEST(TcpEndpoint, AClientThatWritesFasterThanTheLineWaitsAndLosesNothing) {
  Bench bench{TcpMode::kRaw, {.baud = 115200}};
  const FileDescriptor host = attach(bench);
  Bytes bytes(100'000);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  std::size_t written = 0;
  std::size_t backlog = 0;
  ASSERT_TRUE(bench.pump(
      [&] {
        const ssize_t size =
            send(host.get(), bytes.data() + written, bytes.size() - written, MSG_DONTWAIT);
        if (size > 0) written += static_cast<std::size_t>(size);
        backlog = std::max(backlog, bench.line.host_backlog());
        return bench.heard.size() == bytes.size();
      },
      5ms));
  EXPECT_EQ(bench.heard, bytes);
  EXPECT_LE(backlog, TcpEndpoint::kMaxBacklog);
}

TEST(TcpEndpoint, ARunnerServesOneClientAfterTheOther) {
  Bench bench{TcpMode::kRaw};
  bench.echoes = true;
  Runner runner{bench.loop, {.until = kSimStart + 30s}};
  runner.add(bench.endpoint);
  int exchanged = 0;
  std::thread host_thread([&] {
    const timeval patience{10, 0};
    for (int round = 0; round < 20; ++round) {
      const FileDescriptor host = connect_to(bench);
      setsockopt(host.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
      send_all(host, {0x5A});
      std::uint8_t byte = 0;
      if (recv(host.get(), &byte, 1, 0) == 1 && byte == 0x5A) ++exchanged;
    }
    runner.request_stop();
  });
  runner.run();
  host_thread.join();
  EXPECT_EQ(exchanged, 20);
  EXPECT_EQ(bench.endpoint.counters().refused, 0U);
}

TEST(Rfc2217, ANegotiationByteForByte) {
  Bench bench{TcpMode::kRfc2217, {.timing = LineTiming::kIdeal, .baud = 57600}};
  const FileDescriptor host = attach(bench);
  const struct {
    Bytes sent;
    Bytes answered;
  } kTranscript[] = {
      {{}, kOffers},
      {{kIac, kDo, 0, kIac, kWill, 0, kIac, kDo, 3, kIac, kWill, 3}, {}},  // it takes the offers
      {{kIac, kDo, 1, kIac, kWill, 31}, {kIac, kWont, 1, kIac, kDont, 31}},
      {{kIac, kWill, kComPort}, {kIac, kDo, kComPort, kIac, kSb, kComPort, 107, 0xB0, kIac, kSe}},
      {{kIac, kDo, kComPort}, {kIac, kWill, kComPort}},
      {{kIac, kDo, kComPort, kIac, kWill, kComPort}, {}},  // nothing new
      {com_port(0, {}), com_port(100, {'v', 'i', 'r', 't', 'd', 'r', 'i', 'v', 'e'})},
      {com_port(1, {0, 0, 0, 0}), com_port(101, {0, 0, 0xE1, 0})},           // what is it?
      {com_port(1, {0, 0, 0x25, 0x80}), com_port(101, {0, 0, 0x25, 0x80})},  // 9600
      {com_port(1, {0, 0, 0xE0, kIac, kIac}), com_port(101, {0, 0, 0xE0, kIac, kIac})},
      {com_port(1, {0x7E, 0, 0, 0}), com_port(101, {0, 0, 0xE0, kIac, kIac})},  // too fast
      {com_port(2, {0}), com_port(102, {8})},
      {com_port(2, {7}), com_port(102, {7})},
      {com_port(2, {9}), com_port(102, {7})},
      {com_port(3, {0}), com_port(103, {1})},
      {com_port(3, {3}), com_port(103, {3})},
      {com_port(3, {2}), com_port(103, {2})},
      {com_port(3, {4}), com_port(103, {2})},  // no mark parity
      {com_port(4, {0}), com_port(104, {1})},
      {com_port(4, {2}), com_port(104, {2})},
      {com_port(4, {3}), com_port(104, {2})},  // no one and a half
      {com_port(5, {0}), com_port(105, {1})},
      {com_port(5, {1}), com_port(105, {1})},
      {com_port(5, {3}), com_port(105, {1})},  // no hardware flow control
      {com_port(5, {13}), com_port(105, {14})},
      {com_port(5, {15}), com_port(105, {14})},
      {com_port(5, {4}), com_port(105, {6})},
      {com_port(5, {5}), com_port(105, {5})},
      {com_port(5, {4}), com_port(105, {5})},
      {com_port(5, {6}), com_port(105, {6})},
      {com_port(5, {7}), com_port(105, {8})},
      {com_port(5, {9}), com_port(105, {9})},
      {com_port(5, {7}), com_port(105, {9})},
      {com_port(5, {11}), com_port(105, {11})},
      {com_port(5, {12}), com_port(105, {12})},
      {com_port(5, {10}), com_port(105, {12})},
      {com_port(6, {}), com_port(106, {0x60})},
      {com_port(10, {kIac, kIac}), com_port(110, {kIac, kIac})},
      {com_port(11, {0x10}), com_port(111, {0x10})},
      {com_port(7, {}), com_port(107, {0x10})},
      {com_port(12, {1}), com_port(112, {1})},
      {com_port(12, {3}), com_port(112, {3})},
      {{kIac, kDont, kComPort}, {kIac, kWont, kComPort}},
      {{kIac, kWont, kComPort}, {kIac, kDont, kComPort}},
      {com_port(12, {2}), com_port(112, {2})},
  };
  int step = 0;
  for (const auto& [sent, answered] : kTranscript) {
    send_all(host, sent);
    ASSERT_EQ(read_bytes(bench, host, answered.size()), answered) << "step " << step;
    ++step;
  }
  EXPECT_EQ(bench.line.host(), (HostSettings{57599, 2, 7, Parity::kOdd}));
  EXPECT_EQ(bench.endpoint.counters().ignored, 0U);
}

TEST(Rfc2217, EveryByteValuePassesUnchangedBothWays) {
  Bench bench{TcpMode::kRfc2217};
  const FileDescriptor host = attach(bench);
  EXPECT_EQ(read_bytes(bench, host, kOffers.size()), kOffers);
  Bytes escaped = all_values();
  escaped.push_back(kIac);
  for (const std::uint8_t byte : escaped) send_all(host, {byte});  // in pieces
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() >= 256; }));
  EXPECT_EQ(bench.heard, all_values());
  bench.say(all_values());
  EXPECT_EQ(read_bytes(bench, host, 257), escaped);
}

TEST(Rfc2217, AClientThatSetsAnotherBaudRateGetsGarbageAndTheNextClientDoesNot) {
  Bench bench{TcpMode::kRfc2217, {.timing = LineTiming::kIdeal, .baud = 19200}};
  {
    const FileDescriptor host = attach(bench);
    send_all(host, {0x55});  // what goes before a setting leaves with the one before
    send_all(host, com_port(1, {0, 0, 0x25, 0x80}));
    send_all(host, {0x55});
    ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 3; }));
    EXPECT_EQ(bench.heard, (Bytes{0x55, 0x66, 0xE6}));
    EXPECT_EQ(bench.line.host().baud, 9600);
  }
  ASSERT_TRUE(bench.pump([&] { return !bench.endpoint.attached(); }));
  bench.heard.clear();
  const FileDescriptor next = attach(bench);
  EXPECT_EQ(bench.line.host(), HostSettings{});
  send_all(next, {0x55});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  EXPECT_EQ(bench.heard, Bytes{0x55});
}

TEST(Rfc2217, ADriveThatChecksParityHearsNothingOfAClientWithTheOpposite) {
  Bench bench{TcpMode::kRfc2217, {.timing = LineTiming::kIdeal, .parity = Parity::kEven}};
  const FileDescriptor host = attach(bench);
  send_all(host, com_port(3, {2}));
  send_all(host, all_values());  // 0xFF is the first half of the next command
  send_all(host, {kIac});
  send_all(host, com_port(3, {3}));
  send_all(host, {0x42});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  EXPECT_EQ(bench.heard, Bytes{0x42});
  EXPECT_EQ(bench.line.counters().garbled, 256U);
}

TEST(Rfc2217, HoldsBackWhatAClientHasNoRoomForUntilItHas) {
  Bench bench{TcpMode::kRfc2217};
  const FileDescriptor host = attach(bench);
  EXPECT_EQ(read_bytes(bench, host, kOffers.size()), kOffers);
  send_all(host, com_port(8, {}));
  send_all(host, {1});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  bench.say(Bytes(5000, 0x55));
  EXPECT_EQ(bench.endpoint.counters().overrun, 5000 - TcpEndpoint::kMaxPending);
  send_all(host, com_port(12, {2}));  // the other direction
  EXPECT_EQ(read_bytes(bench, host, 1), com_port(112, {2}));
  send_all(host, com_port(9, {}));
  EXPECT_EQ(read_bytes(bench, host, TcpEndpoint::kMaxPending),
            Bytes(TcpEndpoint::kMaxPending, 0x55));
}

TEST(Rfc2217, APurgeThrowsAwayWhatTheDeviceHasSaid) {
  Bench bench{TcpMode::kRfc2217};
  const FileDescriptor host = attach(bench);
  EXPECT_EQ(read_bytes(bench, host, kOffers.size()), kOffers);
  send_all(host, com_port(8, {}));
  send_all(host, {1});
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  bench.say({1, 2, 3});
  send_all(host, com_port(12, {1}));
  send_all(host, com_port(9, {}));
  EXPECT_EQ(read_bytes(bench, host, 1), com_port(112, {1}));
  bench.say({4});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{4});
}

TEST(Rfc2217, MalformedAndTruncatedCommandsAreCountedAndIgnored) {
  Bench bench{TcpMode::kRfc2217};
  const FileDescriptor host = attach(bench);
  EXPECT_EQ(read_bytes(bench, host, kOffers.size()), kOffers);
  const Bytes kBad[] = {
      {kIac, kSb, kIac, kSe},              // nothing in it
      {kIac, kSb, kComPort, kIac, kSe},    // no code
      {kIac, kSb, 31, 0, 80, kIac, kSe},   // another option
      com_port(1, {0, 0, 0x25}),           // too short
      com_port(1, {0, 0, 0x25, 0x80, 0}),  // too long
      com_port(2, {}),
      com_port(5, {20}),  // no such request
      com_port(12, {0}),
      com_port(13, {0}),                       // no such command
      com_port(1, Bytes(100'000, 0)),          // would fill the memory
      {kIac, kSb, kComPort, 1, 0, kIac, 241},  // cut off by a NOP
  };
  for (const Bytes& bad : kBad) send_all(host, bad);
  send_all(host, {kIac, 241, kIac, 246, kIac, kSe, 0x42});  // NOP, AYT, an end without a begin
  ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
  EXPECT_EQ(bench.heard, Bytes{0x42});
  EXPECT_EQ(bench.endpoint.counters().ignored, std::size(kBad));
  EXPECT_EQ(bench.line.host(), HostSettings{});
  bench.say({0x24});
  EXPECT_EQ(read_bytes(bench, host, 1), Bytes{0x24});  // and not a byte was answered
}

TEST(Rfc2217, HostileBytesNeitherCrashItNorMakeTheAnswersGrow) {
  EventLoop loop;
  SerialLine line{loop, kIdeal};
  std::mt19937 random{1};
  for (int round = 0; round < 2000; ++round) {
    ClientOutbox outbox;
    Rfc2217Session session{line, outbox};
    Bytes bytes(500);
    for (std::uint8_t& byte : bytes) {
      const std::size_t dice = random();
      const Bytes kLikely = {kIac, kIac, kSb, kSe, kComPort, kWill, kDo, kDont, kWont};
      byte = dice % 4 == 0   ? static_cast<std::uint8_t>(dice >> 8)
             : dice % 4 == 1 ? static_cast<std::uint8_t>(dice >> 8 & 15)
                             : kLikely[(dice >> 8) % kLikely.size()];
    }
    session.hear(bytes);
    loop.run_until(loop.now());
    ASSERT_LE(outbox.wire.size(), kOffers.size() + 3 * bytes.size());
  }
}

TEST(Rfc2217, AClientThatAsksAndNeverReadsTheAnswersIsNotHeardOnForEver) {
  Bench bench{TcpMode::kRfc2217};
  const FileDescriptor host = attach(bench, 4096);
  Bytes questions;
  for (int i = 0; i < 1000; ++i) {
    const Bytes question = com_port(0, {});
    questions.insert(questions.end(), question.begin(), question.end());
  }
  std::size_t sent = 0;
  int idle = 0;
  bench.pump([&] {  // until nothing more goes in
    const ssize_t size = send(host.get(), questions.data(), questions.size(), MSG_DONTWAIT);
    if (size > 0) sent += static_cast<std::size_t>(size);
    idle = size > 0 ? 0 : idle + 1;
    return idle == 20 || sent > 50'000'000;
  });
  EXPECT_LT(sent, 50'000'000U);
  EXPECT_FALSE(bench.ready());
}

/// A program that is killed when it outlives its deadline.
class Program {
 public:
  explicit Program(std::vector<std::string> words) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    VIRTDRIVE_CHECK(
        posix_spawn(&pid_, arguments[0], nullptr, nullptr, arguments.data(), environ) == 0,
        "posix_spawn {}", words[0]);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    if (ended()) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
  }

  bool ended() {
    if (!reaped_) reaped_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return reaped_;
  }
  int exit_code() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1; }

 private:
  pid_t pid_ = 0;
  int status_ = 0;
  bool reaped_ = false;
};

constexpr const char* kPyserialClient = R"(
import sys, serial
url = 'rfc2217://127.0.0.1:' + sys.argv[1]
data = bytes(range(256))
for round in range(2):
    with serial.serial_for_url(url, baudrate=57600, bytesize=8, parity='E', stopbits=2,
                               timeout=8) as port:
        port.write(data)
        assert port.read(256) == data, 'no echo'
        port.baudrate = 115200
        port.dtr = False
        port.rts = True
        port.break_condition = True
        port.break_condition = False
        assert port.cts and port.dsr and port.cd and not port.ri
        port.reset_input_buffer()
        port.reset_output_buffer()
try:
    serial.serial_for_url(url, rtscts=True)
except ValueError:
    pass
else:
    raise AssertionError('flow control was accepted')
)";

TEST(Rfc2217, PyserialOpensExchangesReconfiguresClosesAndComesAgain) {
  const std::string python = "/usr/bin/python3";
  if (!std::filesystem::exists(python)) GTEST_SKIP() << "no " << python;
  Program probe{{python, "-c", "import serial.rfc2217"}};
  Bench bench{TcpMode::kRfc2217,
              {.timing = LineTiming::kIdeal, .baud = 57600, .parity = Parity::kEven}};
  bench.echoes = true;
  ASSERT_TRUE(bench.pump([&] { return probe.ended(); }));
  if (probe.exit_code() != 0) GTEST_SKIP() << "no pyserial";

  Program client{
      {python, "-B", "-W", "ignore", "-c", kPyserialClient, std::to_string(bench.port())}};
  HostSettings at_57600;
  const auto served = [&] {
    if (bench.line.host().baud == 57600) at_57600 = bench.line.host();
    return client.ended();
  };
  ASSERT_TRUE(bench.pump(served) || bench.pump(served) || bench.pump(served));  // it sleeps a lot
  EXPECT_EQ(client.exit_code(), 0);
  EXPECT_EQ(at_57600, (HostSettings{57600, 2, 8, Parity::kEven}));
  EXPECT_EQ(bench.line.counters().garbled, 0U);
  EXPECT_EQ(bench.endpoint.counters().attached, 3U);
  EXPECT_EQ(bench.endpoint.counters().refused, 0U);
  EXPECT_EQ(bench.endpoint.counters().ignored, 0U);
}

}  // namespace
}  // namespace virtdrive
