// Plots over simulated time as inline SVG: lines, a band of states, ticks of events. All share one
// width and one time axis, so that a page of them reads downwards.
//
//   TimeAxis axis{.time_s = times};
//   std::string svg = line_svg(axis, {"Speed", "rpm", {{"rotor", rpm, Color::kBlue}}});
//
// Colours are CSS classes of the page (html_report.cc), light and dark. Curves are cut down to the
// least and greatest value of a pixel's column: what is drawn does not change, the size is bounded.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

enum class Color { kBlue, kOrange, kGreen, kPurple, kTeal, kRed, kGrey };

/// The CSS class that gives a thing its colour.
std::string_view css_class(Color color);

/// A moment marked by a vertical line through all plots.
struct Moment {
  double time_s;
  std::string text;  // a word or two
};

/// What plots of one page share. Times in seconds, growing, at least two.
struct TimeAxis {
  std::vector<double> time_s;
  std::vector<Moment> moments;
};

struct Line {
  std::string name;
  std::vector<double> values;  // one a time; not a number: a gap
  Color color;
  bool dashed = false;
};
struct LinePlot {
  std::string title;
  std::string unit;
  std::vector<Line> lines;
  double minimum_span = 0;  // of the vertical axis, so that noise does not fill it
};

struct State {
  std::string name;
  Color color;
};
struct BandPlot {
  std::string title;
  std::vector<double> values;  // one a time: the number of a state
  std::vector<State> states;
};

struct Lane {
  std::string name;
  Color color;
};
struct Event {
  double time_s;
  std::size_t lane;
  std::string text;
};
struct EventPlot {
  std::string title;
  std::vector<Lane> lanes;
  std::vector<Event> events;  // in order of time
};

std::string line_svg(const TimeAxis& axis, const LinePlot& plot, bool label_moments = false);
std::string band_svg(const TimeAxis& axis, const BandPlot& plot);
std::string event_svg(const TimeAxis& axis, const EventPlot& plot);

/// Round numbers in low ... high whose step is 1, 2 or 5 times a power of ten, `at_most` or fewer
/// (two at the least are aimed at).
struct Ticks {
  double step;
  std::vector<double> values;
};
Ticks axis_ticks(double low, double high, int at_most);
/// As many decimals as the step needs: "0.5", "1500".
std::string tick_label(double value, double step);

/// The indices of the samples that show in a drawing `columns` pixels wide: all if they are few,
/// else the least and the greatest of each column, and gaps (not a number). In order of time.
std::vector<std::size_t> visible_samples(std::span<const double> time_s,
                                         std::span<const double> values, std::size_t columns);

/// For text and attributes of XML and HTML.
std::string escape_xml(std::string_view text);

}  // namespace virtdrive
