#include "devices/rzt1/codec.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/devices/vectors.h"

namespace virtdrive::rzt1 {
namespace {

using protocol::Values;
using Bytes = std::vector<std::uint8_t>;
using Event = Decoder::Event;

const CommandRow& packet_row(std::uint16_t code) {
  return *protocol::find(kTable.commands, code);
}
const CommandRow& go() {
  return *protocol::find(kTable.functions, 85);
}
const ParameterRow& variable(std::uint16_t id) {
  return *protocol::find(kTable.parameters, id);
}
const std::vector<Vector>& vectors() {
  static const auto all = read_vectors("vectors_rzt1.csv");
  return all;
}
Bytes request(std::string_view name) {
  return golden_frame(vectors(), name, "request");
}
Bytes response(std::string_view name) {
  return golden_frame(vectors(), name, "response");
}

std::vector<Event> feed(Decoder& decoder, const Bytes& bytes) {
  std::vector<Event> events;
  for (const std::uint8_t byte : bytes) {
    const Event event = decoder.push(byte);
    if (event != Event::kNone) events.push_back(event);
  }
  return events;
}

Packet decode(const Bytes& bytes) {
  Decoder decoder;
  EXPECT_EQ(feed(decoder, bytes), std::vector{Event::kPacket});
  return decoder.packet();
}

Line decode_line(std::string_view text) {
  Decoder decoder;
  EXPECT_EQ(feed(decoder, {text.begin(), text.end()}), std::vector{Event::kLine});
  return decoder.line();
}

TEST(Rzt1Packets, EveryGoldenRequestIsOnePacketAtItsLastByte) {
  std::size_t packets = 0;
  for (const auto& v : vectors()) {
    if (!is_request(v) || v.bytes[0] != kStart) continue;
    ++packets;
    Decoder decoder;
    const bool bad = v.name.ends_with("GetModuleData_badsum");
    EXPECT_EQ(feed(decoder, v.bytes), std::vector{bad ? Event::kBadSum : Event::kPacket}) << v.name;
    EXPECT_TRUE(std::ranges::equal(decoder.bytes(), v.bytes)) << v.name;
    EXPECT_EQ(decoder.packet().address, v.bytes[1]) << v.name;
    EXPECT_TRUE(decoder.idle()) << v.name;
    if (bad || decoder.packet().status != Status::kOk) continue;
    EXPECT_EQ(encode_request(decoder.packet()), v.bytes) << v.name;
  }
  EXPECT_EQ(packets, 39U);
}

TEST(Rzt1Packets, ADeclaredRowsValuesAreRead) {
  EXPECT_EQ(decode(request("00_GetModuleData")).row, &packet_row(0));
  EXPECT_EQ(decode(request("00_GetModuleData_axis2")).address, 2);
  EXPECT_EQ(decode(request("01_Report_pos_status")).values, Values{3});
  EXPECT_EQ(decode(request("02_Call_GO")).function, &go());
  const Packet kp = decode(request("05_Set_KP_1500"));
  EXPECT_EQ(kp.parameter, &variable(14));
  EXPECT_EQ(kp.values, (Values{14, 1500}));
  EXPECT_EQ(decode(request("05_Set_ABS_10000")).values, (Values{80, 10000}));
  EXPECT_EQ(decode(request("05_Set_ABS_minus1")).values, (Values{80, -1}));
  EXPECT_EQ(decode(request("06_Get_POS")).parameter, &variable(82));
}

TEST(Rzt1Packets, WhatCannotBeReadCarriesTheStatusToRefuseItWith) {
  EXPECT_EQ(decode(request("08_invalid_code")).status, Status::kBadCode);
  EXPECT_EQ(decode(request("05_Set_index200")).status, Status::kBadIndex);
  EXPECT_EQ(decode(request("06_Get_index200")).status, Status::kBadIndex);
  EXPECT_EQ(decode(request("02_Call_not_a_function")).status, Status::kBadIndex);
  EXPECT_EQ(decode(request("05_Set_KP_badsize")).status, Status::kBadSize);
  EXPECT_EQ(decode(from_hex("aa 01 00 06 07")).status, Status::kBadSize);
  EXPECT_EQ(decode(from_hex("aa 01 01 06 55 5d")).status, Status::kBadIndex);  // GO
  EXPECT_EQ(encode_refusal(Status::kBadIndex), response("status_invalid_index"));
  EXPECT_EQ(encode_refusal(Status::kBadSum), response("checksum_error"));
}

TEST(Rzt1Packets, RefusalsOfTheTableHaveTheirStatus) {
  using protocol::Refusal;
  EXPECT_EQ(encode_refusal(status_of(Refusal::kReadOnly)), response("status_read_only"));
  EXPECT_EQ(encode_refusal(status_of(Refusal::kOutOfRange)), response("status_out_of_range"));
  EXPECT_EQ(encode_refusal(status_of(Refusal::kUnknown)), response("status_invalid_index"));
  EXPECT_EQ(status_of(protocol::check_write(&variable(14), 1500)), Status::kOk);
  EXPECT_EQ(status_of(protocol::check_write(&variable(14), 32768)), Status::kOutOfRange);
  EXPECT_EQ(status_of(protocol::check_write(&variable(1), 5)), Status::kReadOnly);
}

TEST(Rzt1Packets, RepliesAreTheGoldenFrames) {
  const auto reply = [](std::string_view name, const Values& values) {
    return encode_reply(decode(request(name)), values);
  };
  EXPECT_EQ(reply("00_GetModuleData", {3, 0x20, 0, 4}), response("00_GetModuleData"));
  EXPECT_EQ(reply("01_Report_pos_status", {1000, 0x87}), response("01_Report_pos_status"));
  EXPECT_EQ(reply("01_Report_all", {-1000, 7, -3, 250, 5, 1, 0, 0}), response("01_Report_all"));
  EXPECT_EQ(reply("06_Get_POS", {2000}), response("06_Get_POS_2000"));
  EXPECT_EQ(reply("06_Get_KP", {1500}), response("06_Get_KP_1500"));
  EXPECT_EQ(reply("02_Call_GO", {}), response("status_ok"));
  EXPECT_EQ(reply("05_Set_KP_1500", {}), response("status_ok"));
}

TEST(Rzt1Packets, TheHostKnowsFromItsRequestWhereTheReplyEnds) {
  const auto read = [](std::string_view request_name, const Bytes& bytes) {
    PacketReplyDecoder decoder(decode(request(request_name)));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const bool last = i + 1 == bytes.size();
      EXPECT_EQ(decoder.push(bytes[i]),
                last ? PacketReplyDecoder::Event::kReply : PacketReplyDecoder::Event::kNone)
          << request_name << " byte " << i;
    }
    return std::pair(decoder.status(), decoder.values());
  };
  EXPECT_EQ(read("01_Report_pos_status", response("01_Report_pos_status")),
            (std::pair(Status::kOk, Values{1000, 0x87})));
  EXPECT_EQ(read("01_Report_all", response("01_Report_all")),
            (std::pair(Status::kOk, Values{-1000, 7, -3, 250, 5, 1, 0, 0})));
  EXPECT_EQ(read("06_Get_KP", response("06_Get_KP_1500")), (std::pair(Status::kOk, Values{1500})));
  EXPECT_EQ(read("06_Get_POS", response("status_invalid_state")),
            (std::pair(Status::kInvalidState, Values{})));

  PacketReplyDecoder decoder(decode(request("06_Get_KP")));
  Bytes bad = response("06_Get_KP_1500");
  bad.back() ^= 1;
  PacketReplyDecoder::Event event{};
  for (const std::uint8_t byte : bad) event = decoder.push(byte);
  EXPECT_EQ(event, PacketReplyDecoder::Event::kBadSum);
}

TEST(Rzt1Packets, AllNumbersFrom0To144AreAVariableOrAFunction) {
  for (std::uint16_t id = 0; id <= 144; ++id) {
    const bool is_variable = protocol::find(kTable.parameters, id) != nullptr;
    const bool is_function = protocol::find(kTable.functions, id) != nullptr;
    EXPECT_NE(is_variable, is_function) << id;
  }
  EXPECT_EQ(std::size(kFunctions) + std::size(kParameters), 145U);
}

TEST(Rzt1Packets, PvtPointsComeWithAndWithoutTheirCount) {
  const Packet counted = decode(request("04_StreamPVT_1pt_count"));
  EXPECT_TRUE(counted.counted);
  EXPECT_EQ(counted.values, (Values{1, 1000, 65536}));
  const Packet bare = decode(request("04_StreamPVT_1pt_nocount"));
  EXPECT_FALSE(bare.counted);
  EXPECT_EQ(bare.values, (Values{1000, 65536}));
  EXPECT_EQ(decode(request("04_StreamPVT_2pt_count")).values,
            (Values{2, 1000, 65536, 2000, 65536}));
  // A count that is not the points', no points, half a point.
  EXPECT_EQ(decode(from_hex("aa 01 09 04 02 e8 03 00 00 00 00 01 00 fc")).status, Status::kBadSize);
  EXPECT_EQ(decode(from_hex("aa 01 01 04 00 06")).status, Status::kBadSize);
  EXPECT_EQ(decode(from_hex("aa 01 00 04 05")).status, Status::kBadSize);
  EXPECT_EQ(decode(from_hex("aa 01 04 04 01 02 03 04 13")).status, Status::kBadSize);
}

TEST(Rzt1Packets, APvtPacketHolds31PointsWhateverItsLayout) {
  for (const bool counted : {true, false}) {
    Packet stream{.row = &packet_row(4), .counted = counted};
    if (counted) stream.values.push(kMostPoints);
    for (std::size_t i = 0; i < 2 * kMostPoints; ++i) stream.values.push(static_cast<int>(i) - 30);
    const Bytes bytes = encode_request(stream);
    EXPECT_EQ(bytes.size(), 5U + 8 * kMostPoints + counted);
    EXPECT_EQ(decode(bytes).values, stream.values);
  }
}

TEST(Rzt1Packets, AWatermarkMayFollowTheTimeSlice) {
  EXPECT_EQ(decode(request("03_InitPVT_200")).values, Values{200});
  const Packet both{.row = &packet_row(3), .values = {50, 20}};
  EXPECT_EQ(encode_request(both), from_hex("aa 01 02 03 32 14 4c"));
  EXPECT_EQ(decode(encode_request(both)).values, (Values{50, 20}));
  EXPECT_EQ(decode(from_hex("aa 01 03 03 32 14 00 4d")).status, Status::kBadSize);
}

TEST(Rzt1Packets, SetupIsAlsoStartedByAWrite) {
  const Packet setup = decode(from_hex("aa 01 03 05 71 01 00 7b"));
  ASSERT_NE(setup.function, nullptr);
  EXPECT_EQ(setup.function->name, "SETUP");
  EXPECT_EQ(decode(from_hex("aa 01 01 06 71 79")).status, Status::kBadIndex);
  EXPECT_EQ(decode(from_hex("aa 01 03 05 6c 01 00 76")).status, Status::kBadIndex);  // PLAY
}

TEST(Rzt1Packets, ATracesLengthStandsInFrontOfIt) {
  const std::int32_t samples[] = {100, -100, 0};
  EXPECT_EQ(encode_trace(samples, TraceWidth::kTwoBytes), response("07_Trace_3x16"));
  for (const TraceWidth width : {TraceWidth::kTwoBytes, TraceWidth::kFourBytes}) {
    std::vector<std::int32_t> many(kTraceSize, -7);
    PacketReplyDecoder decoder(decode(request("07_Trace_ch1_16")));
    const Bytes bytes = encode_trace(many, width);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      SCOPED_TRACE(i);
      ASSERT_EQ(decoder.push(bytes[i]), i + 1 == bytes.size() ? PacketReplyDecoder::Event::kReply
                                                              : PacketReplyDecoder::Event::kNone);
    }
    EXPECT_TRUE(std::ranges::equal(decoder.samples(), many));
  }
  EXPECT_EQ(encode_trace(samples, TraceWidth::kTwoBytes, {.raw_trace = true}),
            from_hex("00 64 00 9c ff 00 00 ff"));
}

TEST(Rzt1Packets, TheStatusMayTakeTwoBytes) {
  const ReplyFormat two{.status_bytes = 2};
  EXPECT_EQ(encode_reply(decode(request("06_Get_KP")), {1500}, two), from_hex("00 00 dc 05 e1"));
  EXPECT_EQ(encode_refusal(Status::kBadIndex, two), from_hex("02 00 02"));
  EXPECT_EQ(encode_refusal(Status::kBadSum, two), from_hex("ff 00 ff"));
  PacketReplyDecoder decoder(decode(request("06_Get_KP")), two);
  PacketReplyDecoder::Event event{};
  for (const std::uint8_t byte : from_hex("00 00 dc 05 e1")) event = decoder.push(byte);
  EXPECT_EQ(event, PacketReplyDecoder::Event::kReply);
  EXPECT_EQ(decoder.values(), Values{1500});
}

TEST(Rzt1Packets, AMaskBitWithoutAFieldIsIgnored) {
  const Packet report = decode(encode_request(Packet{.row = &packet_row(1), .values = {0xFF02}}));
  EXPECT_EQ(encode_reply(report, {0x87}), from_hex("00 87 00 87"));
}

TEST(Rzt1Packets, ACutPacketWaitsAndABadSumCostsOnlyItself) {
  Decoder decoder;
  Bytes cut = request("05_Set_KP_1500");
  cut.pop_back();
  EXPECT_TRUE(feed(decoder, cut).empty());
  EXPECT_FALSE(decoder.idle());
  // The next packet's first byte is taken for the missing sum.
  EXPECT_EQ(feed(decoder, {kStart}), std::vector{Event::kBadSum});
  EXPECT_EQ(feed(decoder, request("06_Get_POS")), std::vector{Event::kPacket});
}

TEST(Rzt1Lines, EveryGoldenLineIsOneLineAtItsCr) {
  std::size_t lines = 0;
  for (const auto& v : vectors()) {
    if (!is_request(v) || !v.name.starts_with("ascii_")) continue;
    ++lines;
    Decoder decoder;
    EXPECT_EQ(feed(decoder, v.bytes), std::vector{Event::kLine}) << v.name;
  }
  EXPECT_EQ(lines, 16U);
}

TEST(Rzt1Lines, AreTheGoldenRequestsAndReplies) {
  EXPECT_EQ(encode_request(Line{.parameter = &variable(82)}), request("ascii_POS_120"));
  EXPECT_EQ(encode_request(Line{.parameter = &variable(82), .argument = 2000}),
            request("ascii_POS_set"));
  EXPECT_EQ(encode_request(Line{.axis = 2, .parameter = &variable(82)}), request("ascii_axis2"));
  EXPECT_EQ(encode_request(Line{.axis = 2}), request("ascii_axis_default"));
  EXPECT_EQ(encode_request(Line{.parameter = &variable(80), .argument = -500}),
            request("ascii_neg"));
  EXPECT_EQ(encode_reply(to_text(variable(82), 2100), true), response("ascii_POS_2100"));
  EXPECT_EQ(encode_reply(to_text(variable(0), 0x87), true), response("ascii_STA"));
  EXPECT_EQ(encode_reply("", true), response("ascii_POS_set"));
  EXPECT_EQ(encode_reply("", false), response("ascii_unknown"));
}

TEST(Rzt1Lines, NamesAreFoundWhateverTheirCaseAndSpacing) {
  for (const char* text : {"KP 5\r", "kp 5\r", " \tKP  5 \r", "KP =5\r", "KP = 5\r", "KP=5\r",
                           "\nKP 5\r", "KP 0x5\r", "KP 05\r", "KP +5\r"}) {
    const Line line = decode_line(text);
    EXPECT_EQ(line.parameter, &variable(14)) << text;
    EXPECT_EQ(line.argument, 5) << text;
    EXPECT_TRUE(line.accepted) << text;
  }
  EXPECT_EQ(decode_line("ABS 0x10\r").argument, 16);
  EXPECT_EQ(decode_line("ABS 010\r").argument, 8);
  EXPECT_EQ(decode_line("ABS -500\r").argument, -500);
  EXPECT_EQ(decode_line("GO\r").function, &go());
  EXPECT_EQ(decode_line("GO 2000\r").argument, 2000);
  EXPECT_EQ(decode_line("IQCMD\r").parameter, &variable(101));
  EXPECT_EQ(decode_line("idcmd 3\r").parameter, &variable(102));
}

TEST(Rzt1Lines, ALeadingDigitIsTheAxis) {
  const Line other = decode_line("2POS\r");
  EXPECT_EQ(other.axis, 2U);
  EXPECT_EQ(other.parameter, &variable(82));
  EXPECT_EQ(decode_line("POS\r").axis, 0U);
  const Line alone = decode_line("2\r");
  EXPECT_EQ(alone.axis, 2U);
  EXPECT_EQ(alone.parameter, nullptr);
  EXPECT_TRUE(alone.accepted);
  EXPECT_FALSE(decode_line("3POS\r").accepted);
}

TEST(Rzt1Lines, WhatIsNoNameOrNumberIsRefused) {
  for (const char* text : {"FOO\r", "POSX\r", "PO\r", "KP x\r", "KP 5x\r", "KP 5 6\r", "KP 08\r",
                           "KP 99999999999\r", "KP -\r", "KP 0x\r", "0\r"}) {
    EXPECT_FALSE(decode_line(text).accepted) << text;
  }
  EXPECT_TRUE(decode_line("\r").accepted);
}

TEST(Rzt1Lines, OfALineTooLongTheRestIsLost) {
  Decoder decoder;
  EXPECT_TRUE(feed(decoder, Bytes(2000, 'X')).empty());
  EXPECT_EQ(decoder.bytes().size(), 512U);
  EXPECT_EQ(feed(decoder, request("ascii_STA")), std::vector{Event::kLine});
  EXPECT_FALSE(decoder.line().accepted);
  EXPECT_EQ(feed(decoder, request("ascii_STA")), std::vector{Event::kLine});
  EXPECT_EQ(decoder.line().parameter, &variable(0));
}

TEST(Rzt1Lines, TheHostReadsDataLinesAndPrompt) {
  using Reply = LineReplyDecoder::Event;
  LineReplyDecoder decoder;
  const auto read = [&](const Bytes& bytes) {
    std::vector<std::string> seen;
    for (const std::uint8_t byte : bytes) {
      const Reply event = decoder.push(byte);
      if (event == Reply::kText) seen.emplace_back(decoder.text());
      if (event == Reply::kAccepted) seen.emplace_back(">");
      if (event == Reply::kRefused) seen.emplace_back("?");
    }
    return seen;
  };
  using Seen = std::vector<std::string>;
  EXPECT_EQ(read(response("ascii_POS_120")), (Seen{"120", ">"}));
  EXPECT_EQ(read(response("ascii_POS_set")), (Seen{">"}));
  EXPECT_EQ(read(response("ascii_ro_write")), (Seen{"?"}));
  EXPECT_EQ(read(response("ascii_PLAY_2")), (Seen{"1,2,3,4", "5,6,7,8", ">"}));
  EXPECT_EQ(read(encode_reply("120", true, 2)), (Seen{"120", ">"}));
  EXPECT_EQ(read(encode_reply("", false, 1)), (Seen{"?"}));
  EXPECT_EQ(from_text(variable(0), "0087"), 0x87);
  EXPECT_EQ(from_text(variable(82), "-120"), -120);
  EXPECT_EQ(from_text(variable(82), "R120"), std::nullopt);
}

TEST(Rzt1Decoder, APacketIsHeardBetweenLinesAndInTheMiddleOfNoise) {
  Decoder decoder;
  EXPECT_EQ(feed(decoder, request("ascii_POS_120")), std::vector{Event::kLine});
  EXPECT_EQ(feed(decoder, request("06_Get_POS")), std::vector{Event::kPacket});
  feed(decoder, {'x', 0x00, 0xFF});
  EXPECT_EQ(feed(decoder, request("06_Get_POS")), std::vector{Event::kPacket});
  EXPECT_EQ(feed(decoder, request("ascii_POS_120")), std::vector{Event::kLine});
  EXPECT_TRUE(decoder.line().accepted);
}

TEST(Rzt1Decoder, AnyBytesAreTakenAndThreeHundredZerosBringItBack) {
  RandomStream random = Seed{1}.stream("noise");
  Decoder decoder;
  for (int round = 0; round < 1000; ++round) {
    for (int i = 0; i < 300; ++i) decoder.push(static_cast<std::uint8_t>(random.bits()));
    feed(decoder, Bytes(300, 0));  // longer than any packet
    feed(decoder, {'\r'});
    ASSERT_EQ(feed(decoder, request("06_Get_POS")), std::vector{Event::kPacket});
    ASSERT_EQ(decoder.packet().values, Values{82});
  }
}

}  // namespace
}  // namespace virtdrive::rzt1
