#include "scenarios/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>

#include "core/check.h"

namespace virtdrive {
namespace {

// Pixels.
constexpr double kWidth = 960;
constexpr double kLeft = 78;
constexpr double kRight = 18;
constexpr double kPlotWidth = kWidth - kLeft - kRight;
constexpr double kTop = 8;
constexpr double kLabelledTop = 24;  // with the names of the moments
constexpr double kBottom = 24;       // with the times
constexpr double kLineHeight = 170;
constexpr double kBandHeight = 26;
constexpr double kLaneHeight = 22;
constexpr double kLetterWidth = 6.6;  // of the 12 px font, on the wide side
constexpr int kTimeTicks = 12;
constexpr int kValueTicks = 6;
// Strips that show the values under the pointer.
constexpr std::size_t kStrips = 147;

struct Frame {
  double begin_s;
  double end_s;
  double top;
  double height;

  double x(double time_s) const {
    return kLeft + kPlotWidth * (time_s - begin_s) / (end_s - begin_s);
  }
  double bottom() const { return top + height; }
};

Frame make_frame(const TimeAxis& axis, double top, double height) {
  VIRTDRIVE_CHECK(axis.time_s.size() >= 2 && axis.time_s.front() < axis.time_s.back(), "{} times",
                  axis.time_s.size());
  return {axis.time_s.front(), axis.time_s.back(), top, height};
}

template <typename... Args>
void put(std::string& svg, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(svg), format, std::forward<Args>(args)...);
}

std::string begin_svg(std::string_view title, const Frame& frame) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"{}\">\n",
      kWidth, frame.bottom() + kBottom, escape_xml(title));
}

void put_time_axis(std::string& svg, const Frame& frame) {
  const Ticks ticks = axis_ticks(frame.begin_s, frame.end_s, kTimeTicks);
  for (const double t : ticks.values) {
    put(svg,
        "<path class=\"grid\" d=\"M{:.1f} {}V{}\"/><text x=\"{:.1f}\" y=\"{}\" "
        "text-anchor=\"middle\">{} s</text>\n",
        frame.x(t), frame.top, frame.bottom(), frame.x(t), frame.bottom() + 16,
        tick_label(t, ticks.step));
  }
}

void put_moments(std::string& svg, const Frame& frame, const TimeAxis& axis, bool label) {
  double free_from = 0;  // where the label before ends
  for (const Moment& moment : axis.moments) {
    if (moment.time_s < frame.begin_s || moment.time_s > frame.end_s) continue;
    const double x = frame.x(moment.time_s);
    put(svg, "<path class=\"moment\" d=\"M{:.1f} {}V{}\"/>\n", x, frame.top, frame.bottom());
    if (!label) continue;
    const double half = kLetterWidth * static_cast<double>(moment.text.size()) / 2;
    const double centre = std::clamp(x, kLeft + half, kWidth - kRight - half);
    if (centre - half < free_from) continue;
    free_from = centre + half + kLetterWidth;
    put(svg, "<text class=\"strong\" x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
        centre, frame.top - 8, escape_xml(moment.text));
  }
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double step = 1;
};

// The values with round ends.
Range value_range(const LinePlot& plot) {
  Range range;
  for (const Line& line : plot.lines) {
    for (const double value : line.values) {
      if (!std::isfinite(value)) continue;
      range.low = std::min(range.low, value);
      range.high = std::max(range.high, value);
    }
  }
  if (range.low > range.high) range = {0, 0};
  double span = std::max(range.high - range.low, plot.minimum_span);
  if (span == 0) span = range.high == 0 ? 1 : std::abs(range.high);
  const double centre = (range.low + range.high) / 2;
  range.low = std::min(range.low, centre - span / 2);
  range.high = std::max(range.high, centre + span / 2);
  range.step = axis_ticks(range.low, range.high, kValueTicks).step;
  // A curve may stand out of the frame by this part of a step: about two pixels.
  constexpr double kOverhang = 0.08;
  range.low = std::floor(range.low / range.step + kOverhang) * range.step;
  range.high = std::ceil(range.high / range.step - kOverhang) * range.step;
  return range;
}

double y_of(double value, const Range& range, const Frame& frame) {
  return frame.bottom() - frame.height * (value - range.low) / (range.high - range.low);
}

void put_value_axis(std::string& svg, const Frame& frame, const Range& range,
                    std::string_view unit) {
  const int steps = static_cast<int>(std::lround((range.high - range.low) / range.step));
  for (int i = 0; i <= steps; ++i) {
    const double value = range.low + i * range.step;
    const double y = y_of(value, range, frame);
    const bool zero = std::abs(value) < range.step / 2;
    put(svg,
        "<path class=\"{}\" d=\"M{} {:.1f}H{}\"/><text x=\"{}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{}</text>\n",
        zero ? "axis" : "grid", kLeft, y, kWidth - kRight, kLeft - 8, y + 4,
        tick_label(value, range.step));
  }
  put(svg,
      "<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
      frame.top + frame.height / 2, escape_xml(unit));
}

void put_line(std::string& svg, const TimeAxis& axis, const Line& line, const Range& range,
              const Frame& frame) {
  VIRTDRIVE_CHECK(line.values.size() == axis.time_s.size(), "{}: {} values, {} times", line.name,
                  line.values.size(), axis.time_s.size());
  put(svg, "<path class=\"line {}{}\" d=\"", css_class(line.color), line.dashed ? " dashed" : "");
  bool pen_down = false;
  for (const std::size_t i :
       visible_samples(axis.time_s, line.values, static_cast<std::size_t>(kPlotWidth))) {
    if (!std::isfinite(line.values[i])) {
      pen_down = false;
      continue;
    }
    put(svg, "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', frame.x(axis.time_s[i]),
        y_of(line.values[i], range, frame));
    pen_down = true;
  }
  svg += "\"/>\n";
}

std::size_t nearest_sample(const TimeAxis& axis, double time_s) {
  const auto after = std::ranges::lower_bound(axis.time_s, time_s);
  if (after == axis.time_s.begin()) return 0;
  const auto index = static_cast<std::size_t>(after - axis.time_s.begin());
  if (after == axis.time_s.end()) return index - 1;
  return time_s - axis.time_s[index - 1] < *after - time_s ? index - 1 : index;
}

void put_pointer_strips(std::string& svg, const TimeAxis& axis, const LinePlot& plot,
                        const Range& range, const Frame& frame) {
  for (std::size_t i = 0; i < kStrips; ++i) {
    const double width = kPlotWidth / kStrips;
    const double middle = (static_cast<double>(i) + 0.5) / kStrips;
    const std::size_t sample =
        nearest_sample(axis, frame.begin_s + middle * (frame.end_s - frame.begin_s));
    put(svg,
        "<rect class=\"pointer\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\"><title>"
        "{:.3f} s",
        kLeft + static_cast<double>(i) * width, frame.top, width, frame.height,
        axis.time_s[sample]);
    for (const Line& line : plot.lines) {
      put(svg, "\n{}: {} {}", escape_xml(line.name),
          tick_label(line.values[sample], range.step / 100), escape_xml(plot.unit));
    }
    svg += "</title></rect>\n";
  }
}

}  // namespace

std::string_view css_class(Color color) {
  constexpr std::string_view kClasses[] = {"blue", "orange", "green", "purple",
                                           "teal", "red",    "grey"};
  return kClasses[static_cast<std::size_t>(color)];
}

std::string line_svg(const TimeAxis& axis, const LinePlot& plot, bool label_moments) {
  const Frame frame = make_frame(axis, label_moments ? kLabelledTop : kTop, kLineHeight);
  const Range range = value_range(plot);
  std::string svg = begin_svg(plot.title, frame);
  put_time_axis(svg, frame);
  put_value_axis(svg, frame, range, plot.unit);
  put_moments(svg, frame, axis, label_moments);
  for (const Line& line : plot.lines) put_line(svg, axis, line, range, frame);
  put_pointer_strips(svg, axis, plot, range, frame);
  return svg += "</svg>\n";
}

std::string band_svg(const TimeAxis& axis, const BandPlot& plot) {
  VIRTDRIVE_CHECK(plot.values.size() == axis.time_s.size(), "{}: {} values, {} times", plot.title,
                  plot.values.size(), axis.time_s.size());
  const Frame frame = make_frame(axis, kTop, kBandHeight);
  std::string svg = begin_svg(plot.title, frame);
  put_time_axis(svg, frame);
  for (std::size_t first = 0, next = 0; first < plot.values.size(); first = next) {
    while (next < plot.values.size() && plot.values[next] == plot.values[first]) ++next;
    const double end_s = axis.time_s[std::min(next, axis.time_s.size() - 1)];
    const double x = frame.x(axis.time_s[first]);
    const double width = frame.x(end_s) - x;
    constexpr double kThinnest = 0.2;  // bounds the file; nothing of it would be seen
    if (width < kThinnest) continue;
    const auto number = static_cast<std::size_t>(std::max(0.0, plot.values[first]));
    const State state = number < plot.states.size()
                            ? plot.states[number]
                            : State{fmt::format("{}", plot.values[first]), Color::kGrey};
    put(svg,
        "<rect class=\"state {}\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\"><title>"
        "{}\n{:.3f} s to {:.3f} s</title></rect>\n",
        css_class(state.color), x, frame.top, width, frame.height, escape_xml(state.name),
        axis.time_s[first], end_s);
    if (width > kLetterWidth * static_cast<double>(state.name.size() + 2)) {
      put(svg, "<text class=\"inside\" x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
          x + width / 2, frame.top + frame.height / 2 + 4, escape_xml(state.name));
    }
  }
  put_moments(svg, frame, axis, false);
  return svg += "</svg>\n";
}

std::string event_svg(const TimeAxis& axis, const EventPlot& plot) {
  constexpr std::size_t kTextsShown = 4;  // of the events in one pixel column
  const Frame frame = make_frame(axis, kTop, kLaneHeight * static_cast<double>(plot.lanes.size()));
  std::string svg = begin_svg(plot.title, frame);
  put_time_axis(svg, frame);
  put_moments(svg, frame, axis, false);
  for (std::size_t lane = 0; lane < plot.lanes.size(); ++lane) {
    const double middle = frame.top + kLaneHeight * (static_cast<double>(lane) + 0.5);
    put(svg,
        "<path class=\"grid\" d=\"M{} {}H{}\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}"
        "</text>\n",
        kLeft, middle, kWidth - kRight, kLeft - 8, middle + 4, escape_xml(plot.lanes[lane].name));
    std::vector<const Event*> events;
    for (const Event& event : plot.events) {
      if (event.lane == lane && event.time_s >= frame.begin_s && event.time_s <= frame.end_s) {
        events.push_back(&event);
      }
    }
    for (std::size_t first = 0, next = 0; first < events.size(); first = next) {
      const double x = std::round(frame.x(events[first]->time_s));
      std::string texts;
      for (; next < events.size() && std::round(frame.x(events[next]->time_s)) == x; ++next) {
        if (next - first >= kTextsShown) continue;
        texts += fmt::format("{}{:.3f} s  {}", texts.empty() ? "" : "\n", events[next]->time_s,
                             escape_xml(events[next]->text));
      }
      if (next - first > kTextsShown) {
        texts += fmt::format("\nand {} more", next - first - kTextsShown);
      }
      put(svg,
          "<g class=\"event {}\"><path d=\"M{} {}v{}\"/><rect x=\"{}\" y=\"{}\" width=\"5\" "
          "height=\"{}\"/><title>{}</title></g>\n",
          css_class(plot.lanes[lane].color), x, middle - 7, 14, x - 2.5, middle - 9, 18, texts);
    }
  }
  return svg += "</svg>\n";
}

Ticks axis_ticks(double low, double high, int at_most) {
  VIRTDRIVE_CHECK(low < high && at_most >= 2, "{} ... {}, {}", low, high, at_most);
  const double coarse = (high - low) / at_most;
  const double power = std::pow(10, std::floor(std::log10(coarse)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (std::floor(high / (factor * power) + 1e-9) - std::ceil(low / (factor * power) - 1e-9) + 1 >
        at_most) {
      break;
    }
    step = factor * power;
  }
  Ticks ticks{step, {}};
  const double last = std::floor(high / step + 1e-9);
  for (double i = std::ceil(low / step - 1e-9); i <= last; ++i) {
    ticks.values.push_back(i == 0 ? 0 : i * step);
  }
  return ticks;
}

std::string tick_label(double value, double step) {
  constexpr int kMostDecimals = 9;
  const int decimals =
      std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, kMostDecimals);
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool zero = text.find_first_of("123456789in") == std::string::npos;  // nor inf, nan
  return zero && text[0] == '-' ? text.substr(1) : text;
}

std::vector<std::size_t> visible_samples(std::span<const double> time_s,
                                         std::span<const double> values, std::size_t columns) {
  std::vector<std::size_t> visible;
  const bool all = values.size() <= 2 * columns;
  const double begin_s = time_s.empty() ? 0 : time_s.front();
  const double span_s = time_s.empty() ? 0 : time_s.back() - begin_s;
  const auto column_of = [&](std::size_t i) {
    return static_cast<std::size_t>((time_s[i] - begin_s) / span_s * static_cast<double>(columns));
  };
  for (std::size_t first = 0, next = 0; first < values.size(); first = next) {
    next = first + 1;
    if (all || !std::isfinite(values[first])) {
      visible.push_back(first);
      while (!all && next < values.size() && !std::isfinite(values[next])) ++next;
      continue;
    }
    std::size_t least = first;
    std::size_t greatest = first;
    for (;
         next < values.size() && std::isfinite(values[next]) && column_of(next) == column_of(first);
         ++next) {
      if (values[next] < values[least]) least = next;
      if (values[next] > values[greatest]) greatest = next;
    }
    visible.push_back(std::min(least, greatest));
    if (least != greatest) visible.push_back(std::max(least, greatest));
  }
  return visible;
}

std::string escape_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace virtdrive
