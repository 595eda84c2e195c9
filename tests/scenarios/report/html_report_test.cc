#include "scenarios/report/html_report.h"

#include <cmath>
#include <gtest/gtest.h>

namespace virtdrive {
namespace {

Report make_report(int samples) {
  Report report{.title = "A <run> & more", .summary = "What it was.", .facts = {{"Seed", "1"}}};
  LinePlot speed{"Speed", "rpm", {{"rotor", {}, Color::kBlue}}};
  BandPlot stage{
      "Stage", {}, {{"Stop", Color::kGrey}, {"FOC", Color::kGreen}, {"Trip", Color::kRed}}};
  EventPlot frames{"Frames", {{"requests", Color::kBlue}}, {}};
  for (int i = 0; i < samples; ++i) {
    report.axis.time_s.push_back(i * 1e-3);
    speed.lines[0].values.push_back(2000 * std::sin(i * 0.01) + (i * 7919) % 13);
    stage.values.push_back(i * 2 / samples);
    frames.events.push_back({i * 1e-3, 0, "GetSpeed"});
  }
  report.axis.moments = {{0.5, "load"}};
  report.plots = {speed, stage, frames};
  return report;
}

TEST(HtmlReport, HasItsHeadFactsLegendsAndAPlotASection) {
  const std::string page = html(make_report(1000));
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
  for (const std::string part :
       {"<h1>A &lt;run&gt; &amp; more</h1>", "<p>What it was.</p>", "<dt>Seed</dt><dd>1</dd>",
        "<h2>Speed</h2>", "<h2>Stage</h2>", "<h2>Frames</h2>", ">load</text>",
        "<span class=\"key blue\">rotor</span>", "<span class=\"key box green\">FOC</span>",
        "prefers-color-scheme: dark"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(page.find("Trip"), std::string::npos) << "a state that did not occur needs no legend";
}

TEST(HtmlReport, NeedsNothingFromOutside) {
  std::string page = html(make_report(100));
  const std::string name_space = "xmlns=\"http://www.w3.org/2000/svg\"";
  for (std::size_t at; (at = page.find(name_space)) != std::string::npos;) {
    page.erase(at, name_space.size());
  }
  for (const std::string link : {"http", "src=", "href=", "url(", "@import", "<script"}) {
    EXPECT_EQ(page.find(link), std::string::npos) << link;
  }
}

TEST(HtmlReport, StaysSmallHoweverLongTheRun) {
  EXPECT_LT(html(make_report(60'000)).size(), 400'000U);
}

TEST(HtmlReport, EqualRunsGiveEqualPages) {
  EXPECT_EQ(html(make_report(5000)), html(make_report(5000)));
}

TEST(HtmlReport, ARunWithoutSamplesHasNoPlots) {
  EXPECT_EQ(html(make_report(1)).find("<svg"), std::string::npos);
}

}  // namespace
}  // namespace virtdrive
