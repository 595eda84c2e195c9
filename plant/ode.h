// One initial-value problem, integrated from one change of its inputs to the next: the only place
// that knows of integrators.
//
//   OdeSolver<System> solver(Integrator::kDefault, tolerances);
//   OdeOutcome outcome = solver.advance(system, x, duration_s);  // stops early at a state event
//
// kDefault is SUNDIALS ARKODE ERKStep (Dormand-Prince 7-4-5, adaptive); kFast is RK4 with event
// location and a step that the system limits. Both take the same System:
//
//   static constexpr int kStates, kRoots;
//   void derivative(const double* x, double* dx) const;
//   bool watched() const;                          // is any root function active now?
//   void roots(const double* x, double* g) const;  // each positive while the present mode holds
//   double step_limit_s(const double* x) const;    // for kFast; kDefault stays below 4 of these
//
// Time is local: a system sees no t, its inputs are held during advance(). A root function that
// falls through 0 is an event; an inactive one returns a positive constant. The caller handles an
// event (changes the mode, so that the root is positive or 0 again) and advances the rest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

namespace virtdrive {

enum class Integrator : std::uint8_t { kDefault, kFast };

struct OdeOutcome {
  double elapsed_s = 0;
  std::uint32_t fired = 0;  // bit i: root i is at or below 0; 0: the whole duration has passed
};

/// The accepted local error of state i is relative[i] * |x[i]| + absolute[i], in the root mean
/// square over the states.
template <int N>
struct OdeTolerances {
  std::array<double, N> relative{};
  std::array<double, N> absolute{};  // > 0
};

/// SUNDIALS behind plain function pointers: keeps its headers out of everyone else's way.
class ErkIntegrator {
 public:
  struct Problem {
    int states = 0;
    int roots = 0;
    void (*derivative)(const void* system, const double* x, double* dx) = nullptr;
    void (*root_functions)(const void* system, const double* x, double* g) = nullptr;
    const double* relative = nullptr;  // tolerances, copied
    const double* absolute = nullptr;
  };
  /// Throws SetupError if SUNDIALS cannot be set up.
  explicit ErkIntegrator(const Problem& problem);
  ErkIntegrator(ErkIntegrator&&) noexcept;
  ErkIntegrator& operator=(ErkIntegrator&&) noexcept;
  ~ErkIntegrator();

  /// Throws SetupError with SUNDIALS' own message if the integration fails.
  OdeOutcome advance(const void* system, double* x, double duration_s, bool watched,
                     double longest_step_s);
  std::uint64_t derivative_evaluations() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

template <class System>
class OdeSolver {
 public:
  static constexpr int kStates = System::kStates;
  static constexpr int kRoots = System::kRoots;
  using State = std::array<double, kStates>;

  OdeSolver(Integrator integrator, const OdeTolerances<kStates>& tolerances);

  /// Moves x by at most `duration_s` > 0.
  OdeOutcome advance(const System& system, State& x, double duration_s) {
    if (erk_) {
      return erk_->advance(&system, x.data(), duration_s, system.watched(),
                           kLongestStep * system.step_limit_s(x.data()));
    }
    return advance_rk4(system, x, duration_s);
  }

  /// How often System::derivative was called.
  std::uint64_t derivative_evaluations() const {
    return erk_ ? erk_->derivative_evaluations() : 4 * rk4_steps_;
  }

 private:
  // Error control alone would let the steps of a long quiet segment grow to the limit of stability
  // and the states dither at the tolerance.
  static constexpr double kLongestStep = 4;
  static constexpr double kLocatedWithinS = 1e-13;
  static constexpr int kMostTrials = 100;

  OdeOutcome advance_rk4(const System& system, State& x, double duration_s);
  State rk4_step(const System& system, const State& x, double h);
  OdeOutcome locate(const System& system, State& x, const State& after, double h);
  double least_root(const System& system, const State& x, std::uint32_t of) const;
  std::uint32_t fired(const System& system, const State& before, const State& after) const;

  std::unique_ptr<ErkIntegrator> erk_;  // kDefault only
  std::uint64_t rk4_steps_ = 0;
};

template <class System>
OdeSolver<System>::OdeSolver(Integrator integrator, const OdeTolerances<kStates>& tolerances) {
  if (integrator == Integrator::kFast) return;
  ErkIntegrator::Problem problem;
  problem.states = kStates;
  problem.roots = kRoots;
  problem.derivative = [](const void* system, const double* x, double* dx) {
    static_cast<const System*>(system)->derivative(x, dx);
  };
  problem.root_functions = [](const void* system, const double* x, double* g) {
    static_cast<const System*>(system)->roots(x, g);
  };
  problem.relative = tolerances.relative.data();
  problem.absolute = tolerances.absolute.data();
  erk_ = std::make_unique<ErkIntegrator>(problem);
}

template <class System>
typename OdeSolver<System>::State OdeSolver<System>::rk4_step(const System& system, const State& x,
                                                              double h) {
  ++rk4_steps_;
  State k1, k2, k3, k4, y;
  system.derivative(x.data(), k1.data());
  for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + h / 2 * k1[i];
  system.derivative(y.data(), k2.data());
  for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + h / 2 * k2[i];
  system.derivative(y.data(), k3.data());
  for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + h * k3[i];
  system.derivative(y.data(), k4.data());
  for (std::size_t i = 0; i < kStates; ++i) {
    y[i] = x[i] + h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
  }
  return y;
}

template <class System>
std::uint32_t OdeSolver<System>::fired(const System& system, const State& before,
                                       const State& after) const {
  std::array<double, std::max(kRoots, 1)> g{}, g_before{};
  system.roots(after.data(), g.data());
  if (std::ranges::all_of(g, [](double value) { return value > 0; })) return 0;
  system.roots(before.data(), g_before.data());
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kRoots; ++i) {
    // A root that starts at 0 has fired only once it is truly below.
    if (g[i] < 0 || (g[i] == 0 && g_before[i] > 0)) bits |= 1U << i;
  }
  return bits;
}

template <class System>
double OdeSolver<System>::least_root(const System& system, const State& x, std::uint32_t of) const {
  std::array<double, std::max(kRoots, 1)> g{};
  system.roots(x.data(), g.data());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kRoots; ++i) {
    if ((of >> i & 1U) != 0) least = std::min(least, g[i]);
  }
  return least;
}

template <class System>
OdeOutcome OdeSolver<System>::advance_rk4(const System& system, State& x, double duration_s) {
  const bool watched = kRoots > 0 && system.watched();
  double elapsed = 0;
  while (elapsed < duration_s) {
    const double left = duration_s - elapsed;
    // Equal steps instead of whole ones and a rest.
    const double steps = std::ceil(left / system.step_limit_s(x.data()));
    const double h = left / std::max(steps, 1.0);
    const State next = rk4_step(system, x, h);
    if (watched && fired(system, x, next) != 0) {
      const OdeOutcome event = locate(system, x, next, h);
      return {elapsed + event.elapsed_s, event.fired};
    }
    x = next;
    elapsed = steps <= 1 ? duration_s : elapsed + h;
  }
  return {duration_s, 0};
}

/// The first fall of a root within the step from x, by the Illinois method on the length of the
/// step: each trial is a whole RK4 step from x, so the state at the event is as good as any other.
template <class System>
OdeOutcome OdeSolver<System>::locate(const System& system, State& x, const State& after, double h) {
  const std::uint32_t falling = fired(system, x, after);
  double low = 0, high = h;
  double g_low = least_root(system, x, falling), g_high = least_root(system, after, falling);
  if (g_low <= 0) return {0, falling};
  State at_high = after;
  int side = 0;
  for (int trials = 0; high - low > kLocatedWithinS && g_high < 0 && trials < kMostTrials;
       ++trials) {
    double middle = (low * g_high - high * g_low) / (g_high - g_low);
    if (!(middle > low && middle < high)) middle = (low + high) / 2;
    const State trial = rk4_step(system, x, middle);
    const double g = least_root(system, trial, falling);
    if (g > 0) {
      low = middle;
      g_low = g;
      if (side < 0) g_high /= 2;
      side = -1;
    } else {
      high = middle;
      g_high = g;
      at_high = trial;
      if (side > 0) g_low /= 2;
      side = 1;
    }
  }
  const std::uint32_t bits = fired(system, x, at_high);
  x = at_high;
  return {high, bits};
}

}  // namespace virtdrive
