#include "devices/toshiba_mcu/device.h"

#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

#include "tests/devices/vectors.h"
#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr SimDuration kCharacter = 86'806ns;  // 10 bits at 115200 baud

// A line's device end: keeps what is said, takes the time that characters take.
class WirePort final : public SerialPort {
 public:
  WirePort(EventLoop& loop, SimDuration character) : loop_(loop), character_(character) {}
  SimTime send(std::span<const std::uint8_t> bytes) override {
    said.insert(said.end(), bytes.begin(), bytes.end());
    started = loop_.now();
    return loop_.now() + character_ * static_cast<std::int64_t>(bytes.size());
  }
  Bytes said;
  SimTime started = kSimStart;

 private:
  EventLoop& loop_;
  SimDuration character_;
};

class DeviceTest : public testing::Test {
 protected:
  explicit DeviceTest(DeviceOptions options = {}, SimDuration character = kCharacter)
      : port_(rig_.loop, character),
        device_(
            rig_.loop, port_, rig_.firmware, memory_, options,
            [this](const WireEvent& event) { log_ += std::string(event.text) + "\n"; },
            [this](std::string_view note) { notes_.emplace_back(note); }, &stream_port_) {}

  void hear(const Bytes& bytes) {
    for (const std::uint8_t byte : bytes) device_.receive(byte);
  }
  /// The answer to a request heard at once, after 20 ms; empty if there is none.
  Bytes ask(const Bytes& request) {
    port_.said.clear();
    hear(request);
    rig_.run_for(20ms);
    return port_.said;
  }
  std::string ask(const std::string& hex) {
    return fmt::format("{:02x}", fmt::join(ask(from_hex(hex)), " "));
  }
  std::string get(std::uint8_t nr, std::uint8_t id, std::uint8_t offset = 0) {
    return answer_to(0x09, {nr, id, offset});
  }
  std::string set(std::uint8_t nr, std::uint8_t id, std::int32_t value, std::int8_t unit = 0) {
    return answer_to(0x0A, {nr, id, unit, value});
  }
  /// "value unit", "ok", or the error telegram's code.
  std::string answer_to(std::uint8_t command, const protocol::Values& request) {
    Decoder decoder(Direction::kReply);
    Decoder::Event last = Decoder::Event::kNone;
    for (const std::uint8_t byte :
         ask(encode_request(*protocol::find(kTable.commands, command), request))) {
      last = decoder.push(byte);
    }
    if (last != Decoder::Event::kTelegram) return "silence";
    const Telegram& reply = decoder.telegram();
    if (reply.row == &kErrorReply) return fmt::format("error {}", reply.values[0]);
    return command == 0x09 ? fmt::format("{} {}", reply.values[0], reply.values[1]) : "ok";
  }

  Rig rig_;
  MemoryInProcess memory_;
  WirePort port_;
  WirePort stream_port_{rig_.loop, 2us};  // 10 bits at 5 Mbit/s
  std::string log_;
  std::vector<std::string> notes_;
  Device device_;
};

constexpr const char* kRefused = "11 ee ff 77 13";
constexpr const char* kNotReady = "11 ee fe 70 13";
constexpr const char* kCrcError = "11 ee 01 83 13";

// --- Golden vectors ------------------------------------------------------------------------------

// A request and the answer of a drive that was just switched on, by the names of the vectors.
struct Pair {
  const char* request;
  const char* response;
};

TEST_F(DeviceTest, AnswersTheStatelessGoldenVectorsToTheByte) {
  const auto vectors = read_vectors("vectors_toshiba_mcu.csv");
  const auto frame = [&](const char* name, const char* direction) {
    return golden_frame(vectors, name, direction);
  };
  const Pair pairs[] = {
      {"09_GetOneMotorParameter", "09_GetOneMotorParameter"},
      {"0A_SetOneMotorParameter", "0A_SetOneMotorParameter"},
      {"0B_GetMotorParameters", "0B_GetMotorParameters"},
      {"0B_GetMotorParameters_1used", "0B_GetMotorParameters_1used"},
      {"0C_SetMotorParameters", "0C_SetMotorParameters"},
      {"14_GetFWVersion_dummy00", "14_GetFWVersion_3_10"},
      {"14_GetFWVersion_dummyFF", "14_GetFWVersion_3_10"},
      {"09_GetOne_Channels", "09_GetOne_Channels_012"},
      {"09_GetOne_DsoSize", "09_GetOne_DsoSize_320"},
      {"09_GetOne_ParameterTransferCount", "09_GetOne_ParameterTransferCount_8"},
      {"09_GetOne_FirmwareVersion", "09_GetOne_FirmwareVersion_3_10"},
      {"09_GetOne_ResetStatus", "09_GetOne_ResetStatus_1st"},
      {"09_GetOne_ResetStatus", "09_GetOne_ResetStatus_2nd"},
      {"09_GetOne_Temperature", "09_GetOne_Temperature_25"},
      {"09_GetOne_DcLinkVoltage_ch1", "09_GetOne_DcLinkVoltage_24V0"},
      {"09_GetOne_MotorId_off0", "09_GetOne_MotorId_off0"},
      {"09_GetOne_MotorId_off4", "09_GetOne_MotorId_off4"},
      {"09_GetOne_MotorId_off8", "09_GetOne_MotorId_off8"},
      {"09_GetOne_MotorId_off12", "09_GetOne_MotorId_off12"},
      {"09_GetOne_MotorId_off16", "09_GetOne_MotorId_off16"},
      {"00_StartMotor_badcrc", "EE_Error_crc"},
      {"0A_SetOne_PolePairs_0_invalid", "EE_Error_minus1"},
      {"0A_SetOne_FirmwareFeatures_ro", "EE_Error_minus1"},
      {"09_GetOne_Speed_wo", "EE_Error_minus1"},
      {"0A_SetOne_Speed_minus500", "0A_SetOneMotorParameter"},
      {"0A_SetOne_SpeedLimit_6000rpm", "0A_SetOneMotorParameter"},
      {"00_StartMotor", "00_StartMotor"},
      {"01_StopMotor", "01_StopMotor"},
      {"00_StartMotor_ch0", "00_StartMotor"},
      {"01_StopMotor_ch0", "01_StopMotor"},
      {"00_StartMotor_ch2", "00_StartMotor"},
      {"01_StopMotor_ch2", "01_StopMotor"},
      {"06_GetDSOLogData", "EE_Error_minus1"},
      {"05_ConfigDSOLog", "05_ConfigDSOLog"},
      {"06_GetDSOLogData", "EE_Error_minus2"},
      {"05_ConfigDSOLog_rising_center", "05_ConfigDSOLog"},
      {"07_ConfigureHsDSO", "07_ConfigureHsDSO"},
      {"07_ConfigureHsDSO_off", "07_ConfigureHsDSO"},
      {"0E_GetAbsolutePosition", "0E_GetAbsolutePosition"},
      {"0F_AbortLinearMotion", "0F_AbortLinearMotion"},
      {"0D_DoLinearMotion", "0D_DoLinearMotion"},
      {"0D_DoLinearMotion", "0D_DoLinearMotion_range"},  // busy: the same error
      {"12_SetMotorControlMethod", "12_SetMotorControlMethod"},
      {"12_SetMotorControlMethod_bad", "12_SetMotorControlMethod_invalid"},
      {"21_SetDemoState", "21_SetDemoState"},
      {"22_GetDemoState", "22_GetDemoState"},
      {"03_StoreParameters", "03_StoreParameters"},
      {"04_ClearParameters", "04_ClearParameters"},
      {"0A_SetOne_Torque_100mNm", "EE_Error_minus1"},  // 1.85 A at 34 mNm/A are 63 mNm
      {"08_DoTurn", "08_DoTurn"},
      {"10_StartMotorTorqueCtrl", "10_StartMotorTorqueCtrl"},  // running: nothing happens
  };
  for (const Pair& pair : pairs) {
    EXPECT_EQ(ask(frame(pair.request, "request")), frame(pair.response, "response"))
        << pair.request;
  }
  for (const char* silent : {"7F_unknown_cmd", "00_StartMotor_badeot"}) {
    EXPECT_EQ(ask(frame(silent, "request")), Bytes{}) << silent;
  }
}

TEST_F(DeviceTest, AStoppedMotorsStateIsZeroButForTheTick) {
  rig_.run_for(998ms);  // the answer leaves at 999 + 1 ms
  rig_.run_for(1ms);
  EXPECT_EQ(ask("11 02 00 0e 13"),
            "11 02 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 e8 03 00 00 31 13");
}

TEST_F(DeviceTest, TheIdleExtendedStateHasMethodZero) {
  rig_.run_for(4999ms);
  EXPECT_EQ(ask("11 23 00 e9 13"),
            "11 23 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 88 13 00 00 00 50 13");
  EXPECT_EQ(ask("11 11 02 79 13"), "11 11 00 77 13");
}

// --- The receiver --------------------------------------------------------------------------------

TEST_F(DeviceTest, BytesOutsideOfATelegramAreIgnored) {
  EXPECT_EQ(ask("00 ff 13 13 55 11 14 00 6c 13"), "11 14 03 0a 0a 13");
}

TEST_F(DeviceTest, AnUnknownCommandIsSilentAndTheNextTelegramIsAnswered) {
  EXPECT_EQ(ask("11 7f 01 7d 13"), "");
  EXPECT_EQ(ask("11 14 00 6c 13"), "11 14 03 0a 0a 13");
}

TEST_F(DeviceTest, ACutTelegramWaitsForEverAndACrcErrorBringsBothSidesBack) {
  EXPECT_EQ(ask("11 09 01"), "");
  rig_.run_for(60s);
  // The next request is swallowed as the rest: id 11, offset 09, CRC 01, end e1 (wrong, silent).
  EXPECT_EQ(ask("11 09 01 e1 00 07 13"), "");
  EXPECT_EQ(ask("11 14 00 6c 13"), "11 14 03 0a 0a 13");
  // Cut inside the long request, the swallowed bytes end in a wrong CRC or end byte before long.
  EXPECT_EQ(ask("11 02"), "");
  EXPECT_EQ(ask("11 14 13"), kCrcError);
}

TEST_F(DeviceTest, TheAnswerLeavesOneMillisecondAfterTheRequest) {
  const SimTime heard = rig_.loop.now();
  ask("11 14 00 6c 13");
  EXPECT_EQ(port_.started - heard, 1ms);
}

TEST_F(DeviceTest, IsDeafFromTheRequestUntilItsAnswerIsOutButForOneByte) {
  hear(from_hex("11 14 00 6c 13"));
  hear(from_hex("11 14 00 6c 13"));  // the UART keeps the first byte, the others are lost
  EXPECT_EQ(device_.counters().bytes_lost, 4U);
  rig_.run_for(1ms + 5 * kCharacter);
  hear(from_hex("14 00 6c"));  // still busy: the answer's last byte is on its way
  EXPECT_EQ(device_.counters().bytes_lost, 7U);
  rig_.run_for(1ms);
  EXPECT_EQ(port_.said, from_hex("11 14 03 0a 0a 13"));
  EXPECT_EQ(ask("14 00 6c 13"), "11 14 03 0a 0a 13") << "the kept 11 begins this telegram";
}

class LenientDeviceTest : public DeviceTest {
 protected:
  LenientDeviceTest() : DeviceTest({.lenient = true}) {}
};

TEST_F(LenientDeviceTest, KeepsWhatComesWhileItIsBusy) {
  for (int i = 0; i < 3; ++i) hear(from_hex("11 14 00 6c 13"));
  rig_.run_for(20ms);
  EXPECT_EQ(port_.said, from_hex("11 14 03 0a 0a 13 11 14 03 0a 0a 13 11 14 03 0a 0a 13"));
  EXPECT_EQ(device_.counters().bytes_lost, 0U);
}

TEST_F(LenientDeviceTest, GivesACutTelegramUpAfterAHundredMilliseconds) {
  hear(from_hex("11 09 01"));
  rig_.run_for(101ms);
  EXPECT_EQ(ask("11 14 00 6c 13"), "11 14 03 0a 0a 13");
}

TEST_F(LenientDeviceTest, BoundsWhatItKeeps) {
  hear(Bytes(100'000, 0x11));
  rig_.run_for(1s);
  hear(from_hex("11 14 00 6c 13"));
  hear(Bytes(100'000, 0x00));
  EXPECT_GT(device_.counters().bytes_lost, 90'000U);
}

// --- Channels and the system ---------------------------------------------------------------------

TEST_F(DeviceTest, AChannelThatIsNotThereIsRefused) {
  for (const int number : {3, 7, 0xFE}) {
    const auto nr = static_cast<std::uint8_t>(number);
    EXPECT_EQ(answer_to(0x00, {nr}), "error -1");
    EXPECT_EQ(answer_to(0x02, {nr}), "error -1");
    EXPECT_EQ(get(nr, 0x10), "error -1");
    EXPECT_EQ(set(nr, 0x10, 4), "error -1");
  }
  EXPECT_EQ(answer_to(0x00, {0xFF}), "error -1") << "the system has no motor";
}

TEST_F(DeviceTest, TheSystemAnswersForItselfAndItsBoardsButIsNotWritten) {
  EXPECT_EQ(get(0xFF, 0xB0), "778 0");
  EXPECT_EQ(get(1, 0xB0), "778 0");
  EXPECT_EQ(set(0, 0x50, 16000), "ok");
  EXPECT_EQ(get(0xFF, 0x50), "16000 0") << "the lowest channel's";
  EXPECT_EQ(get(1, 0x50), "12500 0");
  EXPECT_EQ(get(0xFF, 0x10), "error -1");
  EXPECT_EQ(get(0xFF, 0xE1), "error -1");
  EXPECT_EQ(set(0xFF, 0x50, 12500), "error -1");
}

TEST_F(DeviceTest, StartAndStopRefuseAsTheFirmwareDoes) {
  EXPECT_EQ(ask("11 01 01 00 13"), kRefused) << "not running";
  EXPECT_EQ(ask("11 00 01 07 13"), "11 00 00 00 13");
  EXPECT_EQ(ask("11 00 01 07 13"), "11 00 00 00 13") << "running already: no-op";
  rig_.axis_of().advance_to(rig_.loop.now());
  rig_.axis_of().set_source_voltage(0);
  rig_.run_for(2s);
  EXPECT_EQ(get(1, 0xE3), "7 0");
  EXPECT_EQ(get(1, 0xE1), "16 0");
  EXPECT_EQ(ask("11 00 01 07 13"), kNotReady) << "Emergency is left by StopMotor only";
  EXPECT_EQ(ask("11 01 01 00 13"), "11 01 00 07 13");
  EXPECT_EQ(get(1, 0xE3), "0 0");
  EXPECT_EQ(get(1, 0xE1), "0 0");
}

// --- Parameters ----------------------------------------------------------------------------------

TEST_F(DeviceTest, EveryReadableRowIsReadAndEveryWritableOneReadsBackWhatWasWritten) {
  for (const ParameterRow& row : kParameters) {
    SCOPED_TRACE(row.name);
    const auto id = static_cast<std::uint8_t>(row.id);
    if (row.support == Support::kRejected) {
      EXPECT_EQ(get(1, id), "error -1");
      EXPECT_EQ(set(1, id, 0), "error -1");
      continue;
    }
    if (row.access == Access::kWriteOnly) {
      EXPECT_EQ(get(1, id), "error -1");
      continue;
    }
    const std::string before = get(1, id);
    EXPECT_EQ(before.find("error"), std::string::npos);
    if (row.access == Access::kReadOnly) {
      EXPECT_EQ(set(1, id, 1), "error -1");
      continue;
    }
    if (row.type == WireType::kText) continue;
    EXPECT_EQ(before, fmt::format("{} {}", row.factory.value, row.factory.unit));
    const auto minimum = static_cast<std::int32_t>(row.range.minimum);
    EXPECT_EQ(set(1, id, minimum, row.factory.unit), "ok");
    EXPECT_EQ(get(1, id), fmt::format("{} {}", minimum, row.factory.unit));
    if (row.range.minimum > INT32_MIN) {
      EXPECT_EQ(set(1, id, minimum - 1, row.factory.unit), "error -1");
    }
    if (row.range.maximum < INT32_MAX) {
      EXPECT_EQ(set(1, id, static_cast<std::int32_t>(row.range.maximum) + 1, row.factory.unit),
                "error -1");
    }
    EXPECT_EQ(get(1, id), fmt::format("{} {}", minimum, row.factory.unit)) << "left unchanged";
    EXPECT_EQ(set(1, id, static_cast<std::int32_t>(row.factory.value), row.factory.unit), "ok");
  }
}

TEST_F(DeviceTest, AnUnknownIdIsRefused) {
  for (int id = 0; id < 256; ++id) {
    if (protocol::find(kTable.parameters, static_cast<std::uint16_t>(id)) != nullptr) continue;
    EXPECT_EQ(get(1, static_cast<std::uint8_t>(id)), "error -1") << id;
    EXPECT_EQ(set(1, static_cast<std::uint8_t>(id), 0), "error -1") << id;
  }
}

TEST_F(DeviceTest, AUnitIsKeptWithItsValueAndAnUnlistedOneRefused) {
  EXPECT_EQ(set(1, 0x19, 1, 0), "ok");  // 1 A
  EXPECT_EQ(get(1, 0x19), "1 0");
  EXPECT_EQ(set(1, 0x19, 1, -6), "error -1");
  EXPECT_EQ(get(1, 0x19), "1 0");
  EXPECT_EQ(set(1, 0x18, 300, -3), "ok") << "not applicable: not looked at";
  EXPECT_EQ(get(1, 0x18), "300 0");
}

TEST_F(DeviceTest, SpeedChangeReachesOneHertzAboveTheSpeedLimit) {
  EXPECT_EQ(set(1, 0x17, 351), "ok");
  EXPECT_EQ(set(1, 0x17, 352), "error -1");
  EXPECT_EQ(set(1, 0x17, 5265, 1), "ok") << "5265 rpm at 4 pole pairs is 351 Hz";
  EXPECT_EQ(set(1, 0x17, 5281, 1), "error -1");
}

TEST_F(DeviceTest, DeadtimeIsRoundedToAHundredNanoseconds) {
  EXPECT_EQ(set(1, 0x70, 449), "ok");
  EXPECT_EQ(get(1, 0x70), "400 0");
  EXPECT_EQ(set(1, 0x70, 450), "ok");
  EXPECT_EQ(get(1, 0x70), "500 0");
  EXPECT_EQ(rig_.channel().output().dead_time, 500ns);
}

TEST_F(DeviceTest, ANameIsWrittenFourBytesAtTheOffsetInTheUnitField) {
  EXPECT_EQ(set(1, 0x1D, 0x64636261, 4), "ok");
  EXPECT_EQ(get(1, 0x1D, 4), fmt::format("{} 0", 0x64636261));
  EXPECT_EQ(get(1, 0x1D, 0), fmt::format("{} 0", 0x6f6e614e)) << "'Nano'";
  EXPECT_EQ(get(2, 0x1D, 4), fmt::format("{} 0", 0x20636574))
      << "'tec ': the other channels' names stay";
  EXPECT_EQ(set(1, 0x1D, 0, 17), "error -1");
  EXPECT_EQ(set(1, 0x1D, 0, -1), "error -1");
  EXPECT_EQ(get(1, 0x1D, 18), "0 0");
  EXPECT_EQ(get(1, 0x1D, 255), "0 0");
}

TEST_F(DeviceTest, AWriteWithoutEffectIsNotedOnce) {
  EXPECT_EQ(set(1, 0x57, 99), "error -1");
  EXPECT_TRUE(notes_.empty()) << "nothing was stored";
  EXPECT_EQ(set(1, 0x57, 1), "ok");
  EXPECT_EQ(set(2, 0x57, 3), "ok");
  EXPECT_EQ(set(1, 0x10, 4), "ok");
  EXPECT_EQ(notes_, (std::vector<std::string>{"CanId is stored, but nothing acts on it"}));
}

TEST_F(DeviceTest, ChannelsKeepTheirOwnSettings) {
  EXPECT_EQ(set(0, 0x10, 7), "ok");
  EXPECT_EQ(get(0, 0x10), "7 0");
  EXPECT_EQ(get(1, 0x10), "4 0");
}

TEST_F(DeviceTest, ManyAtOnceStopAtTheFirstFailureAndSayWhere) {
  const CommandRow& get_many = *protocol::find(kTable.commands, 0x0B);
  const auto read = [&](const protocol::Values& request) {
    Decoder decoder(Direction::kReply);
    protocol::Values padded = request;
    padded.pad(get_many.request);
    for (const std::uint8_t byte : ask(encode_request(get_many, padded))) decoder.push(byte);
    return decoder.telegram().values;
  };
  const auto bad_second = read({1, 3, 0x10, 0, 0xE5, 0, 0x11, 0});
  EXPECT_EQ(bad_second[0], 1);
  EXPECT_EQ(bad_second[1], 1);
  EXPECT_EQ(bad_second[2], 4) << "the slot before the failure is there";
  EXPECT_EQ(bad_second[4], 0) << "the failed one and those behind are zero";
  EXPECT_EQ(bad_second[6], 0);
  for (const std::int64_t entries : {0, 9, 255}) {
    const auto answer = read({1, entries, 0x10});
    EXPECT_EQ(answer[0], 1) << entries;
    EXPECT_EQ(answer[1], 0) << entries;
  }

  EXPECT_EQ(
      ask("11 0c 01 01 19 fd d0 07 00 00" + std::string(42 * 3, ' ') +
          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 fa 13"),
      "11 0c 00 00 fc 13");
  EXPECT_EQ(get(1, 0x19), "2000 -3");
}

TEST_F(DeviceTest, EarlierWritesStayWhenALaterOneIsRefused) {
  const CommandRow& set_many = *protocol::find(kTable.commands, 0x0C);
  protocol::Values request = {1, 3, 0x10, 0, 5, 0x11, 0, 3, 0x18, 0, 100};  // Direction 3 is none
  request.pad(set_many.request);
  EXPECT_EQ(ask(encode_request(set_many, request)), from_hex("11 0c 01 01 ee 13"));
  EXPECT_EQ(get(1, 0x10), "5 0");
  EXPECT_EQ(get(1, 0x11), "2 0");
  EXPECT_EQ(get(1, 0x18), "200 0");
}

TEST_F(DeviceTest, NoRowIsRejected) {
  for (const CommandRow& row : kCommands) EXPECT_NE(row.support, Support::kRejected) << row.name;
  for (const ParameterRow& row : kParameters)
    EXPECT_NE(row.support, Support::kRejected) << row.name;
}

TEST_F(DeviceTest, TheFeaturesAreAllButCan) {
  EXPECT_EQ(get(0xFF, 0x90), fmt::format("{} 0", 0x3F7FF));
}

TEST_F(DeviceTest, TheDemosStateIsKeptAndSaidToBeWithoutEffect) {
  EXPECT_EQ(ask("11 21 03 ee 13"), "11 21 00 e7 13");
  EXPECT_EQ(ask("11 22 ab b6 13"), "11 22 03 e7 13");
  EXPECT_EQ(notes_, (std::vector<std::string>{"SetDemoState is stored, but nothing acts on it",
                                              "GetDemoState is stored, but nothing acts on it"}));
}

// --- Oscilloscopes -------------------------------------------------------------------------------

TEST_F(DeviceTest, ASnapshotIsFetchedBlockByBlockUntilItIsRefused) {
  rig_.run_up(2000);
  EXPECT_EQ(ask("11 05 01 07 00 00 00 00 00 00 00 03 00 00 00 f0 13"), "11 05 14 00 42 13");
  rig_.run_for(20ms);
  double sum = 0;
  for (int block = 0; block < 20; ++block) {
    Decoder decoder(Direction::kReply);
    for (const std::uint8_t byte : ask(from_hex("11 06 00 12 13"))) decoder.push(byte);
    ASSERT_EQ(decoder.telegram().row->code, 0x06);
    for (std::size_t i = 0; i < 16; ++i) sum += double(decoder.telegram().values[i]);
  }
  EXPECT_NEAR(sum / 320, 8192, 200) << "duties";
  EXPECT_EQ(ask("11 06 00 12 13"), kRefused);
}

TEST_F(DeviceTest, ASnapshotIsNotReadyWhileItSamples) {
  rig_.run_up(2000);
  EXPECT_EQ(answer_to(0x05, {1, 7, 0, 0, 0, 255}), "ok");  // 106 times 256 periods
  EXPECT_EQ(ask("11 06 00 12 13"), kNotReady);
  rig_.run_for(2200ms);
  EXPECT_EQ(ask("11 06 00 12 13").substr(0, 5), "11 06");
}

// The frame of the golden vectors: three signals, none missed, stamp 1234.
TEST(ToshibaMcuStreamFrame, IsTheGoldenVector) {
  const std::int16_t values[] = {0x249d, 0x2090, 0x1b62};
  const auto vectors = read_vectors("vectors_toshiba_mcu.csv");
  EXPECT_EQ(encode_stream_frame(0, 1234, values),
            golden_frame(vectors, "HsDSO_frame_3sig", "response"));
}

// Frames of `signals` values; false at the first that is none.
bool each_frame(const Bytes& stream, std::size_t signals,
                const std::function<void(std::span<const std::uint8_t>)>& take) {
  const std::size_t size = 5 + 2 * signals;
  if (stream.size() % size != 0) return false;
  for (std::size_t at = 0; at < stream.size(); at += size) {
    const auto frame = std::span(stream).subspan(at, size);
    if (frame[0] != kBot || frame[1] != crc8(0, frame.subspan(2))) return false;
    take(frame);
  }
  return true;
}

TEST_F(DeviceTest, TheStreamCarriesSeventeenSignalsOfEachPeriod) {
  rig_.run_up(2000);
  EXPECT_EQ(answer_to(0x07, {1, 1, 0x1FFFF, 0}), "ok");
  stream_port_.said.clear();
  rig_.run_for(1s);
  std::size_t frames = 0;
  EXPECT_TRUE(each_frame(stream_port_.said, 17, [&](auto frame) {
    EXPECT_EQ(frame[2], 0);
    ++frames;
  }));
  EXPECT_NEAR(double(frames), 12500, 2);
  EXPECT_EQ(device_.stream()->missed(), 0U);
}

TEST_F(DeviceTest, EighteenSignalsMissEachOtherPeriodAndSaySo) {
  rig_.run_up(2000);
  EXPECT_EQ(answer_to(0x07, {1, 1, 0x3FFFF, 0}), "ok");
  stream_port_.said.clear();
  rig_.run_for(1s);
  std::size_t frames = 0;
  std::optional<int> last;
  EXPECT_TRUE(each_frame(stream_port_.said, 18, [&](auto frame) {
    EXPECT_EQ(frame[2], 1);
    const int stamp = frame[3] | frame[4] << 8;
    EXPECT_EQ((stamp - last.value_or(stamp - 2) + 12500) % 12500, 2);
    last = stamp;
    ++frames;
  }));
  EXPECT_NEAR(double(frames), 6250, 2);
  EXPECT_NEAR(double(device_.stream()->missed()), 6250, 200);
}

TEST_F(DeviceTest, TheStreamIsSwitchedOffAndNeedsASignal) {
  rig_.run_up(2000);
  EXPECT_EQ(answer_to(0x07, {1, 1, 0, 0}), "error -1");
  EXPECT_EQ(answer_to(0x07, {1, 1, 7, 0}), "ok");
  EXPECT_EQ(answer_to(0x07, {1, 0, 7, 0}), "ok");
  stream_port_.said.clear();
  rig_.run_for(100ms);
  EXPECT_TRUE(stream_port_.said.empty());
}

TEST(ToshibaMcuDevice, WithoutASecondLineTheStreamIsNotedAndGoesNowhere) {
  Rig rig;
  MemoryInProcess memory;
  WirePort port(rig.loop, kCharacter);
  std::vector<std::string> notes;
  Device device(rig.loop, port, rig.firmware, memory, {}, nullptr,
                [&](std::string_view note) { notes.emplace_back(note); });
  rig.run_up(1000, 2s);
  for (const std::uint8_t byte : from_hex("11 07 01 01 07 00 00 00 00 cc 13")) device.receive(byte);
  rig.run_for(1s);
  EXPECT_EQ(port.said, from_hex("11 07 00 15 13"));
  EXPECT_EQ(notes.size(), 1U);
  EXPECT_EQ(device.stream(), nullptr);
}

// --- Motion --------------------------------------------------------------------------------------

TEST_F(DeviceTest, AHostTurnsTheMotorAndReadsItsTurns) {
  EXPECT_EQ(answer_to(0x08, {1, -3, 600}), "ok");
  rig_.run_for(30s);
  EXPECT_EQ(get(1, 0xE4), "-3 0");
  EXPECT_EQ(get(1, 0xE3), "0 0");
  EXPECT_EQ(answer_to(0x08, {1, 1, 0}), "error -1");
}

TEST_F(DeviceTest, AHostMovesToAPositionAndReadsItBack) {
  EXPECT_EQ(set(1, 0x30, 3), "ok");
  EXPECT_EQ(set(1, 0x34, 1000), "ok");
  EXPECT_EQ(ask(encode_request(*protocol::find(kTable.commands, 0x0D), {1, 9000, 600})),
            from_hex("11 0d 00 23 13"));
  EXPECT_EQ(ask(encode_request(*protocol::find(kTable.commands, 0x0D), {1, 100, 600})),
            from_hex("11 0d 01 24 13"))
      << "busy";
  rig_.run_for(30s);
  Decoder decoder(Direction::kReply);
  for (const std::uint8_t byte : ask(from_hex("11 0e 01 2d 13"))) decoder.push(byte);
  EXPECT_NEAR(double(decoder.telegram().values[0]), 9000, 12);
  for (const std::uint8_t byte : ask(from_hex("11 13 01 7e 13"))) decoder.push(byte);
  EXPECT_NEAR(double(decoder.telegram().values[0]), 8000, 12);
}

TEST_F(DeviceTest, TheSystemsLoadRisesWithTheMotorsThatRun) {
  EXPECT_EQ(get(0xFF, 0xB2), "5 0");
  rig_.run_up(1000, 2s);
  EXPECT_EQ(get(0xFF, 0xB2), "15 0");
}

// --- Non-volatile memory -------------------------------------------------------------------------

TEST_F(DeviceTest, StoredParametersOutliveAResetAndOthersDoNot) {
  EXPECT_EQ(set(1, 0x10, 7), "ok");
  EXPECT_EQ(set(1, 0x19, 1, 0), "ok");
  EXPECT_EQ(set(1, 0x1D, 0x64636261, 4), "ok");
  EXPECT_EQ(ask("11 03 01 0e 13"), "11 03 00 09 13");
  EXPECT_EQ(set(1, 0x10, 9), "ok");
  EXPECT_EQ(set(2, 0x10, 9), "ok");
  device_.parameters().restore();
  EXPECT_EQ(get(1, 0x10), "7 0");
  EXPECT_EQ(get(1, 0x19), "1 0");
  EXPECT_EQ(get(1, 0x1D, 4), fmt::format("{} 0", 0x64636261));
  EXPECT_EQ(get(2, 0x10), "4 0") << "channel 2 was not stored";
}

TEST_F(DeviceTest, ClearForgetsWhatWasStoredAndLeavesTheRamAlone) {
  EXPECT_EQ(set(1, 0x10, 7), "ok");
  EXPECT_EQ(ask("11 03 01 0e 13"), "11 03 00 09 13");
  EXPECT_EQ(ask("11 04 00 1c 13"), "11 04 00 1c 13");
  EXPECT_EQ(get(1, 0x10), "7 0");
  device_.parameters().restore();
  EXPECT_EQ(get(1, 0x10), "4 0");
}

TEST_F(DeviceTest, ADamagedBlockIsNeverLoadedHalf) {
  EXPECT_EQ(set(1, 0x10, 7), "ok");
  EXPECT_EQ(ask("11 03 01 0e 13"), "11 03 00 09 13");
  const Bytes good = *memory_.read("channel1");
  RandomStream random = Seed{1}.stream("damage");
  for (int i = 0; i < 200; ++i) {
    Bytes bad = good;
    if (i % 2 == 0)
      bad[random.bits() % bad.size()] ^= static_cast<std::uint8_t>(1 + random.bits() % 255);
    else
      bad.resize(random.bits() % bad.size());
    memory_.write("channel1", bad);
    device_.parameters().restore();
    EXPECT_EQ(rig_.channel().settings().pole_pairs, kFactorySettings.pole_pairs);
  }
  memory_.write("channel1", good);
  device_.parameters().restore();
  EXPECT_EQ(get(1, 0x10), "7 0");
}

TEST_F(DeviceTest, AChannelThatIsNotThereIsNotStored) {
  EXPECT_EQ(answer_to(0x03, {3}), "error -1");
  EXPECT_EQ(answer_to(0x03, {0xFF}), "error -1");
}

// --- Torque control ------------------------------------------------------------------------------

TEST_F(DeviceTest, TorqueControlTellsTorquesWhereSpeedControlTellsSpeeds) {
  Load load;
  load.inertia_kgm2 = 2e-5;
  load.quadratic_nm_per_radps2 = 6e-7;
  rig_.axis_of().set_load(load);
  EXPECT_EQ(set(1, 0xE5, 4000), "ok");
  EXPECT_EQ(set(1, 0xE6, 30), "ok");
  EXPECT_EQ(ask("11 10 01 77 13"), "11 10 00 70 13");
  rig_.run_for(6s);
  EXPECT_EQ(ask("11 11 01 70 13"), "11 11 02 79 13");
  Decoder decoder(Direction::kReply);
  for (const std::uint8_t byte : ask(from_hex("11 23 01 ee 13"))) decoder.push(byte);
  const protocol::Values& state = decoder.telegram().values;
  EXPECT_NEAR(double(state[0]), 3000, 30) << "30 mNm in 0.001 Ncm";
  EXPECT_EQ(state[1], 3000);
  EXPECT_NEAR(double(state[2]), 30 / 0.034, 9);
  EXPECT_NEAR(double(state[3]), std::abs(rig_.speed_rpm()), 20);
  EXPECT_EQ(state[5], 2);
}

TEST_F(DeviceTest, ATorqueAboveTheLimitIsRefused) {
  EXPECT_EQ(set(1, 0xE6, 62), "ok");  // 1.85 A * 34 mNm/A is 62.9
  EXPECT_EQ(set(1, 0xE6, 64), "error -1");
  EXPECT_EQ(set(1, 0xE6, -1), "error -1");
}

TEST_F(DeviceTest, TheMethodOfTheNextStartIsRememberedWhileIdleAndOthersAreInvalid) {
  EXPECT_EQ(ask("11 12 01 03 61 13"), "11 12 01 79 13");
  EXPECT_EQ(ask("11 12 01 00 68 13"), "11 12 01 79 13");
  EXPECT_EQ(ask("11 12 02 02 59 13"), "11 12 00 7e 13");
  EXPECT_EQ(ask("11 11 02 79 13"), "11 11 00 77 13") << "idle";
  EXPECT_EQ(answer_to(0x00, {2}), "ok");
  EXPECT_EQ(ask("11 11 02 79 13"), "11 11 02 79 13");
}

// --- A running motor through telegrams -----------------------------------------------------------

TEST_F(DeviceTest, AHostRunsTheMotorAndSeesItsState) {
  EXPECT_EQ(ask("11 0a 01 e5 00 d0 07 00 00 7b 13"), "11 0a 00 36 13");
  EXPECT_EQ(ask("11 00 01 07 13"), "11 00 00 00 13");
  rig_.run_for(4s);
  const auto before = rig_.channel().actual_rpm();
  Decoder decoder(Direction::kReply);
  for (const std::uint8_t byte : ask(from_hex("11 23 01 ee 13"))) decoder.push(byte);
  const protocol::Values& state = decoder.telegram().values;
  EXPECT_NEAR(double(state[0]), before, 3);
  EXPECT_EQ(state[1], 2000);
  EXPECT_NEAR(double(state[2]), 120, 15);  // mA: 4 mNm of friction
  EXPECT_EQ(state[3], static_cast<std::int64_t>(3.4 * static_cast<double>(state[2])));
  EXPECT_EQ(state[5], 1);
  EXPECT_EQ(get(1, 0xE3), "6 0");
  EXPECT_EQ(ask("11 11 01 70 13"), "11 11 01 70 13");
  EXPECT_NE(log_.find("StartMotor motor_nr=1"), std::string::npos);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
