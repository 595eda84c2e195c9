#include "scenarios/recording/wire_recording.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/check.h"
#include "scenarios/recording/bench_description.h"
#include "scenarios/recording/line_monitor.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using protocol::Direction;
using protocol::Verdict;
using Bytes = std::vector<std::uint8_t>;

Bytes contents(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class WireRecordingTest : public testing::Test {
 protected:
  ~WireRecordingTest() override { std::filesystem::remove(path_); }

  // A packet of two bytes from each end, and what else there is.
  Bytes record() {
    WireFile file(path_, "{}", {{"bus", "md485", 9600}, {"console", "rzt1", 115200}},
                  {{.drive = 1, .role = RecordedFile::kMotor, .content = {9, 8, 7}}});
    file.host_settings(1, {kSimStart + 5ns, true},
                       {.baud = 19200, .stop_bits = 2, .data_bits = 7, .parity = Parity::kOdd});
    file.host_write(0, {kSimStart + 1s, false}, Bytes{1, 2, 3});
    const std::vector<WireByte> request = {{1, kSimStart + 1s, kSimStart + 1s + 1ms},
                                           {2, kSimStart + 9s, kSimStart + 9s + 1ms}};
    file.packet(0, {Direction::kRequest, request, Verdict::kFrame, "ask"});
    const std::vector<WireByte> reply = {{3, kSimStart + 10s, kSimStart + 10s, true}};
    file.packet(1, {Direction::kReply, reply, Verdict::kNoise, "no\xFFise\n"});
    file.close(kSimStart + 11s);
    return contents(path_);
  }
  WireRecording parse(std::span<const std::uint8_t> bytes) {
    return parse_wire_recording(bytes, "x.pcapng");
  }
  std::string error_of(std::span<const std::uint8_t> bytes) {
    try {
      parse(bytes);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "no error";
  }

  const std::string path_ =
      testing::TempDir() + "virtdrive_wire_recording_test." + std::to_string(getpid()) + ".pcapng";
};

TEST_F(WireRecordingTest, WhatIsWrittenIsReadBack) {
  const WireRecording recording = parse(record());
  EXPECT_EQ(recording.bench, "{}");
  EXPECT_EQ(recording.lines,
            (std::vector<RecordedLine>{{"bus", "md485", 9600}, {"console", "rzt1", 115200}}));
  ASSERT_EQ(recording.files.size(), 1U);
  EXPECT_EQ(recording.files[0].drive, 1U);
  EXPECT_EQ(recording.files[0].role, RecordedFile::kMotor);
  EXPECT_EQ(recording.files[0].content, (Bytes{9, 8, 7}));

  ASSERT_EQ(recording.actions.size(), 2U);
  EXPECT_EQ(recording.actions[0].line, 1U);
  EXPECT_EQ(recording.actions[0].when, (HostInstant{kSimStart + 5ns, true}));
  EXPECT_EQ(recording.actions[0].settings,
            (HostSettings{.baud = 19200, .stop_bits = 2, .data_bits = 7, .parity = Parity::kOdd}));
  EXPECT_EQ(recording.actions[1].when, (HostInstant{kSimStart + 1s, false}));
  EXPECT_EQ(recording.actions[1].bytes, (Bytes{1, 2, 3}));

  ASSERT_EQ(recording.packets.size(), 2U);
  EXPECT_EQ(recording.packets[0].direction, Direction::kRequest);
  EXPECT_EQ(recording.packets[0].bytes, (Bytes{1, 2}));
  EXPECT_EQ(recording.packets[0].last_bits, (std::vector{kSimStart + 1001ms, kSimStart + 9001ms}));
  EXPECT_EQ(recording.packets[0].comment, "ask (1.000000 ... 9.001000 s)");
  EXPECT_EQ(recording.packets[1].line, 1U);
  EXPECT_EQ(recording.packets[1].direction, Direction::kReply);
  EXPECT_EQ(recording.packets[1].comment, "no.ise. (10.000000 ... 10.000000 s)");
  EXPECT_EQ(recording.end, kSimStart + 11s);
  EXPECT_EQ(recording.cut_short, "");
}

TEST_F(WireRecordingTest, AFileCutAnywhereIsReadUpToItsLastWholeBlock) {
  const Bytes whole = record();
  std::size_t packets = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto cut = std::span(whole).first(size);
    const std::string error = error_of(cut);
    if (error != "no error") {
      EXPECT_EQ(packets, 0U);
      EXPECT_TRUE(error.starts_with("x.pcapng: ")) << error;
      continue;
    }
    const WireRecording recording = parse(cut);
    EXPECT_NE(recording.cut_short, "") << size;
    EXPECT_GE(recording.packets.size(), packets);
    packets = recording.packets.size();
    EXPECT_GE(recording.end, packets > 0 ? kSimStart + 9001ms : kSimStart);
  }
  EXPECT_EQ(packets, 2U);
}

TEST_F(WireRecordingTest, EachDamagedByteIsToleratedOrNamedWithItsOffset) {
  const Bytes whole = record();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes damaged = whole;
      damaged[at] ^= static_cast<std::uint8_t>(flip);
      const std::string error = error_of(damaged);
      EXPECT_TRUE(error == "no error" || error.starts_with("x.pcapng: ")) << at << ": " << error;
    }
  }
}

TEST_F(WireRecordingTest, BlocksAndOptionsOfOthersAreSkipped) {
  Bytes bytes = record();
  const std::uint8_t statistics[] = {5, 0, 0, 0, 16, 0, 0, 0, 1, 2, 3, 4, 16, 0, 0, 0};
  const std::size_t section = bytes[4] | bytes[5] << 8;
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(section), std::begin(statistics),
               std::end(statistics));
  EXPECT_EQ(parse(bytes).packets.size(), 2U);
}

TEST_F(WireRecordingTest, AFullDiskIsReported) {
  std::filesystem::create_symlink("/dev/full", path_);
  try {
    record();
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_EQ(std::string(error.what()), "--wire " + path_ + ": not all of it could be written");
  }
}

TEST(BenchDescription, IsReadBackWhole) {
  RecordedBench bench;
  bench.options = {.drives = {{.kind = "toshiba-mcu",
                               .name = "left",
                               .line = "b",
                               .motors = {"db42s01", "db42s03", "db42s03"},
                               .load = "brake:5mNm@1s",
                               .set = {"1.PolePairs=4", "Speed=3"},
                               .lenient = true}},
                   .lines = {{.name = "a", .baud = 9600},
                             {.name = "b",
                              .timing = LineTiming::kIdeal,
                              .baud = 115200,
                              .duplex = Duplex::kHalf,
                              .echo = true}},
                   .seed = ~std::uint64_t{0},
                   .integrator = Integrator::kFast};
  bench.signals = {"motor1.speed"};
  bench.interval = 250us;
  const std::string text = describe(bench);
  const RecordedBench again = parse_bench(text, "x");
  EXPECT_EQ(describe(again), text);
  EXPECT_EQ(again.options.seed, ~std::uint64_t{0});
  EXPECT_EQ(again.options.drives[0].motors.size(), 3U);
  EXPECT_EQ(again.options.lines[1].timing, LineTiming::kIdeal);
  EXPECT_EQ(again.options.lines[1].duplex, Duplex::kHalf);
  EXPECT_TRUE(again.options.lines[1].echo);
  EXPECT_EQ(again.options.integrator, Integrator::kFast);
  EXPECT_EQ(again.interval, 250us);
}

TEST(BenchDescription, WhatItDoesNotKnowIsRefused) {
  RecordedBench bench;
  bench.options = {.drives = {{.kind = "toshiba-mcu"}}, .lines = {{.baud = 9600}}};
  const std::string text = describe(bench);
  const auto error_with = [&](std::string_view old, std::string_view now) {
    std::string changed = text;
    changed.replace(changed.find(old), old.size(), now);
    try {
      parse_bench(changed, "x.pcapng");
    } catch (const SetupError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(error_with("{", "["), "x.pcapng: the bench's description is no description of a bench");
  EXPECT_EQ(error_with("\"seed\"", "\"sead\""), "x.pcapng: the bench's description lacks 'seed'");
  EXPECT_EQ(error_with("{\"virtdrive\":1", "{\"virtdrive\":1,\"wind\":3"),
            "x.pcapng: the bench's description has 'wind', which this version does not know");
  EXPECT_EQ(error_with("9600", "0"),
            "x.pcapng: the bench's description 'baud' is no number 50 ... 12000000");
}

// --- What is cut into packets --------------------------------------------------------------------

class Listener final : public WireSink {
 public:
  struct Packet {
    Direction direction;
    Bytes bytes;
    Verdict verdict;
    friend bool operator==(const Packet&, const Packet&) = default;
  };

  void host_settings(std::size_t, HostInstant when, const HostSettings& host) override {
    settings.emplace_back(when, host);
  }
  void host_write(std::size_t, HostInstant when, std::span<const std::uint8_t> bytes) override {
    writes.emplace_back(when, Bytes(bytes.begin(), bytes.end()));
  }
  void packet(std::size_t, const WirePacket& packet) override {
    Packet heard{packet.direction, {}, packet.verdict};
    for (const WireByte& byte : packet.bytes) heard.bytes.push_back(byte.byte);
    packets.push_back(heard);
  }

  std::vector<std::pair<HostInstant, HostSettings>> settings;
  std::vector<std::pair<HostInstant, Bytes>> writes;
  std::vector<Packet> packets;
};

struct Monitored {
  EventLoop loop;
  SerialLine line{loop, {.baud = 115200}};  // with a host, and nobody to hear it
  Listener listener;
  LineMonitor monitor{loop, line, 0, "toshiba-mcu", {&listener}};
};

TEST(LineMonitor, NoiseIsGatheredUntilAFrameAGapOrItsMaximum) {
  Monitored wire;
  wire.line.host_send(Bytes{1, 2, 0x11, 0x14, 0x00, 0x6c, 0x13, 3});
  wire.loop.run_until(kSimStart + 1s);
  wire.line.host_send(Bytes{4});
  wire.line.host_send(Bytes(FrameCutter::kLongestNoise, 5));
  wire.loop.run_until(kSimStart + 2s);
  wire.monitor.finish();
  ASSERT_EQ(wire.listener.packets.size(), 5U);
  EXPECT_EQ(wire.listener.packets[0].bytes, (Bytes{1, 2}));
  EXPECT_EQ(wire.listener.packets[1].verdict, Verdict::kFrame);
  EXPECT_EQ(wire.listener.packets[2].bytes, (Bytes{3}));
  EXPECT_EQ(wire.listener.packets[3].bytes.size(), FrameCutter::kLongestNoise);
  EXPECT_EQ(wire.listener.packets[4].bytes, (Bytes{5}));
}

TEST(LineMonitor, TellsWhereAHostsActionStandsAmongTheEventsOfItsInstant) {
  Monitored wire;
  Wakeup event = wire.loop.add(Phase::kScenario, [] {});
  event.at(kSimStart + 1ms);
  wire.loop.run_before(kSimStart + 1ms);
  wire.line.host_send(Bytes{1});
  wire.loop.run_until(kSimStart + 1ms);
  wire.line.host_send(Bytes{2});
  wire.line.set_host({.baud = 9600});
  wire.line.set_host({.baud = 9600});
  ASSERT_EQ(wire.listener.writes.size(), 2U);
  EXPECT_EQ(wire.listener.writes[0].first, (HostInstant{kSimStart + 1ms, true}));
  EXPECT_EQ(wire.listener.writes[1].first, (HostInstant{kSimStart + 1ms, false}));
  ASSERT_EQ(wire.listener.settings.size(), 1U) << "what is the same as before is not told";
  EXPECT_EQ(wire.listener.settings[0].second, (HostSettings{.baud = 9600}));
}

}  // namespace
}  // namespace virtdrive
