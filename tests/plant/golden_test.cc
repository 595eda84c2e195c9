// V3: a 2.2-kW interior-magnet drive under current-vector control, replayed against a run of an
// independent simulator (motulator at rtol 1e-10).
//
// tests/data/ipmsm_2kw_golden.csv: 9600 control intervals of 125 us. Per row the end of the
// interval, the mean switching-state vector over it, and the states at its end; 14 Nm of load from
// 0.8 s on.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <sstream>
#include <vector>

#include "plant/axis.h"
#include "plant/motor_library.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kInterval = 125us;
constexpr double kRatedCurrentA = 4.3, kRatedSpeedRadps = 157.08;

struct Row {
  double t_end, q_alpha, q_beta, i_d, i_q, speed, angle;
};

const std::vector<Row>& golden_rows() {
  static const std::vector<Row> rows = [] {
    std::ifstream file(VIRTDRIVE_TEST_DATA "/ipmsm_2kw_golden.csv");
    std::vector<Row> read;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::ranges::replace(line, ',', ' ');
      std::istringstream fields(line);
      Row r{};
      fields >> r.t_end >> r.q_alpha >> r.q_beta >> r.i_d >> r.i_q >> r.speed >> r.angle;
      read.push_back(r);
    }
    return read;
  }();
  return rows;
}

/// Duties with these line-to-line averages; the zero-sequence part centres them.
PhaseValues duty_of(const Row& row) {
  PhaseValues q = inverse_clarke({row.q_alpha, row.q_beta});
  const double least = std::ranges::min(q), most = std::ranges::max(q);
  for (double& x : q) x = std::clamp(x + 0.5 - (least + most) / 2, 0.0, 1.0);  // 12 digits printed
  return q;
}

AxisParameters ipmsm() {
  const Motor& motor = find_motor("ipmsm-2kw");
  return {.motor = motor.electrical,
          .link = {.source_v = 540, .resistance_ohm = 0, .capacitance_f = 1e-3},
          .mechanics = motor.mechanics};
}

struct Error {
  double current = 0, speed = 0, angle = 0;  // of rated current, of rated speed, rad electrical
};

/// Greatest deviation over all intervals. `load_delay` moves the load step off its moment.
Error replay(Integrator integrator, SimDuration load_delay = 0us) {
  Axis axis(ipmsm(), integrator);
  const SimTime load_step = kSimStart + 800ms + load_delay;
  Error worst;
  SimTime t = kSimStart;
  for (const Row& row : golden_rows()) {
    axis.set_bridge({.mode = Bridge::kDriven, .duty = duty_of(row), .pwm_period = kInterval});
    if (load_step >= t && load_step < t + kInterval) {
      axis.advance_to(load_step);
      axis.set_load({.external_torque_nm = 14});
    }
    t += kInterval;
    axis.advance_to(t);
    const AxisState& x = axis.state();
    worst.current = std::max({worst.current, std::abs(x.i_d_a - row.i_d) / kRatedCurrentA,
                              std::abs(x.i_q_a - row.i_q) / kRatedCurrentA});
    worst.speed = std::max(worst.speed, std::abs(x.speed_radps - row.speed) / kRatedSpeedRadps);
    worst.angle = std::max(
        worst.angle, std::abs(std::remainder(3 * x.angle_rad - row.angle, 2 * std::numbers::pi)));
  }
  return worst;
}

TEST(IpmsmGolden, HasItsPublishedPoints) {
  ASSERT_EQ(golden_rows().size(), 9600U);
  const auto at = [](double t) { return golden_rows()[std::lround(t / 125e-6) - 1]; };
  EXPECT_NEAR(at(0.3).i_q, 3.741028, 1e-6);
  EXPECT_NEAR(at(0.3).speed, 132.800220, 1e-6);
  EXPECT_NEAR(at(0.5).speed, 156.898472, 1e-6);
  EXPECT_NEAR(at(1.0).i_d, -0.880182, 1e-6);
  EXPECT_NEAR(at(1.0).i_q, 5.717218, 1e-6);
  EXPECT_NEAR(at(1.2).i_q, 5.582685, 1e-6);
  EXPECT_NEAR(at(1.2).speed, 157.063103, 1e-6);
}

// Measured: current 4.1e-8 of the rated current, speed 2.0e-9 of the rated speed, angle 1.4e-8 rad,
// for both integrators; the file's digits and its rtol are in that.
TEST(IpmsmGolden, BothIntegratorsFollowItOverAllIntervalsAndTheLoadStep) {
  for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
    const Error error = replay(integrator);
    EXPECT_LT(error.current, 1e-7);
    EXPECT_LT(error.speed, 1e-8);
    EXPECT_LT(error.angle, 1e-7);
  }
}

// What the alignment of the load step to its moment is worth.
TEST(IpmsmGolden, ALoadStepTenMicrosecondsLateIsFarOff) {
  EXPECT_GT(replay(Integrator::kDefault, 10us).current, 1e-3);
}

}  // namespace
}  // namespace virtdrive
