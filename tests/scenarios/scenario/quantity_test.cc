#include "scenarios/scenario/quantity.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

TEST(Quantity, IsANumberWithItsUnit) {
  const auto speed = parse_quantity("2000 rpm");
  ASSERT_TRUE(speed);
  EXPECT_EQ(speed->value, 2000);
  EXPECT_EQ(speed->unit, "rpm");
  EXPECT_EQ(parse_quantity("-1.5mNm")->unit, "mNm");
  EXPECT_EQ(parse_quantity("1e-5 Nm/(rad/s)")->unit, "Nm/(rad/s)");
  EXPECT_EQ(parse_quantity("7")->unit, "");
  for (const std::string_view bad :
       {"", "rpm", "010 rpm", "1 2", "1 rpm now", "inf", "nan V", "1.2.3"}) {
    EXPECT_FALSE(parse_quantity(bad)) << bad;
  }
}

TEST(Quantity, ConvertsBetweenUnitsOfTheSameKindOnly) {
  EXPECT_DOUBLE_EQ(*convert(20, "mNm", "Nm"), 0.02);
  EXPECT_DOUBLE_EQ(*convert(10, "rad/s", "rpm"), 95.492965855137202);
  EXPECT_DOUBLE_EQ(*convert(10, "%", ""), 0.1);
  EXPECT_DOUBLE_EQ(*convert(5, "furlong", "furlong"), 5);
  EXPECT_FALSE(convert(1, "V", "A"));
  EXPECT_FALSE(convert(1, "", "A"));
  EXPECT_FALSE(convert(1, "furlong", "V"));
}

TEST(Quantity, TimesAreReadAndShownTheSameWay) {
  EXPECT_EQ(parse_time("1.5 s"), SimDuration(1500ms));
  EXPECT_EQ(parse_time("24 h"), SimDuration(24h));
  EXPECT_EQ(parse_time("0"), SimDuration(0));
  for (const std::string_view bad : {"-1 s", "5", "1 V", "1e9 h", ""}) {
    EXPECT_FALSE(parse_time(bad)) << bad;
  }
  for (const SimDuration time : {SimDuration(60s), SimDuration(1500us), SimDuration(24h),
                                 SimDuration(0), SimDuration(2500ns), SimDuration(20ms)}) {
    EXPECT_EQ(parse_time(show_time(time)), time) << show_time(time);
  }
  EXPECT_EQ(show_time(60s), "60 s");
  EXPECT_EQ(show_instant(kSimStart + 2413ms), "2.413 s");
  EXPECT_EQ(show_instant(kSimStart + 2413871us), "2.413871 s");
}

}  // namespace
}  // namespace virtdrive
