#include "firmware_models/md/six_step.h"

#include <algorithm>
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

BridgeCommand six_step(int sector, double output, SimDuration pwm_period) {
  PhasePair pair = pair_of(sector);
  if (output < 0) std::swap(pair.source, pair.sink);
  BridgeCommand command{
      .mode = Bridge::kDriven, .legs = {Leg::kHiZ, Leg::kHiZ, Leg::kHiZ}, .pwm_period = pwm_period};
  command.duty[pair.source] = std::min(1.0, std::fabs(output));
  command.legs[pair.source] = Leg::kDuty;
  command.legs[pair.sink] = Leg::kLow;
  return command;
}

BridgeCommand six_step_overlapped(int sector, double output, SimDuration pwm_period) {
  BridgeCommand command = six_step(sector, output, pwm_period);
  const BridgeCommand next = six_step((sector + (output < 0 ? 5 : 1)) % 6, output, pwm_period);
  for (std::size_t leg = 0; leg < command.legs.size(); ++leg) {
    if (command.legs[leg] != Leg::kHiZ) continue;
    command.legs[leg] = next.legs[leg];
    command.duty[leg] = next.duty[leg];
  }
  return command;
}

double overlapped_current_a(int sector, const PhaseValues& current_a) {
  const PhasePair pair = pair_of(sector);
  const double in = current_a[pair.source], out = -current_a[pair.sink];
  return std::fabs(in) > std::fabs(out) ? in : out;
}

double pair_current_a(int sector, const PhaseValues& current_a) {
  const PhasePair pair = pair_of(sector);
  return (current_a[pair.source] - current_a[pair.sink]) / 2;
}

}  // namespace virtdrive::md
