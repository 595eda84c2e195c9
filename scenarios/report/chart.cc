#include "scenarios/report/chart.h"

#include <algorithm>
#include <cmath>

#include "scenarios/report/svg_plot.h"

namespace virtdrive {
namespace {

// Colours stand in the file: whoever shows it need not know style variables.
constexpr std::string_view kStyle = R"(
.page { fill: #ffffff }
text { font: 12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: #5b6675 }
.title { font-size: 22px; font-weight: 600; fill: #1c2430 }
.head { font-size: 14px; font-weight: 600; fill: #1c2430 }
.value { font-size: 14px; fill: #1c2430 }
.grid, .axis, .line, .mark { fill: none; stroke-width: 1 }
.grid { stroke: #e8ebef }
.axis { stroke: #aab2bd }
.line { stroke-width: 2; stroke-linejoin: round }
.mark { stroke: #5b6675; stroke-dasharray: 3 3 }
.dashed { stroke-dasharray: 6 4 }
.blue { stroke: #1f6fd6 } .orange { stroke: #d9630f } .green { stroke: #1f8a4c } .grey { stroke: #7b8694 }
.fill-blue { fill: #1f6fd6; fill-opacity: .16 } .fill-orange { fill: #d9630f; fill-opacity: .10 }
.dots { fill: #ffffff; stroke-width: 1.5 }
.rated { fill: #ffffff; stroke: #1c2430; stroke-width: 2 }
.rim { stroke: #1c2430; stroke-width: 1.5; fill: none }
@media (prefers-color-scheme: dark) {
  .page { fill: #14181e }
  text { fill: #98a3b1 }
  .title, .head, .value { fill: #e4e8ee }
  .grid { stroke: #262d36 }
  .axis { stroke: #55606d }
  .dots { fill: #14181e }
  .rated { fill: #14181e; stroke: #e4e8ee }
  .rim { stroke: #e4e8ee }
}
)";

constexpr double kLetterWidth = 6.6;  // of the 12 px font, on the wide side

bool on_step(double value, double step) {
  return std::abs(value) < step / 2;
}

}  // namespace

double Scale::share(double value) const {
  if (logarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

std::vector<double> Scale::ticks() const {
  std::vector<double> ticks;
  if (logarithmic) {
    for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high; decade *= 10) {
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double tick = factor * decade;
        if (tick >= low * (1 - 1e-9) && tick <= high * (1 + 1e-9)) ticks.push_back(tick);
      }
    }
    return ticks;
  }
  const auto steps = std::lround((high - low) / step);
  for (long i = 0; i <= steps; ++i) ticks.push_back(low + static_cast<double>(i) * step);
  return ticks;
}

std::string Scale::label(double tick) const {
  return logarithmic ? fmt::format("{:g}", tick) : tick_label(tick, step);
}

Scale scale(double low, double high, int ticks, std::string unit) {
  if (!(high > low)) high = low + 1;
  const double step = axis_ticks(low, high, ticks).step;
  return {.low = std::floor(low / step + 1e-9) * step,
          .high = std::ceil(high / step - 1e-9) * step,
          .step = step,
          .unit = std::move(unit)};
}

Scale scale_up_to(double high, int ticks, std::string unit) {
  return scale(0, high > 0 ? high : 1, ticks, std::move(unit));
}

Scale logarithmic_scale(double low, double high, std::string unit) {
  return {.low = low, .high = high, .unit = std::move(unit), .logarithmic = true};
}

std::string path_of(const Plot& plot, std::span<const Point> points) {
  std::string path;
  bool pen_down = false;
  for (const Point& point : points) {
    if (!std::isfinite(point.y)) {
      pen_down = false;
      continue;
    }
    fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M',
                   plot.px(point.x), plot.py(point.y));
    pen_down = true;
  }
  return path;
}

Chart::Chart(std::string_view label, double width) : label_(label), width_(width) {}

void Chart::axes(const Plot& p) {
  for (const double v : p.y.ticks()) {
    put("<path class=\"{}\" d=\"M{:.1f} {:.1f}h{:.1f}\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{}</text>\n",
        on_step(v, p.y.step) && !p.y.logarithmic ? "axis" : "grid", p.left, p.py(v), p.width,
        p.left - 8, p.py(v) + 4, p.y.label(v));
  }
  for (const double v : p.x.ticks()) {
    put("<path class=\"{}\" d=\"M{:.1f} {:.1f}v{:.1f}\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
        "text-anchor=\"middle\">{}</text>\n",
        on_step(v, p.x.step) && !p.x.logarithmic ? "axis" : "grid", p.px(v), p.top, p.height,
        p.px(v), p.bottom() + 17, p.x.label(v));
  }
  put("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", p.left + p.width,
      p.bottom() + 32, escape_xml(p.x.unit));
  put("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", p.left - 8, p.top - 8,
      escape_xml(p.y.unit));
}

void Chart::heading(const Plot& p, std::string_view text) {
  put("<text class=\"head\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", p.left, p.top - 26,
      escape_xml(text));
}

void Chart::keys(const Plot& p, const std::vector<Key>& keys) {
  double x = p.left;
  for (const Key& key : keys) {
    if (key.classes.find("dots") != std::string_view::npos) {
      put("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>", key.classes, x + 10,
          p.top - 12);
    } else {
      put("<path class=\"line {}\" d=\"M{:.1f} {:.1f}h20\"/>", key.classes, x, p.top - 12);
    }
    put("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 26, p.top - 8, escape_xml(key.text));
    x += 26 + kLetterWidth * static_cast<double>(key.text.size()) + 18;
  }
}

void Chart::curve(const Plot& p, std::span<const Point> points, std::string_view classes) {
  put("<path class=\"line {}\" d=\"{}\"/>\n", classes, path_of(p, points));
}

void Chart::dots(const Plot& p, std::span<const Point> points, std::string_view classes) {
  for (const Point& point : points) {
    put("<circle class=\"dots {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>{:.6g} {}, {:.6g} "
        "{}</title></circle>\n",
        classes, p.px(point.x), p.py(point.y), point.x, escape_xml(p.x.unit), point.y,
        escape_xml(p.y.unit));
  }
}

std::string Chart::svg(double height) const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" "
             "height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n<style>{3}</style>\n"
             "<rect class=\"page\" width=\"{0}\" height=\"{1:.0f}\"/>\n",
             width_, height, escape_xml(label_), kStyle) +
         body_ + "</svg>\n";
}

}  // namespace virtdrive
