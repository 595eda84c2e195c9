#include "plant/ode.h"

#include <gtest/gtest.h>
#include <string>

#include "core/check.h"

namespace virtdrive {
namespace {

const Integrator kBoth[] = {Integrator::kDefault, Integrator::kFast};

template <int N>
OdeTolerances<N> tight(double tolerance = 1e-6) {
  OdeTolerances<N> t;
  t.relative.fill(tolerance);
  t.absolute.fill(tolerance);
  return t;
}

/// A first-order lag of 1 ms behind a held input.
struct Lag {
  static constexpr int kStates = 1;
  static constexpr int kRoots = 0;
  double input = 0;

  void derivative(const double* x, double* dx) const { dx[0] = (input - x[0]) / 1e-3; }
  bool watched() const { return false; }
  void roots(const double*, double*) const {}
  double step_limit_s(const double*) const { return 20e-6; }
};

/// Greatest error of a lag over many steps of its input, against the closed form.
double worst_error_over_input_steps(Integrator integrator, double tolerance, double period_s) {
  OdeSolver<Lag> solver(integrator, tight<1>(tolerance));
  Lag lag;
  OdeSolver<Lag>::State x{};
  double exact = 0, worst = 0;
  for (int k = 0; k < 2000; ++k) {
    lag.input = k * 7 % 11 - 5;  // -5 .. 5 in leaps
    solver.advance(lag, x, period_s);
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
struct FanDrive {
  static constexpr int kStates = 2;
  static constexpr int kRoots = 0;
  static constexpr double kInertia = 0.58, kTorque = 181.4477, kRatedSpeed = 157.0796;

  void derivative(const double* x, double* dx) const {
    dx[0] = (kTorque - 181.4 * x[0] * x[0] / (kRatedSpeed * kRatedSpeed)) / kInertia;
    dx[1] = x[0];
  }
  bool watched() const { return false; }
  void roots(const double*, double*) const {}
  double step_limit_s(const double*) const { return 1e-3; }
};

TEST(OdeSolver, RunsTheModelicaFanDriveUpAlongItsClosedForm) {
  // w(t) = 157.10029 tanh(t / 0.502173 s)
  const std::pair<double, double> points[] = {
      {0.25, 72.3311}, {0.5, 119.3602}, {1.0, 151.3521}, {1.5, 156.3030}, {2.0, 156.9912}};
  for (const Integrator integrator : kBoth) {
    OdeSolver<FanDrive> solver(integrator, tight<2>());
    OdeSolver<FanDrive>::State x{};
    double t = 0;
    for (const auto& [time, speed] : points) {
      solver.advance({}, x, time - t);
      t = time;
      EXPECT_NEAR(x[0], speed, 6e-5);
      EXPECT_NEAR(x[0], 157.10029 * std::tanh(t / 0.502173), 5e-4);  // digits of the constants
    }
    // theta = w0 T ln cosh(t / T)
    EXPECT_NEAR(x[1], 157.10029 * 0.502173 * std::log(std::cosh(2 / 0.502173)), 1e-3);
  }
}

/// A ball thrown up: height, speed; the floor is a root.
struct Ball {
  static constexpr int kStates = 2;
  static constexpr int kRoots = 2;
  double floor = 0;

  void derivative(const double* x, double* dx) const {
    dx[0] = x[1];
    dx[1] = -10;
  }
  bool watched() const { return true; }
  void roots(const double* x, double* g) const {
    g[0] = 1;
    g[1] = x[0] - floor;
  }
  double step_limit_s(const double*) const { return 0.4; }
};

TEST(OdeSolver, StopsWhereARootFalls) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<Ball> solver(integrator, tight<2>());
    OdeSolver<Ball>::State x{0, 5};  // starts on the root and leaves it upwards
    const OdeOutcome outcome = solver.advance({}, x, 10);
    EXPECT_EQ(outcome.fired, 2U);
    EXPECT_NEAR(outcome.elapsed_s, 1, 1e-9);
    EXPECT_NEAR(x[0], 0, 1e-8);
    EXPECT_NEAR(x[1], -5, 1e-8);
  }
}

TEST(OdeSolver, ARootThatStartsAtZeroAndFallsFires) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<Ball> solver(integrator, tight<2>());
    OdeSolver<Ball>::State x{0, -1};
    const OdeOutcome outcome = solver.advance({}, x, 1e-3);
    EXPECT_EQ(outcome.fired, 2U);
    EXPECT_LE(outcome.elapsed_s, 1e-3);
  }
}

TEST(OdeSolver, ARootThatRisesIsNoEvent) {
  for (const Integrator integrator : kBoth) {
    OdeSolver<Ball> solver(integrator, tight<2>());
    OdeSolver<Ball>::State x{0, 20};  // below the floor, rising through it
    const OdeOutcome outcome = solver.advance({.floor = 1}, x, 1);
    EXPECT_EQ(outcome.fired, 0U);
    EXPECT_EQ(outcome.elapsed_s, 1);
  }
}

struct Broken {
  static constexpr int kStates = 1;
  static constexpr int kRoots = 0;

  void derivative(const double*, double* dx) const {
    dx[0] = std::numeric_limits<double>::quiet_NaN();
  }
  bool watched() const { return false; }
  void roots(const double*, double*) const {}
  double step_limit_s(const double*) const { return 1; }
};

TEST(OdeSolver, AFailureOfTheSolverIsAnErrorThatNamesItAndPrintsNothing) {
  OdeSolver<Broken> solver(Integrator::kDefault, tight<1>());
  OdeSolver<Broken>::State x{};
  testing::internal::CaptureStderr();
  try {
    solver.advance({}, x, 1);
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
