#include "firmware_models/toshiba_mcu/firmware.h"

#include <gtest/gtest.h>
#include <memory>

#include "plant/motor_library.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

// An axis that outlives the programs that drive it.
class FirmwareLife : public testing::Test {
 protected:
  FirmwareLife() { boot(); }

  void boot() {
    Axis* const axes[] = {&axis_};
    firmware_ = std::make_unique<Firmware>(loop_, axes, Seed{1});
  }
  void cut_power() { firmware_.reset(); }
  void run_for(SimDuration time) {
    loop_.run_until(loop_.now() + time);
    axis_.advance_to(loop_.now());
  }
  double rpm() const { return axis_.state().speed_radps * 9.549296585513721; }
  double most_current_a() const {
    double most = 0;
    for (const double current : axis_.phase_currents_a()) most = std::max(most, std::abs(current));
    return most;
  }
  void run_up(std::int32_t speed) {
    firmware_->board(0).set_speed_rpm(speed);
    firmware_->board(0).start();
    run_for(4s);
    ASSERT_NEAR(rpm(), speed, 10);
  }

  EventLoop loop_;
  Axis axis_{{.motor = find_motor("db42s03").electrical,
              .link = {.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3},
              .mechanics = find_motor("db42s03").mechanics},
             Integrator::kFast,
             {.inertia_kgm2 = 2e-5}};
  std::unique_ptr<Firmware> firmware_;
};

TEST_F(FirmwareLife, WithoutPowerTheGatesAreOffAndTheRotorSpinsOn) {
  run_up(2000);
  cut_power();
  run_for(5ms);
  EXPECT_EQ(most_current_a(), 0);
  EXPECT_GT(rpm(), 1900);
  const double before = rpm();
  run_for(100ms);
  EXPECT_LT(rpm(), before);
  EXPECT_GT(rpm(), 500) << "friction alone slows it down";
}

TEST_F(FirmwareLife, AProgramThatCrashedInTheMiddleOfAnInterruptLeavesNoGateOn) {
  run_up(2000);
  loop_.run_until(loop_.now() + 40us);  // between two PWM interrupts
  cut_power();
  EXPECT_EQ(loop_.next(), kNever) << "nothing of it is left in the loop";
  loop_.run_until(loop_.now() + 20ms);
  axis_.advance_to(loop_.now());
  EXPECT_EQ(most_current_a(), 0);
}

TEST_F(FirmwareLife, ItComesUpWithTheRotorSpinningStoppedAndAsAfterAReset) {
  run_up(2000);
  EXPECT_EQ(firmware_->take_reset_status(), 1);
  EXPECT_EQ(firmware_->take_reset_status(), 0);
  cut_power();
  run_for(20ms);
  boot();
  const MotorChannel& channel = firmware_->board(0).channel();
  EXPECT_EQ(channel.stage(), Stage::kStop);
  EXPECT_EQ(channel.target_rpm(), 0);
  EXPECT_EQ(channel.settings().pole_pairs, kFactorySettings.pole_pairs);
  EXPECT_EQ(firmware_->tick(), 0U);
  EXPECT_EQ(firmware_->take_reset_status(), 1);
  EXPECT_EQ(firmware_->board(0).turn_number(), 0);
  EXPECT_GT(rpm(), 1500);
  run_for(50ms);
  EXPECT_EQ(most_current_a(), 0) << "in reset the gates are off";
}

TEST_F(FirmwareLife, AStartAfterThePowerCameBackRunsTheMotorAgain) {
  run_up(2000);
  cut_power();
  run_for(3s);
  EXPECT_EQ(rpm(), 0);
  boot();
  run_up(-1500);
  EXPECT_EQ(firmware_->board(0).channel().errors(), 0U);
}

TEST_F(FirmwareLife, TheEncodersCountBeginsAtTheResetWhereverTheRotorStands) {
  ChannelSettings settings = kFactorySettings;
  settings.encoder.value = 3;
  firmware_->board(0).set_settings(settings);
  run_up(1000);
  EXPECT_GT(firmware_->board(0).encoder_count(), 1000);
  cut_power();
  run_for(2s);
  boot();
  firmware_->board(0).set_settings(settings);
  EXPECT_EQ(firmware_->board(0).encoder_count(), 0);
  EXPECT_EQ(firmware_->board(0).absolute_position(), 0U);
}

TEST_F(FirmwareLife, ManyPowerCyclesWhileStartingHarmNothing) {
  RandomStream random = Seed{7}.stream("power");
  for (int i = 0; i < 40; ++i) {
    firmware_->board(0).set_speed_rpm(i % 2 == 0 ? 2000 : -2000);
    firmware_->board(0).start();
    run_for(SimDuration{static_cast<std::int64_t>(random.uniform() * 1.5e9)});
    cut_power();
    run_for(SimDuration{static_cast<std::int64_t>(random.uniform() * 2e8)});
    boot();
  }
  run_for(3s);
  EXPECT_EQ(rpm(), 0);
  EXPECT_EQ(axis_.counters().stalled, 0U);
  EXPECT_LT(axis_.state().bus_v, 30);
}

TEST_F(FirmwareLife, AnArmedOscilloscopeIsForgottenInAReset) {
  firmware_->snapshot_scope().arm({.motor = 0, .selected = 7});
  cut_power();
  boot();
  std::array<std::int16_t, SnapshotScope::kBlock> block{};
  EXPECT_EQ(firmware_->snapshot_scope().next_block(block), Outcome::kRefused);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
