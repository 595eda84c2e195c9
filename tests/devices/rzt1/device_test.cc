#include "devices/rzt1/device.h"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "devices/protocol/checksum.h"
#include "tests/devices/rzt1/line_rig.h"
#include "tests/devices/vectors.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

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

// Header and sum around a code and its data.
Bytes packet(std::uint8_t address, std::uint8_t code, const Bytes& data) {
  Bytes bytes = {kStart, address, static_cast<std::uint8_t>(data.size()), code};
  bytes.insert(bytes.end(), data.begin(), data.end());
  bytes.push_back(protocol::sum8(std::span(bytes).subspan(1)));
  return bytes;
}
Bytes get(std::uint8_t id, std::uint8_t address = 1) {
  return packet(address, 6, {id});
}
Bytes call(std::uint8_t id, std::uint8_t address = 1) {
  return packet(address, 2, {id});
}

const Bytes kOk = {0, 0};
const Bytes kNothing = {};

// A servo that is on, phased and at rest.
void switch_on(LineRig& rig, std::size_t axis = 0) {
  ASSERT_EQ(rig.rig.ready(axis), Result::kOk);
}

// --- The document's frames -----------------------------------------------------------------------

TEST(Rzt1Device, AnswersTheGoldenPackets) {
  LineRig rig;
  EXPECT_EQ(rig.ask(request("00_GetModuleData")), response("00_GetModuleData"));
  EXPECT_EQ(rig.ask(request("00_GetModuleData_axis2")), response("00_GetModuleData"));
  EXPECT_EQ(rig.ask(request("00_GetModuleData_badsum")), response("checksum_error"));
  EXPECT_EQ(rig.ask(request("08_invalid_code")), response("status_invalid_code"));
  EXPECT_EQ(rig.ask(request("02_Call_not_a_function")), response("status_invalid_index"));
  EXPECT_EQ(rig.ask(request("03_InitPVT_200")), response("status_ok"));
  EXPECT_EQ(rig.ask(request("03_InitPVT_0")), response("status_out_of_range"));
  EXPECT_EQ(rig.ask(request("04_StreamPVT_1pt_count")), response("status_ok"));
  EXPECT_EQ(rig.ask(request("04_StreamPVT_1pt_nocount")), response("status_ok"));
  EXPECT_EQ(rig.axis(0).pvt_depth(), 2);
  EXPECT_EQ(rig.ask(request("04_StreamPVT_2pt_count")), response("status_ok"));
  EXPECT_EQ(rig.axis(1).pvt_depth(), 2);
  EXPECT_EQ(rig.ask(request("05_Set_KP_1500")), response("status_ok"));
  EXPECT_EQ(rig.ask(request("06_Get_KP")), response("06_Get_KP_1500"));
  EXPECT_EQ(rig.ask(request("05_Set_ABS_10000")), response("status_ok"));
  EXPECT_EQ(rig.axis().target(), 10000);
  EXPECT_EQ(rig.ask(request("05_Set_ABS_minus1")), response("status_ok"));
  EXPECT_EQ(rig.axis().target(), -1);
  EXPECT_EQ(rig.ask(request("05_Set_KP_badsize")), response("status_invalid_format"));
  EXPECT_EQ(rig.ask(request("05_Set_ERR_ro")), response("status_read_only"));
  EXPECT_EQ(rig.ask(request("05_Set_index200")), response("status_invalid_index"));
  EXPECT_EQ(rig.ask(request("05_Set_GEARIN_0")), response("status_out_of_range"));
  EXPECT_EQ(rig.ask(request("06_Get_index200")), response("status_invalid_index"));
  EXPECT_EQ(rig.ask(request("15_Baud_9_invalid")), response("status_out_of_range"));
  EXPECT_EQ(rig.ask(request("15_Baud_broadcast")), kNothing);
  rig.type("POS 2000");
  EXPECT_EQ(rig.ask(request("06_Get_POS")), response("06_Get_POS_2000"));
}

TEST(Rzt1Device, CallsTheGoldenFunctions) {
  for (const char* name :
       {"GO", "OFF", "ENABLE", "DISABLE", "STOP", "ABORT", "SAVE", "ERESET", "ALIGN", "ON"}) {
    LineRig rig;
    EXPECT_EQ(rig.ask(request(fmt::format("02_Call_{}", name))), kOk) << name;
  }
  LineRig rig;
  EXPECT_EQ(rig.ask(request("02_Call_HOME")), response("status_invalid_state"));
}

TEST(Rzt1Device, ReportsPositionAndStatusOfAServoThatIsOn) {
  LineRig rig;
  switch_on(rig);
  ASSERT_EQ(rig.axis().set_position(1000 - rig.axis().position_error()), Result::kOk);
  const Bytes reply = rig.ask(request("01_Report_pos_status"));
  ASSERT_EQ(reply.size(), 8U);
  EXPECT_EQ(reply[0], 0);
  const int position = reply[1] | reply[2] << 8 | reply[3] << 16 | reply[4] << 24;
  EXPECT_NEAR(position, 1000, 5);
  EXPECT_EQ(Bytes(reply.begin() + 5, reply.begin() + 7), (Bytes{0x87, 0x00}));
}

TEST(Rzt1Device, AnswersTheGoldenLines) {
  LineRig rig;
  const auto ask = [&](std::string_view name) { return rig.ask(request(name)); };
  ASSERT_EQ(rig.axis().set_position(120), Result::kOk);
  EXPECT_EQ(ask("ascii_POS_120"), response("ascii_POS_120"));
  ASSERT_EQ(rig.axis().set_position(2100), Result::kOk);
  EXPECT_EQ(ask("ascii_POS_2100"), response("ascii_POS_2100"));
  EXPECT_EQ(ask("ascii_POS_set"), response("ascii_POS_set"));
  EXPECT_EQ(ask("ascii_POS_2000"), response("ascii_POS_2000"));
  EXPECT_EQ(ask("ascii_lower"), response("ascii_lower"));
  EXPECT_EQ(ask("ascii_unknown"), response("ascii_unknown"));
  EXPECT_EQ(ask("ascii_ro_write"), response("ascii_ro_write"));
  EXPECT_EQ(ask("ascii_empty"), response("ascii_empty"));
  EXPECT_EQ(ask("ascii_EQUERY"), response("ascii_EQUERY"));
  EXPECT_EQ(ask("ascii_hex_arg"), response("ascii_hex_arg"));
  EXPECT_EQ(rig.axis().target(), 16);
  EXPECT_EQ(ask("ascii_neg"), response("ascii_neg"));
  EXPECT_EQ(rig.axis().target(), -500);
  EXPECT_EQ(ask("ascii_axis2"), response("ascii_axis2"));
  EXPECT_EQ(ask("ascii_axis_default"), response("ascii_axis_default"));
  EXPECT_EQ(rig.type("POS"), "0\r\n>");
  EXPECT_EQ(rig.device.default_axis(0), 2U);
}

TEST(Rzt1Device, InputsOfBothAxesAreOneWord) {
  LineRig rig;
  rig.rig.hardware.axis[0].input_pins = 1;
  rig.rig.turn_to(0);
  rig.run_for(10ms);
  EXPECT_EQ(rig.type("INP").substr(1, 1), "1");
  EXPECT_EQ(rig.type("INP"), fmt::format("{:04X}\r\n>", rig.rig.drive->inputs()));
}

// --- Two protocols, three consoles ---------------------------------------------------------------

TEST(Rzt1Device, TellsEachRequestFromItsFirstByte) {
  LineRig rig;
  EXPECT_EQ(rig.type("POS"), "0\r\n>");
  EXPECT_EQ(rig.ask(request("00_GetModuleData")), response("00_GetModuleData"));
  EXPECT_EQ(rig.type("KP"), "2000\r\n>");
}

TEST(Rzt1Device, ThreeConsolesWorkAtTheSameTimeEachWithItsOwnAxis) {
  LineRig rig;
  EXPECT_EQ(rig.type("2", 1), "\r\n>");
  rig.type("2DATA0 77", 2);
  EXPECT_EQ(rig.type("DATA0", 1), "77\r\n>");
  EXPECT_EQ(rig.type("DATA0", 0), "0\r\n>");
  EXPECT_EQ(rig.type("2DATA0", 0), "77\r\n>");
  EXPECT_EQ(rig.type("DATA0", 2), "0\r\n>");
  // One is cut short in a packet, the others do not care.
  rig.ask({0xAA, 0x01}, 0);
  EXPECT_EQ(rig.type("KP", 1), "2000\r\n>");
}

TEST(Rzt1Device, SaysRWhenItIsReadyOnConsole2) {
  LineRig rig;
  EXPECT_EQ(rig.heard(2), response("boot"));
  EXPECT_EQ(rig.heard(0), kNothing);
}

TEST(Rzt1Device, AnArgumentOfAFunctionIsATargetForGoAndNothingElsewhere) {
  LineRig rig;
  switch_on(rig);
  EXPECT_EQ(rig.type("GO 1500"), "\r\n>");
  EXPECT_EQ(rig.axis().target(), 1500);
  rig.rig.run_to_end_of_motion();
  rig.run_for(50ms);
  EXPECT_NEAR(rig.axis().position(), 1500, 10);
  rig.type("FWD");
  rig.run_for(100ms);
  EXPECT_EQ(rig.type("STOP 1"), "\r\n>");  // a STOP that is not obeyed would not be safe
  rig.rig.run_to_end_of_motion();
  EXPECT_FALSE(rig.axis().moving());
}

TEST(Rzt1Device, NumbersOutOfRangeAndWhatIsNoNumberAreRefused) {
  LineRig rig;
  for (const char* line : {"KP 32768", "KP -1", "KP x", "PRO 4", "GEARIN 0", "CH1 4", "CH1 22",
                           "ADDR 0", "ADDR 128", "TRACE 11", "ACC 0", "STA 1", "VER 1",
                           "ABS 2147483648", "EADDR 256", "ETYPE 6", "PWM 32768"}) {
    EXPECT_EQ(rig.type(line), "\r\n?") << line;
  }
  EXPECT_EQ(rig.type("ABS -2147483648"), "\r\n>");
  EXPECT_EQ(rig.type("ABS"), "-2147483648\r\n>");
  EXPECT_EQ(rig.type("ERRMASK 0xFFFFFFFF"), "\r\n>");
  EXPECT_EQ(rig.type("ERRMASK"), "FFFFFFFF\r\n>");
}

TEST(Rzt1Device, TheVersionIsATextInALineAndFourBytesInAPacket) {
  LineRig rig;
  EXPECT_EQ(rig.type("VER"), std::string(kVersionText) + "\r\n>");
  EXPECT_EQ(rig.ask(get(97)), response("00_GetModuleData"));
}

// --- Addresses -----------------------------------------------------------------------------------

TEST(Rzt1Device, HearsItsTwoAddressesTheBroadcastAndItsGroups) {
  LineRig rig;
  EXPECT_EQ(rig.ask(packet(3, 0, {})), kNothing);
  EXPECT_EQ(rig.ask(packet(0, 0, {})), kNothing);  // group 0 is no group
  EXPECT_EQ(rig.ask(packet(1, 5, {124, 50, 0})), kOk);
  EXPECT_EQ(rig.ask(packet(2, 5, {124, 50, 0})), kOk);
  // All members act, nobody answers.
  EXPECT_EQ(rig.ask(packet(50, 5, {63, 7, 0, 0, 0})), kNothing);
  EXPECT_EQ(rig.axis(0).settings().data0, 7);
  EXPECT_EQ(rig.axis(1).settings().data0, 7);
  EXPECT_EQ(rig.ask(packet(kAllModules, 5, {63, 9, 0, 0, 0})), kNothing);
  EXPECT_EQ(rig.axis(0).settings().data0, 9);
  EXPECT_EQ(rig.axis(1).settings().data0, 9);
}

TEST(Rzt1Device, AGroupsMasterAnswersForIt) {
  LineRig rig({.group_master = 2});
  rig.ask(packet(1, 5, {124, 50, 0}));
  rig.ask(packet(2, 5, {124, 50, 0}));
  rig.type("2DATA0 -1");
  EXPECT_EQ(rig.ask(get(63, 50)), (Bytes{0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFC}));
  EXPECT_EQ(rig.ask(packet(50, 8, {})), (Bytes{1, 1}));
}

TEST(Rzt1Device, AddressesAreGivenInLinesOnly) {
  LineRig rig;
  EXPECT_EQ(rig.ask(packet(1, 5, {123, 40, 0})), response("status_invalid_state"));
  EXPECT_EQ(rig.type("ADDR 40"), "\r\n>");
  EXPECT_EQ(rig.ask(packet(1, 0, {})), kNothing);
  EXPECT_EQ(rig.ask(packet(40, 0, {})), response("00_GetModuleData"));
}

// --- Options -------------------------------------------------------------------------------------

TEST(Rzt1Device, CanSpeakAsTheTextAndAsThePublicFirmwareDo) {
  LineRig rig({.format = {.status_bytes = 2}, .prompt_axis = true});
  EXPECT_EQ(rig.ask(get(14)), from_hex("00 00 d0 07 d7"));
  EXPECT_EQ(rig.ask(packet(1, 8, {})), from_hex("01 00 01"));
  EXPECT_EQ(rig.type("KP"), "2000\r\n1>");
  EXPECT_EQ(rig.type("2"), "\r\n2>");
  EXPECT_EQ(rig.type("FOO"), "\r\n2?");
}

// --- Bad hosts -----------------------------------------------------------------------------------

TEST(Rzt1Device, LosesWhatComesWhileARequestIsHandled) {
  LineRig rig({.latency = 1ms});
  Bytes two = request("06_Get_POS");
  const Bytes again = two;
  two.insert(two.end(), again.begin(), again.end());
  EXPECT_EQ(rig.ask(two), from_hex("00 00 00 00 00 00"));
  EXPECT_EQ(rig.device.counters().bytes_lost, again.size());
  EXPECT_EQ(rig.ask(again), from_hex("00 00 00 00 00 00"));
}

TEST(Rzt1Device, LenientKeepsItAndGivesUpWhatWasCutShort) {
  LineRig rig({.latency = 1ms, .lenient = true});
  Bytes two = request("06_Get_POS");
  const Bytes again = two;
  two.insert(two.end(), again.begin(), again.end());
  EXPECT_EQ(rig.ask(two).size(), 12U);
  EXPECT_EQ(rig.device.counters().bytes_lost, 0U);
  rig.ask(Bytes(again.begin(), again.begin() + 3));
  rig.run_for(101ms);
  EXPECT_EQ(rig.ask(again).size(), 6U);
}

TEST(Rzt1Device, APacketCutAnywhereWaitsForItsMissingBytes) {
  const Bytes whole = request("05_Set_KP_1500");
  for (std::size_t cut = 1; cut < whole.size(); ++cut) {
    LineRig rig;
    EXPECT_EQ(rig.ask(Bytes(whole.begin(), whole.begin() + static_cast<long>(cut))), kNothing);
    rig.run_for(2s);
    EXPECT_EQ(rig.ask(Bytes(whole.begin() + static_cast<long>(cut), whole.end())), kOk) << cut;
    EXPECT_EQ(rig.axis().settings().kp, 1500);
  }
}

TEST(Rzt1Device, AfterACutTheNextPacketsBytesFillTheGap) {
  LineRig rig;
  rig.ask(from_hex("aa 01 03 05 0e dc"));
  // Two bytes are missing: the next packet's AA 01 end it with a wrong sum; the rest is a line.
  const Bytes next = request("06_Get_POS");
  EXPECT_EQ(rig.ask(next), response("checksum_error"));
  EXPECT_EQ(rig.ask(next), from_hex("00 00 00 00 00 00"));
}

TEST(Rzt1Device, LongLinesLoseTheirEnd) {
  LineRig rig;
  EXPECT_EQ(rig.type(std::string(2000, 'X')), "\r\n?");
  EXPECT_EQ(rig.type("KP"), "2000\r\n>");
}

// --- Bit rate ------------------------------------------------------------------------------------

struct BaudPort final : SerialPort {
  explicit BaudPort(EventLoop& its_loop) : loop(its_loop) {}
  SimTime send(std::span<const std::uint8_t> bytes) override {
    said.insert(said.end(), bytes.begin(), bytes.end());
    if (baud == 115200) old_rate += bytes.size();
    return loop.now() + SimDuration(std::int64_t(bytes.size()) * 86'806);
  }
  void set_baud(int its) override { baud = its; }
  EventLoop& loop;
  int baud = 115200;
  std::size_t old_rate = 0;  // bytes said at the old rate
  Bytes said;
};

TEST(Rzt1Device, ChangesItsBitRateAfterTheAnswerAndLosesItAtAReset) {
  Rig rig;
  MemoryInProcess memory;
  BaudPort port(rig.loop);
  const std::array<SerialPort*, 3> ports = {&port, nullptr, nullptr};
  Device device(rig.loop, ports, *rig.drive, memory, {}, {});
  const auto say = [&](const Bytes& bytes) {
    rig.run_for(1ms);
    for (const std::uint8_t byte : bytes) device.console(0).receive(byte);
    rig.run_for(1ms);
  };
  constexpr int kRates[] = {115200, 230400,  250000,  460800, 500000,
                            921600, 1000000, 1250000, 1500000};
  for (std::uint8_t code = 0; code < 9; ++code) {
    const std::size_t before = port.said.size();
    say(packet(1, 15, {code}));
    EXPECT_EQ(port.said.size(), before + 2);
    EXPECT_EQ(port.baud, kRates[code]);
  }
  EXPECT_EQ(port.old_rate, 4U);  // the first answer, and the second: the switch is after it
  say(call(88));
  rig.run_for(200ms);
  EXPECT_EQ(port.baud, 115200);
}

// --- Memory and reset ----------------------------------------------------------------------------

TEST(Rzt1Device, SavesAndRestoresThePersistentSetOfAnAxis) {
  LineRig rig;
  rig.type("KP 1234");
  rig.type("VEL 99");
  rig.type("2KP 4321");
  EXPECT_EQ(rig.type("SAVE"), "\r\n>");
  rig.type("KP 1");
  EXPECT_EQ(rig.type("RESTORE"), "\r\n>");
  EXPECT_EQ(rig.type("KP"), "1234\r\n>");
  EXPECT_EQ(rig.type("RESET"), "\r\n>");
  rig.run_for(150ms);
  EXPECT_EQ(rig.type("KP"), "1234\r\n>");
  EXPECT_EQ(rig.type("2KP"), "2000\r\n>");  // axis 2 was not saved
  EXPECT_EQ(rig.type("VEL"), "7158282\r\n>");
}

TEST(Rzt1Device, ADamagedMemoryGivesTheFactorysSettingsAndANote) {
  LineRig rig;
  rig.type("KP 1234");
  rig.type("SAVE");
  auto block = *rig.memory.read("axis1");
  block[block.size() / 2] ^= 0x40;
  rig.memory.write("axis1", block);
  EXPECT_EQ(rig.type("RESTORE"), "\r\n>");
  EXPECT_EQ(rig.type("KP"), "2000\r\n>");
  ASSERT_EQ(rig.notes.size(), 1U);
  EXPECT_EQ(rig.notes[0], "the parameters saved of axis 1 are damaged; it has the factory's");
}

class FailingMemory final : public NonVolatileMemory {
 public:
  std::optional<std::vector<std::uint8_t>> read(std::string_view) override { return std::nullopt; }
  bool write(std::string_view, std::span<const std::uint8_t>) override { return false; }
  bool erase() override { return false; }
};

TEST(Rzt1Device, AFlashThatFailsIsAnExecutionError) {
  Rig rig;
  FailingMemory memory;
  BaudPort port(rig.loop);
  const std::array<SerialPort*, 3> ports = {&port, nullptr, nullptr};
  Device device(rig.loop, ports, *rig.drive, memory, {}, {});
  rig.run_for(1ms);
  for (const std::uint8_t byte : request("02_Call_SAVE")) device.console(0).receive(byte);
  rig.run_for(1ms);
  EXPECT_EQ(port.said, response("status_execution_error"));
}

TEST(Rzt1Device, AResetAnswersThenIsDeafThenSaysR) {
  LineRig rig;
  rig.heard(2);
  EXPECT_EQ(rig.ask(request("02_Call_RESET"), 0), kOk);
  EXPECT_EQ(rig.type("KP", 1), "");
  EXPECT_GT(rig.device.counters().bytes_lost, 0U);
  rig.run_for(100ms);
  EXPECT_EQ(rig.heard(2), response("boot"));
  EXPECT_EQ(rig.type("KP"), "2000\r\n>");
}

TEST(Rzt1Device, WithAnAbsoluteEncoderItListensLater) {
  LineRig rig;
  rig.type("2ETYPE 1");
  rig.type("2SAVE");
  rig.type("RESET");
  rig.run_for(101ms);
  EXPECT_EQ(rig.heard(2), (Bytes{'R', 'R'}));
  EXPECT_EQ(rig.type("KP"), "");  // the main loop waits for the encoder
  rig.run_for(160ms);
  EXPECT_EQ(rig.type("2ETYPE"), "1\r\n>");
}

TEST(Rzt1Device, TellsOnceThatAVariableHasNoEffect) {
  LineRig rig;
  rig.type("BRAKE 1");
  rig.type("BRAKE 2");
  EXPECT_EQ(rig.notes.size(), 1U);
}

// --- Recorder ------------------------------------------------------------------------------------

TEST(Rzt1Device, PlaysWhatWasRecordedInLinesAndPackets) {
  LineRig rig;
  rig.type("CH1 0");
  rig.type("CH2 8");
  rig.type("CH3 10");
  rig.type("TRATE 2");
  ASSERT_EQ(rig.axis().set_position(-70000), Result::kOk);
  EXPECT_EQ(rig.type("TRACE 2"), "\r\n>");
  EXPECT_EQ(rig.type("TMODE"), "2\r\n>");
  rig.run_for(60ms);
  EXPECT_EQ(rig.type("TMODE"), "0\r\n>");

  Client client(rig.wire());
  const std::string played = client.line("PLAY");
  EXPECT_EQ(std::ranges::count(played, '\n'), 511);
  EXPECT_EQ(played.substr(0, 9), "-70000,0,");
  const auto wide = client.trace(0, TraceWidth::kFourBytes);
  ASSERT_EQ(wide.size(), 512U);
  EXPECT_EQ(wide[0], -70000);
  EXPECT_EQ(client.trace(0, TraceWidth::kTwoBytes)[0], static_cast<std::int16_t>(-70000));
  EXPECT_EQ(client.trace(3, TraceWidth::kTwoBytes)[0], -70000 >> 16);  // the high words
  EXPECT_EQ(client.trace(1, TraceWidth::kFourBytes).size(), 512U);
  EXPECT_EQ(rig.ask(packet(1, 7, {4})), response("status_out_of_range"));
}

TEST(Rzt1Device, WhileItPrintsMoreThanItsBufferItDoesNotListen) {
  LineRig rig;
  rig.type("TRACE 2");
  rig.run_for(60ms);
  rig.wire().write(Bytes{'P', 'L', 'A', 'Y', '\r'});
  rig.run_for(1ms);
  const auto lost = rig.device.counters().bytes_lost;
  rig.wire().write(Bytes{'K', 'P', '\r'});
  EXPECT_EQ(rig.device.counters().bytes_lost, lost + 3);
}

// --- Units ---------------------------------------------------------------------------------------

TEST(Rzt1Device, UnitsOfVelocityAndAccelerationAreTheDocumentsExamples) {
  EXPECT_EQ(velocity_units(5000, 100us), 32768);
  EXPECT_EQ(acceleration_units(30000, 100us), 19);

  LineRig rig;
  switch_on(rig);
  Client client(rig.wire());
  client.set("VEL", velocity_units(5000, 100us));
  client.set("ACC", acceleration_units(30000, 100us));
  client.call("FWD");
  rig.run_for(100ms);
  const double early = rig.axis().command_velocity() / 65536.0 / 100e-6;
  EXPECT_NEAR(early, 0.1 * 30000, 0.05 * 30000);
  rig.run_for(400ms);
  const double from = rig.axis().position();
  rig.run_for(1s);
  EXPECT_NEAR(rig.axis().position() - from, 5000, 10);
}

TEST(Rzt1Device, TheHostSetsThePhasesInPcmode3) {
  LineRig rig;
  EXPECT_EQ(rig.type("U 20000"), "\r\n?");
  rig.type("PCMODE 3");
  rig.type("ENABLE");
  EXPECT_EQ(rig.type("U 200"), "\r\n>");
  EXPECT_EQ(rig.type("V 300"), "\r\n>");
  EXPECT_EQ(rig.type("U"), "200\r\n>");
  EXPECT_EQ(rig.type("V"), "300\r\n>");
}

TEST(Rzt1Device, PointsFiveMillisecondsApartComeThroughAt115200Baud) {
  LineRig rig;
  switch_on(rig);
  Client client(rig.wire());
  ASSERT_EQ(rig.axis().set_position(0), Result::kOk);
  constexpr double kAmplitude = 20000, kOmega = 3.14159265, kSlice = 5e-3;
  const auto point = [&](int i) {
    const double t = i * kSlice;
    return Client::Point{
        static_cast<std::int32_t>(std::lround(kAmplitude * (1 - std::cos(kOmega * t)))),
        velocity_units(kAmplitude * kOmega * std::sin(kOmega * t), 100us)};
  };
  client.set("PRO", 3);
  client.send(*protocol::find(kTable.commands, 3), {50});
  int next = 1;
  const auto send_some = [&] {
    std::vector<Client::Point> points;
    for (std::size_t i = 0; i < kMostPoints; ++i) points.push_back(point(next++));
    client.stream(points);
  };
  send_some();
  send_some();
  client.call("GO");
  SimDuration listening{};
  for (const SimTime begin = rig.rig.loop.now(); rig.rig.loop.now() < begin + 3s;) {
    if (rig.axis().pvt_depth() <= 69) {
      send_some();
    } else {
      rig.run_for(1ms);
      listening += 1ms;
    }
    ASSERT_EQ(rig.axis().status() & kPvtStarved, 0) << next;
    ASSERT_LT(std::abs(rig.axis().position_error()), 300) << next;
  }
  EXPECT_GT(listening, 2s);  // the line is free most of the time
}

TEST(Rzt1Device, PvtPointsThatDoNotFitAreRefusedWhole) {
  LineRig rig;
  Client client(rig.wire());
  std::vector<Client::Point> points(kMostPoints);
  for (int i = 0; i < 3; ++i) client.stream(points);
  EXPECT_EQ(rig.axis().pvt_depth(), 93);
  try {
    client.stream(points);
    FAIL();
  } catch (const DriveRefused& refused) {
    EXPECT_EQ(refused.code(), 9);
  }
  EXPECT_EQ(rig.axis().pvt_depth(), 93);
}

}  // namespace
}  // namespace virtdrive::rzt1
