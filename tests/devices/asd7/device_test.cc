// The 7-Series' own protocol at the drive: what is answered, what is not, and what it does. "8.1"
// and the like: the frames that the manuals print, from tests/data.
#include "devices/asd7/device.h"

#include <gtest/gtest.h>

#include "devices/asd7/client.h"
#include "devices/protocol/checksum.h"
#include "tests/devices/asd7/line_rig.h"
#include "tests/devices/vectors.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

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
Bytes binary(Bytes bytes) {
  bytes.insert(bytes.begin(), kBinaryStart);
  bytes.push_back(protocol::sum8(bytes));
  return bytes;
}

// Forward at 60 Hz with the shortest ramp that does not trip.
void run_at_60_hz(LineRig& rig) {
  ASSERT_EQ(rig.say("(P000A0005)"), "(N0002)");
  ASSERT_EQ(rig.say("(P00090014)"), "(P00090014)");
  ASSERT_EQ(rig.say("(PFA011770)"), "(PFA011770)");
  ASSERT_EQ(rig.say("(PFA00C400)"), "(PFA00C400)");
  rig.run(3s);
  ASSERT_EQ(rig.drive.monitor().output_frequency, 6000);
}

// --- Frames that the manuals print ---------------------------------------------------------------

TEST(Asd7Device, PrintedWritesAreEchoed) {
  for (const char* name : {"W0010", "PFA01_1770", "PFA01_1F40", "W0803_padded"}) {
    LineRig rig;
    EXPECT_EQ(rig.ask(request(name)), response(name)) << name;
  }
  for (const char* name : {"PFA00_8400", "PFA00_8600", "PFA00_C600", "PFA00_C400", "PFA00_9000",
                           "bin_W0010", "bin_PFA00_9000", "bin_PFA01_1770", "bin_PFA00_C400"}) {
    LineRig rig;
    EXPECT_EQ(rig.ask(request(name)), response(name)) << name;
  }
}

TEST(Asd7Device, APrintedReadAtSixtyHertzIsAnsweredInEachFormat) {
  LineRig rig;
  run_at_60_hz(rig);
  EXPECT_EQ(rig.ask(request("RFD00")), response("RFD00_60"));
  EXPECT_EQ(rig.ask(request("sum_RFD00")), response("sum_RFD001770"));
  EXPECT_EQ(rig.ask(request("bin_RFD00")), response("bin_RFD00"));
  EXPECT_EQ(rig.ask(request("wide_RFD00")), response("wide_RFD00_plus60"));
  EXPECT_EQ(rig.say("(RFD01)"), "(RFD016400)");
  rig.say("(PFA00C000)");
  rig.run(10s);
  EXPECT_EQ(rig.say("(RFD01)"), "(RFD014000)");
}

TEST(Asd7Device, EveryPrintedRequestIsAnsweredInItsForm) {
  for (const Vector& v : vectors()) {
    if (!is_request(v) || v.name == "bin_SFA01" || v.name == "group2_read") continue;
    const bool other =
        v.name.find("01RFD") != std::string::npos || v.name.find("05P") != std::string::npos;
    LineRig rig;
    const Bytes heard = rig.ask(v.bytes);
    const bool group = v.name == "group9";  // 09 would answer
    EXPECT_EQ(heard.empty(), other || group) << v.name;
    if (heard.empty()) continue;
    EXPECT_EQ(heard.front(), v.bytes.front()) << v.name;
  }
}

// --- Forms ---------------------------------------------------------------------------------------

TEST(Asd7Device, OptionalPartsAreMirrored) {
  LineRig rig;
  EXPECT_EQ(rig.say("(R0009"), "(R00090064");
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
  EXPECT_EQ(rig.say("(00R0009)"), "(00R00090064)");
  EXPECT_EQ(rig.say("(00R0009&AB)"), "(00N0004&C0)");
  EXPECT_EQ(rig.say("(R0009&69)"), "(R00090064&33)");
}

TEST(Asd7Device, ANumberThatIsNotItsOwnIsSilence) {
  LineRig rig({}, "0.75", 5);
  EXPECT_EQ(rig.say("(05R0009)"), "(05R00090064)");
  EXPECT_EQ(rig.say("(04R0009)"), "");
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
  EXPECT_EQ(rig.ask(binary({5, 'R', 0x00, 0x09})), binary({5, 'R', 0x00, 0x09, 0x00, 0x64}));
  EXPECT_TRUE(rig.ask(binary({4, 'R', 0x00, 0x09})).empty());
}

TEST(Asd7Device, WidthsAgreeOnSignedAndUnsignedValues) {
  LineRig rig;
  EXPECT_EQ(rig.ask(binary({'L', 'R', 0x00, 0x09})),
            binary({'L', 'R', 0x00, 0x09, 0, 0, 0x00, 0x64}));
  EXPECT_EQ(rig.ask(binary({'L', 'P', 0x08, 0x80, 0, 0, 0xFF, 0xFF})),
            binary({'L', 'P', 0x08, 0x80, 0, 0, 0xFF, 0xFF}));
  EXPECT_EQ(rig.ask(binary({'R', 0x08, 0x80})), binary({'R', 0x08, 0x80, 0xFF, 0xFF}));
  EXPECT_EQ(rig.ask(binary({'L', 'P', 0x08, 0x80, 0, 1, 0, 0})), response("bin_error_1"));
  EXPECT_EQ(rig.ask(binary({'L', 'P', 0xFA, 0x00, 0, 1, 0x84, 0})), response("bin_error_1"));
}

TEST(Asd7Device, InReverseAFrequencyIsNegativeOnlyWhenAskedFor) {
  LineRig rig;
  rig.say("(P00090014)");
  rig.say("(PFA011F40)");
  rig.say("(PFA00C600)");
  rig.run(4s);
  EXPECT_EQ(rig.say("(RFD00)"), "(RFD001F40)");
  EXPECT_EQ(rig.say("(RFD01)"), "(RFD016600)");
  set_profile(rig.profile, "signed_frequency", "on");
  EXPECT_EQ(rig.say("(RFD00)"), "(RFD00E0C0)");  // excerpt, p. 24
  EXPECT_EQ(rig.ask(request("wide_RFD00")), response("wide_RFD00_minus80"));
}

TEST(Asd7Device, LInAsciiIsAnUnknownCommandUntilItIsSwitchedOn) {
  LineRig rig;
  EXPECT_EQ(rig.say("(LR0009)"), "(N0003)");
  set_profile(rig.profile, "ascii_wide", "on");
  EXPECT_EQ(rig.say("(LR0009)"), "(LR000900000064)");
}

// --- Errors --------------------------------------------------------------------------------------

TEST(Asd7Device, EachErrorHasItsCode) {
  LineRig rig;
  EXPECT_EQ(rig.say("(P00090)&)"), "");           // no sum behind &
  EXPECT_EQ(rig.say("(PFA01FFFF)"), "(N0001)");   // above FH
  EXPECT_EQ(rig.say("(PFA0112345)"), "(N0001)");  // five digits
  EXPECT_EQ(rig.say("(PFA01)"), "(N0001)");       // none
  EXPECT_EQ(rig.say("(R0002)"), "(N0002)");
  EXPECT_EQ(rig.say("(RFA06)"), "(N0002)");  // an option board's
  EXPECT_EQ(rig.say("(X0009)"), "(N0003)");
  EXPECT_EQ(rig.say("(G00090000)"), "(N0003)");  // binary only
  EXPECT_EQ(rig.say("(R0009&00)"), "(N0004&60)");
  EXPECT_EQ(rig.say("(PFD000000)"), "(N0000)");  // read-only
  EXPECT_EQ(rig.say("(RFD001770)"), "");         // R with data
}

TEST(Asd7Device, MaximumFrequencyIsLockedWhileRunning) {
  LineRig rig;
  EXPECT_EQ(rig.say("(P00111770)"), "(P00111770)");
  EXPECT_EQ(rig.say("(PFA011388)"), "(PFA011388)");
  EXPECT_EQ(rig.say("(PFA00C400)"), "(PFA00C400)");
  rig.run(500ms);
  EXPECT_EQ(rig.say("(P00111F40)"), "(N0000)");
  EXPECT_EQ(rig.say("(R0011)"), "(R00111770)");
}

TEST(Asd7Device, ErrorsCarryASumAlwaysIfSwitchedSo) {
  LineRig rig({.error_sum_always = true});
  EXPECT_EQ(rig.say("(R0002)"), "(N0002&5E)");
}

// --- Silences ------------------------------------------------------------------------------------

TEST(Asd7Device, AFormatErrorIsSilence) {
  LineRig rig;
  for (const char* text : {"(1R0009)", "(R00)", "(R0009]", "(R0009)x", "(R00G9)", "()"}) {
    EXPECT_EQ(rig.say(text), "") << text;
    EXPECT_EQ(rig.say("(R0009)"), "(R00090064)") << text;
  }
}

TEST(Asd7Device, AnUnknownBinaryCommandIsSilence) {
  LineRig rig;
  EXPECT_TRUE(rig.ask(binary({'X', 0x00, 0x09, 0x00})).empty());
  EXPECT_TRUE(rig.ask(binary({'r', 0x00, 0x09})).empty());
  EXPECT_EQ(rig.ask(binary({'R', 0x00, 0x09})), binary({'R', 0x00, 0x09, 0x00, 0x64}));
}

TEST(Asd7Device, AnUnfinishedFrameIsGivenUpAfterHalfASecond) {
  LineRig rig;
  const Bytes cut = {kBinaryStart, 'R', 0x00};
  EXPECT_TRUE(rig.ask(cut, 450ms).empty());
  EXPECT_TRUE(rig.ask({0x09}, 10ms).empty());  // it waited
  EXPECT_EQ(rig.ask({0x8A}), binary({'R', 0x00, 0x09, 0x00, 0x64}));
  EXPECT_TRUE(rig.ask(cut, 550ms).empty());
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
  EXPECT_TRUE(rig.ask({'(', 'R', '0'}, 550ms).empty());
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
}

TEST(Asd7Device, OfTwoRequestsTheSecondIsLostWhileTheFirstIsAnswered) {
  LineRig rig;
  Bytes twice = binary({'R', 0x00, 0x09});
  const Bytes one = twice;
  twice.insert(twice.end(), one.begin(), one.end());
  EXPECT_EQ(rig.ask(twice), binary({'R', 0x00, 0x09, 0x00, 0x64}));
  EXPECT_EQ(rig.station.counters().bytes_lost, one.size());
}

// --- Times ---------------------------------------------------------------------------------------

TEST(Asd7Device, AnAnswerTakesItsTimeAndNotLessThanTheWaitTime) {
  LineRig rig;
  const auto time_of = [&](const char* text) {
    Bytes frame(text, text + std::string_view(text).size());
    frame.push_back('\r');
    rig.write(frame);
    const SimTime asked = rig.loop.now();
    EXPECT_TRUE(rig.read(3s));
    const SimDuration taken = rig.loop.now() - asked - LineRig::kCharacter;
    rig.hear(50ms);
    return taken;
  };
  EXPECT_EQ(time_of("(R0009)"), 10ms);
  EXPECT_EQ(time_of("(P08800001)"), 10ms);
  EXPECT_EQ(time_of("(W08800001)"), 50ms);
  rig.say("(P08050028)", 500ms);  // 0.40 s
  EXPECT_EQ(time_of("(R0009)"), 400ms);
  EXPECT_EQ(time_of("(W08800001)"), 400ms);
}

TEST(Asd7Device, BaudRateAndParityCountFromTheNextResetOn) {
  LineRig rig;
  EXPECT_EQ(rig.say("(W08000002)"), "(W08000002)");
  EXPECT_EQ(rig.say("(W08010000)"), "(W08010000)");
  EXPECT_EQ(rig.station.time_of(1), from_seconds(11.0 / 9600));
  rig.mains(false);
  rig.run(30s);
  EXPECT_FALSE(rig.drive.alive());
  rig.mains(true);
  rig.run(3s);
  EXPECT_EQ(rig.station.time_of(1), from_seconds(10.0 / 4800));
}

TEST(Asd7Device, AnOwnNumberCountsAtOnce) {
  LineRig rig;
  EXPECT_EQ(rig.say("(00P08020007)"), "(00P08020007)");
  EXPECT_EQ(rig.say("(00R0802)"), "");
  EXPECT_EQ(rig.say("(07R0802)"), "(07R08020007)");
}

// --- Broadcasts ----------------------------------------------------------------------------------

TEST(Asd7Device, ABroadcastIsAnsweredByTheNumberWithZerosForStars) {
  LineRig rig;
  EXPECT_EQ(rig.ask(request("all")), response("all"));
  EXPECT_EQ(rig.ask(request("bin_all")), response("bin_all"));
  EXPECT_EQ(rig.say("(*0PFA010BB8)"), "(00PFA010BB8)");
  EXPECT_EQ(rig.say("(0*PFA010BB8)"), "(00PFA010BB8)");
}

TEST(Asd7Device, TheOthersDoAsTheyAreToldAndSayNothing) {
  LineRig rig({}, "0.75", 29);
  EXPECT_EQ(rig.ask(request("group9")), Bytes{});
  EXPECT_EQ(rig.drive.frequency(), 6000);
  EXPECT_EQ(rig.say("(2*PFA010BB8)"), "");
  EXPECT_EQ(rig.drive.frequency(), 3000);
  EXPECT_EQ(rig.say("(*8PFA011770)"), "");
  EXPECT_EQ(rig.drive.frequency(), 3000);
  EXPECT_TRUE(rig.ask(request("bin_all")).empty());
  EXPECT_EQ(rig.drive.frequency(), 6000);
  EXPECT_EQ(rig.say("(**PFA01FFFF)"), "");  // nor errors
}

TEST(Asd7Device, ABroadcastThatReadsIsSilenceUntilItIsSwitchedOn) {
  LineRig rig;
  EXPECT_EQ(rig.say("(**R0009)"), "");
  EXPECT_EQ(rig.say("(**R0002)"), "");
  EXPECT_TRUE(rig.ask(binary({0xFF, 'G', 0x00, 0x09, 0, 0})).empty());
  LineRig family({.broadcast_read = true}, "0.75", 2);
  EXPECT_EQ(family.ask(request("group2_read")), response("group2_read"));
}

// --- Trips, resets, power ------------------------------------------------------------------------

TEST(Asd7Device, WhileTrippedCommandsAreLowerCase) {
  LineRig rig;
  rig.say("(PFA009000)");
  EXPECT_EQ(rig.say("(RFC90)"), "(rFC900011)");
  EXPECT_EQ(rig.say("(RFD01)"), "(rFD011003)");
  EXPECT_EQ(rig.say("(R0002&62)"), "(n0002&7E)");
  EXPECT_EQ(rig.ask(request("bin_RFC90")), binary({'r', 0xFC, 0x90, 0x00, 0x11}));
  EXPECT_EQ(rig.ask(binary({'G', 0xFC, 0x90, 0, 0})), binary({'g', 0xFC, 0x90, 0x00, 0x11}));
  EXPECT_EQ(rig.ask(binary({'L', 'R', 0xFC, 0x90})),
            binary({'L', 'r', 0xFC, 0x90, 0, 0, 0x00, 0x11}));
}

TEST(Asd7Device, Bit14OfTheStatusCanMeanAFault) {
  LineRig rig({.bit14_faulted = true});
  EXPECT_EQ(rig.say("(RFD01)"), "(RFD010000)");
  rig.say("(PFA009000)");
  EXPECT_EQ(rig.say("(RFD01)"), "(rFD015003)");
}

TEST(Asd7Device, AResetIsNotAnsweredAndTwoSecondsOfSilenceFollow) {
  LineRig rig;
  rig.say("(PFA009000)");
  EXPECT_EQ(rig.say("(PFA002000)"), "");
  EXPECT_EQ(rig.say("(RFC90)", 1s), "");
  EXPECT_GT(rig.station.counters().bytes_lost, 0U);
  rig.run(1500ms);
  EXPECT_EQ(rig.say("(RFC90)"), "(RFC900000)");
  EXPECT_EQ(rig.say("(RFE10)"), "(RFE100011)");
  EXPECT_EQ(rig.say("(RFA00)"), "(RFA000000)");
}

TEST(Asd7Device, AResetWithoutATripIsSilence) {
  LineRig rig;
  EXPECT_EQ(rig.say("(PFA002000)"), "");
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
}

TEST(Asd7Device, WIsKeptWithoutPowerAndPIsNot) {
  LineRig rig;
  rig.say("(W00090032)");
  rig.say("(P00100019)");
  EXPECT_EQ(rig.say("(R0009)"), "(R00090032)");
  EXPECT_EQ(rig.say("(R0010)"), "(R00100019)");
  EXPECT_EQ(rig.drive.memory().eeprom_writes, 1U);
  rig.mains(false);
  rig.run(30s);
  EXPECT_EQ(rig.say("(R0009)"), "");
  rig.mains(true);
  rig.run(3s);
  EXPECT_EQ(rig.say("(R0009)"), "(R00090032)");
  EXPECT_EQ(rig.say("(R0010)"), "(R00100064)");
  EXPECT_EQ(rig.say("(RFA01)"), "(RFA010000)");
}

TEST(Asd7Device, InitialisationTakesASecondInWhichWritesAreRefused) {
  LineRig rig;
  rig.say("(W00090032)");
  EXPECT_EQ(rig.say("(W00070002)"), "(N0001)");
  EXPECT_EQ(rig.say("(W00070003)"), "(W00070003)");
  EXPECT_EQ(rig.say("(W00090032)"), "(N0000)");
  EXPECT_EQ(rig.say("(R0009)"), "(R00090064)");
  EXPECT_EQ(rig.say("(R0007)"), "(R00070000)");
  rig.run(1s);
  EXPECT_EQ(rig.say("(W00090032)"), "(W00090032)");
}

// --- EEPROM --------------------------------------------------------------------------------------

TEST(Asd7Device, AWriteThatTheEepromDoesNotTakeTripsEep1) {
  LineRig rig;
  rig.eeprom.faults.write_fails = true;
  EXPECT_EQ(rig.say("(P00090032)"), "(P00090032)");
  EXPECT_EQ(rig.say("(W00090032)").substr(1), "n0000)");
  EXPECT_EQ(rig.say("(RFC90)"), "(rFC900012)");
}

TEST(Asd7Device, DamagedParametersBecomeTheFactorysAndTripEep3) {
  LineRig rig;
  rig.say("(W00090032)");
  const auto image = rig.memory.read("parameters");
  ASSERT_TRUE(image);
  Bytes damaged = *image;
  damaged[0] ^= 0x40;
  rig.mains(false);
  rig.run(30s);
  rig.memory.write("parameters", damaged);
  rig.mains(true);
  rig.run(3s);
  EXPECT_EQ(rig.say("(RFC90)"), "(rFC900014)");
  EXPECT_EQ(rig.say("(R0009)"), "(r00090064)");
  EXPECT_EQ(rig.say("(W00070003)"), "(w00070003)");  // makes it good again
  rig.run(2s);
  rig.say("(PFA002000)");
  rig.run(3s);
  EXPECT_EQ(rig.say("(RFC90)"), "(RFC900000)");
}

TEST(Asd7Device, AnEepromThatCannotBeReadTripsEep2) {
  LineRig rig;
  rig.eeprom.faults.read_fails = true;
  rig.mains(false);
  rig.run(30s);
  rig.mains(true);
  rig.run(3s);
  EXPECT_EQ(rig.say("(RFC90)"), "(rFC900013)");
}

TEST(Asd7Device, TripsAndHoursOutliveThePower) {
  LineRig rig;
  rig.say("(PFA009000)");
  rig.run(2s);
  EXPECT_EQ(Eeprom(rig.memory, factory_parameters(rig.model)).kept().past_trips[0], 0x11);
}

// --- Time-out ------------------------------------------------------------------------------------

TEST(Asd7Device, TheTimeOutTripsErr5AfterTheLastFrameForIt) {
  LineRig rig;
  EXPECT_EQ(rig.say("(P08030002)"), "(P08030002)");
  rig.run(1500ms);
  EXPECT_EQ(rig.say("(05R0009)"), "");  // another's does not count
  EXPECT_EQ(rig.say("(R00)"), "");      // nor does what is no message
  EXPECT_FALSE(rig.drive.tripped());
  rig.run(400ms);
  EXPECT_EQ(rig.drive.trip(), Trip::kErr5);
}

TEST(Asd7Device, EachFrameForItStartsTheTimeOutAnew) {
  LineRig rig;
  rig.say("(P08030001)");
  for (int i = 0; i < 10; ++i) {
    rig.run(700ms);
    rig.say("(R0009)");
  }
  EXPECT_FALSE(rig.drive.tripped());
  rig.say("(P08030000)");
  rig.run(10s);
  EXPECT_FALSE(rig.drive.tripped());
}

TEST(Asd7Device, ATimeOutCanBeAnAlarmThatTheNextFrameEnds) {
  LineRig rig({.time_out_unit = 100ms});
  rig.say("(P08040000)");
  rig.say("(P08030005)");  // 0.5 s
  rig.run(600ms);
  EXPECT_NE(rig.drive.alarms() & kAlarmCommunication, 0);
  EXPECT_FALSE(rig.drive.tripped());
  rig.say("(R0009)");
  EXPECT_EQ(rig.drive.alarms() & kAlarmCommunication, 0);
}

TEST(Asd7Device, P9sMatrixCountsThisPortInItsLowerPlace) {
  LineRig rig({.time_out_actions = TimeOutActions::kMatrix});
  EXPECT_EQ(rig.say("(P08040006)"), "(P08040006)");  // none
  rig.say("(P08030001)");
  rig.run(2s);
  EXPECT_FALSE(rig.drive.tripped());
  rig.say("(P08040008)");  // trip
  rig.run(2s);
  EXPECT_EQ(rig.drive.trip(), Trip::kErr5);
}

// --- Drive to drive ------------------------------------------------------------------------------

TEST(Asd7Device, SFromAMasterSetsTheFrequencyAndIsNeverAnswered) {
  LineRig rig;
  EXPECT_TRUE(rig.ask(request("bin_SFA01")).empty());
  EXPECT_EQ(rig.drive.frequency(), 3000);  // 50 % of 0 .. 60 Hz
  rig.say("(P08120FA0)");                  // 0 % is 40 Hz
  EXPECT_TRUE(rig.ask(request("bin_SFA01")).empty());
  EXPECT_EQ(rig.drive.frequency(), 5000);
  EXPECT_TRUE(rig.ask(binary({'S', 0xFA, 0x01, 0x27, 0x11})).empty());  // 100.01 %
  EXPECT_TRUE(rig.ask(binary({'S', 0x00, 0x09, 0x00, 0x01})).empty());
  EXPECT_TRUE(rig.ask({kBinaryStart, 'S', 0xFA, 0x01, 0x00, 0x00, 0x00}).empty());  // wrong sum
  EXPECT_EQ(rig.drive.frequency(), 5000);
}

TEST(Asd7Device, ATrippedMasterIsObeyedAsF806Says) {
  const Bytes tripped = binary({'s', 0xFA, 0x01, 0x13, 0x88});
  LineRig stops;
  stops.ask(request("bin_SFA01"));
  EXPECT_TRUE(stops.ask(tripped).empty());
  EXPECT_EQ(stops.drive.frequency(), 0);
  LineRig goes_on;
  goes_on.say("(P08060001)");
  goes_on.ask(request("bin_SFA01"));
  goes_on.ask(tripped);
  EXPECT_EQ(goes_on.drive.frequency(), 3000);
  LineRig trips;
  trips.say("(P08060002)");
  trips.ask(tripped);
  EXPECT_EQ(trips.drive.trip(), Trip::kE);
}

TEST(Asd7Device, AMasterSaysItsFrequencyToTheOthers) {
  LineRig rig;
  rig.say("(PFA010BB8)");
  rig.say("(PFA00C000)");
  rig.say("(P08060003)", 30ms);
  Bytes heard = rig.hear(450ms);
  ASSERT_GE(heard.size(), 7U);
  heard.resize(7);
  EXPECT_EQ(heard, request("bin_SFA01"));
  rig.say("(P08060004)", 30ms);
  heard = rig.hear(450ms);
  ASSERT_GE(heard.size(), 7U);
  heard.resize(7);
  EXPECT_EQ(heard, binary({'S', 0xFA, 0x01, 0, 0}));
}

// --- The client ----------------------------------------------------------------------------------

TEST(Asd7Client, ReadsAndWritesInEachFormat) {
  const ParameterRow& acceleration = *protocol::find(kTable.parameters, 0x0009);
  for (const Format format : {Format::kAscii, Format::kBinary16, Format::kBinary32}) {
    LineRig rig;
    Client client(rig, format);
    client.write(acceleration, 50, true);
    EXPECT_EQ(client.read(acceleration), 50);
    EXPECT_THROW(client.write(acceleration, 50000, true), DriveRefused);
    client.set_number(AsdNumber{.tens = 0, .units = 7});
    EXPECT_THROW(client.read(acceleration), DriveSilent);
  }
}

}  // namespace
}  // namespace virtdrive::asd7
