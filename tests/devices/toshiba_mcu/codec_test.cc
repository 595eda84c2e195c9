#include "devices/toshiba_mcu/codec.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/devices/vectors.h"

namespace virtdrive::toshiba_mcu {
namespace {

using Event = Decoder::Event;

std::vector<Event> push_all(Decoder& decoder, const std::vector<std::uint8_t>& bytes) {
  std::vector<Event> events;
  for (const std::uint8_t byte : bytes) events.push_back(decoder.push(byte));
  return events;
}

// Vectors that are wrong on purpose, and the high-speed oscilloscope's frames, which are another
// format.
bool is_no_telegram(const std::string& name) {
  return name.ends_with("_as_printed") || name.ends_with("_badcrc") || name.ends_with("_badeot") ||
         name.ends_with("_truncated") || name.starts_with("7F_") || name.starts_with("HsDSO");
}

TEST(ToshibaMcuCodec, EveryGoldenVectorDecodesAndEncodesToTheByte) {
  const auto vectors = read_vectors("vectors_toshiba_mcu.csv");
  ASSERT_GT(vectors.size(), 100U);
  std::size_t checked = 0;
  for (const Vector& vector : vectors) {
    if (is_no_telegram(vector.name)) continue;
    SCOPED_TRACE(vector.name + " " + vector.direction);
    const bool request = vector.direction == "request";
    Decoder decoder(request ? Direction::kRequest : Direction::kReply);
    const auto events = push_all(decoder, vector.bytes);
    ASSERT_EQ(events.back(), Event::kTelegram);
    const Telegram& telegram = decoder.telegram();
    EXPECT_EQ(request ? encode_request(*telegram.row, telegram.values)
                      : encode_reply(*telegram.row, telegram.values),
              vector.bytes);
    ++checked;
  }
  EXPECT_EQ(checked, vectors.size() - 6);
}

TEST(ToshibaMcuCodec, TheVectorsCoverEveryCommandOfTheTable) {
  const auto vectors = read_vectors("vectors_toshiba_mcu.csv");
  for (const CommandRow& row : kCommands) {
    const bool covered = std::ranges::any_of(vectors, [&](const Vector& vector) {
      return vector.direction == "request" && vector.bytes.size() > 1 &&
             vector.bytes[1] == row.code;
    });
    EXPECT_TRUE(covered) << row.name;
  }
}

// Chapter 6 prints this table; these are entries that the scan left readable in each row.
TEST(ToshibaMcuCodec, Crc8IsPolynomial07) {
  const auto entry = [](std::uint8_t i) { return crc8(0, std::span(&i, 1)); };
  EXPECT_EQ(entry(1), 0x07);
  EXPECT_EQ(entry(15), 0x2d);
  EXPECT_EQ(entry(31), 0x5d);
  EXPECT_EQ(entry(64), 0xc7);
  EXPECT_EQ(entry(128), 0x89);
  EXPECT_EQ(entry(255), 0xf3);
}

TEST(ToshibaMcuCodec, TheValuesOfTheDocumentsExamples) {
  Decoder decoder(Direction::kReply);
  push_all(decoder,
           from_hex("11 02 f1 01 00 00 f4 01 00 00 3c 00 00 00 cc 00 00 00 ea 21 01 00 43 13"));
  EXPECT_EQ(decoder.telegram().values, (protocol::Values{497, 500, 60, 204, 74218}));  // 4.2.3

  push_all(decoder, from_hex("11 09 fd ff ff ff 00 ab 13"));
  EXPECT_EQ(decoder.telegram().values, (protocol::Values{-3, 0}));
}

TEST(ToshibaMcuDecoder, TellsEachWayInWhichATelegramGoesWrong) {
  Decoder decoder(Direction::kRequest);
  EXPECT_EQ(push_all(decoder, from_hex("11 00 01 06 13")).back(), Event::kBadCrc);
  EXPECT_EQ(push_all(decoder, from_hex("11 00 01 07 12")).back(), Event::kBadEnd);
  EXPECT_EQ(push_all(decoder, from_hex("11 7f")).back(), Event::kUnknownCommand);
  EXPECT_TRUE(decoder.idle());
  EXPECT_EQ(push_all(decoder, from_hex("01 7d 13")),
            (std::vector{Event::kNoise, Event::kNoise, Event::kNoise}));
  EXPECT_EQ(push_all(decoder, from_hex("11 00 01 07 13")).back(), Event::kTelegram);
}

TEST(ToshibaMcuDecoder, StartAndEndBytesInsideAPayloadAreOrdinaryData) {
  const auto bytes = encode_request(*protocol::find(kTable.commands, 0x09), {0x11, 0x13, 0x11});
  Decoder decoder(Direction::kRequest);
  EXPECT_EQ(push_all(decoder, bytes).back(), Event::kTelegram);
  EXPECT_EQ(decoder.telegram().values, (protocol::Values{0x11, 0x13, 0x11}));
}

TEST(ToshibaMcuDecoder, ACutTelegramSwallowsTheBytesOfTheNext) {
  Decoder decoder(Direction::kRequest);
  push_all(decoder, from_hex("11 00"));
  // 11 is taken as the motor number, 00 as the CRC (which does not fit), 01 as the end byte.
  const auto events = push_all(decoder, from_hex("11 00 01 07 13"));
  EXPECT_EQ(events, (std::vector{Event::kNone, Event::kNone, Event::kBadEnd, Event::kNoise,
                                 Event::kNoise}));
}

TEST(ToshibaMcuDecoder, AnErrorTelegramTakesThePlaceOfAnyReply) {
  Decoder decoder(Direction::kReply);
  EXPECT_EQ(push_all(decoder, from_hex("11 ee fe 70 13")).back(), Event::kTelegram);
  EXPECT_EQ(decoder.telegram().row, &kErrorReply);
  EXPECT_EQ(decoder.telegram().values[0], -2);
  Decoder drive(Direction::kRequest);
  EXPECT_EQ(push_all(drive, from_hex("11 ee")).back(), Event::kUnknownCommand);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
