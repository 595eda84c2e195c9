// The second and third way to a controller: TTL232 and CAN.
#include <gtest/gtest.h>

#include "devices/md485/can_codec.h"
#include "devices/protocol/binding.h"
#include "tests/devices/md485/line_rig.h"

namespace virtdrive::md485 {
namespace {

using namespace std::chrono_literals;
using protocol::Direction;
using protocol::Values;

const CommandRow& command(std::uint16_t pid) {
  return *protocol::find(kTable.commands, pid);
}
const ParameterRow& parameter(std::uint16_t pid) {
  return *protocol::find(kTable.parameters, pid);
}

TEST(Md485Can, AFrameHoldsThePidAndItsData) {
  const std::uint8_t data[] = {0x82, 0x18, 0xFC};
  EXPECT_EQ(can_request({}, command(130), {-1000}), extended_frame(0x00B7AC01, data));
  const std::uint8_t id[] = {0x85, 0xAA, 0x07};
  EXPECT_EQ(can_request({.host = 184, .id = 254}, parameter(133), {kWriteCheck, 7}),
            extended_frame(0x00B7B8FE, id));
  const std::uint8_t position[] = {0xC5, 0xC4, 0xFF, 0xFF, 0xFF};
  EXPECT_EQ(can_reply({.host = 128}, parameter(198), {-60})->id, 0x0080B701U);
  ParameterRow one = parameter(197);
  one.fields = one.fields.first(1);
  EXPECT_EQ(can_reply({}, one, {-60}), extended_frame(0x00ACB701, position));
  EXPECT_FALSE(can_reply({}, parameter(193), {0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Md485Can, OnlyExtendedFramesOfItsNumbersAreMeant) {
  const CanFrame request = can_request({.host = 184, .id = 9}, command(4), {193});
  const auto route = can_route(Direction::kRequest, request);
  ASSERT_TRUE(route);
  EXPECT_EQ(route->route, (Route{.host = 184, .id = 9}));
  EXPECT_EQ(route->pid, 4);
  CanFrame other = request;
  other.extended = false;
  EXPECT_FALSE(can_route(Direction::kRequest, other));
  other = request;
  other.id |= 1U << 24;
  EXPECT_FALSE(can_route(Direction::kRequest, other));
  other = request;
  other.length = 0;
  EXPECT_FALSE(can_route(Direction::kRequest, other));
  EXPECT_FALSE(can_route(Direction::kReply, request));
}

class CanRig final : public CanPort {
 public:
  explicit CanRig(std::string_view model = "md400t") : line(model) {
    receiver = &line.device.add_can(*this);
  }
  void open(int, bool) override {}
  void close() override {}
  CanState state() const override { return {}; }
  bool send(const CanFrame& frame) override {
    said.emplace_back(line.rig.loop.now(), frame);
    return true;
  }

  std::vector<CanFrame> ask(const CanFrame& frame, SimDuration time = 20ms) {
    said.clear();
    receiver->receive(frame);
    line.rig.run_for(time);
    std::vector<CanFrame> frames;
    for (const auto& [at, what] : said) frames.push_back(what);
    return frames;
  }

  LineRig line;
  CanReceiver* receiver;
  std::vector<std::pair<SimTime, CanFrame>> said;
};

TEST(Md485Can, ARequestIsAnsweredOnCanTwoMillisecondsLater) {
  CanRig rig;
  const SimTime asked = rig.line.rig.loop.now();
  const auto answer = rig.ask(can_request({.host = 184}, command(4), {1}));
  const std::uint8_t version[] = {1, 44};
  EXPECT_EQ(answer, std::vector{extended_frame(0x00B8B701, version)});
  EXPECT_EQ(rig.said[0].first - asked, 2ms);
  EXPECT_EQ(rig.line.ask({}, 20ms), Bytes{});  // nothing of it on RS-485
}

TEST(Md485Can, WhatDoesNotFitIsNotAnsweredAndEightBytesFitAsPaddingOnly) {
  CanRig rig;
  EXPECT_TRUE(rig.ask(can_request({}, command(4), {193})).empty());
  EXPECT_TRUE(rig.ask(can_request({}, command(4), {197})).empty());  // both positions
  CanFrame padded = can_request({}, command(4), {1});
  padded.length = 8;
  EXPECT_EQ(rig.ask(padded).size(), 1U);
}

TEST(Md485Can, CommandsMoveTheMotorsAndRs485SeesIt) {
  CanRig rig;
  EXPECT_TRUE(rig.ask(can_request({}, command(130), {600})).empty());
  rig.ask(can_request({.id = kAllControllers}, command(207), {0, 0, 1, -300, 0}));
  rig.line.rig.run_for(2s);
  EXPECT_NEAR(rig.line.rig.speed_rpm(0), 600, 15);
  EXPECT_NEAR(rig.line.rig.speed_rpm(1), -300, 15);
  EXPECT_TRUE(rig.line.data(210));
  rig.ask(can_request({}, command(5), {0}));
  rig.line.rig.run_for(3s);
  EXPECT_NEAR(rig.line.rig.speed_rpm(0), 0, 1);
}

TEST(Md485Can, ItFeedsTheWatchdogAndHasBroadcastsOfItsOwn) {
  CanRig rig;
  rig.ask(can_request({}, parameter(185), {5}));
  rig.ask(can_request({}, command(130), {500}));
  for (int i = 0; i < 10; ++i) rig.ask(can_request({}, command(4), {138}), 300ms);
  EXPECT_NEAR(rig.line.rig.speed_rpm(), 500, 15);
  // PID 197 fits on a single model only; 193 never.
  EXPECT_TRUE(rig.ask(can_request({}, command(10), {5}), 1s).empty());
}

TEST(Md485Can, WhatIsNotMeantOrNotUnderstoodIsSilence) {
  CanRig rig;
  EXPECT_TRUE(rig.ask(can_request({.id = 9}, command(4), {1})).empty());
  const std::uint8_t unknown[] = {99, 0}, cut[] = {130, 1};
  EXPECT_TRUE(rig.ask(extended_frame(0x00B7AC01, unknown)).empty());
  EXPECT_TRUE(rig.ask(extended_frame(0x00B7AC01, cut)).empty());
  EXPECT_EQ(rig.line.device.counters().bad_frames, 2U);
}

TEST(Md485Can, WhatIsHeardGoesOutOnRs485WhenItWasAskedFor) {
  CanRig rig;
  const std::uint8_t data[] = {0x82, 0xE8, 0x03};
  const CanFrame stranger = extended_frame(0x1234567, data);
  rig.receiver->receive(stranger);
  EXPECT_EQ(rig.line.ask({}, 50ms), Bytes{});
  rig.line.ask(LineRig::frame(10, {23}, 1, 128));
  rig.receiver->receive(stranger);
  rig.receiver->receive(extended_frame(1, std::span(data).first(1)));
  CanFrame remote = stranger;
  remote.remote = true;
  rig.receiver->receive(remote);
  const Bytes heard = rig.line.ask({}, 100ms);
  const Bytes first = {128, 183, 1, 238, 7, 0x67, 0x45, 0x23, 0x01, 0x82, 0xE8, 0x03};
  const Bytes second = {128, 183, 1, 238, 5, 1, 0, 0, 0, 0x82};
  ASSERT_EQ(heard.size(), first.size() + second.size() + 2);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), heard.begin()));
  EXPECT_TRUE(std::equal(second.begin(), second.end(), heard.begin() + 13));
  rig.line.ask(LineRig::frame(10, {24}));
  rig.receiver->receive(stranger);
  EXPECT_EQ(rig.line.ask({}, 50ms), Bytes{});
  EXPECT_FALSE(rig.line.data(238));
}

TEST(Md485Can, WithoutCanThereIsNothingToResend) {
  LineRig rig("md200");
  EXPECT_EQ(rig.table.number(23), nullptr);
  EXPECT_EQ(rig.table.parameter(137)->support, Support::kStored);
  EXPECT_EQ(LineRig("md1k").table.parameter(137)->support, Support::kImplemented);
}

TEST(Md485Ttl, TheSecondPortIsAnsweredWhereItWasAsked) {
  LineRig rig;
  Wire ttl(rig.rig.loop, 10 * SimDuration(104'167));
  ttl.attach(rig.device.add_serial(ttl.port()));
  ttl.write(LineRig::frame(4, {1}));
  const Bytes both = LineRig::frame(4, {205}, 1, 184);
  rig.write(both);  // while the first answer is under way
  Bytes on_ttl, on_rs485;
  while (const auto byte = ttl.read(60ms)) on_ttl.push_back(*byte);
  while (const auto byte = rig.read(60ms)) on_rs485.push_back(*byte);
  EXPECT_EQ(on_ttl, (Bytes{172, 183, 1, 1, 1, 44, 0x6E}));
  ASSERT_EQ(on_rs485.size(), 6U + 10U);
  EXPECT_EQ(on_rs485[0], 184);
  ttl.write(LineRig::frame(10, {5}));
  Bytes heard;
  for (const SimTime end = rig.rig.loop.now() + 1s; rig.rig.loop.now() < end;) {
    if (const auto byte = ttl.read(10ms)) heard.push_back(*byte);
  }
  EXPECT_NEAR(double(heard.size()), 10 * 23, 23);
  EXPECT_EQ(rig.ask({}, 50ms), Bytes{});
}

}  // namespace
}  // namespace virtdrive::md485
