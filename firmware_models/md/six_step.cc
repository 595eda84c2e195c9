#include "firmware_models/md/six_step.h"

#include <array>
#include <cmath>
#include <utility>

namespace virtdrive::md {
namespace {

constexpr std::size_t kA = 0, kB = 1, kC = 2;
// Sector 0 lies around 60 electrical degrees, its torque axis at 150: into b, out of a.
constexpr std::array<PhasePair, 6> kPairs = {
    {{kB, kA}, {kC, kA}, {kC, kB}, {kA, kB}, {kA, kC}, {kB, kC}}};

}  // namespace

PhasePair pair_of(int sector) {
  return kPairs[static_cast<std::size_t>(sector)];
}

// The third leg stands at the middle of the two: the bridge has no command that floats one leg.
BridgeCommand six_step(int sector, double output, SimDuration pwm_period) {
  PhasePair pair = pair_of(sector);
  if (output < 0) std::swap(pair.source, pair.sink);
  const double duty = std::min(1.0, std::fabs(output));
  BridgeCommand command{.mode = Bridge::kDriven, .pwm_period = pwm_period};
  command.duty = {duty / 2, duty / 2, duty / 2};
  command.duty[pair.source] = duty;
  command.duty[pair.sink] = 0;
  return command;
}

double pair_current_a(int sector, const PhaseValues& current_a) {
  const PhasePair pair = pair_of(sector);
  return (current_a[pair.source] - current_a[pair.sink]) / 2;
}

}  // namespace virtdrive::md
