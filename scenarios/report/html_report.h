// A run on one page: what was simulated, and plots of its signals and frames. The page is a single
// file that needs nothing else (no script, no link, no date): equal runs give equal pages.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "scenarios/report/svg_plot.h"

namespace virtdrive {

using Plot = std::variant<LinePlot, BandPlot, EventPlot>;

struct Fact {
  std::string name;
  std::string value;
};

struct Report {
  std::string title;
  std::string summary;  // a sentence or two for a reader who knows nothing yet
  std::vector<Fact> facts;
  TimeAxis axis;
  std::vector<Plot> plots;  // from top to bottom; the first is not a band, it names the moments
};

/// A whole page of its own around `body`, in the reports' style, light and dark; `style` adds to
/// it.
std::string html_page(std::string_view title, std::string_view style, std::string_view body);
/// A list of facts.
std::string html(const std::vector<Fact>& facts);
/// Figures over one time axis; "" if it has less than two times.
std::string html(const TimeAxis& axis, const std::vector<Plot>& plots);

/// The page; without plots if there are less than two times.
std::string html(const Report& report);

}  // namespace virtdrive
