// The search for the axis' zero (7.6, figure 7.2), each 100 us.
//
//   HMASK 0      index:      move back, index -> stop -> POS := POS - index - HOFFS -> to 0
//   HMASK 3      hard stop:  move on, |ERR| > 100 -> POS := -HOFFS -> stop -> to 0
//   HMASK other  switch:     forward while it is off, back while it is on; its change -> stop ->
//                            move on to the index, and so on as there
//
// A search whose move ends without a hit has failed.
#pragma once

#include <cstdint>

#include "firmware_models/rzt1/settings.h"

namespace virtdrive::rzt1 {

/// How far the searches go. The document gives no distance; the successor's published example has
/// counts that suit one encoder.
struct HomingDistances {
  double index_turns = 1.2;
  double switch_turns = 8;
  double stop_turns = 8;
  /// Index at absolute -50000 (from the switch: 50000), switch at absolute +-1000000, hard stop
  /// 5500 counts on.
  bool literal = false;
};

enum class HomingState : std::uint8_t {
  kIdle,  // never asked for, or given up
  kFindingHardStop,
  kFindingSwitch,
  kFindingIndex,
  kWaitingAtHardStop,  // Wait to Stop
  kWaitingAtSwitch,    // Wait to Stop 2
  kWaitingAtIndex,     // Wait to Stop 3
  kMovingHome,
  kDone,
  kFailed,
};

/// What the axis tells it.
struct HomingReading {
  std::int32_t position = 0;
  std::int32_t position_error = 0;
  bool moving = false;
  bool captured = false;
  std::int32_t index = 0;
  std::uint8_t inputs = 0;  // ServoAxis::digital_inputs()
};

/// What the axis is to do.
struct HomingOrder {
  enum class What : std::uint8_t {
    kNothing,
    kMove,       // to `value`
    kArmIndex,   // and move to `value`
    kStop,       // smoothly
    kSetHere,    // POS := value, and stand still at once
    kShiftHome,  // POS := POS - value, and move to 0
  } what = What::kNothing;
  std::int32_t value = 0;
};

class Homing {
 public:
  HomingState state() const { return state_; }
  bool busy() const { return state_ != HomingState::kIdle && state_ < HomingState::kDone; }

  HomingOrder start(const HomingReading& reading, const Settings& settings,
                    const HomingDistances& distances);
  HomingOrder step(const HomingReading& reading, const Settings& settings,
                   const HomingDistances& distances);
  /// STOP, ABORT, OFF.
  void abort();

 private:
  HomingOrder fail();

  HomingState state_ = HomingState::kIdle;
  std::uint8_t switch_before_ = 0;
};

}  // namespace virtdrive::rzt1
