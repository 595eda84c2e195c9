// One initial-value problem, integrated from one change of its inputs to the next: the only place
// that knows of integrators.
//
//   OdeSolver<System> solver(Integrator::kDefault);
//   OdeOutcome outcome = solver.advance(system, x, duration_s);  // stops early at a state event
//
// kDefault is SUNDIALS ARKODE ERKStep (Dormand-Prince 7-4-5, adaptive); kFast is RK4 with event
// location and a step that the system limits. Both take the same System:
//
//   int states() const;                            // may differ from one advance() to the next
//   void derivative(const double* x, double* dx) const;
//   const double* relative_tolerance() const;      // kDefault: accepted local error of state i is
//   const double* absolute_tolerance() const;      //   relative[i] * |x[i]| + absolute[i] (rms)
//   bool watched() const;                          // can any of the present modes end by itself?
//   double margin(const double* x) const;          // positive while all present modes hold
//   double step_limit_s(const double* x) const;    // for kFast; kDefault stays below 4 of these,
//   bool short_steps() const;                      //   or 1 where the margin comes and goes
//   quickly double next_kink_s(const double* x) const;     // for kFast: when the derivative next
//   bends
//
// Time is local: a system sees no t, its inputs are held during advance(). The margin falling to 0
// is an event: the caller changes the mode that has ended, so that the margin is positive again,
// and advances the rest. It is one number however many modes there are, because an integrator only
// has to know when to stop; which of them ended is a question about the state where it stopped.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace virtdrive {

enum class Integrator : std::uint8_t { kDefault, kFast };

struct OdeOutcome {
  double elapsed_s = 0;
  bool event = false;  // false: the whole duration has passed
};

inline constexpr int kMostStates = 512;

/// SUNDIALS behind plain function pointers: keeps its headers out of everyone else's way.
class ErkIntegrator {
 public:
  struct Problem {
    int states = 0;  // 1 .. kMostStates
    void (*derivative)(const void* system, const double* x, double* dx) = nullptr;
    double (*margin)(const void* system, const double* x) = nullptr;
  };
  /// What is valid for one advance().
  struct Segment {
    const void* system = nullptr;
    double duration_s = 0;
    bool watched = false;
    double longest_step_s = 0;
    const double* relative = nullptr;
    const double* absolute = nullptr;
  };
  /// Throws SetupError if SUNDIALS cannot be set up.
  explicit ErkIntegrator(const Problem& problem);
  ErkIntegrator(ErkIntegrator&&) noexcept;
  ErkIntegrator& operator=(ErkIntegrator&&) noexcept;
  ~ErkIntegrator();

  int states() const;
  /// Throws SetupError with SUNDIALS' own message if the integration fails.
  OdeOutcome advance(const Segment& segment, double* x);
  std::uint64_t derivative_evaluations() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

template <class System>
class OdeSolver {
 public:
  explicit OdeSolver(Integrator integrator) : integrator_(integrator) {}

  /// Moves x by at most `duration_s` > 0.
  OdeOutcome advance(const System& system, double* x, double duration_s) {
    if (integrator_ == Integrator::kFast) {
      // One axis alone has five states: worth a loop of known length.
      return system.states() == 5 ? advance_rk4<5>(system, x, duration_s)
                                  : advance_rk4<0>(system, x, duration_s);
    }
    return erk(system.states())
        .advance(
            {.system = &system,
             .duration_s = duration_s,
             .watched = system.watched(),
             .longest_step_s = (system.short_steps() ? 1 : kLongestStep) * system.step_limit_s(x),
             .relative = system.relative_tolerance(),
             .absolute = system.absolute_tolerance()},
            x);
  }

  /// How often System::derivative was called.
  std::uint64_t derivative_evaluations() const {
    std::uint64_t sum = 4 * rk4_steps_;
    for (const ErkIntegrator& erk : erks_) sum += erk.derivative_evaluations();
    return sum;
  }

 private:
  // Error control alone would let the steps of a long quiet segment grow to the limit of stability
  // and the states dither at the tolerance.
  static constexpr double kLongestStep = 4;
  static constexpr double kLocatedWithinS = 1e-13;
  static constexpr int kMostTrials = 100;

  ErkIntegrator& erk(int states);
  template <int N>
  OdeOutcome advance_rk4(const System& system, double* x, double duration_s);
  template <int N>
  void rk4_step(const System& system, const double* x, double h, double* after);
  template <int N>
  double locate(const System& system, double* x, double* after, double h);

  Integrator integrator_;
  std::vector<ErkIntegrator> erks_;  // one per number of states met
  std::uint64_t rk4_steps_ = 0;
};

template <class System>
ErkIntegrator& OdeSolver<System>::erk(int states) {
  for (ErkIntegrator& erk : erks_) {
    if (erk.states() == states) return erk;
  }
  return erks_.emplace_back(ErkIntegrator::Problem{
      .states = states,
      .derivative = [](const void* system, const double* x,
                       double* dx) { static_cast<const System*>(system)->derivative(x, dx); },
      .margin = [](const void* system,
                   const double* x) { return static_cast<const System*>(system)->margin(x); }});
}

/// N: the number of states if it is known here, else 0.
template <class System>
template <int N>
void OdeSolver<System>::rk4_step(const System& system, const double* x, double h, double* after) {
  constexpr std::size_t kCapacity = N > 0 ? N : kMostStates;
  const int n = N > 0 ? N : system.states();
  double k1[kCapacity], k2[kCapacity], k3[kCapacity], k4[kCapacity], y[kCapacity];
  ++rk4_steps_;
  system.derivative(x, k1);
  for (int i = 0; i < n; ++i) y[i] = x[i] + h / 2 * k1[i];
  system.derivative(y, k2);
  for (int i = 0; i < n; ++i) y[i] = x[i] + h / 2 * k2[i];
  system.derivative(y, k3);
  for (int i = 0; i < n; ++i) y[i] = x[i] + h * k3[i];
  system.derivative(y, k4);
  for (int i = 0; i < n; ++i) after[i] = x[i] + h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
}

template <class System>
template <int N>
OdeOutcome OdeSolver<System>::advance_rk4(const System& system, double* x, double duration_s) {
  constexpr std::size_t kCapacity = N > 0 ? N : kMostStates;
  const int n = N > 0 ? N : system.states();
  const bool watched = system.watched();
  double next[kCapacity];
  double elapsed = 0;
  while (elapsed < duration_s) {
    const double left = duration_s - elapsed;
    // Equal steps instead of whole ones and a rest; but a bend of the derivative ends one.
    const double limit = system.step_limit_s(x);
    const bool last = left <= limit;
    const double step = last ? left : left / std::ceil(left / limit);
    const double kink = system.next_kink_s(x);
    const bool bends = kink < step;
    const double h = bends ? kink : step;
    rk4_step<N>(system, x, h, next);
    if (watched && system.margin(next) <= 0) {
      const double at = locate<N>(system, x, next, h);
      std::copy_n(next, n, x);
      return {elapsed + at, true};
    }
    std::copy_n(next, n, x);
    elapsed = last && !bends ? duration_s : elapsed + h;
  }
  return {duration_s, false};
}

/// The first fall of the margin within the step from x. Each trial is a whole RK4 step from x, so
/// the state at the event is as good as any other; it is left in `after`.
///
/// The margin is the least of several modes' own: a line through points on both sides of the event
/// may join two that have nothing to do with each other. Behind it they are mostly of one, so it is
/// a line through two points there that tells where to look; halving finds them. Trials aim a hair
/// late, so that the one that is good enough lies behind the event.
template <class System>
template <int N>
double OdeSolver<System>::locate(const System& system, double* x, double* after, double h) {
  constexpr std::size_t kCapacity = N > 0 ? N : kMostStates;
  const int n = N > 0 ? N : system.states();
  double low = 0, high = h, beyond = h;
  double g_low = system.margin(x), g_high = system.margin(after), g_beyond = g_high;
  if (g_low <= 0) {
    std::copy_n(x, n, after);
    return 0;
  }
  // What the margin falls by within that time, on the average of the step.
  const double near_enough = (g_low - g_high) * kLocatedWithinS / h;
  const auto crossing = [](double a, double g_a, double b, double g_b) {
    return (a * g_b - b * g_a) / (g_b - g_a);
  };
  double trial[kCapacity];
  enum class Next { kHalve, kAcross, kBehind } next = Next::kHalve;
  for (int trials = 0;
       high - low > kLocatedWithinS && g_high < -near_enough && trials < kMostTrials; ++trials) {
    double middle = low;
    if (next == Next::kBehind) middle = crossing(high, g_high, beyond, g_beyond);
    if (!(middle > low && middle < high) && next != Next::kHalve) {
      next = Next::kAcross;
      middle = crossing(low, g_low, high, g_high);
    }
    if (middle > low && middle < high)
      middle += std::min(kLocatedWithinS / 16, (high - middle) / 2);
    else
      middle = (low + high) / 2;
    rk4_step<N>(system, x, middle, trial);
    const double g = system.margin(trial);
    if (g > 0) {
      low = middle;
      g_low = g;
      next = next == Next::kBehind ? Next::kAcross : Next::kHalve;
    } else {
      beyond = high;
      g_beyond = g_high;
      high = middle;
      g_high = g;
      next = Next::kBehind;
      std::copy_n(trial, n, after);
    }
  }
  return high;
}

}  // namespace virtdrive
