// Searches for the rotor and for the zero, from as many starts as asked for.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {

enum class Friction : std::uint8_t { kNone, kRated, kHigh };

inline AxisParameters bench_with(Friction friction) {
  AxisParameters parameters = bench_axis();
  if (friction == Friction::kNone) parameters.mechanics.coulomb_nm = 0;
  if (friction == Friction::kHigh) parameters.mechanics.coulomb_nm = 0.1;
  return parameters;
}

// By how much the drive is wrong about the d axis, in electrical degrees.
inline double error_deg(Rig& rig) {
  const ServoAxis& axis = rig.axis();
  rig.run_for(std::chrono::milliseconds(1));
  const double thinks = static_cast<double>(axis.phase_angle()) / axis.settings().pcounts - 0.25;
  const double is = 5 * rig.angle_rad() / kTurnRad;
  return std::remainder(thinks - is, 1.0) * 360;
}

struct Case {
  int mode;
  Friction friction;
  double allowed_deg;  // friction over the torque of PIOUT, or the Halls' sampling
};

inline void phase_from(const Case& c, int angles) {
  for (int i = 0; i < angles; ++i) {
    const double start = kTurnRad * i / angles / 5;
    Rig rig(bench_with(c.friction));
    rig.turn_to(start);
    rig.set(&Settings::pimode, c.mode);
    ASSERT_EQ(rig.axis().align(), Result::kOk);
    EXPECT_TRUE((rig.axis().status() & kBusy) != 0);
    EXPECT_EQ(rig.axis().status() & kPhased, 0);
    ASSERT_GT(rig.run_to([&] { return !rig.axis().busy(); }, 5), 0);
    EXPECT_TRUE(rig.axis().phased());
    EXPECT_FALSE(rig.axis().search_failed());
    rig.run_for(std::chrono::milliseconds(100));
    EXPECT_LE(std::fabs(error_deg(rig)), c.allowed_deg)
        << "mode " << c.mode << " friction " << static_cast<int>(c.friction) << " start "
        << 360.0 * i / angles;
    // It stays near: Halls turn it by a sector at most, dithering by less than a pole.
    const double most = c.mode == 0 ? kTurnRad / 5 : c.mode == 1 ? kTurnRad / 20 : kTurnRad / 5;
    EXPECT_LE(std::fabs(rig.angle_rad() - start), most);
  }
}

// PIOUT gives 3.7 A: 1.3 Nm. asin(0.02 / 1.3) is 0.9 degrees, asin(0.1 / 1.3) is 4.4.
inline const Case kCases[] = {
    {0, Friction::kNone, 1}, {0, Friction::kRated, 1.5}, {0, Friction::kHigh, 6},
    {1, Friction::kNone, 3}, {1, Friction::kRated, 3},   {1, Friction::kHigh, 3},
    {2, Friction::kNone, 1}, {2, Friction::kRated, 2},   {2, Friction::kHigh, 8}};

// --- Homing ---

inline constexpr double kCountRad = kTurnRad / kTurn;
inline constexpr std::int32_t kSlow = 1'000'000;  // 15 counts a cycle: 150'000 counts/s

struct Found {
  double least = 1e9, most = -1e9;  // the shaft's angle at POS 0, in counts
  void add(Rig& rig) {
    const double zero = rig.angle_rad() / kCountRad - rig.axis().position();
    least = std::min(least, zero);
    most = std::max(most, zero);
  }
};

inline void prepare(Rig& rig, double start_rad) {
  rig.turn_to(start_rad);
  rig.set(&Settings::pimode, 1);
  rig.set(&Settings::vel, kSlow);
  rig.set(&Settings::acc, 5000);
  rig.set(&Settings::dec, 5000);
  ASSERT_EQ(rig.ready(), Result::kOk);
}

inline void home(Rig& rig, HomingState end) {
  ASSERT_EQ(rig.axis().home(), Result::kOk);
  EXPECT_TRUE((rig.axis().status() & kBusy) != 0);
  EXPECT_EQ(rig.axis().home(), Result::kInvalidState);
  EXPECT_EQ(rig.axis().go(), Result::kInvalidState);
  ASSERT_GT(rig.run_to([&] { return !rig.axis().busy() && !rig.axis().moving(); }, 60), 0);
  EXPECT_EQ(rig.axis().homing_state(), end);
  rig.run_for(std::chrono::milliseconds(60));
}

inline Hardware with_index_and_switch() {
  Hardware hardware;
  hardware.axis[0].incremental.index_angle_rad = 1.0;
  // From 3.4 turns on, well away from an index.
  hardware.axis[0].home_switch = {.input = 3, .from_rad = 3.7 * kTurnRad, .to_rad = 100 * kTurnRad};
  return hardware;
}

inline void by_index(int starts) {
  RandomStream random(3);
  for (int i = 0; i < starts; ++i) {
    Rig rig(bench_axis(), {}, with_index_and_switch());
    prepare(rig, kTurnRad * random.uniform());
    home(rig, HomingState::kDone);
    EXPECT_NEAR(rig.axis().position(), 0, 4);
    const double zero = rig.angle_rad() - rig.axis().position() * kCountRad;
    EXPECT_NEAR(std::remainder(zero - 1.0, kTurnRad) / kCountRad, 0, 1.5);
    EXPECT_EQ(rig.axis().command_position(), 0);
  }
}

inline void by_switch(int starts) {
  RandomStream random(4);
  Found found;
  for (int i = 0; i < starts; ++i) {
    Rig rig(bench_axis(), {}, with_index_and_switch());
    prepare(rig, kTurnRad * 7 * random.uniform());
    rig.set(&Settings::hmask, 4);
    home(rig, HomingState::kDone);
    found.add(rig);
  }
  EXPECT_LE(found.most - found.least, 2);
  EXPECT_NEAR(found.least * kCountRad, 4 * kTurnRad + 1.0, 1e-3);
}

inline void by_hard_stop(int starts) {
  RandomStream random(5);
  Found found;
  for (int i = 0; i < starts; ++i) {
    Rig rig;
    prepare(rig, kTurnRad * 4 * random.uniform());
    Load load;
    load.upper_stop_rad = 4.5 * kTurnRad;
    load.stop_nm_per_rad = 200;
    load.stop_nm_per_radps = 0.05;
    rig.change_load(load);
    rig.set(&Settings::hmask, 3);
    home(rig, HomingState::kDone);
    found.add(rig);
  }
  // A poll is 100 us: one loop cycle of the velocity.
  EXPECT_LE(found.most - found.least, 2 * (kSlow >> 16));
  EXPECT_NEAR(found.least * kCountRad, 4.5 * kTurnRad, 0.02);
}

}  // namespace virtdrive::rzt1
