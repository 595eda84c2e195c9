// What an axis costs and errs, beside the least that the same equations can cost: one RK4 step of
// 50 us, written out by hand.
//
//   virtdrive_simulation_benchmark
//
// The db42s03 on 24 V is run by a current controller at 2000 rpm with a duty for every 50 us;
// the duties from standstill on are recorded and replayed. Counters: `of_bare` the cost relative to
// the bare step in the same run, `error` the greatest current error over 0.1 s against RK4 at 0.2
// us, as a share of the rated current. The others run a whole drive in closed loop.
#include <algorithm>
#include <array>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/event_loop.h"
#include "firmware_models/rzt1/servo_drive.h"
#include "firmware_models/toshiba_mcu/firmware.h"
#include "plant/axis.h"
#include "plant/motor_library.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kPeriod = 50us;
constexpr int kPeriods = 2000;
constexpr double kTargetSpeedRadps = 209.44;

AxisParameters bench() {
  const Motor& motor = find_motor("db42s03");
  return {.motor = motor.electrical,
          .link = {.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3},
          .mechanics = motor.mechanics};
}

// 20 mNm at 2000 rpm.
constexpr Load kLoad{.inertia_kgm2 = 1e-5, .quadratic_nm_per_radps2 = 4.56e-7};

/// The equations once more, with nothing around them.
struct Bare {
  using State = std::array<double, 5>;  // id, iq, speed, angle, bus

  double p, r, ld, lq, psi, inertia, viscous, friction, source_v, source_r, capacitance;
  double alpha = 0, beta = 0;

  explicit Bare(const AxisParameters& a)
      : p(a.motor.pole_pairs),
        r(a.motor.resistance_ohm),
        ld(a.motor.inductance_d_h),
        lq(a.motor.inductance_q_h),
        psi(a.motor.flux_wb),
        inertia(a.mechanics.inertia_kgm2 + kLoad.inertia_kgm2),
        viscous(a.mechanics.viscous_nm_per_radps),
        friction(a.mechanics.coulomb_nm),
        source_v(a.link.source_v),
        source_r(a.link.resistance_ohm),
        capacitance(a.link.capacitance_f) {}

  State f(const State& x) const {
    const double c = std::cos(p * x[3]), s = std::sin(p * x[3]);
    const double sd = alpha * c + beta * s, sq = beta * c - alpha * s;
    const double we = p * x[2];
    const double torque = 1.5 * p * (psi + (ld - lq) * x[0]) * x[1];
    const double dry =
        x[2] != 0 ? std::copysign(friction, x[2]) : std::clamp(torque, -friction, friction);
    return {(x[4] * sd - r * x[0] + we * lq * x[1]) / ld,
            (x[4] * sq - r * x[1] - we * (ld * x[0] + psi)) / lq,
            (torque - (viscous + kLoad.quadratic_nm_per_radps2 * std::fabs(x[2])) * x[2] - dry) /
                inertia,
            x[2],
            (std::max(0.0, (source_v - x[4]) / source_r) - 1.5 * (sd * x[0] + sq * x[1])) /
                capacitance};
  }

  State step(const State& x, double h) const {
    const auto moved = [&](const State& k, double by) {
      State y;
      for (std::size_t i = 0; i < 5; ++i) y[i] = x[i] + by * k[i];
      return y;
    };
    const State k1 = f(x), k2 = f(moved(k1, h / 2)), k3 = f(moved(k2, h / 2)), k4 = f(moved(k3, h));
    State y;
    for (std::size_t i = 0; i < 5; ++i) y[i] = x[i] + h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
    return y;
  }
};

struct Replay {
  std::vector<PhaseValues> duty;       // per period
  std::vector<Bare::State> reference;  // at its end
};

/// A PI current controller in dq with the speed held by a P controller, on the bare equations.
Replay record() {
  const AxisParameters parameters = bench();
  Bare bare(parameters);
  Replay replay;
  Bare::State x{0, 0, 0, 0, 24};
  Dq integral;
  const double kp = bare.lq * 2 * std::numbers::pi * 800, ki = bare.r * 2 * std::numbers::pi * 800;
  const double dt = seconds(kPeriod);
  for (int k = 0; k < kPeriods; ++k) {
    // The reference torque changes every 5 ms, so that the currents keep moving.
    const double wanted = k / 100 % 2 == 0 ? 1.5 : 0.3;
    const double iq = std::clamp(0.05 * (kTargetSpeedRadps - x[2]) + wanted, -1.85, 1.85);
    const Dq error{-x[0], iq - x[1]};
    integral.d += ki * dt * error.d;
    integral.q += ki * dt * error.q;
    const Dq v{kp * error.d + integral.d, kp * error.q + integral.q};
    const Rotation r(bare.p * (x[3] + 0.5 * dt * x[2]));
    PhaseValues duty = inverse_clarke(inverse_park({v.d / x[4], v.q / x[4]}, r));
    for (double& d : duty) d = std::clamp(d + 0.5, 0.0, 1.0);
    const AlphaBeta share = clarke(duty);
    bare.alpha = share.alpha;
    bare.beta = share.beta;
    for (int i = 0; i < 250; ++i) x = bare.step(x, dt / 250);
    replay.duty.push_back(duty);
    replay.reference.push_back(x);
  }
  return replay;
}

const Replay& recorded() {
  static const Replay replay = record();
  return replay;
}

double worst_error_a(double so_far, double i_d_a, double i_q_a, int period) {
  const Bare::State& exact = recorded().reference[static_cast<std::size_t>(period)];
  return std::max({so_far, std::fabs(i_d_a - exact[0]), std::fabs(i_q_a - exact[1])});
}

/// What one replay tells.
struct Result {
  double error_a = 0;
  double derivatives = 0;
};

Result replay_bare() {
  Bare bare(bench());
  Bare::State x{0, 0, 0, 0, 24};
  Result result{.derivatives = 4.0 * kPeriods};
  for (int k = 0; k < kPeriods; ++k) {
    const AlphaBeta share = clarke(recorded().duty[static_cast<std::size_t>(k)]);
    bare.alpha = share.alpha;
    bare.beta = share.beta;
    x = bare.step(x, seconds(kPeriod));
    result.error_a = worst_error_a(result.error_a, x[0], x[1], k);
  }
  return result;
}

Result replay_axis(Integrator integrator, SimDuration period) {
  Axis axis(bench(), integrator, kLoad);
  Result result;
  SimTime t = kSimStart;
  for (int k = 0; k < kPeriods; ++k) {
    axis.set_bridge({.mode = Bridge::kDriven,
                     .duty = recorded().duty[static_cast<std::size_t>(k)],
                     .pwm_period = period});
    axis.advance_to(t += period);
    result.error_a = worst_error_a(result.error_a, axis.state().i_d_a, axis.state().i_q_a, k);
  }
  result.derivatives = static_cast<double>(axis.counters().derivative_evaluations);
  return result;
}

template <class F>
double seconds_of(const F& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Runs kPeriods of 50 us of something and of the bare steps by turns, so that both meet the same
/// machine, and compares the best of each.
template <class Run>
void compare(benchmark::State& state, const Run& run) {
  recorded();
  double best = 1, best_bare = 1;
  for (auto _ : state) {
    const double taken = seconds_of(run);
    state.SetIterationTime(taken);
    best = std::min(best, taken);
    best_bare = std::min(best_bare, seconds_of([] { benchmark::DoNotOptimize(replay_bare()); }));
  }
  state.counters["ns_per_50us"] = 1e9 * best / kPeriods;
  state.counters["of_bare"] = best / best_bare;
}

template <class Replayed>
void compare_replay(benchmark::State& state, const Replayed& replayed) {
  Result result;
  compare(state, [&] { result = replayed(); });
  state.counters["derivatives"] = result.derivatives / kPeriods;
  state.counters["error"] = result.error_a / bench().motor.rated_current_a;
}

void bare_step(benchmark::State& state) {
  compare_replay(state, replay_bare);
}
void axis_default(benchmark::State& state) {
  compare_replay(state, [] { return replay_axis(Integrator::kDefault, kPeriod); });
}
void axis_fast(benchmark::State& state) {
  compare_replay(state, [] { return replay_axis(Integrator::kFast, kPeriod); });
}

/// The whole drive in FOC at 2000 rpm: event loop, converters, firmware at 12.5 kHz, plant.
void drive(benchmark::State& state, Integrator integrator) {
  EventLoop loop;
  Axis axis(bench(), integrator, kLoad);
  Axis* const axes[] = {&axis};
  toshiba_mcu::Firmware firmware(loop, axes, Seed{1});
  firmware.board(0).set_speed_rpm(2000);
  firmware.board(0).start();
  loop.run_until(kSimStart + 5s);
  if (firmware.board(0).channel().actual_rpm() < 1900)
    state.SkipWithError("the motor does not run");
  compare(state, [&] { loop.run_until(loop.now() + kPeriods * kPeriod); });
}
void drive_default(benchmark::State& state) {
  drive(state, Integrator::kDefault);
}
void drive_fast(benchmark::State& state) {
  drive(state, Integrator::kFast);
}

/// The RZ/T1 kit's two servo axes on one link, a task each 50 us; so many of them turn at 500 rpm,
/// the others are off.
void kit(benchmark::State& state) {
  EventLoop loop;
  const Motor motor = find_motor("servo-400w");
  const DcBus bus({.source_v = 280, .resistance_ohm = 0.5, .capacitance_f = 470e-6},
                  Integrator::kFast);
  Axis first({.motor = motor.electrical, .mechanics = motor.mechanics}, bus);
  Axis second({.motor = motor.electrical, .mechanics = motor.mechanics}, bus);
  Axis* const axes[] = {&first, &second};
  rzt1::Hardware hardware;
  rzt1::ServoDrive drive(loop, axes, {rzt1::factory_settings(1), rzt1::factory_settings(2)},
                         hardware, Seed{1});
  const auto turning = static_cast<std::size_t>(state.range(0));
  for (std::size_t i = 0; i < turning; ++i) (void)drive.axis(i).on();
  loop.run_until(kSimStart + 1s);
  for (std::size_t i = 0; i < turning; ++i) (void)drive.axis(i).forward();
  loop.run_until(kSimStart + 2s);
  if (turning > 0 && drive.axis(turning - 1).velocity_counts() < 100) {
    state.SkipWithError("the motor does not run");
  }
  compare(state, [&] { loop.run_until(loop.now() + kPeriods * kPeriod); });
}

BENCHMARK(bare_step)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(axis_default)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(axis_fast)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(drive_default)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(drive_fast)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(kit)->DenseRange(0, 2)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace virtdrive

BENCHMARK_MAIN();
