#include "devices/asd7_modbus/device.h"

#include <gtest/gtest.h>

#include "devices/asd7_modbus/client.h"
#include "devices/protocol/checksum.h"
#include "tests/devices/asd7/line_rig.h"
#include "tests/devices/vectors.h"

namespace virtdrive::asd7_modbus {
namespace {

using namespace std::chrono_literals;
using asd7::Bytes;
using asd7::ModbusRig;

const std::vector<Vector>& vectors() {
  static const auto all = read_vectors("vectors_asd7_modbus.csv");
  return all;
}
Bytes request(std::string_view name) {
  return golden_frame(vectors(), name, "request");
}
Bytes response(std::string_view name) {
  return golden_frame(vectors(), name, "response");
}
Bytes frame(Bytes bytes) {
  const std::uint16_t crc = protocol::crc16_modbus(bytes);
  bytes.push_back(static_cast<std::uint8_t>(crc));
  bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
  return bytes;
}

TEST(Asd7ModbusDevice, AnswersThePrintedFrames) {
  ModbusRig rig;
  for (const char* name : {"read_two", "write_60Hz", "no_number"}) {
    EXPECT_EQ(rig.ask(request(name)), response(name)) << name;
  }
  rig.ask(frame({1, kWrite, 0x00, 0x09, 0x00, 0x14}));
  rig.ask(frame({1, kWrite, 0xFA, 0x00, 0xC4, 0x00}));
  rig.run(3s);
  EXPECT_EQ(rig.ask(request("read_60Hz")), response("read_60Hz"));
}

TEST(Asd7ModbusDevice, EachExceptionHasItsCause) {
  ModbusRig rig;
  const auto exception = [](std::uint8_t function, std::uint8_t code) {
    return frame({1, static_cast<std::uint8_t>(function | 0x80), code});
  };
  EXPECT_EQ(rig.ask(frame({1, 0x04, 0xFD, 0x00, 0x00, 0x01})), exception(0x04, 1));
  EXPECT_EQ(rig.ask(frame({1, kRead, 0x00, 0x02, 0x00, 0x01})), exception(kRead, 2));
  EXPECT_EQ(rig.ask(frame({1, kRead, 0x00, 0x09, 0x00, 0x00})), exception(kRead, 3));
  EXPECT_EQ(rig.ask(frame({1, kWrite, 0xFA, 0x01, 0xFF, 0xFF})), exception(kWrite, 3));
  EXPECT_EQ(rig.ask(frame({1, kWrite, 0xFD, 0x00, 0x00, 0x00})), exception(kWrite, 4));
  EXPECT_EQ(rig.ask(frame({1, kRead, 0x00, 0x09})), exception(kRead, 3));
}

TEST(Asd7ModbusDevice, WritesGoIntoTheEepromBySixAndBySixteen) {
  ModbusRig rig;
  EXPECT_EQ(rig.ask(frame({1, kWrite, 0x00, 0x09, 0x00, 0x32})),
            frame({1, kWrite, 0x00, 0x09, 0x00, 0x32}));
  EXPECT_EQ(rig.ask(frame({1, kWriteSome, 0x00, 0x10, 0x00, 0x01, 0x02, 0x00, 0x19})),
            frame({1, kWriteSome, 0x00, 0x10, 0x00, 0x01}));
  EXPECT_EQ(rig.eeprom.parameters().settings.acceleration1, 50);
  EXPECT_EQ(rig.eeprom.parameters().settings.deceleration1, 25);
  EXPECT_EQ(rig.ask(frame({1, kWriteSome, 0x00, 0x10, 0x00, 0x02, 0x02, 0x00, 0x19})),
            frame({1, 0x90, 3}));
}

TEST(Asd7ModbusDevice, OtherUnitsWrongCrcsAndBroadcastsAreSilence) {
  ModbusRig rig;
  EXPECT_TRUE(rig.ask(frame({2, kRead, 0x00, 0x09, 0x00, 0x01})).empty());
  Bytes wrong = request("read_60Hz");
  wrong.back() ^= 1;
  EXPECT_TRUE(rig.ask(wrong).empty());
  EXPECT_TRUE(rig.ask({1}).empty());
  EXPECT_TRUE(rig.ask(frame({0, kRead, 0x00, 0x09, 0x00, 0x01})).empty());
  EXPECT_TRUE(rig.ask(frame({0, kWrite, 0xFA, 0x01, 0x17, 0x70})).empty());
  EXPECT_EQ(rig.drive.frequency(), 6000);
  EXPECT_TRUE(rig.ask(frame({0, kWrite, 0x00, 0x02, 0x00, 0x00})).empty());
}

TEST(Asd7ModbusDevice, ThreeAndAHalfCharactersOfSilenceEndAFrame) {
  const Bytes whole = frame({1, kRead, 0x00, 0x09, 0x00, 0x01});
  const auto split_with = [&](SimDuration pause) {
    ModbusRig rig;
    rig.write(std::span(whole).first(4));
    rig.run(pause);
    return rig.ask(Bytes(whole.begin() + 4, whole.end()));
  };
  // The next character takes one of the three and a half.
  EXPECT_FALSE(split_with(ModbusRig::kCharacter * 2).empty());
  EXPECT_TRUE(split_with(ModbusRig::kCharacter * 3).empty());
  ModbusRig rig;
  Bytes two = whole;
  two.insert(two.end(), whole.begin(), whole.end());
  EXPECT_TRUE(rig.ask(two).empty());
  EXPECT_EQ(rig.ask(whole), frame({1, kRead, 2, 0x00, 0x64}));
}

TEST(Asd7ModbusDevice, EveryRegisterIsReadAsTheOwnProtocolReadsIt) {
  ModbusRig rig({.reply_time = 1ms});
  Client client(rig);
  std::size_t read = 0;
  for (const ParameterRow& row : kTable.parameters) {
    if (row.support == protocol::Support::kRejected) {
      EXPECT_THROW(client.read(row), DriveRefused) << row.name;
      continue;
    }
    EXPECT_EQ(client.read(row), rig.station.registers().read(row.id).value) << row.name;
    ++read;
  }
  EXPECT_GT(read, 180U);
}

TEST(Asd7ModbusDevice, ASignedRegisterIsATwosComplement) {
  ModbusRig rig;
  Client client(rig);
  const auto row = [](std::uint16_t id) -> const ParameterRow& {
    return *protocol::find(kTable.parameters, id);
  };
  client.write(row(0x0009), 20);
  client.write(row(0xFA01), 6000);
  client.write(row(0xFA00), 0xC600);
  rig.run(4s);
  EXPECT_LT(client.read(row(0xFD16)), -5000);
  EXPECT_EQ(client.read(row(0xFD00)), 6000);
}

TEST(Asd7ModbusDevice, ATripIsReadAndAResetIsSilent) {
  ModbusRig rig;
  rig.ask(frame({1, kWrite, 0xFA, 0x00, 0x90, 0x00}));
  EXPECT_EQ(rig.ask(frame({1, kRead, 0xFC, 0x90, 0x00, 0x01})), frame({1, kRead, 2, 0x00, 0x11}));
  EXPECT_TRUE(rig.ask(frame({1, kWrite, 0xFA, 0x00, 0x20, 0x00}), 1s).empty());
  rig.run(2s);
  EXPECT_EQ(rig.ask(frame({1, kRead, 0xFC, 0x90, 0x00, 0x01})), frame({1, kRead, 2, 0x00, 0x00}));
}

}  // namespace
}  // namespace virtdrive::asd7_modbus
