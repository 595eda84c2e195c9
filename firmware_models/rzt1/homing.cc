#include "firmware_models/rzt1/homing.h"

#include <cmath>
#include <cstdlib>

#include "firmware_models/rzt1/counts.h"

namespace virtdrive::rzt1 {
namespace {

using What = HomingOrder::What;

constexpr std::int32_t kHardStopMask = 3;
constexpr std::int32_t kHardStopError = 100;  // counts (7.6)
constexpr std::int32_t kLiteralIndex = 50000;
constexpr std::int32_t kLiteralStop = 5500;
constexpr std::int32_t kLiteralSwitch = 1000000;

std::int32_t turns(double n, const Settings& settings) {
  return static_cast<std::int32_t>(std::lround(n * settings.ecpr));
}

std::uint8_t switch_bits(const HomingReading& reading, const Settings& settings) {
  return static_cast<std::uint8_t>((reading.inputs ^ settings.invert) & settings.hmask);
}

}  // namespace

HomingOrder Homing::start(const HomingReading& reading, const Settings& settings,
                          const HomingDistances& distances) {
  if (settings.hmask == 0) {
    state_ = HomingState::kFindingIndex;
    return {What::kArmIndex,
            distances.literal
                ? -kLiteralIndex
                : difference(reading.position, turns(distances.index_turns, settings))};
  }
  if (settings.hmask == kHardStopMask) {
    state_ = HomingState::kFindingHardStop;
    return {What::kMove,
            sum(reading.position,
                distances.literal ? kLiteralStop : turns(distances.stop_turns, settings))};
  }
  state_ = HomingState::kFindingSwitch;
  switch_before_ = switch_bits(reading, settings);
  const bool back = switch_before_ != 0;
  const std::int32_t way = turns(distances.switch_turns, settings);
  if (distances.literal) return {What::kMove, back ? -kLiteralSwitch : kLiteralSwitch};
  return {What::kMove, back ? difference(reading.position, way) : sum(reading.position, way)};
}

HomingOrder Homing::step(const HomingReading& reading, const Settings& settings,
                         const HomingDistances& distances) {
  switch (state_) {
    case HomingState::kFindingHardStop:
      if (std::abs(reading.position_error) > kHardStopError) {
        state_ = HomingState::kWaitingAtHardStop;
        return {What::kSetHere, difference(0, settings.hoffs)};
      }
      return reading.moving ? HomingOrder{} : fail();
    case HomingState::kFindingSwitch:
      if (switch_bits(reading, settings) != switch_before_) {
        state_ = HomingState::kWaitingAtSwitch;
        return {What::kStop};
      }
      return reading.moving ? HomingOrder{} : fail();
    case HomingState::kWaitingAtSwitch:
      if (reading.moving) return {};
      state_ = HomingState::kFindingIndex;
      return {What::kArmIndex, distances.literal
                                   ? kLiteralIndex
                                   : sum(reading.position, turns(distances.index_turns, settings))};
    case HomingState::kFindingIndex:
      if (reading.captured) {
        state_ = HomingState::kWaitingAtIndex;
        return {What::kStop};
      }
      return reading.moving ? HomingOrder{} : fail();
    case HomingState::kWaitingAtHardStop:
      if (reading.moving) return {};
      state_ = HomingState::kMovingHome;
      return {What::kMove, 0};
    case HomingState::kWaitingAtIndex:
      if (reading.moving) return {};
      state_ = HomingState::kMovingHome;
      return {What::kShiftHome, sum(reading.index, settings.hoffs)};
    case HomingState::kMovingHome:
      if (!reading.moving) state_ = HomingState::kDone;
      return {};
    case HomingState::kIdle:
    case HomingState::kDone:
    case HomingState::kFailed:
      return {};
  }
  return {};
}

HomingOrder Homing::fail() {
  state_ = HomingState::kFailed;
  return {};
}

void Homing::abort() {
  if (busy()) state_ = HomingState::kIdle;
}

}  // namespace virtdrive::rzt1
