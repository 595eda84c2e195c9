#include "devices/asd7/codec.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/devices/vectors.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Direction;
using protocol::Values;
using Bytes = std::vector<std::uint8_t>;
using Event = Decoder::Event;

const CommandRow& row(char code) {
  return *protocol::find(kTable.commands, static_cast<std::uint8_t>(code));
}
const ParameterRow& parameter(std::uint16_t id) {
  return *protocol::find(kTable.parameters, id);
}
const std::vector<Vector>& vectors() {
  static const auto all = read_vectors("vectors_asd7.csv");
  return all;
}
Bytes request(std::string_view name) {
  return golden_frame(vectors(), name, "request");
}
Bytes response(std::string_view name) {
  return golden_frame(vectors(), name, "response");
}
Bytes ascii(std::string_view text) {
  Bytes bytes(text.begin(), text.end());
  bytes.push_back('\r');
  return bytes;
}

std::vector<Event> feed(Decoder& decoder, const Bytes& bytes) {
  std::vector<Event> events;
  for (const std::uint8_t byte : bytes) {
    const Event event = decoder.push(byte);
    if (event != Event::kNone) events.push_back(event);
  }
  return events;
}

Message decode(const Bytes& bytes, Direction direction = Direction::kRequest) {
  Decoder decoder(direction);
  EXPECT_EQ(feed(decoder, bytes), std::vector{Event::kMessage});
  return decoder.message();
}

std::optional<Error> error_of(std::string_view text) {
  return decode(ascii(text)).error;
}

TEST(Asd7Codec, EveryGoldenFrameIsOneMessageAtItsLastByte) {
  EXPECT_EQ(vectors().size(), 88U);
  for (const auto& v : vectors()) {
    Decoder decoder(is_request(v) ? Direction::kRequest : Direction::kReply);
    EXPECT_EQ(feed(decoder, v.bytes), std::vector{Event::kMessage}) << v.name;
    EXPECT_TRUE(std::ranges::equal(decoder.bytes(), v.bytes)) << v.name;
    EXPECT_TRUE(decoder.idle()) << v.name;
    EXPECT_NE(decoder.message().error, Error::kSum) << v.name;
  }
}

TEST(Asd7Codec, EveryGoldenFrameIsEncodedAgain) {
  for (const auto& v : vectors()) {
    if (v.name.ends_with("padded")) continue;  // fewer digits of data become four
    const Message m = decode(v.bytes, is_request(v) ? Direction::kRequest : Direction::kReply);
    if (is_request(v)) {
      EXPECT_EQ(encode_request(m), v.bytes) << v.name;
    } else if (m.row == &kErrorReply) {
      EXPECT_EQ(encode_error(m, static_cast<Error>(m.values[0]), {m.tripped}), v.bytes) << v.name;
    } else {
      EXPECT_EQ(encode_reply(m, m.values[1], {m.tripped}), v.bytes) << v.name;
    }
  }
}

TEST(Asd7Codec, ARequestsReplyIsTheGoldenOne) {
  const auto reply = [](std::string_view name, std::int64_t value, bool tripped = false) {
    return encode_reply(decode(request(name)), value, {tripped});
  };
  EXPECT_EQ(reply("RFE03", 1915), response("RFE03"));
  EXPECT_EQ(reply("RFD00", 6000), response("RFD00_60"));
  EXPECT_EQ(reply("W1234_padded", 0x12), response("W1234_padded"));
  EXPECT_EQ(reply("W0803_padded", 0), response("W0803_padded"));
  EXPECT_EQ(reply("RFD03", 9000), response("RFD03"));
  EXPECT_EQ(reply("group2_read", 0), response("group2_read"));
  EXPECT_EQ(reply("sum_RFD00", 6000), response("sum_RFD001770"));
  EXPECT_EQ(reply("sum_01RFD00", 6000), response("sum_01RFD001770"));
  EXPECT_EQ(reply("bin_RFD00", 6000), response("bin_RFD00"));
  EXPECT_EQ(reply("bin_01RFD00", 6000), response("bin_01RFD00"));
  EXPECT_EQ(reply("bin_RFE03", 1915), response("bin_RFE03"));
  EXPECT_EQ(reply("bin_RFD01", 3, true), response("bin_RFD01_tripped"));
  EXPECT_EQ(reply("bin_RFC90", 0x18, true), response("bin_RFC90_tripped"));
  EXPECT_EQ(reply("wide_RFD00", 6000), response("wide_RFD00_plus60"));
  EXPECT_EQ(reply("wide_RFD00", -8000), response("wide_RFD00_minus80"));
  EXPECT_EQ(reply("wide_RFD00", 6000, true), response("wide_RFD00_tripped"));
}

TEST(Asd7Codec, ABroadcastIsAnsweredWithZerosForStars) {
  const Message all = decode(request("all"));
  EXPECT_TRUE(all.number->is_broadcast());
  EXPECT_TRUE(all.number->matches(0) && all.number->matches(42));
  EXPECT_EQ(encode_reply(all, 6000, {}), response("all"));
  const Message group = decode(request("group9"));
  EXPECT_TRUE(group.number->matches(9) && group.number->matches(29));
  EXPECT_FALSE(group.number->matches(92));
  EXPECT_EQ(encode_reply(group, 6000, {}), response("group9"));
  EXPECT_EQ(encode_reply(decode(request("bin_all")), 6000, {}), response("bin_all"));
}

TEST(Asd7Codec, ValuesCarryTheirSignAcrossTheWidths) {
  // Excerpt p. 24: -80 Hz is E0C0 in 16 bits and FFFFE0C0 in 32.
  EXPECT_EQ(encode_reply(decode(ascii("(RFD00)")), -8000, {}), ascii("(RFD00E0C0)"));
  EXPECT_EQ(encode_reply(decode(ascii("(RFD16)")), -8000, {}), ascii("(RFD16E0C0)"));
  EXPECT_EQ(decode(ascii("(RFD16E0C0)"), Direction::kReply).values, (Values{0xFD16, -8000}));
  EXPECT_EQ(decode(from_hex("2f 4c 52 fd 16 ff ff e0 c0 7e"), Direction::kReply).values,
            (Values{0xFD16, -8000}));
  // What has no sign keeps bit 15 as a value.
  EXPECT_EQ(decode(request("PFA00_C400")).values, (Values{0xFA00, 0xC400}));
  EXPECT_EQ(decode(request("PFA00_C400")).parameter, &parameter(0xFA00));
}

TEST(Asd7Codec, AValueTooWideForSixteenBitsIsAModeError) {
  const Message speed = decode(from_hex("2f 52 fd 16 94"));
  EXPECT_EQ(encode_reply(speed, 32768, {}), response("bin_error_0"));
  EXPECT_EQ(encode_reply(speed, -32769, {}), response("bin_error_0"));
  EXPECT_EQ(encode_reply(speed, 32768, {.mode_error = Error::kRange}), from_hex("2f 4e 00 01 7e"));
  EXPECT_EQ(encode_reply(decode(request("bin_RFE03")), 65536, {}), response("bin_error_0"));
  EXPECT_EQ(encode_reply(decode(request("wide_RFD00")), 40000, {}),
            from_hex("2f 4c 52 fd 00 00 00 9c 40 a6"));
}

TEST(Asd7Codec, ErrorsHaveTheRequestsFormAndAreLowerCaseWhileTripped) {
  const auto error = [](std::string_view text, Error code, bool tripped) {
    return encode_error(decode(ascii(text)), code, {tripped});
  };
  EXPECT_EQ(error("(RFD00&8A)", Error::kNumber, false), response("error_2"));
  EXPECT_EQ(error("(RFD00&8A)", Error::kNumber, true), response("sum_n0002"));
  EXPECT_EQ(error("(07RFD00&F1)", Error::kRange, false), response("sum_07N0001"));
  EXPECT_EQ(error("(RFD00", Error::kNumber, false), ascii("(N0002"));
  EXPECT_EQ(encode_error(decode(request("wide_RFD00")), Error::kSum, {}), response("bin_error_4"));
  EXPECT_EQ(encode_error(decode(request("bin_RFD00")), Error::kSum, {true}),
            response("bin_error_tripped"));
}

TEST(Asd7Decoder, OptionalPartsAreToldAsTheyCame) {
  const Message bare = decode(ascii("(RFD00"));
  EXPECT_FALSE(bare.number || bare.with_sum || bare.closed);
  const Message full = decode(ascii("(01RFD00&EB)"));
  EXPECT_EQ(full.number, (AsdNumber{.tens = 0, .units = 1}));
  EXPECT_TRUE(full.with_sum && full.closed);
  EXPECT_EQ(full.format, Format::kAscii);
  EXPECT_EQ(decode(request("wide_05PFA01")).format, Format::kBinary32);
  EXPECT_EQ(decode(request("wide_05PFA01")).number, (AsdNumber{.tens = 0, .units = 5}));
}

TEST(Asd7Codec, AnErrorCarriesASumWhereTheRequestHadOneOrAlways) {
  const Message bare = decode(ascii("(R0002"));
  EXPECT_EQ(encode_error(bare, Error::kNumber, {}), ascii("(N0002"));
  EXPECT_EQ(encode_error(bare, Error::kNumber, {.error_sum_always = true}), ascii("(N0002&5E"));
}

TEST(Asd7Codec, WideAsciiIsAnUnknownCommandUntilItIsSwitchedOn) {
  Decoder decoder(Direction::kRequest, true);
  EXPECT_EQ(feed(decoder, ascii("(05LPFA0100001770)")), std::vector{Event::kMessage});
  EXPECT_EQ(decoder.message().format, Format::kAscii32);
  EXPECT_EQ(decoder.message().values, (Values{0xFA01, 6000}));
  EXPECT_EQ(encode_reply(decoder.message(), 6000, {}), ascii("(05LPFA0100001770)"));
  EXPECT_EQ(encode_error(decoder.message(), Error::kRange, {}), ascii("(05N0001)"));
  EXPECT_EQ(feed(decoder, ascii("(LRFD16)")), std::vector{Event::kMessage});
  EXPECT_EQ(encode_reply(decoder.message(), -8000, {}), ascii("(LRFD16FFFFE0C0)"));
  EXPECT_EQ(error_of("(LPFA0100001770)"), Error::kCommand);
}

TEST(Asd7Codec, BinaryHasThreeCommandsThatAsciiLacks) {
  const Message read = decode(request("bin_GFE03"));
  EXPECT_EQ(read.row, &row('G'));
  EXPECT_EQ(encode_reply(read, 1915, {}), response("bin_GFE03"));
  const Message master = decode(request("bin_SFA01"));
  EXPECT_EQ(master.row, &row('S'));
  EXPECT_EQ(master.values, (Values{0xFA01, 5000}));
  EXPECT_EQ(decode(from_hex("2f 73 fa 01 13 88 38")).row, &row('s'));
  for (const char* text : {"(GFE030000)", "(SFA011388)", "(sFA011388)"}) {
    EXPECT_EQ(error_of(text), Error::kCommand) << text;
  }
}

TEST(Asd7Decoder, AWritesDataMayBeShortAndStandToTheRight) {
  EXPECT_EQ(decode(request("W1234_padded")).values, (Values{0x1234, 0x12}));
  EXPECT_EQ(decode(ascii("(PFA015)")).values, (Values{0xFA01, 5}));
}

TEST(Asd7Decoder, TheFirstErrorInTheDrivesOrderIsTheOneToAnswer) {
  EXPECT_EQ(error_of("(RFD00)"), std::nullopt);
  EXPECT_EQ(error_of("(RFD00&8a)"), std::nullopt);
  EXPECT_EQ(error_of("(PFA0112345)"), Error::kRange);
  EXPECT_EQ(error_of("(PFA01)"), Error::kRange);
  EXPECT_EQ(error_of("(R0002)"), Error::kNumber);
  EXPECT_EQ(error_of("(P000212345)"), Error::kNumber);
  EXPECT_EQ(error_of("(XFD00)"), Error::kCommand);
  EXPECT_EQ(error_of("(rFD00)"), Error::kCommand);
  EXPECT_EQ(error_of("(LRFD00)"), Error::kCommand);
  EXPECT_EQ(error_of("(XFD00&00)"), Error::kSum);
  Bytes bad = request("bin_RFD00");
  bad.back() ^= 1;
  EXPECT_EQ(decode(bad).error, Error::kSum);
}

TEST(Asd7Decoder, AFormatErrorIsSilence) {
  for (const char* text :
       {"(1RFD00)", "(R11)", "(RFD0)", "(RFD00]", "(RFD00)x", "(RFD00&8)", "(RFD001770)", "(RFDG0)",
        "()", "(", "(RFD00&)", "(&8A)", "(PFA0112G4)"}) {
    Decoder decoder(Direction::kRequest);
    EXPECT_EQ(feed(decoder, ascii(text)), std::vector{Event::kFormatError}) << text;
    EXPECT_EQ(feed(decoder, request("RFD00")), std::vector{Event::kMessage}) << text;
  }
}

TEST(Asd7Decoder, AParenthesisStartsAnewAndTooLongALineIsDropped) {
  Decoder decoder(Direction::kRequest);
  EXPECT_EQ(feed(decoder, ascii("(PFA0(RFD00)")),
            (std::vector{Event::kFormatError, Event::kMessage}));
  EXPECT_EQ(decoder.message().row, &row('R'));
  const std::string text = "(" + std::string(31, '0');
  EXPECT_EQ(feed(decoder, {text.begin(), text.end()}), std::vector{Event::kFormatError});
  EXPECT_TRUE(decoder.idle());
  EXPECT_EQ(feed(decoder, ascii("\n(RFD00)")), std::vector{Event::kMessage});
}

TEST(Asd7Decoder, AnUnknownBinaryCommandIsDroppedAndTheRestIsNoise) {
  Decoder decoder(Direction::kRequest);
  EXPECT_EQ(feed(decoder, from_hex("2f 58 02 05 c4")),
            (std::vector{Event::kUnknownCommand, Event::kNoise, Event::kNoise, Event::kNoise}));
  EXPECT_EQ(feed(decoder, request("bin_RFD00")), std::vector{Event::kMessage});
}

TEST(Asd7Decoder, ACutBinaryMessageWaitsUntilItIsReset) {
  Decoder decoder(Direction::kRequest);
  EXPECT_TRUE(feed(decoder, from_hex("2f 50 fa 01 17")).empty());
  EXPECT_FALSE(decoder.idle());
  decoder.reset();
  EXPECT_EQ(feed(decoder, request("bin_RFD00")), std::vector{Event::kMessage});
}

TEST(Asd7Decoder, AnyBytesAreTakenAndAResetBringsItBack) {
  RandomStream random = Seed{1}.stream("noise");
  constexpr std::string_view kAlphabet = "(()/&*0189AFRWPLNnX\r\n";
  for (const Direction direction : {Direction::kRequest, Direction::kReply}) {
    Decoder decoder(direction);
    for (int round = 0; round < 2000; ++round) {
      for (int i = 0; i < 100; ++i) {
        const std::uint64_t bits = random.bits();
        const char c = kAlphabet[bits % kAlphabet.size()];
        decoder.push(static_cast<std::uint8_t>(round % 2 == 0 ? bits >> 8 : c));
      }
      decoder.reset();
      const Bytes frame =
          direction == Direction::kRequest ? request("RFD00") : response("RFD00_60");
      ASSERT_EQ(feed(decoder, frame), std::vector{Event::kMessage});
    }
  }
}

}  // namespace
}  // namespace virtdrive::asd7
