#include "devices/md485/device.h"

#include <gtest/gtest.h>

#include "devices/md485/client.h"
#include "devices/protocol/binding.h"
#include "devices/protocol/checksum.h"
#include "tests/devices/md485/line_rig.h"

namespace virtdrive::md485 {
namespace {

using namespace std::chrono_literals;

std::int64_t word(const Bytes& bytes, std::size_t at) {
  return protocol::load(std::span(bytes).subspan(at, 2), WireType::kI16,
                        protocol::ByteOrder::kLittleEndian);
}
std::int64_t dword(const Bytes& bytes, std::size_t at) {
  return protocol::load(std::span(bytes).subspan(at, 4), WireType::kI32,
                        protocol::ByteOrder::kLittleEndian);
}
Bytes le16(int value) {
  return {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8)};
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// --- Answers and silence -------------------------------------------------------------------------

TEST(Md485Device, AnAnswerGoesToTheNumberThatAskedFor) {
  LineRig rig;
  for (const std::uint8_t host : Bytes{172, 184, 128}) {
    const Bytes reply = rig.ask(LineRig::frame(4, {1}, 1, host));
    ASSERT_EQ(reply.size(), 7U);
    EXPECT_EQ((Bytes(reply.begin(), reply.end() - 1)), (Bytes{host, 183, 1, 1, 1, 44}));
    EXPECT_EQ(protocol::sum8(reply), 0);
  }
}

TEST(Md485Device, AnAnswerLeavesTwoMillisecondsAfterTheRequest) {
  LineRig rig;
  rig.write(LineRig::frame(4, {1}));
  const SimTime asked = rig.rig.loop.now();
  ASSERT_TRUE(rig.read(20ms));
  EXPECT_EQ(rig.rig.loop.now() - asked, 2ms + LineRig::kCharacter);
}

TEST(Md485Device, MainDataHasSeventeenBytesAndSixteenByTheDocument) {
  LineRig today("md200t");
  EXPECT_EQ(today.data(193)->size(), 17U);
  EXPECT_EQ(today.data(200)->size(), 17U);
  EXPECT_EQ(today.data(197)->size(), 8U);
  LineRig strict("md200t", Profile::kStrict);
  EXPECT_EQ(strict.data(193)->size(), 16U);
  EXPECT_EQ(strict.data(200)->size(), 16U);
  EXPECT_EQ(strict.data(197)->size(), 4U);
  LineRig single;
  EXPECT_EQ(single.data(197)->size(), 4U);
}

TEST(Md485Device, BlocksHaveTheSizesThatHostsCountOn) {
  LineRig rig("md400t");
  const std::pair<std::uint8_t, std::size_t> sizes[] = {
      {194, 17}, {196, 12}, {201, 12}, {202, 17}, {210, 18}, {216, 14},
      {203, 6},  {222, 4},  {225, 3},  {226, 5},  {227, 9},  {239, 4},
      {250, 4},  {133, 1},  {137, 1},  {149, 1},  {143, 2},  {1, 1}};
  for (const auto& [pid, size] : sizes) EXPECT_EQ(rig.data(pid)->size(), size) << int{pid};
}

TEST(Md485Device, TheTypeIsItsNameWithoutAnEnd) {
  for (const md::Model& model : md::models()) {
    LineRig rig(model.name);
    const auto text = rig.data(205);
    ASSERT_TRUE(text);
    EXPECT_EQ(std::string(text->begin(), text->end()), std::string(model.title) + "-V4.4");
  }
}

TEST(Md485Device, CommandsWritesAndUnknownPidsAreNotAnswered) {
  LineRig rig;
  EXPECT_EQ(rig.send(130, le16(500)), Bytes{});
  EXPECT_EQ(rig.send(153, le16(100)), Bytes{});
  EXPECT_EQ(rig.send(12, {0}), Bytes{});
  EXPECT_EQ(rig.send(99, {0}), Bytes{});
  for (const std::uint8_t pid :
       Bytes{2, 3, 5, 6, 7, 10, 12, 13, 30, 100, 130, 140, 207, 217, 243, 251}) {
    EXPECT_FALSE(rig.data(pid)) << int{pid};
  }
  EXPECT_TRUE(rig.data(1));
}

TEST(Md485Device, AWriteToWhatIsOnlyReadIsLeftAlone) {
  LineRig rig;
  EXPECT_EQ(rig.send(210, {0}), Bytes{});
  EXPECT_EQ(rig.send(1, {9}), Bytes{});
  EXPECT_EQ(*rig.data(1), Bytes{44});
}

TEST(Md485Device, ItListensToItsIdAndTo254Only) {
  LineRig rig;
  for (const std::uint8_t id : Bytes{0, 2, 253, 255}) EXPECT_FALSE(rig.data(1, id)) << int{id};
  const Bytes reply = rig.send(4, {1}, 254);
  ASSERT_EQ(reply.size(), 7U);
  EXPECT_EQ(reply[2], 1);  // its own ID
}

TEST(Md485Device, NumMayBeZeroWhereTheDataDoNotMatter) {
  LineRig rig;
  rig.send(217, {100, 0, 0, 0});
  EXPECT_EQ(dword(*rig.data(197), 0), 100);
  rig.send(13, {});
  EXPECT_EQ(dword(*rig.data(197), 0), 0);
}

TEST(Md485Device, ReturnTypeAnswersCommandsAndWritesButNotToAll) {
  LineRig rig;
  const auto pid_of = [](const Bytes& reply) { return reply.size() > 3 ? int{reply[3]} : 0; };
  rig.send(149, {0xAA, 2});
  const Bytes ack = rig.send(130, le16(0));
  EXPECT_EQ((Bytes(ack.begin(), ack.end() - 1)), (Bytes{172, 183, 1, 7, 1, 130}));
  EXPECT_EQ(pid_of(rig.send(153, le16(10))), 7);
  EXPECT_EQ(rig.send(130, le16(0), 254), Bytes{});
  EXPECT_EQ(pid_of(rig.send(149, {0xAA, 1})), 196);
  EXPECT_EQ(pid_of(rig.send(130, le16(0))), 196);
  rig.send(149, {0xAA, 3});
  EXPECT_EQ(pid_of(rig.send(5, {0})), 194);
  rig.send(149, {0xAA, 0});
  EXPECT_EQ(rig.send(5, {0}), Bytes{});
}

// --- Settings ------------------------------------------------------------------------------------

TEST(Md485Device, AnIdIsWrittenBehindItsCheckAndCountsAtOnce) {
  LineRig rig;
  rig.send(133, {0x55, 7}, 254);
  EXPECT_EQ(*rig.data(133), Bytes{1});
  rig.send(133, {0xAA, 0}, 254);
  rig.send(133, {0xAA, 254}, 254);
  EXPECT_EQ(*rig.data(133), Bytes{1});
  rig.send(133, {0xAA, 7}, 254);
  EXPECT_FALSE(rig.data(133));
  EXPECT_EQ(*rig.data(133, 7), Bytes{7});
}

TEST(Md485Device, NumbersOutOfRangeGoToItsEndAndNamesAreNotTaken) {
  LineRig rig;
  rig.send(153, le16(2000));
  EXPECT_EQ(word(*rig.data(153), 0), 1023);
  rig.send(211, le16(30000));
  EXPECT_EQ(word(*rig.data(211), 0), 300);  // 150 % of 20 A
  rig.send(24, {6});
  EXPECT_EQ(*rig.data(24), Bytes{0});
  rig.send(25, {4});
  EXPECT_EQ(*rig.data(25), Bytes{0});
}

TEST(Md485Device, RowsOfPid225To227AreAskedForByTheirNumber) {
  LineRig rig;
  rig.send(225, Bytes{3} + le16(-700));
  const Bytes third = rig.send(164, {225, 3});
  ASSERT_EQ(third.size(), 9U);
  EXPECT_EQ(third[5], 3);
  EXPECT_EQ(word(third, 6), -700);
  EXPECT_EQ(word(rig.send(164, {225, 7}), 6), 3000);
  EXPECT_EQ((*rig.data(225))[0], 1);
  EXPECT_EQ(rig.send(164, {225, 8}), Bytes{});
  EXPECT_EQ(rig.send(164, {193, 1}), Bytes{});
}

TEST(Md485Device, WhatWasWrittenIsThereAfterThePowerCameBack) {
  LineRig rig;
  rig.send(221, le16(1234));
  rig.send(226, Bytes{2} + le16(300) + le16(400));
  rig.send(180, le16(800));
  const md::Settings kept = stored_settings(rig.rig.model, rig.memory);
  EXPECT_EQ(kept.max_rpm, 1234);
  EXPECT_EQ(kept.curve[1].y, 400);
}

TEST(Md485Device, DamagedSettingsAreToldAndReplacedByTheModelsOwn) {
  LineRig rig;
  rig.send(221, le16(1234));
  std::vector<std::string> notes;
  const auto note = [&](std::string_view text) { notes.emplace_back(text); };
  EXPECT_EQ(stored_settings(rig.rig.model, rig.memory, note).max_rpm, 1234);
  EXPECT_TRUE(notes.empty());
  EXPECT_EQ(stored_settings(md::model_named("md200"), rig.memory, note).max_rpm, 3000);
  const auto good = *rig.memory.read("settings");
  for (const std::size_t size : {std::size_t{0}, good.size() / 2}) {
    rig.memory.write("settings", std::span(good).first(size));
    EXPECT_EQ(stored_settings(rig.rig.model, rig.memory, note).max_rpm, 3000);
  }
  for (std::size_t at = 0; at < good.size(); at += 7) {
    auto block = good;
    block[at] ^= 1;
    rig.memory.write("settings", block);
    EXPECT_EQ(stored_settings(rig.rig.model, rig.memory, note).max_rpm, 3000) << at;
  }
  EXPECT_EQ(notes.front(),
            "the stored settings are of another model or version: md200 starts with its own");
  EXPECT_EQ(notes.back(), "the stored settings are damaged: md400 starts with its own");
  EXPECT_EQ(notes.size(), 1 + 2 + (good.size() + 6) / 7);
}

TEST(Md485Device, WhoDrivesAtPowerUpIsASetting) {
  LineRig rig;
  rig.rig.pins().cw = false;
  rig.rig.pins().speed_v = 2.5;
  rig.rig.run_for(1s);
  EXPECT_GT(rig.rig.speed_rpm(), 500);
  rig.send(78, {1});
  EXPECT_TRUE(rig.rig.controller->frames_drive());
  rig.send(78, {0});
  EXPECT_FALSE(rig.rig.controller->frames_drive());
  md::Settings settings = rig.rig.controller->settings();
  settings.ui_com = 1;
  EventLoop loop;
  md::Controller other(loop, {}, rig.rig.model, settings, Seed{1});
  EXPECT_TRUE(other.frames_drive());
}

TEST(Md485Device, TheDefaultSettingLeavesIdAndBaudRate) {
  LineRig rig;
  rig.send(221, le16(1234));
  rig.send(135, {0xAA, 4});
  rig.send(133, {0xAA, 9});
  rig.send(3, {0x54}, 9);
  EXPECT_EQ(word(*rig.data(221, 9), 0), 1234);
  rig.send(3, {0x55}, 9);
  EXPECT_EQ(word(*rig.data(221, 9), 0), 3000);
  EXPECT_EQ(*rig.data(135, 9), Bytes{4});
}

TEST(Md485Device, TheNextFrameWaitsForTheFlash) {
  LineRig rig;
  const Bytes both = LineRig::frame(153, le16(10)) + LineRig::frame(4, {153});
  rig.write(both);
  const SimTime heard = rig.rig.loop.now();
  ASSERT_TRUE(rig.read(50ms));
  // The write began one request before; its 5 ms are over, the answer's 2 ms are not.
  EXPECT_GE(rig.rig.loop.now() - heard, 2ms);
  Bytes burst;
  for (int i = 0; i < 3; ++i) burst = burst + LineRig::frame(153, le16(i));
  const std::string before = rig.log;
  for (const std::uint8_t byte : burst + LineRig::frame(4, {153})) rig.device.receive(byte);
  const SimTime burst_end = rig.rig.loop.now();
  Bytes reply;
  while (const auto byte = rig.read(50ms)) reply.push_back(*byte);
  EXPECT_EQ(word(reply, reply.size() - 3), 2);
  EXPECT_GE(rig.rig.loop.now() - burst_end, 17ms);
}

TEST(Md485Device, WhatNothingActsOnIsNotedOnce) {
  LineRig rig;
  rig.send(45, {1});
  rig.send(45, {0});
  rig.send(24, {1});
  EXPECT_EQ(rig.notes,
            (std::vector<std::string>{"PID_BLUETOOTH is stored, but nothing acts on it"}));
}

TEST(Md485Device, AStartUpAsHostsOfTodayDoItIsTaken) {
  LineRig rig("md400t");
  rig.send(84, {1});
  rig.send(16, {1});
  rig.send(18, {0});
  rig.send(17, {0});
  rig.send(185, le16(10) + le16(0));  // some write two words
  rig.send(46, {0});
  rig.send(21, {2});
  rig.send(10, {61});
  rig.send(10, {62});
  EXPECT_EQ(*rig.data(16), Bytes{1});
  EXPECT_EQ(word(*rig.data(185), 0), 10);
  EXPECT_EQ(rig.device.counters().bad_frames, 0U);
  LineRig strict("md400t", Profile::kStrict);
  strict.send(185, le16(10));
  EXPECT_FALSE(strict.data(185));
}

TEST(Md485Client, AValueThatIsNotTakenIsARefusal) {
  LineRig rig;
  Client client(rig);
  const auto row = [](std::uint16_t pid) -> const ParameterRow& {
    return *protocol::find(kTable.parameters, pid);
  };
  client.set(row(221), {1500});
  client.set(row(225), {3, -700});
  client.set(row(137), {4});
  client.set(row(203), {10, 400, 500});
  const auto held = [&](std::uint16_t pid, const protocol::Values& values) -> std::int64_t {
    try {
      client.set(row(pid), values);
    } catch (const DriveRefused& refused) {
      return refused.code();
    }
    return -1;
  };
  EXPECT_EQ(held(153, {2000}), 1023);
  EXPECT_EQ(held(24, {6}), 0);
  EXPECT_EQ(held(222, {100, 300}), 512);
  EXPECT_EQ(held(133, {254}), 1);
  EXPECT_EQ(held(133, {255}), 1);
  client.set(row(133), {9});
  EXPECT_EQ(client.id(), 9);
  EXPECT_EQ(client.read(row(221))[0], 1500);
  EXPECT_THROW(client.read(row(200)), DriveSilent);
}

// --- Two motors ----------------------------------------------------------------------------------

TEST(Md485Device, ATwoMotorCommandIsAnsweredAsItsLastByteSays) {
  LineRig rig("md400t");
  const Bytes speeds = Bytes{1} + le16(0) + Bytes{1} + le16(0);
  EXPECT_EQ(rig.send(207, speeds + Bytes{0}), Bytes{});
  EXPECT_EQ(rig.send(207, speeds), Bytes{});  // six bytes: the return type is 0
  const Bytes monitor = rig.send(207, speeds + Bytes{1});
  ASSERT_EQ(monitor.size(), 6U + 14U);
  EXPECT_EQ(monitor[3], 216);
  const Bytes main = rig.send(207, speeds + Bytes{2});
  ASSERT_EQ(main.size(), 6U + 18U);
  EXPECT_EQ(main[3], 210);
  EXPECT_EQ(rig.send(207, speeds + Bytes{3}), Bytes{});
}

TEST(Md485Device, AMotorWhoseByteIsZeroKeepsWhatItDoes) {
  LineRig rig("md400t");
  rig.send(207, Bytes{1} + le16(600) + Bytes{1} + le16(-600) + Bytes{0});
  rig.send(207, Bytes{0} + le16(0) + Bytes{1} + le16(300) + Bytes{0});
  rig.rig.run_for(2s);
  EXPECT_NEAR(rig.rig.speed_rpm(0), 600, 15);
  EXPECT_NEAR(rig.rig.speed_rpm(1), 300, 15);
}

TEST(Md485Device, ASingleControllerActsOnTheHalfWithItsId) {
  LineRig rig;
  rig.send(133, {0xAA, 2}, 254);
  rig.send(207, Bytes{1} + le16(900) + Bytes{2} + le16(500) + Bytes{2}, 254);
  rig.rig.run_for(2s);
  EXPECT_NEAR(rig.rig.speed_rpm(), 500, 15);
  rig.send(174, {1, 0, 0}, 2);
  EXPECT_EQ(rig.rig.motor().type(), md::ControlType::kOff);
}

TEST(Md485Device, TheSecondSpeedCommandIsTheSecondMotorsOrTenfold) {
  LineRig dual("md400t");
  dual.send(131, le16(300));
  dual.rig.run_for(2s);
  EXPECT_NEAR(dual.rig.speed_rpm(0), 0, 1);
  EXPECT_NEAR(dual.rig.speed_rpm(1), 300, 15);
  LineRig single;
  single.send(131, le16(30));
  single.rig.run_for(2s);
  EXPECT_NEAR(single.rig.speed_rpm(), 300, 15);
}

TEST(Md485Device, InverseSignsTurnCommandsAndWhatIsReported) {
  LineRig rig("md400t");
  rig.send(16, {1});
  rig.send(207, Bytes{1} + le16(500) + Bytes{1} + le16(500) + Bytes{0});
  rig.rig.run_for(2s);
  EXPECT_NEAR(rig.rig.speed_rpm(0), -500, 15);
  EXPECT_NEAR(rig.rig.speed_rpm(1), 500, 15);
  const Bytes data = *rig.data(210);
  EXPECT_NEAR(double(word(data, 0)), 500, 15);
  EXPECT_NEAR(double(word(data, 9)), 500, 15);
  EXPECT_GT(dword(data, 5), 100);
  EXPECT_GT(dword(data, 14), 100);
}

// --- Broadcasts and the watchdog -----------------------------------------------------------------

TEST(Md485Device, BroadcastsComeEachTenthOfASecondToWhoAskedForThem) {
  LineRig rig("md400t");
  const Bytes none = rig.ask(LineRig::frame(10, {5}, 1, 128), 50ms);
  EXPECT_EQ(none, Bytes{});
  const Bytes heard = rig.ask({}, 1s);
  ASSERT_EQ(heard.size(), 10U * (6 + 17));
  EXPECT_EQ(heard[0], 128);
  EXPECT_EQ(heard[3], 193);
  rig.ask(LineRig::frame(10, {50}), 1ms);
  const Bytes two = rig.ask({}, 1s);
  EXPECT_NEAR(static_cast<double>(two.size()), 20 * 23, 2 * 23);
  rig.ask(LineRig::frame(14, {0}), 100ms);
  rig.ask(LineRig::frame(10, {51}), 100ms);
  EXPECT_EQ(rig.ask({}, 500ms), Bytes{});
}

TEST(Md485Device, ARequestIsAnsweredBetweenBroadcasts) {
  LineRig rig("md400t");
  for (const std::uint8_t number : Bytes{5, 11, 13, 50, 52, 54, 61}) rig.send(10, {number});
  int answered = 0;
  Decoder decoder(protocol::Direction::kReply);
  while (rig.read(5ms)) {
  }
  for (int i = 0; i < 20; ++i) {
    const Bytes heard = rig.ask(LineRig::frame(4, {1}), 200ms);
    for (const std::uint8_t byte : heard) {
      for (auto e = decoder.push(byte); e != Decoder::Event::kNone; e = decoder.next()) {
        EXPECT_EQ(e, Decoder::Event::kFrame);
        answered += decoder.frame().pid == 1;
      }
    }
  }
  EXPECT_EQ(answered, 20);
}

TEST(Md485Device, WithoutFramesTheWatchdogStopsTheMotor) {
  LineRig rig;
  rig.send(185, le16(5));  // 0.5 s
  rig.send(130, le16(500));
  for (int i = 0; i < 10; ++i) {
    rig.ask(LineRig::frame(4, {193}), 200ms);  // any good frame feeds it
  }
  EXPECT_NEAR(rig.rig.speed_rpm(), 500, 15);
  rig.rig.run_for(250ms);
  EXPECT_NEAR(rig.rig.speed_rpm(), 500, 15);
  rig.rig.run_for(1s);
  EXPECT_NEAR(rig.rig.speed_rpm(), 0, 1);
}

// --- The line ------------------------------------------------------------------------------------

TEST(Md485Device, AnswersOfOthersOnTheLineMakeItMissNothing) {
  LineRig rig;
  Bytes other = {172, 183, 2, 193, 17, 0xE8, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  other.push_back(protocol::negated_sum8(other));
  const Bytes reply = rig.ask(other + LineRig::frame(4, {1}));
  EXPECT_EQ(reply.size(), 7U);
}

TEST(Md485Device, AFrameThatWasCutShortIsGivenUpAfterTenMilliseconds) {
  LineRig rig;
  const Bytes request = LineRig::frame(4, {1});
  rig.write(std::span(request).first(4));
  rig.rig.run_for(11ms);
  EXPECT_EQ(rig.ask(request).size(), 7U);
  Bytes spoilt = request;
  spoilt.back() ^= 1;
  EXPECT_EQ(rig.ask(spoilt), Bytes{});
  EXPECT_EQ(rig.ask(request).size(), 7U);
  EXPECT_EQ(rig.device.counters().bad_frames, 1U);
}

}  // namespace
}  // namespace virtdrive::md485
