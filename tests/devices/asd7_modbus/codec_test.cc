#include "devices/asd7_modbus/codec.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "devices/asd7_modbus/framer.h"
#include "devices/protocol/checksum.h"
#include "tests/devices/vectors.h"

namespace virtdrive::asd7_modbus {
namespace {

using protocol::Direction;
using protocol::Values;
using Bytes = std::vector<std::uint8_t>;

const std::vector<Vector>& vectors() {
  static const auto all = read_vectors("vectors_asd7_modbus.csv");
  return all;
}
const CommandRow& row(std::uint16_t code) {
  return *protocol::find(kTable.commands, code);
}
Direction direction_of(const Vector& vector) {
  return is_request(vector) ? Direction::kRequest : Direction::kReply;
}

TEST(Asd7ModbusCodec, EveryGoldenFrameIsDecodedAndEncodedAgain) {
  EXPECT_EQ(vectors().size(), 8U);
  for (const Vector& v : vectors()) {
    Frame frame;
    ASSERT_EQ(decode(direction_of(v), v.bytes, frame), FrameError::kNone) << v.name;
    EXPECT_EQ(expected_size(direction_of(v), v.bytes), v.bytes.size()) << v.name;
    const auto function = static_cast<std::uint8_t>(frame.function & 0x7F);
    const Bytes again = frame.exception ? encode_exception(frame.unit, function,
                                                           static_cast<Exception>(*frame.exception))
                        : is_request(v) ? encode_request(frame.unit, *frame.row, *frame.values)
                                        : encode_reply(frame.unit, *frame.row, *frame.values);
    EXPECT_EQ(again, v.bytes) << v.name;
  }
}

TEST(Asd7ModbusCodec, AFrameTellsItsUnitFunctionAndValues) {
  Frame frame;
  decode(Direction::kRequest, golden_frame(vectors(), "write_60Hz", "request"), frame);
  EXPECT_EQ(frame.unit, 1);
  EXPECT_EQ(frame.row, &row(kWrite));
  EXPECT_EQ(frame.values, (Values{0xFA01, 6000}));
  decode(Direction::kReply, golden_frame(vectors(), "read_two", "response"), frame);
  EXPECT_EQ(frame.exception, 3);
  EXPECT_EQ(frame.row, &row(kRead));
}

TEST(Asd7ModbusCodec, OneWrongBitIsAWrongCrc) {
  const Bytes good = golden_frame(vectors(), "read_60Hz", "request");
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    Frame frame;
    EXPECT_EQ(decode(Direction::kRequest, bad, frame), FrameError::kCrc);
  }
}

TEST(Asd7ModbusCodec, WhatHasAnotherLengthHasNoValues) {
  Bytes frame_bytes = {1, kRead, 0xFD, 0x00, 0x00};
  const std::uint16_t crc = protocol::crc16_modbus(frame_bytes);
  frame_bytes.push_back(static_cast<std::uint8_t>(crc));
  frame_bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
  Frame frame;
  EXPECT_EQ(decode(Direction::kRequest, frame_bytes, frame), FrameError::kNone);
  EXPECT_FALSE(frame.values);
  EXPECT_EQ(decode(Direction::kRequest, std::span(frame_bytes).first(3), frame),
            FrameError::kTooShort);
}

TEST(Asd7ModbusFramer, CutsAConversationIntoFrames) {
  const auto framer = make_framer();
  std::vector<protocol::Run> runs;
  for (const Vector& v : vectors()) {
    for (const std::uint8_t byte : v.bytes) framer->push(direction_of(v), byte, runs);
  }
  ASSERT_EQ(runs.size(), vectors().size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(runs[i].verdict, protocol::Verdict::kFrame);
    EXPECT_EQ(runs[i].size, vectors()[i].bytes.size());
  }
  runs.clear();
  for (const int byte : {1, 3, 0xFD}) {
    framer->push(Direction::kRequest, static_cast<std::uint8_t>(byte), runs);
  }
  framer->expire(Direction::kRequest, runs);
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].verdict, protocol::Verdict::kCutShort);
}

}  // namespace
}  // namespace virtdrive::asd7_modbus
