// What many drives cost: each axis a motor in FOC at 2000 rpm under its firmware (12.5 kHz), on the
// fast path and a link of its own, all in one thread.
//
//   virtdrive_fleet [SVG]
//
// Prints the cost of 1 to 200 axes, without and with firmware, in processor time of the thread, and
// how 50 of them keep to the wall clock for ten seconds. Draws the cost into a file.
#include <cmath>
#include <ctime>
#include <fmt/core.h>
#include <fstream>
#include <memory>
#include <numbers>
#include <vector>

#include "core/event_loop.h"
#include "firmware_models/toshiba_mcu/firmware.h"
#include "plant/axis.h"
#include "plant/motor_library.h"
#include "pty/runner.h"
#include "scenarios/report/chart.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr int kChannels = 3;
constexpr int kRounds = 7;
constexpr SimDuration kRound = 40ms;

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<Axis> make_axes(int count) {
  const Motor motor = find_motor("db42s03");
  std::vector<Axis> axes;
  for (int i = 0; i < count; ++i) {
    axes.emplace_back(
        AxisParameters{.motor = motor.electrical,
                       .link = {.source_v = 24, .resistance_ohm = 0.1, .capacitance_f = 1e-3},
                       .mechanics = motor.mechanics},
        Integrator::kFast, Load{.inertia_kgm2 = 1e-5, .quadratic_nm_per_radps2 = 4.56e-7});
  }
  return axes;
}

/// Controllers of three channels, their motors at speed.
class Fleet {
 public:
  explicit Fleet(int count) : axes_(make_axes(count)) {
    std::vector<Axis*> group;
    for (int i = 0; i < count; ++i) {
      group.push_back(&axes_[static_cast<std::size_t>(i)]);
      if (group.size() < kChannels && i + 1 < count) continue;
      controllers_.push_back(
          std::make_unique<toshiba_mcu::Firmware>(loop, group, Seed{static_cast<unsigned>(i)}));
      for (std::size_t channel = 0; channel < group.size(); ++channel) {
        controllers_.back()->board(channel).set_speed_rpm(2000);
        controllers_.back()->board(channel).start();
      }
      group.clear();
    }
    loop.run_until(loop.now() + 4s);
  }

  int at_speed() {
    int count = 0;
    for (Axis& axis : axes_) {
      axis.advance_to(loop.now());
      count += std::fabs(axis.state().speed_radps - 209.4) < 2 ? 1 : 0;
    }
    return count;
  }

  EventLoop loop;

 private:
  std::vector<Axis> axes_;
  std::vector<std::unique_ptr<toshiba_mcu::Firmware>> controllers_;
};

/// The least processor time per simulated second of some rounds.
template <class Run>
double cost(const Run& run) {
  double best = 1e9;
  for (int i = 0; i < kRounds; ++i) {
    const double start = cpu_seconds();
    run();
    best = std::min(best, (cpu_seconds() - start) / seconds(kRound));
  }
  return best;
}

double cost_of_plant(int count) {
  std::vector<Axis> axes = make_axes(count);
  for (Axis& axis : axes) axis.set_motion(0, 209.4);
  int k = 0;
  return cost([&] {
    for (int i = 0; i < kRound / 50us; ++i, ++k) {
      const double angle = k * 209.4 * 4 * 50e-6 + 1.7;
      PhaseValues duty = inverse_clarke({0.3 * std::cos(angle), 0.3 * std::sin(angle)});
      for (double& d : duty) d += 0.5;
      for (Axis& axis : axes) {
        axis.set_bridge({.mode = Bridge::kDriven, .duty = duty});
        axis.advance_to(axis.now() + 50us);
      }
    }
  });
}

double cost_of_drives(int count) {
  Fleet fleet(count);
  return cost([&] { fleet.loop.run_until(fleet.loop.now() + kRound); });
}

std::string draw(const std::vector<Point>& plant, const std::vector<Point>& drives) {
  Chart chart("Cost over the number of axes", 960);
  const Plot p{.left = 84,
               .top = 62,
               .width = 960 - 84 - 24,
               .height = 260,
               .x = logarithmic_scale(1, 200, "axes in one thread"),
               .y = logarithmic_scale(2e-3, 5, "s/s")};
  chart.heading(p, "Processor time per simulated second");
  chart.keys(p, {{"blue", "drives in FOC with firmware"},
                 {"green", "plant alone, a new duty each 50 us"},
                 {"grey dashed", "in proportion to one axis; real time is 1"}});
  chart.axes(p);
  for (const auto* curve : {&plant, &drives}) {
    std::vector<Point> proportional;
    for (const Point& point : *curve) {
      proportional.push_back({point.x, curve->front().y * point.x});
    }
    chart.curve(p, proportional, "grey dashed");
  }
  chart.curve(p, plant, "green");
  chart.dots(p, plant, "green");
  chart.curve(p, drives, "blue");
  chart.dots(p, drives, "blue");
  return chart.svg(380);
}

void keep_to_the_clock(int count) {
  Fleet fleet(count);
  const double start = cpu_seconds();
  Runner runner(fleet.loop, {.until = fleet.loop.now() + 10s});
  const PacingReport report = runner.run();
  const auto ms = [](auto time) { return std::chrono::duration<double, std::milli>(time).count(); };
  fmt::print(
      "\n{} axes with firmware at real time for 10 s, {} of them at 2000 rpm: {:.1f} s of "
      "processor "
      "time, {} overruns (over 10 ms late), worst lag {:.1f} ms, {:.0f} ms given up\n",
      count, fleet.at_speed(), cpu_seconds() - start, report.overruns, ms(report.max_lag),
      ms(report.slipped));
}

int measure(const char* svg_path) {
  std::vector<Point> plant, drives;
  fmt::print(
      "| axes | plant alone: ns per axis and 50 us | times real time | with firmware: ns per "
      "axis and 50 us | times real time |\n|---|---|---|---|---|\n");
  for (const int count : {1, 2, 5, 10, 20, 50, 100, 200}) {
    plant.push_back({double(count), cost_of_plant(count)});
    drives.push_back({double(count), cost_of_drives(count)});
    fmt::print("| {} | {:.0f} | {:.3g} | {:.0f} | {:.3g} |\n", count, plant.back().y / count * 50e3,
               1 / plant.back().y, drives.back().y / count * 50e3, 1 / drives.back().y);
  }
  keep_to_the_clock(50);
  if (svg_path == nullptr) return 0;
  std::ofstream file(svg_path);
  file << draw(plant, drives);
  return file.flush() ? 0 : 1;
}

}  // namespace
}  // namespace virtdrive

int main(int argc, char** argv) {
  return virtdrive::measure(argc > 1 ? argv[1] : nullptr);
}
