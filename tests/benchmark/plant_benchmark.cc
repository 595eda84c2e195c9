// What the plant costs, beside the least that its equations can cost: one RK4 step written out by
// hand (averaged: 50 us; six-step: 12.5 us), by turns in one process.
//
//   virtdrive_plant_benchmark
//
// Counters: `of_bare` the cost relative to bare RK4 steps over the same simulated time, `rtf`
// simulated seconds per second, `ns_per_50us`.
#include <array>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <ctime>

#include "tests/benchmark/plant_cases.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

/// The PMSM's equations with nothing around them.
struct Bare {
  using State = std::array<double, 5>;  // id, iq, speed, angle, bus
  AxisParameters a;
  AlphaBeta share;

  State f(const State& x) const {
    const PmsmParameters& m = a.motor;
    const Dq i{x[0], x[1]}, s = park(share, Rotation(m.pole_pairs * x[3]));
    const Dq di = current_derivative(m, i, {x[4] * s.d, x[4] * s.q}, m.pole_pairs * x[2]);
    return {di.d, di.q,
            (torque_nm(m, i) - a.mechanics.viscous_nm_per_radps * x[2] -
             std::copysign(a.mechanics.coulomb_nm, x[2])) /
                (6 * a.mechanics.inertia_kgm2),
            x[2],
            (std::max(0.0, (a.link.source_v - x[4]) / a.link.resistance_ohm) -
             1.5 * (s.d * i.d + s.q * i.q)) /
                a.link.capacitance_f};
  }
  State step(const State& x, double h) const {
    const auto moved = [&](const State& k, double by) {
      State y;
      for (std::size_t n = 0; n < 5; ++n) y[n] = x[n] + by * k[n];
      return y;
    };
    const State k1 = f(x), k2 = f(moved(k1, h / 2)), k3 = f(moved(k2, h / 2)), k4 = f(moved(k3, h));
    State y;
    for (std::size_t n = 0; n < 5; ++n) y[n] = x[n] + h / 6 * (k1[n] + 2 * (k2[n] + k3[n]) + k4[n]);
    return y;
  }
};

void bare_steps(const PlantCase& c, SimDuration step) {
  Bare bare{c.parameters, {}};
  Bare::State x{0, 0, c.start_speed_radps, 0, bare.a.link.source_v};
  const auto steps = static_cast<int>(c.duration / step);
  for (int k = 0; k < steps; ++k) {
    bare.share = {0.2 * std::cos(bare.a.motor.pole_pairs * x[3]), 0.1};
    x = bare.step(x, seconds(step));
  }
  benchmark::DoNotOptimize(x);
}

/// Of this thread, so that other programs on the machine count less.
double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class F>
double seconds_of(const F& f) {
  const double start = cpu_seconds();
  f();
  return cpu_seconds() - start;
}

/// `simulated_s` of something and of bare steps by turns; the best of each.
template <class Run, class Yardstick>
void compare(benchmark::State& state, double simulated_s, const Run& run, const Yardstick& bare) {
  double best = 1e9, best_bare = 1e9;
  for (auto _ : state) {
    const double taken = seconds_of(run);
    state.SetIterationTime(taken);
    best = std::min(best, taken);
    best_bare = std::min(best_bare, seconds_of(bare));
  }
  state.counters["of_bare"] = best / best_bare;
  state.counters["ns_per_50us"] = 1e9 * best * 50e-6 / simulated_s;
  state.counters["rtf"] = simulated_s / best;
}

void replayed(benchmark::State& state, PlantCase c, Integrator integrator, SimDuration bare_step) {
  c.duration = 10ms;
  const std::vector<BridgeCommand> commands = c.record();
  compare(
      state, seconds(c.duration),
      [&] {
        Axis axis = c.axis(integrator);
        benchmark::DoNotOptimize(c.replay(axis, commands));
      },
      [&] { bare_steps(c, bare_step); });
}

const PlantCase& averaged_case() {
  static const PlantCase c("db42s03", PlantMode::kAveraged, 50us);
  return c;
}

void averaged(benchmark::State& state, Integrator integrator) {
  replayed(state, averaged_case(), integrator, 50us);
}
void switched_foc(benchmark::State& state, Integrator integrator) {
  replayed(state, {"db42s03", PlantMode::kSwitched, 50us}, integrator, 50us);
}
void six_step_24khz_drone(benchmark::State& state, Integrator integrator) {
  replayed(state, {"gt2215", PlantMode::kSixStep, 41600ns}, integrator, 12500ns);
}

/// A shaft at rest with its gates off, asked each 50 us.
void resting(benchmark::State& state) {
  Axis axis(averaged_case().parameters, Integrator::kDefault);
  compare(
      state, seconds(averaged_case().duration),
      [&] {
        for (int k = 0; k < averaged_case().duration / averaged_case().period; ++k) {
          axis.advance_to(axis.now() + averaged_case().period);
        }
      },
      [&] { bare_steps(averaged_case(), 50us); });
}

constexpr int kPeriodsAtOnce = 10;

/// N axes, each with a link to itself, each with its duty for each 50 us.
void axes(benchmark::State& state) {
  const std::vector<BridgeCommand> commands = averaged_case().record();
  std::vector<Axis> fleet;
  for (int n = 0; n < state.range(0); ++n) fleet.push_back(averaged_case().axis(Integrator::kFast));
  std::size_t k = 0;
  double best = 1e9;
  for (auto _ : state) {
    const double taken = seconds_of([&] {
      for (int i = 0; i < kPeriodsAtOnce; ++i) {
        const BridgeCommand& command = commands[k++ % commands.size()];
        for (Axis& axis : fleet) {
          axis.set_bridge(command);
          axis.advance_to(axis.now() + 50us);
        }
      }
    });
    state.SetIterationTime(taken);
    best = std::min(best, taken);
  }
  const auto count = static_cast<double>(state.range(0));
  state.counters["ns_per_50us_and_axis"] = 1e9 * best / kPeriodsAtOnce / count;
  state.counters["rtf"] = kPeriodsAtOnce * 50e-6 / best;
}

/// N axes on one link: one circuit.
void axes_on_one_bus(benchmark::State& state) {
  const std::vector<BridgeCommand> commands = averaged_case().record();
  DcBus bus(averaged_case().parameters.link, Integrator::kFast);
  std::vector<Axis> fleet;
  for (int n = 0; n < state.range(0); ++n) {
    fleet.emplace_back(averaged_case().parameters, bus, averaged_case().load);
    fleet.back().set_motion(0, averaged_case().start_speed_radps);
  }
  std::size_t k = 0;
  double best = 1e9;
  for (auto _ : state) {
    const double taken = seconds_of([&] {
      for (int i = 0; i < kPeriodsAtOnce; ++i) {
        const BridgeCommand& command = commands[k++ % commands.size()];
        for (Axis& axis : fleet) axis.set_bridge(command);
        bus.advance_to(bus.now() + 50us);
      }
    });
    state.SetIterationTime(taken);
    best = std::min(best, taken);
  }
  state.counters["ns_per_50us_and_axis"] =
      1e9 * best / kPeriodsAtOnce / static_cast<double>(state.range(0));
  state.counters["rtf"] = kPeriodsAtOnce * 50e-6 / best;
}

BENCHMARK_CAPTURE(averaged, default, Integrator::kDefault)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(averaged, fast, Integrator::kFast)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(switched_foc, default, Integrator::kDefault)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(switched_foc, fast, Integrator::kFast)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(six_step_24khz_drone, default, Integrator::kDefault)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(six_step_24khz_drone, fast, Integrator::kFast)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(resting)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(axes)->Arg(1)->Arg(10)->Arg(50)->Arg(100)->Arg(200)->UseManualTime()->Unit(
    benchmark::kMillisecond);
BENCHMARK(axes_on_one_bus)
    ->Arg(1)
    ->Arg(3)
    ->Arg(8)
    ->Arg(32)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace virtdrive

BENCHMARK_MAIN();
