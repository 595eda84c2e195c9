// The plots of docs/validation.md: ours as a line, the published numbers as dots.
//
//   virtdrive_validation_plots DIRECTORY
//
// Nothing in them depends on the machine or the clock. The same cases are tests with gates.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/core.h>
#include <fstream>
#include <numbers>
#include <sstream>
#include <vector>

#include "plant/axis.h"
#include "plant/motor_library.h"
#include "scenarios/report/chart.h"
#include "tests/plant/six_step.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr double kRpmPerRadps = 30 / std::numbers::pi;
constexpr double kWidth = 960, kHeight = 300;

using Points = std::vector<Point>;

Plot plot(Scale x, Scale y, double left = 84, double width = kWidth - 84 - 24) {
  return {
      .left = left, .top = 62, .width = width, .height = 190, .x = std::move(x), .y = std::move(y)};
}

// --- V1 ------------------------------------------------------------------------------------------

/// The fan drive of the Modelica Standard Library; speeds of its closed form.
std::string run_up() {
  const Motor motor = find_motor("smpm-msl");
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 300, .resistance_ohm = 0},
             .mechanics = motor.mechanics},
            Integrator::kDefault,
            {.inertia_kgm2 = 0.29,
             .external_torque_nm = -181.4477,
             .quadratic_nm_per_radps2 = 181.4 / (157.0796 * 157.0796)});
  Points ours;
  for (int i = 0; i <= 200; ++i) {
    axis.advance_to(kSimStart + i * 10ms);
    ours.push_back({i * 0.01, axis.state().speed_radps});
  }
  Chart chart("V1: run-up of a fan drive", kWidth);
  const Plot p = plot(scale(0, 2, 10, "s"), scale(0, 160, 6, "rad/s"));
  chart.heading(p, "V1: run-up at constant torque against a fan");
  chart.keys(p, {{"blue", "ours"}, {"orange dots", "157.10 tanh(t / 0.50217 s)"}});
  chart.axes(p);
  chart.curve(p, ours, "blue");
  chart.dots(
      p, Points{{0.25, 72.3311}, {0.5, 119.3602}, {1, 151.3521}, {1.5, 156.3030}, {2, 156.9912}},
      "orange");
  return chart.svg(kHeight);
}

// --- V3 ------------------------------------------------------------------------------------------

struct GoldenRow {
  double t_end, q_alpha, q_beta, i_d, i_q, speed, angle;
};

std::vector<GoldenRow> golden_rows() {
  std::ifstream file(VIRTDRIVE_TEST_DATA "/ipmsm_2kw_golden.csv");
  std::vector<GoldenRow> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    GoldenRow r{};
    fields >> r.t_end >> r.q_alpha >> r.q_beta >> r.i_d >> r.i_q >> r.speed >> r.angle;
    rows.push_back(r);
  }
  return rows;
}

/// The 2.2-kW drive: the golden run's voltages replayed.
std::string golden_run() {
  const Motor motor = find_motor("ipmsm-2kw");
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 540, .resistance_ohm = 0, .capacitance_f = 1e-3},
             .mechanics = motor.mechanics},
            Integrator::kDefault);
  constexpr SimDuration kInterval = 125us;
  Points current, speed, golden_current, golden_speed;
  int k = 0;
  for (const GoldenRow& row : golden_rows()) {
    PhaseValues duty = inverse_clarke({row.q_alpha, row.q_beta});
    const double centre = (std::ranges::min(duty) + std::ranges::max(duty)) / 2;
    for (double& d : duty) d = std::clamp(d + 0.5 - centre, 0.0, 1.0);
    if (axis.now() == kSimStart + 800ms) axis.set_load({.external_torque_nm = 14});
    axis.set_bridge({.mode = Bridge::kDriven, .duty = duty, .pwm_period = kInterval});
    axis.advance_to(axis.now() + kInterval);
    ++k;
    if (k % 8 == 0) {
      current.push_back({row.t_end, axis.state().i_q_a});
      speed.push_back({row.t_end, axis.state().speed_radps});
    }
    if (k % 240 == 0) {
      golden_current.push_back({row.t_end, row.i_q});
      golden_speed.push_back({row.t_end, row.speed});
    }
  }
  Chart chart("V3: a 2.2-kW IPMSM against motulator", kWidth);
  const Scale time = scale(0, 1.2, 6, "s");
  const double half = kWidth / 2;
  const Plot left = plot(time, scale(0, 10, 5, "A"), 84, half - 84 - 24);
  const Plot right = plot(time, scale(0, 160, 6, "rad/s"), half + 84, half - 84 - 24);
  chart.heading(left, "V3: q current, load step at 0.8 s");
  chart.keys(left, {{"blue", "ours"}, {"orange dots", "motulator at rtol 1e-10"}});
  chart.axes(left);
  chart.curve(left, current, "blue");
  chart.dots(left, golden_current, "orange");
  chart.heading(right, "Speed");
  chart.axes(right);
  chart.curve(right, speed, "blue");
  chart.dots(right, golden_speed, "orange");
  return chart.svg(kHeight);
}

// --- V6 ------------------------------------------------------------------------------------------

/// The traction machine at 100 rad/s whose terminals are shorted at t = 0, without current before.
std::string short_circuit() {
  const Motor motor = find_motor("gem-pmsm");
  MechanicsParameters rigid = motor.mechanics;
  rigid.inertia_kgm2 = 1e9;
  Axis axis({.motor = motor.electrical,
             .link = {.source_v = 300, .resistance_ohm = 0},
             .mechanics = rigid},
            Integrator::kDefault);
  axis.set_motion(0, 100);
  axis.set_bridge({.mode = Bridge::kShort});
  // The published eigenvalues and end point; the slopes at t = 0 are those of the EMF.
  constexpr double kDecay = -31.824, kTurn = 299.528, kEndD = -176.9437, kEndQ = -8.8472;
  const PmsmParameters& m = motor.electrical;
  const double emf_v = m.pole_pairs * 100 * m.flux_wb;
  const auto closed = [&](double t, double end, double slope) {
    const double swing = (slope + kDecay * end) / kTurn;
    return end + std::exp(kDecay * t) * (-end * std::cos(kTurn * t) + swing * std::sin(kTurn * t));
  };
  Points d, q, closed_d, closed_q;
  for (int i = 0; i <= 500; ++i) {
    const double t = i * 2e-4;
    axis.advance_to(kSimStart + i * 200us);
    d.push_back({t, axis.state().i_d_a});
    q.push_back({t, axis.state().i_q_a});
    if (i % 10 != 0) continue;
    closed_d.push_back({t, closed(t, kEndD, 0)});
    closed_q.push_back({t, closed(t, kEndQ, -emf_v / m.inductance_q_h)});
  }
  Chart chart("V6: short circuit of a traction machine", kWidth);
  const Plot p = plot(scale(0, 0.1, 10, "s"), scale(-350, 150, 6, "A"));
  chart.heading(p, "V6: terminals shorted at 100 rad/s");
  chart.keys(p, {{"blue", "d current, ours"},
                 {"green", "q current, ours"},
                 {"orange dots", "by the published eigenvalues and end point"}});
  chart.axes(p);
  chart.curve(p, d, "blue");
  chart.curve(p, q, "green");
  chart.dots(p, closed_d, "orange");
  chart.dots(p, closed_q, "orange");
  return chart.svg(kHeight);
}

// --- V7 ------------------------------------------------------------------------------------------

/// maxon EC 45 flat 30 W, 24 V, as six_step_test.cc has it.
std::string block_commutation() {
  constexpr double kVolts = 24, kOhm = 4.83, kHenry = 2.24e-3, kNmPerA = 51e-3, kNoLoadA = 0.073;
  AxisParameters parameters{
      .motor = bldc_line_to_line(8, kOhm, kHenry, kNmPerA, 1),
      .link = {.source_v = kVolts, .resistance_ohm = 0},
      .mechanics = {.inertia_kgm2 = 92.5e-7, .coulomb_nm = kNmPerA * kNoLoadA}};
  parameters.effects.emf = EmfShape::trapezoid(2 * std::numbers::pi / 3);
  Points speed, current, linear_speed, linear_current;
  for (double load_nm = 0; load_nm < 66e-3; load_nm += 5e-3) {
    Axis axis(parameters, Integrator::kFast, {.brake_torque_nm = load_nm});
    SixStep commutation;
    commutation.run(axis, kSimStart + 500ms, 10us);
    double charge = 0;
    int samples = 0;
    const double angle = axis.state().angle_rad;
    commutation.run(axis, kSimStart + 600ms, 5us, [&] {
      charge += axis.source_current_a();
      ++samples;
    });
    speed.push_back({load_nm * 1e3, (axis.state().angle_rad - angle) / 0.1 * kRpmPerRadps});
    current.push_back({load_nm * 1e3, charge / samples});
    const double amps = load_nm / kNmPerA + kNoLoadA;
    linear_speed.push_back({load_nm * 1e3, (kVolts - kOhm * amps) / kNmPerA * kRpmPerRadps});
    linear_current.push_back({load_nm * 1e3, amps});
  }
  Chart chart("V7: maxon EC 45 flat under six-step", kWidth);
  const Scale load = scale(0, 70, 7, "mNm");
  const double half = kWidth / 2;
  const Plot left = plot(load, scale(2000, 4500, 6, "rpm"), 84, half - 84 - 24);
  const Plot right = plot(load, scale(0, 1.4, 7, "A"), half + 84, half - 84 - 24);
  chart.heading(left, "V7: EC 45 flat 30 W, 24 V: speed");
  chart.keys(left,
             {{"blue", "ours"}, {"grey dashed", "linear model"}, {"orange dots", "data sheet"}});
  chart.axes(left);
  chart.curve(left, linear_speed, "grey dashed");
  chart.curve(left, speed, "blue");
  chart.dots(left, Points{{0, 4380}, {55.3, 2940}}, "orange");
  chart.heading(right, "Current out of the supply");
  chart.axes(right);
  chart.curve(right, linear_current, "grey dashed");
  chart.curve(right, current, "blue");
  chart.dots(right, Points{{0, 0.073}, {55.3, 1.01}}, "orange");
  return chart.svg(kHeight);
}

// --- V9 ------------------------------------------------------------------------------------------

/// Stick-slip of a mass on a spring whose end is drawn at 0.5 rad/s.
std::string stick_slip() {
  const Load load{.inertia_kgm2 = 1e-4,
                  .brake_torque_nm = 0.1,
                  .viscous_nm_per_radps = 1e-3,
                  .stiction_nm = 0.15,
                  .stribeck_radps = 0.2};
  AxisParameters parameters{.motor = find_motor("db42s03").electrical};
  parameters.link = {.source_v = 24, .resistance_ohm = 0};
  parameters.mechanics = {.inertia_kgm2 = 1e12, .transmission = {.stiffness_nm_per_rad = 10}};
  Axis axis(parameters, Integrator::kDefault, load, 1e-9);
  axis.set_motion(0, 0.5);
  axis.set_load({.inertia_kgm2 = 1e-4, .locked = true});
  axis.set_load(load);
  Points mass, end;
  for (int i = 0; i <= 4000; ++i) {
    axis.advance_to(kSimStart + i * 500us);
    if (i < 3200) continue;
    mass.push_back({i * 5e-4, axis.load_angle_rad()});
    end.push_back({i * 5e-4, axis.state().angle_rad});
  }
  Chart chart("V9: stick-slip", kWidth);
  const Plot p = plot(scale(1.6, 2, 8, "s"), scale(0.78, 1.02, 6, "rad"));
  chart.heading(p, "V9: a mass that sticks and slips on a drawn spring");
  chart.keys(
      p, {{"blue", fmt::format("the mass, ours: {} events in 2 s", axis.counters().state_events)},
          {"grey dashed", "the spring's end"},
          {"orange dots", "two prototypes: the end of the 116th event, the angle at 2 s"}});
  chart.axes(p);
  chart.curve(p, end, "grey dashed");
  chart.curve(p, mass, "blue");
  chart.dots(p, Points{{1.991243692, 0.991086929}, {2, 0.991086929}}, "orange");
  return chart.svg(kHeight);
}

int draw_all(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  const std::pair<const char*, std::string (*)()> plots[] = {
      {"v1-run-up.svg", run_up},
      {"v3-golden-run.svg", golden_run},
      {"v6-short-circuit.svg", short_circuit},
      {"v7-six-step.svg", block_commutation},
      {"v9-stick-slip.svg", stick_slip}};
  for (const auto& [name, draw] : plots) {
    std::ofstream file(directory / name);
    file << draw();
    if (!file.flush()) {
      fmt::print(stderr, "{} cannot be written\n", (directory / name).string());
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace virtdrive

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: {} DIRECTORY\n", argv[0]);
    return 2;
  }
  return virtdrive::draw_all(argv[1]);
}
