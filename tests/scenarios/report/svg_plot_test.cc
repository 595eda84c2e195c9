#include "scenarios/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace virtdrive {
namespace {

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1))
    ++n;
  return n;
}

TEST(AxisTicks, AreRoundNumbersInsideTheRange) {
  EXPECT_EQ(axis_ticks(0, 5.3, 12).values,
            (std::vector<double>{0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5}));
  EXPECT_EQ(axis_ticks(-30, 2040, 6).values, (std::vector<double>{0, 500, 1000, 1500, 2000}));
  EXPECT_EQ(axis_ticks(-3, 3, 4).values, (std::vector<double>{-2, 0, 2}));
}

TEST(AxisTicks, HaveAStepOfOneTwoOrFiveAndAreNeverTooMany) {
  for (double span = 1e-6; span < 1e6; span *= 1.37) {
    const Ticks ticks = axis_ticks(-span / 3, span, 6);
    EXPECT_GE(ticks.values.size(), 2U) << span;
    EXPECT_LE(ticks.values.size(), 6U) << span;
    const double leading = ticks.step / std::pow(10, std::floor(std::log10(ticks.step) + 1e-9));
    EXPECT_TRUE(std::abs(leading - 1) < 1e-9 || std::abs(leading - 2) < 1e-9 ||
                std::abs(leading - 5) < 1e-9)
        << ticks.step;
  }
}

TEST(TickLabel, HasTheDecimalsOfTheStep) {
  EXPECT_EQ(tick_label(1500, 500), "1500");
  EXPECT_EQ(tick_label(0.5, 0.5), "0.5");
  EXPECT_EQ(tick_label(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(tick_label(24, 0.02), "24.00");
  EXPECT_EQ(tick_label(-0.0001, 0.1), "0.0") << "no negative zero";
  EXPECT_EQ(tick_label(-1, 1), "-1");
}

TEST(VisibleSamples, AreAllWhereTheyAreFew) {
  const std::vector<double> times = {0, 1, 2, 3};
  EXPECT_EQ(visible_samples(times, times, 100), (std::vector<std::size_t>{0, 1, 2, 3}));
}

TEST(VisibleSamples, KeepTheLeastAndGreatestOfEachColumn) {
  std::vector<double> times;
  std::vector<double> values;
  for (int i = 0; i <= 10'000; ++i) {
    times.push_back(i);
    values.push_back(0);
  }
  values[1234] = 5;  // narrower than a pixel
  values[1235] = -7;
  const std::vector<std::size_t> visible = visible_samples(times, values, 100);
  EXPECT_LE(visible.size(), 202U);
  EXPECT_EQ(std::ranges::count(visible, 1234U), 1);
  EXPECT_EQ(std::ranges::count(visible, 1235U), 1);
  EXPECT_TRUE(std::ranges::is_sorted(visible));
}

TEST(VisibleSamples, KeepGaps) {
  std::vector<double> times;
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) {
    times.push_back(i);
    values.push_back(i == 500 ? std::numeric_limits<double>::quiet_NaN() : 1);
  }
  const std::vector<std::size_t> visible = visible_samples(times, values, 10);
  EXPECT_EQ(std::ranges::count(visible, 500U), 1);
}

TEST(EscapeXml, LeavesNoMarkup) {
  EXPECT_EQ(escape_xml("a<b & \"c\">"), "a&lt;b &amp; &quot;c&quot;&gt;");
}

TEST(LineSvg, DrawsACurveALineAndLiftsThePenOverAGap) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  const TimeAxis axis{{0, 1, 2, 3, 4}, {{1, "start"}}};
  const std::string svg =
      line_svg(axis, {"Speed", "rpm", {{"rotor", {0, 1, gap, 2, 3}, Color::kBlue}}}, true);
  const std::string start = "<path class=\"line blue\" d=\"";
  const std::size_t begin = svg.find(start) + start.size();
  const std::string path = svg.substr(begin, svg.find('"', begin) - begin);
  EXPECT_EQ(count(path, "M"), 2U) << path;
  EXPECT_EQ(count(path, "L"), 2U) << path;
  EXPECT_EQ(path.find("nan"), std::string::npos) << path;
  EXPECT_NE(svg.find(">start</text>"), std::string::npos);
  EXPECT_NE(svg.find("rotor: 1.00 rpm"), std::string::npos) << "values under the pointer";
}

TEST(LineSvg, AConstantStandsInTheMiddleOfItsLeastSpan) {
  const TimeAxis axis{{0, 1}, {}};
  const std::string svg = line_svg(axis, {"", "V", {{"", {24, 24}, Color::kBlue}}, 0.4});
  EXPECT_NE(svg.find(">23.8</text>"), std::string::npos);
  EXPECT_NE(svg.find(">24.2</text>"), std::string::npos);
}

TEST(BandSvg, HasARectangleAState) {
  const TimeAxis axis{{0, 1, 2, 3, 4, 5}, {}};
  const BandPlot plot{
      "Stage", {0, 0, 1, 1, 9, 9}, {{"Stop", Color::kGrey}, {"FOC", Color::kGreen}}};
  const std::string svg = band_svg(axis, plot);
  EXPECT_EQ(count(svg, "<rect"), 3U);
  EXPECT_NE(svg.find("<title>FOC\n2.000 s to 4.000 s</title>"), std::string::npos);
  EXPECT_NE(svg.find("<title>9\n"), std::string::npos) << "a state without a name is its number";
}

TEST(EventSvg, FramesOfOnePixelAreOneTick) {
  const TimeAxis axis{{0, 100}, {}};
  EventPlot plot{"Frames", {{"requests", Color::kBlue}, {"errors", Color::kRed}}, {}};
  for (int i = 0; i < 7; ++i) plot.events.push_back({50 + i * 1e-4, 0, "GetSpeed"});
  plot.events.push_back({60, 1, "checksum <bad>"});
  const std::string svg = event_svg(axis, plot);
  EXPECT_EQ(count(svg, "<g class=\"event"), 2U);
  EXPECT_NE(svg.find("and 3 more"), std::string::npos);
  EXPECT_NE(svg.find("<g class=\"event red\">"), std::string::npos);
  EXPECT_NE(svg.find("checksum &lt;bad&gt;"), std::string::npos);
}

}  // namespace
}  // namespace virtdrive
