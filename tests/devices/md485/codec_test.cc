#include "devices/md485/codec.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "core/random.h"
#include "devices/md485/can_codec.h"
#include "devices/protocol/binding.h"
#include "devices/protocol/checksum.h"
#include "tests/devices/vectors.h"

namespace virtdrive::md485 {
namespace {

using protocol::Direction;
using protocol::Values;
using Bytes = std::vector<std::uint8_t>;
using Event = Decoder::Event;

const CommandRow& command(std::uint16_t pid) {
  return *protocol::find(kTable.commands, pid);
}
const ParameterRow& parameter(std::uint16_t pid) {
  return *protocol::find(kTable.parameters, pid);
}
const ParameterRow& main_data() {
  return parameter(193);
}
Bytes golden(std::string_view name, bool request = true) {
  static const auto vectors = read_vectors("vectors_md485.csv");
  return golden_frame(vectors, name, request ? "request" : "response");
}

// All events but kNone, in order; `frames` gets each frame's values.
std::vector<Event> feed(Decoder& decoder, const Bytes& bytes,
                        std::vector<Values>* frames = nullptr) {
  std::vector<Event> events;
  for (const std::uint8_t byte : bytes) {
    for (Event e = decoder.push(byte); e != Event::kNone; e = decoder.next()) {
      events.push_back(e);
      if (e == Event::kFrame && frames != nullptr) frames->push_back(decoder.frame().values);
    }
  }
  return events;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

const Values kRunning = {1000, 25, 1, 1000, 511, 0, -60, 0, 31, 0};

TEST(Md485Codec, RequestsAreTheGoldenFrames) {
  EXPECT_EQ(encode_request({}, command(4), {193}), golden("REQ_PID_DATA_193"));
  EXPECT_EQ(encode_request({.host = 184}, command(4), {193}), golden("REQ_PID_DATA_193_host184"));
  EXPECT_EQ(encode_request({.host = 128}, command(4), {193}), golden("REQ_PID_DATA_193_host128"));
  EXPECT_EQ(encode_request({}, command(13), {0}), golden("POSI_RESET"));
  EXPECT_EQ(encode_request({}, command(130), {1000}), golden("VEL_CMD_1000"));
  EXPECT_EQ(encode_request({}, command(130), {-1000}), golden("VEL_CMD_minus1000"));
  EXPECT_EQ(encode_request({.id = kAllControllers}, command(130), {0}), golden("VEL_CMD_all"));
}

TEST(Md485Codec, CommandsOfSeveralNumbersAreTheGoldenFrames) {
  EXPECT_EQ(encode_request({}, command(207), {1, 120, 1, -80, 2}),
            golden("PNT_VEL_both_return_main"));
  EXPECT_EQ(encode_request({.id = kAllControllers}, command(207), {1, 300, 2, -300, 0}),
            golden("PNT_VEL_ids_all"));
  EXPECT_EQ(encode_request({}, command(206), {1, 1000, 300, 0, 0, 0, 1}), golden("PNT_POSI_VEL"));
  EXPECT_EQ(encode_request({}, command(215), {1, 60, 1, -60, 0}), golden("PNT_INC_POSI"));
  EXPECT_EQ(encode_request({}, command(219), {-100000, 1500}), golden("POSI_VEL_CMD"));
  EXPECT_EQ(encode_request({}, command(164), {225, 3}), golden("REQ_PID_DATA2_step3"));
}

TEST(Md485Codec, WritesAreTheGoldenFrames) {
  EXPECT_EQ(encode_request({.id = kAllControllers}, parameter(133), {0xAA, 7}),
            golden("ID_to_7_all"));
  EXPECT_EQ(encode_request({}, parameter(137), {0xAA, 4}), golden("ECAN_BITRATE_500k"));
  EXPECT_EQ(encode_request({}, parameter(153), {300}), golden("SLOW_START_300"));
  EXPECT_EQ(encode_request({}, parameter(226), {2, 600, 800}), golden("CURVE_PT_2"));
  EXPECT_EQ(encode_request({}, parameter(239), {1000, 10}), golden("FUNC_SPEED"));
}

TEST(Md485Codec, AnswersAreTheGoldenFrames) {
  EXPECT_EQ(encode_reply({}, parameter(196), {-500, 12, 340, 0, -60, 0x68}),
            golden("MONITOR_12", false));
  EXPECT_EQ(encode_reply({}, parameter(194), {0, 0, 0, 0x68, 0, 0, 4, 0, 0, 281, 10, 10, 102}),
            golden("IO_MONITOR_17", false));
  EXPECT_EQ(encode_reply({}, parameter(210), {120, 8, 0, 6000, -80, 5, 0, -4000}),
            golden("PNT_MAIN_DATA", false));
  EXPECT_EQ(encode_reply({}, parameter(216), {120, 0, 6000, -80, 0, -4000}),
            golden("PNT_MONITOR", false));
  EXPECT_EQ(encode_reply({}, parameter(227), {7, 300, -300}), golden("PRESET_DATA_dual", false));
  const std::uint8_t heard[] = {0x82, 0xE8, 0x03};
  EXPECT_EQ(encode_can_resend({}, extended_frame(0x00B7AC01, heard)), golden("CAN_RESEND", false));
}

TEST(Md485Codec, TheMonitorBlockIsSeventeenBytesWithTheHostsOwnNumberInFront) {
  EXPECT_EQ(encode_reply({}, main_data(), kRunning), golden("MAIN_DATA_17", false));
  EXPECT_EQ(encode_reply({.host = 184}, main_data(), kRunning),
            golden("MAIN_DATA_17_host184", false));
}

TEST(Md485Codec, EveryGoldenFrameIsOneFrameAtItsLastByte) {
  for (const auto& v : read_vectors("vectors_md485.csv")) {
    Decoder decoder(is_request(v) ? Direction::kRequest : Direction::kReply, v.bytes[0]);
    const Bytes but_last(v.bytes.begin(), v.bytes.end() - 1);
    EXPECT_TRUE(feed(decoder, but_last).empty()) << v.name;
    EXPECT_EQ(decoder.push(v.bytes.back()), Event::kFrame) << v.name;
    EXPECT_TRUE(std::ranges::equal(decoder.bytes(), v.bytes)) << v.name;
    EXPECT_EQ(decoder.next(), Event::kNone) << v.name;
    EXPECT_TRUE(decoder.idle()) << v.name;
  }
}

TEST(Md485Decoder, TellsRouteRowAndValues) {
  Decoder decoder(Direction::kRequest);
  feed(decoder, golden("VEL_CMD_minus1000"));
  EXPECT_EQ(decoder.frame().route, (Route{.host = 172, .id = 1}));
  EXPECT_EQ(decoder.frame().command, &command(130));
  EXPECT_EQ(decoder.frame().values, Values{-1000});

  Decoder host(Direction::kReply, 184);
  feed(host, golden("MAIN_DATA_17_host184", false));
  EXPECT_EQ(host.frame().route, (Route{.host = 184, .id = 1}));
  EXPECT_EQ(host.frame().parameter, &main_data());
  EXPECT_EQ(host.frame().values, kRunning);
  EXPECT_EQ(protocol::describe(main_data().fields, host.frame().values),
            "speed=1000rpm current=2.5A control_type=1 reference_speed=1000rpm output=511 status=0 "
            "position=-60counts brake_duty=0 temperature=31degC status2=0");
}

TEST(Md485Decoder, NumRulesTheLengthSoOptionalBytesMayBeMissing) {
  Decoder decoder(Direction::kRequest);
  std::vector<Values> frames;
  const Bytes both = golden("POSI_RESET_NUM0") + golden("VEL_CMD_1000");
  EXPECT_EQ(feed(decoder, both, &frames), (std::vector{Event::kFrame, Event::kFrame}));
  EXPECT_EQ(frames, (std::vector<Values>{{0}, {1000}}));

  Decoder host(Direction::kReply);
  frames.clear();
  feed(host, golden("MAIN_DATA_16", false), &frames);
  EXPECT_EQ(frames, std::vector<Values>{kRunning});
}

TEST(Md485Decoder, AHostTakesOnlyWhatAControllerSendsToItsOwnNumber) {
  Bytes stranger = {172, 128, 1, 193, 0};
  stranger.push_back(protocol::negated_sum8(stranger));
  for (const Bytes& bytes : {stranger, golden("MAIN_DATA_17_host184", false)}) {
    Decoder host(Direction::kReply, 172);
    const std::vector<Event> events = feed(host, bytes);
    EXPECT_EQ(std::ranges::count(events, Event::kNoise), std::ssize(events));
    EXPECT_FALSE(events.empty());
  }
}

TEST(Md485Decoder, ExtraDataAreLeftAloneAndMissingOnesAreTooShort) {
  Bytes longer = {183, 172, 1, 130, 3, 0xE8, 0x03, 0x55};
  longer.push_back(protocol::negated_sum8(longer));
  Bytes shorter = {183, 172, 1, 130, 1, 0xE8};
  shorter.push_back(protocol::negated_sum8(shorter));
  Decoder decoder(Direction::kRequest);
  std::vector<Values> frames;
  EXPECT_EQ(feed(decoder, longer + shorter, &frames),
            (std::vector{Event::kFrame, Event::kTooShort}));
  EXPECT_EQ(frames, std::vector<Values>{{1000}});
}

TEST(Md485Decoder, AnUnknownPidIsToldWithItsRoute) {
  Bytes bytes = {183, 172, 9, 99, 0};
  bytes.push_back(protocol::negated_sum8(bytes));
  Decoder decoder(Direction::kRequest);
  EXPECT_EQ(feed(decoder, bytes), std::vector{Event::kUnknownPid});
  EXPECT_EQ(decoder.frame().pid, 99);
  EXPECT_EQ(decoder.frame().route.id, 9);
}

TEST(Md485Decoder, AfterABadSumItLooksForAFrameFromTheNextByteOn) {
  // A stray 183 makes a false frame: its NUM is the true frame's PID, 130, and takes in what
  // follows.
  Decoder decoder(Direction::kRequest);
  std::vector<Values> frames;
  Bytes bytes = {183};
  bytes = bytes + golden("VEL_CMD_1000");
  while (bytes.size() < 6 + 130) bytes = bytes + golden("VEL_CMD_minus1000");
  const std::vector<Event> events = feed(decoder, bytes, &frames);
  ASSERT_EQ(events.front(), Event::kBadSum);
  ASSERT_EQ(frames.size(), 1 + (bytes.size() - 9) / 8);
  EXPECT_EQ(frames.front(), Values{1000});
  EXPECT_EQ(frames.back(), Values{-1000});
}

TEST(Md485Decoder, SilenceFreesAFrameThatAFalseStartHadSwallowed) {
  Decoder decoder(Direction::kRequest);
  Bytes bytes = {183};
  EXPECT_TRUE(feed(decoder, bytes + golden("VEL_CMD_1000")).empty());
  EXPECT_FALSE(decoder.idle());
  EXPECT_EQ(decoder.expire(), Event::kFrame);
  EXPECT_EQ(decoder.frame().values, Values{1000});
  EXPECT_EQ(decoder.expire(), Event::kNone);
  EXPECT_TRUE(decoder.idle());
}

TEST(Md485Decoder, AFlippedBitIsNeverAFrame) {
  const Bytes frame = golden("VEL_CMD_1000");
  for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
    Bytes bytes = frame;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    Decoder decoder(Direction::kRequest);
    std::vector<Values> frames;
    feed(decoder, bytes, &frames);
    while (decoder.expire() == Event::kFrame) frames.push_back(decoder.frame().values);
    EXPECT_TRUE(frames.empty()) << "bit " << bit;
  }
}

TEST(Md485Decoder, FindsEachFrameBehindNoiseOnceTheLineIsSilent) {
  RandomStream random = Seed{1}.stream("noise");
  Decoder decoder(Direction::kRequest);
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes(random.bits() % 300);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    if (round % 2 == 0 && !bytes.empty()) bytes.back() = kController;
    std::vector<Values> frames;
    feed(decoder, bytes + golden("VEL_CMD_1000"), &frames);
    for (Event e = decoder.expire(); e != Event::kNone; e = decoder.expire()) {
      if (e == Event::kFrame) frames.push_back(decoder.frame().values);
    }
    ASSERT_EQ(std::ranges::count(frames, Values{1000}), 1) << round;
    ASSERT_TRUE(decoder.idle());
  }
}

}  // namespace
}  // namespace virtdrive::md485
