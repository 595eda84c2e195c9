#include "scenarios/report/chart.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace virtdrive {
namespace {

Plot square(Scale x, Scale y) {
  return {
      .left = 100, .top = 50, .width = 200, .height = 100, .x = std::move(x), .y = std::move(y)};
}

TEST(Chart, AScaleHasRoundEndsAndTicksBetweenThem) {
  const Scale s = scale(-3, 47, 6, "A");
  EXPECT_EQ(s.low, -10);
  EXPECT_EQ(s.high, 50);
  EXPECT_EQ(s.ticks(), (std::vector<double>{-10, 0, 10, 20, 30, 40, 50}));
  EXPECT_EQ(scale_up_to(0, 5, "A").high, 1) << "nothing is drawn up to 1";
}

TEST(Chart, ALogarithmicScaleHasEqualStepsForEqualRatios) {
  const Scale s = logarithmic_scale(1, 100, "axes");
  EXPECT_NEAR(s.share(10), 0.5, 1e-12);
  EXPECT_EQ(s.ticks(), (std::vector<double>{1, 2, 5, 10, 20, 50, 100}));
  EXPECT_EQ(s.label(50), "50");
}

TEST(Chart, APathLiesInItsPlotAndHasGaps) {
  const Plot plot = square(scale(0, 10, 5, "s"), scale(0, 1, 5, "A"));
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Point points[] = {{0, 0}, {5, 0.5}, {6, none}, {10, 1}};
  EXPECT_EQ(path_of(plot, points), "M100.0 150.0L200.0 100.0M300.0 50.0");
}

TEST(Chart, AFileNeedsNothingElseAndHasADarkSide) {
  Chart chart("<a>", 400);
  const Plot plot = square(scale(0, 10, 5, "s"), scale(0, 1, 5, "A & B"));
  chart.axes(plot);
  chart.keys(plot, {{"blue", "ours"}, {"orange dots", "theirs"}});
  const std::string svg = chart.svg(200);
  EXPECT_TRUE(svg.starts_with("<svg xmlns="));
  EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(svg.find("aria-label=\"&lt;a&gt;\""), std::string::npos);
  EXPECT_NE(svg.find("A &amp; B"), std::string::npos);
}

}  // namespace
}  // namespace virtdrive
