#include "plant/ode.h"

#include <array>
#include <gtest/gtest.h>
#include <string>

#include "core/check.h"

namespace virtdrive {
namespace {

const Integrator kBoth[] = {Integrator::kDefault, Integrator::kFast};

/// What the systems below have in common: one tolerance for all states, no modes, no kinks.
template <int N>
struct Plain {
  std::array<double, N> tolerance = filled(1e-6);

  static std::array<double, N> filled(double value) {
    std::array<double, N> all;
    all.fill(value);
    return all;
  }
  int states() const { return N; }
  const double* relative_tolerance() const { return tolerance.data(); }
  const double* absolute_tolerance() const { return tolerance.data(); }
  bool watched() const { return false; }
  bool short_steps() const { return false; }
  double margin(const double*) const { return 1; }
  double next_kink_s(const double*) const { return std::numeric_limits<double>::infinity(); }
};

/// A first-order lag of 1 ms behind a held input.
struct Lag : Plain<1> {
  double input = 0;

  void derivative(const double* x, double* dx) const { dx[0] = (input - x[0]) / 1e-3; }
  double step_limit_s(const double*) const { return 20e-6; }
};

/// Greatest error of a lag over many steps of its input, against the closed form.
double worst_error_over_input_steps(Integrator integrator, double tolerance, double period_s) {
  OdeSolver<Lag> solver(integrator);
  Lag lag;
  lag.tolerance = {tolerance};
  std::array<double, 1> x{};
  double exact = 0, worst = 0;
  for (int k = 0; k < 2000; ++k) {
    lag.input = k * 7 % 11 - 5;  // -5 .. 5 in leaps
    solver.advance(lag, x.data(), period_s);
    exact = lag.input + (exact - lag.input) * std::exp(-period_s / 1e-3);
    worst = std::max(worst, std::abs(x[0] - exact));
  }
  return worst;
}

// Dormand-Prince takes its first stage over from the last step. Without a reset at an input's step
// that stage belongs to the old input: 2e-4 here, and at a tighter tolerance the solver fails.
TEST(OdeSolver, AnInputThatStepsIsSeenFromTheFirstStageOn) {
  EXPECT_LT(worst_error_over_input_steps(Integrator::kDefault, 1e-6, 110e-6), 2e-6);
  EXPECT_LT(worst_error_over_input_steps(Integrator::kFast, 1e-6, 110e-6), 2e-6);
}

// A multistep method (CVODE) carries a history across the edges of held inputs and is wrong by
// 1e-3 at any tolerance, or fails at a tight one. A one-step method that is reset has none: the
// error follows the tolerance.
TEST(OdeSolver, TheErrorFollowsTheToleranceOverManyInputSteps) {
  EXPECT_LT(worst_error_over_input_steps(Integrator::kDefault, 1e-8, 500e-6), 1e-7);
  EXPECT_LT(worst_error_over_input_steps(Integrator::kDefault, 1e-10, 500e-6), 1e-9);
}

/// V1: SMPM_CurrentSource of the Modelica Standard Library. The current source gives a constant
/// torque; the load grows with the square of the speed. {speed, angle}.
struct FanDrive : Plain<2> {
  static constexpr double kInertia = 0.58, kTorque = 181.4477, kRatedSpeed = 157.0796;

  void derivative(const double* x, double* dx) const {
    dx[0] = (kTorque - 181.4 * x[0] * x[0] / (kRatedSpeed * kRatedSpeed)) / kInertia;
    dx[1] = x[0];
  }
  double step_limit_s(const double*) const { return 1e-3; }
};

TEST(OdeSolver, RunsTheModelicaFanDriveUpAlongItsClosedForm) {
  // w(t) = 157.10029 tanh(t / 0.502173 s)
  const std::pair<double, double> points[] = {
      {0.25, 72.3311}, {0.5, 119.3602}, {1.0, 151.3521}, {1.5, 156.3030}, {2.0, 156.9912}};
  for (const Integrator integrator : kBoth) {
    OdeSolver<FanDrive> solver(integrator);
    std::array<double, 2> x{};
    double t = 0;
    for (const auto& [time, speed] : points) {
      solver.advance({}, x.data(), time - t);
      t = time;
      EXPECT_NEAR(x[0], speed, 6e-5);
      EXPECT_NEAR(x[0], 157.10029 * std::tanh(t / 0.502173), 5e-4);  // digits of the constants
    }
    // theta = w0 T ln cosh(t / T)
    EXPECT_NEAR(x[1], 157.10029 * 0.502173 * std::log(std::cosh(2 / 0.502173)), 1e-3);
  }
}

/// A ball thrown up: height, speed; it must stay above the floor.
struct Ball : Plain<2> {
  double floor = 0;

  void derivative(const double* x, double* dx) const {
    dx[0] = x[1];
    dx[1] = -10;
  }
  bool watched() const { return true; }
  double margin(const double* x) const { return x[0] - floor; }
  double step_limit_s(const double*) const { return 0.4; }
};

TEST(OdeSolver, StopsWhereTheMarginFallsToZero) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<Ball> solver(integrator);
    std::array<double, 2> x{0, 5};
    Ball ball;
    ball.floor = -1e-9;
    const OdeOutcome outcome = solver.advance(ball, x.data(), 10);
    EXPECT_TRUE(outcome.event);
    EXPECT_NEAR(outcome.elapsed_s, 1, 1e-8);
    EXPECT_NEAR(x[0], 0, 1e-8);
    EXPECT_NEAR(x[1], -5, 1e-8);
  }
}

TEST(OdeSolver, WithoutAFallTheWholeDurationPasses) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<Ball> solver(integrator);
    std::array<double, 2> x{1, 5};
    const OdeOutcome outcome = solver.advance({}, x.data(), 0.5);
    EXPECT_FALSE(outcome.event);
    EXPECT_EQ(outcome.elapsed_s, 0.5);
  }
}

/// A sawtooth's integral: the derivative bends at each whole second of x[0].
struct Saw : Plain<2> {
  void derivative(const double* x, double* dx) const {
    dx[0] = 1;
    dx[1] = std::abs(std::remainder(x[0], 2.0));
  }
  double step_limit_s(const double*) const { return 0.3; }
  double next_kink_s(const double* x) const { return std::floor(x[0] + 1e-9) + 1 - x[0]; }
};

TEST(OdeSolver, TheFastIntegratorEndsAStepWhereTheDerivativeBends) {
  OdeSolver<Saw> solver(Integrator::kFast);
  std::array<double, 2> x{0.1, 0};
  solver.advance({}, x.data(), 7.9);
  EXPECT_NEAR(x[1], 4 - 0.005, 1e-12);
}

/// The error of a method's single order: a pendulum over one second with steps of h.
struct Pendulum : Plain<2> {
  double h = 1e-3;
  void derivative(const double* x, double* dx) const {
    dx[0] = x[1];
    dx[1] = -std::sin(x[0]);
  }
  double step_limit_s(const double*) const { return h; }
};

std::array<double, 2> pendulum_after(double h, Integrator integrator, double tolerance) {
  OdeSolver<Pendulum> solver(integrator);
  Pendulum pendulum;
  // kDefault stays below four of these steps; a loose tolerance makes it take all of it.
  pendulum.h = integrator == Integrator::kFast ? h : h / 4;
  pendulum.tolerance = Plain<2>::filled(tolerance);
  std::array<double, 2> x{1, 0.5};
  // Short advances, so that the first steps, which the solver takes carefully, do not count.
  for (int k = 0; k < 4; ++k) solver.advance(pendulum, x.data(), 1);
  return x;
}

double observed_order(Integrator integrator, double h) {
  const auto exact = pendulum_after(1.0 / 512, Integrator::kDefault, 1e-13);
  const auto error = [&](double step) {
    const auto x = pendulum_after(step, integrator, 1e3);
    return std::hypot(x[0] - exact[0], x[1] - exact[1]);
  };
  return std::log2(error(h) / error(h / 2));
}

TEST(OdeSolver, BothIntegratorsConvergeWithTheirOrder) {
  EXPECT_NEAR(observed_order(Integrator::kFast, 1.0 / 8), 4, 0.3);
  EXPECT_NEAR(observed_order(Integrator::kDefault, 1.0 / 4), 5, 0.6);
}

/// More states than any loop is unrolled for.
struct ManyLags : Plain<40> {
  void derivative(const double* x, double* dx) const {
    for (int i = 0; i < 40; ++i) dx[i] = (i - x[i]) / 1e-3;
  }
  double step_limit_s(const double*) const { return 20e-6; }
};

TEST(OdeSolver, TakesAnyNumberOfStates) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<ManyLags> solver(integrator);
    std::array<double, 40> x{};
    solver.advance({}, x.data(), 1e-3);
    for (int i = 0; i < 40; ++i) {
      EXPECT_NEAR(x[static_cast<std::size_t>(i)], i * (1 - std::exp(-1)), 1e-4);
    }
  }
}

struct Broken : Plain<1> {
  void derivative(const double*, double* dx) const {
    dx[0] = std::numeric_limits<double>::quiet_NaN();
  }
  double step_limit_s(const double*) const { return 1; }
};

TEST(OdeSolver, AFailureOfTheSolverIsAnErrorThatNamesItAndPrintsNothing) {
  OdeSolver<Broken> solver(Integrator::kDefault);
  std::array<double, 1> x{};
  testing::internal::CaptureStderr();
  try {
    solver.advance({}, x.data(), 1);
    ADD_FAILURE() << "no error";
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("SUNDIALS: ERKStepEvolve failed with ARK_"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace virtdrive
