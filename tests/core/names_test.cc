#include "core/names.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

TEST(Names, EditDistanceCountsSwappedNeighboursOnceAndIgnoresCase) {
  EXPECT_EQ(edit_distance("db42s03", "DB42S03"), 0U);
  EXPECT_EQ(edit_distance("db42s30", "db42s03"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
}

TEST(Names, AMisspeltNameGetsTheNearestOnesOffered) {
  EXPECT_EQ(unknown_name("motor", "db42s30", {"db42s03", "db42s01", "dr38312"}),
            "unknown motor 'db42s30'; did you mean db42s03 or db42s01? "
            "(known: db42s03, db42s01, dr38312)");
}

TEST(Names, ANameThatWasCutShortGetsTheWholeOne) {
  EXPECT_EQ(unknown_name("drive", "toshiba", {"md50", "toshiba-mcu"}),
            "unknown drive 'toshiba'; did you mean toshiba-mcu? (known: md50, toshiba-mcu)");
}

TEST(Names, AFarNameGetsTheListOnly) {
  EXPECT_EQ(unknown_name("motor", "xyz", {"db42s03"}), "unknown motor 'xyz' (known: db42s03)");
}

}  // namespace
}  // namespace virtdrive
