// The long sweeps: every search from many starts.
#include <gtest/gtest.h>

#include "tests/firmware_models/rzt1/searches.h"

namespace virtdrive::rzt1 {
namespace {

TEST(PhasingSweep, EachModeFindsTheRotorFromTwentyFourAngles) {
  for (const Case& c : kCases) phase_from(c, 24);
}

TEST(HomingSweep, TheIndexGivesTheSameZeroFromTwentyStarts) {
  by_index(20);
}

TEST(HomingSweep, TheSwitchGivesTheSameZeroFromTwentyStarts) {
  by_switch(20);
}

TEST(HomingSweep, TheHardStopGivesTheSameZeroFromTwentyStarts) {
  by_hard_stop(20);
}

}  // namespace
}  // namespace virtdrive::rzt1
