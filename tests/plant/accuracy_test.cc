// docs/accuracy.md in bounds: every motor, mode and integrator of its table.
#include <gtest/gtest.h>

#include "tests/benchmark/plant_cases.h"

namespace virtdrive {
namespace {

double worst_share(const std::vector<PhaseValues>& currents,
                   const std::vector<PhaseValues>& exact) {
  double worst = 0, peak = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    for (std::size_t x = 0; x < 3; ++x) {
      worst = std::max(worst, std::abs(currents[k][x] - exact[k][x]));
      peak = std::max(peak, std::abs(exact[k][x]));
    }
  }
  return worst / peak;
}

/// By mode, of the run's greatest phase current: about twice what docs/accuracy.md tells for the
/// worst of the motors.
double bound(PlantMode mode) {
  switch (mode) {
    case PlantMode::kAveraged:
      return 1e-5;
    case PlantMode::kSwitched:
      return 5e-5;
    case PlantMode::kSixStep:
      return 5e-4;
    case PlantMode::kRectifying:
      return 5e-5;  // what a sliver of conduction is worth that a step leaps over
    case PlantMode::kShorted:
      return 5e-6;
    case PlantMode::kOwnEffects:
      return 5e-4;  // the corners of a trapezoid, which bound no step of the default integrator
                    // here
  }
  return 0;
}

TEST(Accuracy, StaysWithinThePublishedTable) {
  for (const PlantCase& c : plant_cases()) {
    const std::vector<BridgeCommand> commands = c.record();
    Axis tight = c.axis(Integrator::kDefault, 1e-12);
    const std::vector<PhaseValues> exact = c.replay(tight, commands);
    for (const Integrator integrator : {Integrator::kDefault, Integrator::kFast}) {
      Axis axis = c.axis(integrator);
      EXPECT_LT(worst_share(c.replay(axis, commands), exact), bound(c.mode))
          << c.motor << ", " << c.mode_name()
          << (integrator == Integrator::kFast ? ", fast" : ", default");
      EXPECT_EQ(axis.counters().stalled, 0U) << c.motor << ", " << c.mode_name();
    }
  }
}

}  // namespace
}  // namespace virtdrive
