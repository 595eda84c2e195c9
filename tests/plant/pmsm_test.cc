#include "plant/pmsm.h"

#include <Eigen/Eigenvalues>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>

#include "core/check.h"
#include "plant/motor_library.h"

namespace virtdrive {
namespace {

PmsmParameters motor(std::string_view name) {
  return find_motor(name).electrical;
}

TEST(Transforms, AreInverseAndKeepTheAmplitude) {
  const Rotation r(0.7);
  const PhaseValues abc = inverse_clarke(inverse_park({3, -4}, r));
  EXPECT_NEAR(abc[0] + abc[1] + abc[2], 0, 1e-15);
  EXPECT_NEAR(abc[0], 3 * std::cos(0.7) + 4 * std::sin(0.7), 1e-15);
  EXPECT_NEAR(
      abc[1],
      3 * std::cos(0.7 - 2 * std::numbers::pi / 3) + 4 * std::sin(0.7 - 2 * std::numbers::pi / 3),
      1e-14);
  const Dq back = park(clarke({abc[0] + 5, abc[1] + 5, abc[2] + 5}), r);
  EXPECT_NEAR(back.d, 3, 1e-14);
  EXPECT_NEAR(back.q, -4, 1e-14);
}

// V1: SMPM_CurrentSource of the Modelica Standard Library, at its steady state.
TEST(Pmsm, ReproducesTheModelicaMachineAtSteadyState) {
  const PmsmParameters p = motor("smpm-msl");
  EXPECT_NEAR(p.inductance_d_h, 1.273240e-3, 1e-9);
  EXPECT_NEAR(p.flux_wb, 0.505528, 1e-6);
  const Dq i{-53.5 * std::numbers::sqrt2, 84.6 * std::numbers::sqrt2};
  EXPECT_NEAR(torque_nm(p, i), 181.4477, 1e-4);
  const double speed = 157.10029;
  const Dq v = steady_state_voltage_v(p, i, 2 * speed);
  EXPECT_NEAR(v.d, -50.1331, 1e-4);
  EXPECT_NEAR(v.q, 132.1582, 1e-4);
  EXPECT_NEAR(std::hypot(v.d, v.q) / std::numbers::sqrt2, 99.948, 1e-3);
  EXPECT_NEAR(std::hypot(i.d, i.q) / std::numbers::sqrt2, 100.097, 1e-3);
  EXPECT_NEAR(1.5 * (v.d * i.d + v.q * i.q), 29407.2, 0.1);
  EXPECT_NEAR(torque_nm(p, i) * speed, 28505.5, 0.1);
  EXPECT_NEAR(std::atan2(-v.d, v.q) * 180 / std::numbers::pi, 20.774, 1e-3);
  const Dq slope = current_derivative(p, i, v, 2 * speed);
  EXPECT_NEAR(slope.d, 0, 1e-9);
  EXPECT_NEAR(slope.q, 0, 1e-9);
}

// V3: the operating point of the 2.2-kW machine at its rated torque.
TEST(Pmsm, MaximumTorquePerAmpereOfThe2KwMachine) {
  const PmsmParameters p = motor("ipmsm-2kw");
  const Dq i = mtpa_current_a(p, 5.64234);
  EXPECT_NEAR(i.d, -0.83760, 1e-5);
  EXPECT_NEAR(i.q, 5.57983, 1e-5);
  EXPECT_NEAR(torque_nm(p, i), 14, 2e-5);
  const Dq v = steady_state_voltage_v(p, i, 3 * 157.08);
  EXPECT_NEAR(std::hypot(v.d, v.q), 296.334, 1e-3);
}

// V6: 10.1109/TPEL.2020.3006779.
TEST(Pmsm, MaximumTorquePerAmpereOfTheTractionMachine) {
  const PmsmParameters p = motor("gem-pmsm");
  const Dq i = mtpa_current_a(p, 240);
  EXPECT_NEAR(i.d, -150.9865, 1e-4);
  EXPECT_NEAR(i.q, 186.5558, 1e-4);
  EXPECT_NEAR(torque_nm(p, i), 160.6124, 1e-4);
  const Dq braking = mtpa_current_a(p, -240);
  EXPECT_DOUBLE_EQ(braking.d, i.d);
  EXPECT_DOUBLE_EQ(braking.q, -i.q);
}

TEST(Pmsm, MaximumTorquePerAmpereWithoutSaliencyIsAllOnTheQAxis) {
  const Dq i = mtpa_current_a(motor("db42s03"), 1.5);
  EXPECT_EQ(i.d, 0);
  EXPECT_EQ(i.q, 1.5);
}

TEST(Pmsm, EigenvaluesOfTheTractionMachineAtSpeed) {
  const PmsmParameters p = motor("gem-pmsm");
  // The derivative is affine in the currents: its differences are the Jacobian.
  const double speed = 3 * 100;
  const Dq zero = current_derivative(p, {}, {}, speed);
  const Dq by_d = current_derivative(p, {1, 0}, {}, speed);
  const Dq by_q = current_derivative(p, {0, 1}, {}, speed);
  Eigen::Matrix2d jacobian;
  jacobian << by_d.d - zero.d, by_q.d - zero.d, by_d.q - zero.q, by_q.q - zero.q;
  const Eigen::Vector2cd values = jacobian.eigenvalues();
  EXPECT_NEAR(values[0].real(), -31.824, 1e-3);
  EXPECT_NEAR(std::abs(values[0].imag()), 299.528, 1e-3);
}

TEST(Pmsm, ParametersOutOfRangeAreNamed) {
  PmsmParameters p = motor("db42s03");
  p.inductance_q_h = 0;
  try {
    validate(p);
    ADD_FAILURE() << "no error";
  } catch (const SetupError& error) {
    EXPECT_STREQ(error.what(), "motor: inductance_q_h must be above 0, not 0");
  }
}

}  // namespace
}  // namespace virtdrive
