#include "plant/motor_curves.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kRpm = std::numbers::pi / 30;

double length(Dq x) {
  return std::hypot(x.d, x.q);
}

// Data sheet of the Wittenstein premo 2D: 31.6 V rms at 1000 rpm, 2.00 ms, 7023 rpm without load.
TEST(MotorConstants, AgreeWithADataSheetThatGivesThemAll) {
  const MotorConstants k = motor_constants(find_motor("premo-2d"));
  EXPECT_NEAR(k.torque_constant_nm_per_arms, 0.52, 1e-12);
  EXPECT_NEAR(k.line_emf_vrms_per_krpm, 31.6, 0.02 * 31.6);
  EXPECT_NEAR(k.electrical_time_constant_s, 2.00e-3, 0.01e-3);
  EXPECT_NEAR(k.no_load_radps / kRpm, 7023, 0.03 * 7023);
  EXPECT_NEAR(k.rated_torque_nm, 2.11, 0.03 * 2.11);
}

// Delta prints 8.36 ms for this motor.
TEST(MotorConstants, ElectricalTimeConstantOfTheDeltaServo) {
  EXPECT_NEAR(motor_constants(find_motor("ecma-c20807")).electrical_time_constant_s, 8.36e-3, 1e-4);
}

TEST(MotorConstants, KvAndTorqueConstantAreOneThing) {
  const MotorConstants k = motor_constants(find_motor("gt2215"));
  EXPECT_NEAR(k.speed_constant_rpm_per_v, 1165, 1);
  // Kt per peak ampere = sqrt(3)/2 of the line-to-line EMF per rad/s.
  EXPECT_NEAR(k.torque_constant_nm_per_a,
              std::numbers::sqrt3 / 2 / (k.speed_constant_rpm_per_v * kRpm), 1e-9);
}

// V6: 240 A of maximum torque per ampere; short circuit at psi / Ld.
TEST(MotorCurves, TractionMachineAtLowSpeed) {
  const Motor motor = find_motor("gem-pmsm");
  const auto point = most_torque(motor, limits_of(motor), 0);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->torque_nm, 160.6124, 1e-3);
  EXPECT_NEAR(point->current_a.d, -150.9865, 0.01);
  EXPECT_NEAR(point->current_a.q, 186.5558, 0.01);
  EXPECT_NEAR(motor_constants(motor).characteristic_current_a, 66e-3 / 0.37e-3, 1e-9);
}

// V3: |i| and |u| of the 2.2-kW machine at 14 Nm and 157.08 rad/s.
TEST(MotorCurves, LeastCurrentIsMaximumTorquePerAmpereWhileTheVoltageLasts) {
  const Motor motor = find_motor("ipmsm-2kw");
  const auto point = least_current(motor, limits_of(motor), 14, 157.08);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->current_peak_a(), 5.64234, 1e-5);
  EXPECT_NEAR(point->current_a.d, -0.83760, 1e-3);
  EXPECT_NEAR(length(point->voltage_v), 296.334, 0.01);
}

// Without resistance and friction the voltage ellipse is a circle around -psi/L: closed form.
TEST(MotorCurves, FieldWeakeningOfASurfaceMagnetMachineInClosedForm) {
  Motor motor = find_motor("db42s03");
  motor.electrical.resistance_ohm = 0;
  motor.mechanics.coulomb_nm = motor.mechanics.viscous_nm_per_radps = 0;
  const DriveLimits limits = limits_of(motor);
  const double speed_radps = 750;
  const double w = 4 * speed_radps, l = 1.05e-3, psi = 5.667e-3;
  const double radius = limits.voltage_v / (w * l), centre = psi / l;
  const double i = limits.current_a;
  const double d = (radius * radius - i * i - centre * centre) / (2 * centre);
  ASSERT_LT(d, 0);
  const auto point = most_torque(motor, limits, speed_radps);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->current_a.d, d, 1e-6);
  EXPECT_NEAR(point->torque_nm, 34.002e-3 * std::sqrt(i * i - d * d), 1e-8);
  EXPECT_NEAR(length(point->voltage_v), limits.voltage_v, 1e-6);
}

TEST(MotorCurves, PointsKeepTheirLimitsAndTheirPowerBalance) {
  for (const char* name : {"db42s03", "gem-pmsm", "ipmsm-2kw", "gt2215", "md200t", "ecma-c20807",
                           "syrm-7kw", "re40-24v", "voice-coil-20n"}) {
    const Motor motor = find_motor(name);
    const SteadyMotor steady(motor);
    const DriveLimits limits = limits_of(motor);
    const MotorConstants k = motor_constants(steady);
    const double no_load = std::isfinite(k.no_load_radps) ? k.no_load_radps : 2 * k.base_radps;
    for (double share = 0; share < 1.4; share += 0.05) {
      const double speed = share * no_load;
      const auto most = most_torque(steady, limits, speed);
      if (!most || most->torque_nm <= 0) continue;
      const auto point = least_current(steady, limits, 0.7 * most->torque_nm, speed);
      ASSERT_TRUE(point) << name << " " << speed;
      EXPECT_LE(point->current_peak_a(), most->current_peak_a() * (1 + 1e-6));
      for (const OperatingPoint& p : {*most, *point}) {
        EXPECT_LE(p.current_peak_a(), limits.current_a * (1 + 1e-6));
        EXPECT_LE(length(p.voltage_v), limits.voltage_v * (1 + 1e-6));
        const MechanicsParameters& m = motor.mechanics;
        const double copper_w =
            steady.phases() * steady.resistance_ohm() * p.current_peak_a() * p.current_peak_a();
        const double friction_w = (m.viscous_nm_per_radps * speed + m.coulomb_nm) * speed;
        EXPECT_NEAR(p.input_w, p.output_w + copper_w + friction_w, 1e-9 * p.input_w);
      }
    }
  }
}

TEST(MotorCurves, WhatIsOutOfReachHasNoPoint) {
  const Motor motor = find_motor("db42s03");
  const DriveLimits limits = limits_of(motor);
  const double most_nm = most_torque(motor, limits, 100)->torque_nm;
  EXPECT_TRUE(least_current(motor, limits, 0.9999 * most_nm, 100));
  EXPECT_FALSE(least_current(motor, limits, 1.0001 * most_nm, 100));
  EXPECT_FALSE(most_torque(motor, limits, 1e5));
}

// Data sheet of the maxon RE 40, 148867: 7580 rpm and 137 mA without load, 80.2 A and 2420 mNm at
// stall, 6940 rpm at 177 mNm and 6.00 A, 91 % at best.
TEST(MotorCurves, ABrushedMotorKeepsItsDataSheet) {
  const Motor motor = find_motor("re40-24v");
  const MotorConstants k = motor_constants(motor);
  EXPECT_NEAR(k.no_load_radps / kRpm, 7580, 10);
  EXPECT_NEAR(k.stall_current_a, 80.2, 0.1);
  EXPECT_NEAR(k.stall_current_a * k.torque_constant_nm_per_a, 2.42, 0.01);
  EXPECT_NEAR(k.mechanical_time_constant_s, 4.67e-3, 0.1e-3);
  const auto point = least_current(motor, limits_of(motor), 0.177, 6000 * kRpm);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->current_a.q, 6.0, 0.05);
  const auto most = most_torque(motor, {.voltage_v = 24, .current_a = 100}, 6940 * kRpm);
  EXPECT_NEAR(most->torque_nm, 0.177, 0.03);
}

// A flat machine with a 120-degree trapezoid: the fundamental is 12 / pi^2 of the flat top.
TEST(MotorCurves, OfATrapezoidTheFundamentalCounts) {
  const Motor motor = find_motor("ec60-flat-24v");
  const MotorConstants k = motor_constants(motor);
  EXPECT_NEAR(k.torque_constant_nm_per_a,
              1.5 * (12 / std::numbers::pi / std::numbers::pi) * 53.4e-3 / 2, 1e-7);
}

// V5 at a fixed current: the curves see the saturated machine.
TEST(MotorCurves, ASaturatedMachineGivesTheTorqueOfItsFluxes) {
  const Motor motor = find_motor("syrm-7kw");
  const SteadyMotor steady(motor);
  EXPECT_NEAR(steady.air_gap_nm({15.92812, 16.45667}), 19.90656, 5e-3);
  EXPECT_NEAR(steady.flux_wb({8.71181, 5.44467}).d, 0.4, 1e-4);
  const DriveLimits limits = limits_of(motor);
  const auto most = most_torque(steady, limits, 0);
  ASSERT_TRUE(most);
  EXPECT_GT(most->torque_nm, steady.air_gap_nm({15.5, 15.5}));
  const auto point = least_current(steady, limits, 0.5 * most->torque_nm, 200);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->torque_nm, 0.5 * most->torque_nm, 1e-6);
  EXPECT_LE(length(point->voltage_v), limits.voltage_v);
}

TEST(MotorCurves, AVoiceCoilCountsInNewtonsAndMetres) {
  const Motor motor = find_motor("voice-coil-20n");
  const MotorConstants k = motor_constants(motor);
  EXPECT_NEAR(k.torque_constant_nm_per_a, 10, 1e-12);
  EXPECT_NEAR(k.stall_current_a, 4.8, 1e-12);
  EXPECT_NEAR(k.rated_torque_nm, 19.8, 1e-9);
  // 24 V = 5 Ohm (0.2 + 0.5 v) / 10 + 10 v.
  EXPECT_NEAR(k.no_load_radps, 23.9 / 10.25, 1e-9);
}

// The averaged plant holds the motor at the point that the curves tell.
TEST(MotorCurves, NoLoadSpeedIsWhereTorqueMeetsFriction) {
  const Motor motor = find_motor("db42s03");
  const MotorConstants k = motor_constants(motor);
  const double friction_nm = 3e-3 + 5e-6 * k.no_load_radps;
  const Dq current_a{0, friction_nm / k.torque_constant_nm_per_a};
  EXPECT_NEAR(length(steady_state_voltage_v(motor.electrical, current_a, 4 * k.no_load_radps)),
              24 / std::numbers::sqrt3, 1e-9);
}

}  // namespace
}  // namespace virtdrive
