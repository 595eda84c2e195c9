// The integration error of the plant per motor, mode and integrator, as a page of documentation.
//
//   virtdrive_plant_accuracy > docs/accuracy.md
//
// Nothing in it depends on the machine or the clock.
#include <fmt/core.h>

#include "tests/benchmark/plant_cases.h"

namespace virtdrive {
namespace {

struct Error {
  double worst = 0, rms = 0, peak = 0;
};

Error error_of(const std::vector<PhaseValues>& currents, const std::vector<PhaseValues>& exact) {
  Error e;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    for (std::size_t x = 0; x < 3; ++x) {
      const double d = std::fabs(currents[k][x] - exact[k][x]);
      e.worst = std::max(e.worst, d);
      e.rms += d * d;
      e.peak = std::max(e.peak, std::fabs(exact[k][x]));
    }
  }
  e.rms = std::sqrt(e.rms / static_cast<double>(3 * exact.size()));
  return e;
}

void print_header() {
  fmt::print(R"(# Accuracy

```
./dev bench --accuracy
```

writes this page. Each row is one run of 50 ms: the commands of a run under feedback are recorded and replayed to the integrator that is measured and to a
reference, the default integrator at a tolerance of 1e-12. The error is that of the phase currents at the end of each PWM period, as a share of the greatest
phase current of the run: the worst and the root mean square. What the table does not contain is the error of the models; [validation](validation.md) does.

`default` is ERKStep (Dormand-Prince 7-4-5) at a relative tolerance of 1e-6, `fast` RK4 with event location. In `six-step` the motor has a trapezoidal EMF, its
open phase conducts through body diodes, and the corners of the EMF, the edges of the PWM and the diodes' events all bound steps.
In the other modes the EMF is a sine and every motor is linear, but for the last three rows: they have the motor's own saturation, thermal network and EMF, or,
of which no motor of the library has a source, a tenth of fifth harmonic with cogging and hysteresis of a twentieth of the rated torque each. With gates off and the EMF just above the link, a diode conducts for slivers; one that a step
leaps over is worth up to 2e-5.

| motor | mode | PWM period | default: worst | rms | fast: worst | rms | diode and other state events |
|---|---|---|---|---|---|---|---|
)");
}

int print_page() {
  print_header();
  for (const PlantCase& c : plant_cases()) {
    const std::vector<BridgeCommand> commands = c.record();
    Axis tight = c.axis(Integrator::kDefault, 1e-12);
    const std::vector<PhaseValues> exact = c.replay(tight, commands);
    Axis standard = c.axis(Integrator::kDefault), fast = c.axis(Integrator::kFast);
    const Error d = error_of(c.replay(standard, commands), exact);
    const Error f = error_of(c.replay(fast, commands), exact);
    fmt::print("| {} | {} | {:.1f} us | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} |\n", c.motor,
               c.mode_name(), seconds(c.period) * 1e6, d.worst / d.peak, d.rms / d.peak,
               f.worst / f.peak, f.rms / f.peak, tight.counters().state_events);
    if (tight.counters().stalled + standard.counters().stalled + fast.counters().stalled > 0) {
      fmt::print(stderr, "{}, {}: stalled\n", c.motor, c.mode_name());
      return 1;
    }
  }
  fmt::print(R"(
A synchronous machine under replayed duties is an open loop, in which any difference grows with the angle; under its own controller the errors are smaller.
)");
  return 0;
}

}  // namespace
}  // namespace virtdrive

int main() {
  return virtdrive::print_page();
}
