// The long sweeps: every search from many starts.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/searches.h"

namespace virtdrive::rzt1 {
namespace {

TEST(PhasingSweep, EachModeFindsTheRotorFromTwentyFourAngles) {
  for (const Case& c : kCases) phase_from(c, 24);
}

TEST(HomingSweep, TheIndexGivesTheSameZeroFromTwentyStarts) {
  by_index(20);
}

TEST(HomingSweep, TheSwitchGivesTheSameZeroFromTwentyStarts) {
  by_switch(20);
}

TEST(HomingSweep, TheHardStopGivesTheSameZeroFromTwentyStarts) {
  by_hard_stop(20);
}

// --- The factory's gains on other motors ---------------------------------------------------------

struct Variant {
  double inertia_kgm2, resistance_ohm, inductance_h, dead_time_s;
  int encoder_lines;
};

// The limits that the factory's gains were chosen by, with a margin of 1.5. A dead time of 2 us
// that nothing compensates, with the coarser encoder, makes it cycle by some counts more.
void check(const Variant& v) {
  SCOPED_TRACE(testing::Message() << "J " << v.inertia_kgm2 << " R " << v.resistance_ohm << " L "
                                  << v.inductance_h << " dead " << v.dead_time_s << " lines "
                                  << v.encoder_lines);
  AxisParameters parameters = bench_axis();
  parameters.mechanics.inertia_kgm2 = v.inertia_kgm2;
  parameters.motor.resistance_ohm = v.resistance_ohm;
  parameters.motor.inductance_d_h = parameters.motor.inductance_q_h = v.inductance_h;
  Hardware hardware;
  hardware.dead_time_s = v.dead_time_s;
  for (AxisHardware& axis : hardware.axis) axis.incremental.lines = v.encoder_lines;
  Settings settings;
  settings.pimode = 1;  // dead time leaves PIOUT nothing to force with
  settings.ecpr = 4 * v.encoder_lines;
  settings.pcounts = settings.ecpr / 5;
  Rig rig(parameters, {}, hardware, settings);
  ASSERT_EQ(rig.ready(), Result::kOk);
  const std::int32_t target = rig.axis().position() + settings.ecpr;
  ASSERT_GT(rig.move_to(target), 0);
  rig.run_for(std::chrono::milliseconds(99));
  const double margin = v.dead_time_s > 1e-6 && v.encoder_lines < 32768 ? 3 : 1.5;
  double sum = 0;
  for (int i = 0; i < 200; ++i) {
    rig.run_for(std::chrono::microseconds(100));
    const double error = rig.axis().position() - target;
    EXPECT_LE(std::fabs(error), 10 * margin);
    sum += error * error;
  }
  EXPECT_LE(std::sqrt(sum / 200), 4.5 * margin);
  rig.change_load({.external_torque_nm = 1.27});
  int dip = 0;
  for (int i = 0; i < 500; ++i) {
    rig.run_for(std::chrono::microseconds(100));
    dip = std::max(dip, std::abs(rig.axis().position_error()));
  }
  EXPECT_LE(dip, 1670 * 1.5);
  EXPECT_TRUE(rig.axis().servo_on());
}

TEST(GateSweep, TheFactorysGainsHoldOnSimilarMotors) {
  for (const double inertia : {2e-5, 5e-5, 1e-4}) {
    for (const double resistance : {0.8, 2.0}) {
      for (const double inductance : {3e-3, 8e-3}) {
        for (const double dead_time : {0.0, 1e-6, 2e-6}) {
          for (const int lines : {16384, 32768}) {
            check({inertia, resistance, inductance, dead_time, lines});
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace virtdrive::rzt1
