#include "devices/protocol/payload.h"

#include <gtest/gtest.h>

namespace virtdrive::protocol {
namespace {

constexpr Field kPair[] = {{.name = "id"}, {.name = "value", .type = WireType::kI16}};
constexpr Field kFields[] = {
    {.name = "nr"},
    {.name = "pair", .count = 2, .members = kPair},
    {.name = "speed", .type = WireType::kI32, .unit = "Hz", .scale = 0.01}};

TEST(Payload, GroupsAndRepetitionsLieInWireOrder) {
  EXPECT_EQ(width(kFields), 11U);
  EXPECT_EQ(values(kFields), 6U);
  std::vector<std::uint8_t> bytes;
  pack(kFields, ByteOrder::kLittleEndian, {1, 2, -2, 3, 0x1234, -1}, bytes);
  EXPECT_EQ(bytes,
            (std::vector<std::uint8_t>{1, 2, 0xFE, 0xFF, 3, 0x34, 0x12, 0xFF, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(unpack(kFields, ByteOrder::kLittleEndian, bytes), (Values{1, 2, -2, 3, 0x1234, -1}));
}

TEST(Payload, BigEndianIsTheOtherWayRound) {
  std::vector<std::uint8_t> bytes(4);
  store(bytes, WireType::kI32, ByteOrder::kBigEndian, -8000);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0xFF, 0xFF, 0xE0, 0xC0}));
  EXPECT_EQ(load(bytes, WireType::kI32, ByteOrder::kBigEndian), -8000);
  EXPECT_EQ(load(bytes, WireType::kU32, ByteOrder::kBigEndian), 0xFFFFE0C0);
}

TEST(Payload, EveryWidthKeepsItsEdges) {
  const auto round_trip = [](WireType type, std::int64_t value) {
    std::vector<std::uint8_t> bytes(width(type));
    store(bytes, type, ByteOrder::kLittleEndian, value);
    return load(bytes, type, ByteOrder::kLittleEndian);
  };
  EXPECT_EQ(round_trip(WireType::kU8, 255), 255);
  EXPECT_EQ(round_trip(WireType::kI8, -128), -128);
  EXPECT_EQ(round_trip(WireType::kI16, INT16_MIN), INT16_MIN);
  EXPECT_EQ(round_trip(WireType::kU16, UINT16_MAX), UINT16_MAX);
  EXPECT_EQ(round_trip(WireType::kI32, INT32_MIN), INT32_MIN);
  EXPECT_EQ(round_trip(WireType::kU32, UINT32_MAX), UINT32_MAX);
  EXPECT_EQ(round_trip(WireType::kU8, 256), 0) << "upper bits are lost, as in a C structure";
}

TEST(Payload, DescribesValuesInTheirUnits) {
  EXPECT_EQ(describe(kFields, {1, 2, -2, 3, 4, 6000}),
            "nr=1 id=2 value=-2 id=3 value=4 speed=60Hz");
}

}  // namespace
}  // namespace virtdrive::protocol
