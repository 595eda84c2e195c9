// Encoders, what SAVE keeps, and the recorder.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

Settings absolute(EncoderType type) {
  Settings settings;
  settings.etype = static_cast<std::int32_t>(type);
  settings.ecpr = 65536;
  settings.pcounts = 13107;
  return settings;
}

TEST(AbsoluteEncoders, NeedNoPhasingAndKeepTheirPosition) {
  for (int type = 1; type <= 5; ++type) {
    Rig rig(bench_axis(), {}, {}, absolute(static_cast<EncoderType>(type)));
    rig.turn_to(3.3);
    EXPECT_EQ(rig.axis(1).position(), 0);
    EXPECT_EQ(rig.axis(1).on(), Result::kFault);
    rig.run_for(200ms);  // 150 ms until it answers (5.3)
    EXPECT_TRUE(rig.axis(1).phased());
    rig.turn_to(3.3 + 2 * kTurnRad, 1);
    const std::int32_t expected =
        static_cast<std::int32_t>((3.3 + 2 * kTurnRad + kTurnRad / 20) / kTurnRad * 65536);
    EXPECT_EQ(rig.axis(1).position(), expected);
    // 500 rpm are half the counts here; KP stays, since it is per count and cycle.
    rig.set(&Settings::vkp, 24, 1);
    rig.set(&Settings::vki, 4, 1);
    rig.set(&Settings::vel, 3'000'000, 1);
    ASSERT_EQ(rig.axis(1).on(), Result::kOk);
    EXPECT_FALSE(rig.axis(1).busy());
    EXPECT_GT(rig.move_to(expected + 65536, 1), 0);
    rig.run_for(100ms);
    EXPECT_NEAR(rig.axis(1).position(), expected + 65536, 4);
    EXPECT_NEAR(rig.angle_rad(1), 3.3 + 3 * kTurnRad, 1e-3);
    EXPECT_EQ(rig.axis(1).encoder_id(), 0x17160001U);
    EXPECT_EQ(rig.axis(1).encoder_status(), 0);
  }
}

TEST(AbsoluteEncoders, AreReadOneSlotLate) {
  PositionInput input;
  input.start(EncoderType::kBiss, false);
  ShaftReading reading{.answer = ShaftReading::Answer::kWord, .word = {.position = 100}};
  input.read(reading);
  EXPECT_EQ(input.position(), 100);
  reading.word.position = 140;
  input.read(reading);
  EXPECT_EQ(input.position(), 100);
  input.read(reading);
  EXPECT_EQ(input.position(), 140);
}

TEST(AbsoluteEncoders, TellTheirFaults) {
  Rig rig(bench_axis(), {}, {}, absolute(EncoderType::kEndat));
  rig.run_for(200ms);
  FittedAbsoluteEncoder& encoder = rig.hardware.axis[1].absolute;
  const auto bits = [&] {
    rig.drive->hardware_changed();
    rig.run_for(2ms);
    return rig.axis(1).status() & (kEncoderFault | kEncoderWarning);
  };
  EXPECT_EQ(bits(), 0);
  encoder.sensor.battery = AbsoluteEncoder::Battery::kLow;
  EXPECT_EQ(bits(), kEncoderWarning);
  encoder.sensor.battery = AbsoluteEncoder::Battery::kLost;
  EXPECT_EQ(bits(), kEncoderFault | kEncoderWarning);
  encoder.sensor.battery = AbsoluteEncoder::Battery::kGood;
  encoder.sensor.crc_fault = true;
  EXPECT_EQ(bits(), kEncoderFault);
  EXPECT_EQ(rig.axis(1).encoder_status(), kEncoderCrc);
  encoder.sensor.crc_fault = false;
  encoder.silent = true;
  EXPECT_EQ(bits(), kEncoderFault);
  std::uint16_t word = 0;
  EXPECT_EQ(rig.axis(1).read_encoder_word(word), Result::kExecution);
  EXPECT_EQ(rig.axis(1).on(), Result::kFault);
}

TEST(AbsoluteEncoders, HaveAMemory) {
  Rig rig(bench_axis(), {}, {}, absolute(EncoderType::kFaCoder));
  rig.run_for(200ms);
  std::uint16_t word = 1;
  rig.set(&Settings::eaddr, 12, 1);
  EXPECT_EQ(rig.axis(1).read_encoder_word(word), Result::kOk);
  EXPECT_EQ(word, 0);
  EXPECT_EQ(rig.axis(1).write_encoder_word(0xBEEF), Result::kOk);
  rig.drive->restart({rig.axis(0).settings(), rig.axis(1).settings()});
  rig.run_for(200ms);
  EXPECT_EQ(rig.axis(1).read_encoder_word(word), Result::kOk);
  EXPECT_EQ(word, 0xBEEF);
  rig.set(&Settings::eaddr, 256, 1);
  EXPECT_EQ(rig.axis(1).write_encoder_word(1), Result::kOutOfRange);
  Rig incremental;
  EXPECT_EQ(incremental.axis(1).read_encoder_word(word), Result::kOutOfRange);
}

TEST(AbsoluteEncoders, TheInterfaceTakesOneProtocolUntilAReset) {
  Rig rig;
  ServoAxis& axis = rig.axis(1);
  EXPECT_EQ(rig.axis(0).set(&Settings::etype, 1), Result::kInvalidState);  // channel 2 only
  EXPECT_EQ(axis.set(&Settings::etype, 6), Result::kOutOfRange);
  EXPECT_EQ(axis.set(&Settings::etype, 2), Result::kOk);
  EXPECT_EQ(axis.settings().ecpr, 65536);
  EXPECT_EQ(axis.settings().pcounts, 13107);
  EXPECT_EQ(axis.set(&Settings::etype, 1), Result::kInvalidState);
  EXPECT_EQ(axis.set(&Settings::etype, 0), Result::kOk);
  EXPECT_EQ(axis.set(&Settings::etype, 1), Result::kInvalidState);
  EXPECT_EQ(axis.set(&Settings::etype, 2), Result::kOk);
  EXPECT_EQ(axis.set(&Settings::etype, 0), Result::kOk);
  rig.drive->restart({rig.axis(0).settings(), axis.settings()});
  EXPECT_EQ(axis.set(&Settings::etype, 1), Result::kOk);

  FirmwareOptions options;
  options.absolute_on_both = true;
  Rig both(bench_axis(), options);
  EXPECT_EQ(both.axis(0).set(&Settings::etype, 1), Result::kOk);
}

TEST(AbsoluteEncoders, APhaseOriginIsSavedAsTheEncoderCounts) {
  Hardware hardware;
  hardware.axis[1].absolute.sensor.zero_rad = 0.7;  // mounted anyhow
  const Settings settings = absolute(EncoderType::kEndat);
  Rig rig(bench_axis(), {}, hardware, settings);
  rig.run_for(200ms);
  ASSERT_EQ(rig.axis(1).align(), Result::kOk);
  ASSERT_GT(rig.run_to([&] { return !rig.axis(1).busy(); }), 0);
  ASSERT_EQ(rig.axis(1).set_position(123'456), Result::kOk);
  const Settings saved = rig.axis(1).saved();
  const double angle = rig.angle_rad(1);
  rig.drive->restart({settings, saved});
  rig.run_for(200ms);
  EXPECT_TRUE(rig.axis(1).phased());
  const double thinks = rig.axis(1).phase_angle() / 13107.0 - 0.25;
  EXPECT_NEAR(std::remainder(thinks - 5 * angle / kTurnRad, 1.0), 0, 0.005);
}

TEST(IncrementalEncoder, CountsFromPowerUpAndMayBeInverted) {
  Rig rig;
  rig.turn_to(1.0);
  rig.drive->restart({Settings{}, Settings{}});
  EXPECT_EQ(rig.axis().position(), 0);
  rig.turn_to(1.0 + 0.25 * kTurnRad);
  EXPECT_NEAR(rig.axis().position(), kTurn / 4, 1);
  rig.set(&Settings::pinvert, 1);
  EXPECT_NEAR(rig.axis().position(), -kTurn / 4, 1);
  rig.turn_to(1.0 + 0.5 * kTurnRad);
  EXPECT_NEAR(rig.axis().position(), -kTurn / 2, 1);
}

TEST(IncrementalEncoder, TheCounterWrapsAndSaysSo) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().set_position(INT32_MAX - 20'000), Result::kOk);
  EXPECT_EQ(rig.axis().status() & kPositionWrapped, 0);
  ASSERT_EQ(rig.axis().jog(5'000'000), Result::kOk);
  rig.run_for(300ms);
  EXPECT_LT(rig.axis().position(), 0);
  EXPECT_TRUE((rig.axis().status() & kPositionWrapped) != 0);
  EXPECT_NEAR(rig.axis().position_error(), 0, 60);
}

TEST(Encoder, ACutCableLetsTheErrorGrow) {
  Rig rig;
  rig.set(&Settings::ctime, 0);
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().jog(3'000'000), Result::kOk);
  rig.run_for(100ms);
  rig.hardware.axis[0].incremental_cut = true;
  const std::int32_t held = rig.axis().position();
  rig.run_for(300ms);
  EXPECT_NEAR(rig.axis().position(), held, 100);
  EXPECT_TRUE((rig.axis().status() & kPositionErrorBit) != 0);
}

// --- SAVE ----------------------------------------------------------------------------------------

TEST(SavedSettings, ComeBackWholeOrNotAtAll) {
  Settings settings;
  settings.kp = 1234;
  settings.data7 = -5;
  settings.errmask = -1;
  settings.vel = 99;  // is not saved
  std::vector<std::uint8_t> block = pack(settings);
  Settings read;
  ASSERT_TRUE(unpack(block, read));
  EXPECT_EQ(read.kp, 1234);
  EXPECT_EQ(read.data7, -5);
  EXPECT_EQ(read.errmask, -1);
  EXPECT_EQ(read.vel, Settings{}.vel);
  for (std::size_t i = 0; i < block.size(); i += 7) {
    std::vector<std::uint8_t> damaged = block;
    damaged[i] ^= 0x10;
    Settings untouched;
    EXPECT_FALSE(unpack(damaged, untouched));
    EXPECT_EQ(untouched, Settings{});
  }
  block.resize(block.size() - 3);
  EXPECT_FALSE(unpack(block, read));
  EXPECT_FALSE(unpack({}, read));
}

TEST(SavedSettings, AreRestoredIntoAnAxisThatIsOff) {
  Rig rig;
  Settings saved = rig.axis().saved();
  saved.kp = 777;
  EXPECT_EQ(rig.axis().restore(saved), Result::kOk);
  EXPECT_EQ(rig.axis().settings().kp, 777);
  ASSERT_EQ(rig.ready(), Result::kOk);
  EXPECT_EQ(rig.axis().restore(saved), Result::kInvalidState);
}

TEST(Parameters, WhatCannotBeIsRefused) {
  Rig rig;
  for (const auto member : {&Settings::pole_pairs, &Settings::ecpr, &Settings::pcounts,
                            &Settings::gear_in, &Settings::gear_out, &Settings::itime}) {
    EXPECT_EQ(rig.axis().set(member, 0), Result::kOutOfRange);
  }
  EXPECT_EQ(rig.axis().set(&Settings::ds, 0), Result::kOk);  // ignored
  EXPECT_EQ(rig.axis().settings().ds, 2);
  EXPECT_EQ(rig.axis().set(&Settings::pmap, 6), Result::kOutOfRange);
  rig.set(&Settings::pole_pairs, 4);
  EXPECT_EQ(rig.axis().settings().pcounts, 32768);
}

// --- Recorder ------------------------------------------------------------------------------------

TEST(Recorder, TakesAMotionFromItsStartToItsEnd) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  Recorder& recorder = rig.drive->recorder();
  ASSERT_EQ(recorder.set_channel(0, 0, 0), Result::kOk);  // position, 32 bits
  ASSERT_EQ(recorder.set_channel(1, 8, 0), Result::kOk);
  ASSERT_EQ(recorder.set_channel(2, 12, 0), Result::kOk);
  recorder.set_rate(4);
  ASSERT_EQ(rig.drive->set_trigger(3), Result::kOk);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kArmed);
  rig.run_for(20ms);
  EXPECT_EQ(recorder.sample_count(), 0U);
  const std::int32_t start = rig.axis().position();
  rig.axis().set_target(start + 10'000);
  ASSERT_EQ(rig.axis().go(), Result::kOk);
  const double time_s = rig.run_to_end_of_motion();
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kIdle);
  EXPECT_NEAR(static_cast<double>(recorder.sample_count()), time_s / 200e-6, 2);
  EXPECT_TRUE(recorder.wide());
  EXPECT_NEAR(recorder.value(0, 0), start, 5);
  const std::size_t last = recorder.sample_count() - 1;
  EXPECT_NEAR(recorder.value(0, last), start + 10'000, 60);
  for (std::size_t i = 1; i <= last; ++i) {
    EXPECT_GE(recorder.value(0, i), recorder.value(0, i - 1) - 3);
    EXPECT_LE(std::abs(recorder.value(1, i)), 120);
  }
}

TEST(Recorder, UntilFullOrAsARing) {
  Rig rig;
  ASSERT_EQ(rig.ready(), Result::kOk);
  Recorder& recorder = rig.drive->recorder();
  ASSERT_EQ(recorder.set_channel(0, 8, 0), Result::kOk);
  ASSERT_EQ(recorder.set_channel(3, 10, 0), Result::kOk);
  ASSERT_EQ(rig.drive->set_trigger(2), Result::kOk);
  rig.run_for(25ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kUntilFull);
  rig.run_for(1ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kIdle);
  EXPECT_EQ(recorder.sample_count(), Recorder::kCapacity);
  EXPECT_FALSE(recorder.wide());

  ASSERT_EQ(rig.drive->set_trigger(1), Result::kOk);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kRing);
  rig.run_for(100ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kRing);
  rig.move_to(rig.axis().position() + 3000);
  rig.run_for(1ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kIdle);
  EXPECT_EQ(recorder.sample_count(), Recorder::kCapacity);
  ASSERT_EQ(rig.drive->set_trigger(0), Result::kOk);
}

TEST(Recorder, WaitsForLevelsInputsAndOutputs) {
  Rig rig;
  Recorder& recorder = rig.drive->recorder();
  ASSERT_EQ(recorder.set_channel(0, 0, 0), Result::kOk);
  ASSERT_EQ(rig.ready(), Result::kOk);
  ASSERT_EQ(rig.axis().set_position(0), Result::kOk);
  recorder.set_level(4000);
  ASSERT_EQ(rig.drive->set_trigger(9), Result::kOk);
  rig.run_for(5ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kArmed);
  rig.move_to(8000);
  EXPECT_NEAR(recorder.value(0, 0), 4000, 60);
  ASSERT_EQ(rig.drive->set_trigger(6), Result::kOk);  // until it is below
  rig.move_to(0);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kIdle);
  EXPECT_NEAR(recorder.value(0, recorder.sample_count() - 1), 4000, 60);

  recorder.set_level(2);
  ASSERT_EQ(rig.drive->set_trigger(8), Result::kOk);
  rig.hardware.axis[0].input_pins = 4;
  rig.run_for(2ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kArmed);
  rig.hardware.axis[0].input_pins = 6;
  rig.run_for(2ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kUntilFull);

  ASSERT_EQ(rig.axis().off(), Result::kOk);
  ASSERT_EQ(rig.drive->set_trigger(7), Result::kOk);
  rig.run_for(2ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kArmed);
  ASSERT_EQ(rig.axis().set_output(500), Result::kOk);
  rig.run_for(2ms);
  EXPECT_EQ(recorder.mode(), Recorder::Mode::kUntilFull);
}

TEST(Recorder, RefusesReservedSourcesAndUnknownTriggers) {
  Recorder recorder;
  for (const int source : {-1, 4, 7, 22}) {
    EXPECT_EQ(recorder.set_channel(0, source, 0), Result::kOutOfRange);
  }
  EXPECT_EQ(recorder.set_channel(0, 21, 1), Result::kOk);
  EXPECT_EQ(recorder.axis(), 1U);
  EXPECT_EQ(recorder.set_trigger(11), Result::kOutOfRange);
}

}  // namespace
}  // namespace virtdrive::rzt1
