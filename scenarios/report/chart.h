// Curves over two axes as one SVG file that needs nothing else, light and dark: what the pages of
// motors and the documents' plots are drawn with.
//
//   Chart chart("Speed of the rotor", 960);
//   const Plot plot{.left = 80, .top = 60, .width = 860, .height = 240,
//                   .x = scale(0, 2, 10, "s"), .y = scale(0, 160, 6, "rad/s")};
//   chart.axes(plot);
//   chart.curve(plot, points, "blue");
//   std::string svg = chart.svg(height);
#pragma once

#include <fmt/format.h>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

/// An axis' values. Ticks lie on multiples of the step, or if it is logarithmic on the decades.
struct Scale {
  double low = 0, high = 1;
  double step = 1;
  std::string unit;
  bool logarithmic = false;

  /// 0 at the low end, 1 at the high one.
  double share(double value) const;
  std::vector<double> ticks() const;
  std::string label(double tick) const;
};

/// With round ends around low ... high, and about so many ticks.
Scale scale(double low, double high, int ticks, std::string unit);
/// From 0 up to a round number; of what is nothing, up to 1.
Scale scale_up_to(double high, int ticks, std::string unit);
/// With ends as they are, both above 0.
Scale logarithmic_scale(double low, double high, std::string unit);

struct Point {
  double x, y;
};

/// A place for curves. Pixels.
struct Plot {
  double left, top, width, height;
  Scale x, y;

  double px(double value) const { return left + width * x.share(value); }
  double py(double value) const { return top + height * (1 - y.share(value)); }
  double bottom() const { return top + height; }
};

/// "M... L..." through the points; one that is not a number is a gap.
std::string path_of(const Plot& plot, std::span<const Point> points);

class Chart {
 public:
  /// `label` is for those who do not see it.
  Chart(std::string_view label, double width);

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(body_), format, std::forward<Args>(args)...);
  }
  void put(std::string_view raw) { body_ += raw; }

  void axes(const Plot& plot);
  void heading(const Plot& plot, std::string_view text);

  /// Colours: blue, orange, green, grey; with "dashed" a line is; "dots" is what dots() draws.
  struct Key {
    std::string_view classes;
    std::string text;
  };
  void keys(const Plot& plot, const std::vector<Key>& keys);
  void curve(const Plot& plot, std::span<const Point> points, std::string_view classes);
  void dots(const Plot& plot, std::span<const Point> points, std::string_view classes);

  std::string svg(double height) const;

 private:
  std::string label_;
  double width_;
  std::string body_;
};

}  // namespace virtdrive
