#include "scenarios/report/html_report.h"

#include <algorithm>
#include <fmt/format.h>

namespace virtdrive {
namespace {

constexpr std::string_view kStyle = R"(
:root {
  color-scheme: light dark;
  --page: #ffffff; --ink: #1c2430; --soft: #5b6675; --grid: #e8ebef; --axis: #aab2bd;
  --blue: #1f6fd6; --orange: #d9630f; --green: #1f8a4c; --purple: #8046b8; --teal: #0b8494;
  --red: #d02b3a; --grey: #8a94a1;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14181e; --ink: #e4e8ee; --soft: #98a3b1; --grid: #262d36; --axis: #55606d;
    --blue: #63a4ff; --orange: #ff9d57; --green: #5cc987; --purple: #bf93f0; --teal: #4cc4d4;
    --red: #ff6b75; --grey: #7d8895;
  }
}
.blue { --c: var(--blue) } .orange { --c: var(--orange) } .green { --c: var(--green) }
.purple { --c: var(--purple) } .teal { --c: var(--teal) } .red { --c: var(--red) }
.grey { --c: var(--grey) }
body { margin: 0 auto; padding: 24px 20px 40px; max-width: 1000px; background: var(--page);
  color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif }
h1 { font-size: 24px; font-weight: 600; margin: 0 0 4px }
h2 { font-size: 15px; font-weight: 600; margin: 0 }
p { margin: 0 0 18px; color: var(--soft); max-width: 76ch }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(200px, 1fr)); gap: 12px 24px;
  margin: 0 0 28px; padding: 14px 0; border: solid var(--grid); border-width: 1px 0 }
dt { color: var(--soft); font-size: 12px }
dd { margin: 0; font-variant-numeric: tabular-nums }
figure { margin: 0 0 18px }
figcaption { display: flex; flex-wrap: wrap; align-items: baseline; gap: 2px 18px;
  padding: 0 18px 2px 0 }
.keys { display: flex; flex-wrap: wrap; gap: 2px 16px; color: var(--soft); font-size: 13px }
.key::before { content: ""; display: inline-block; width: 18px; margin-right: 6px;
  vertical-align: middle; border-top: 2px solid var(--c) }
.key.dashed::before { border-top-style: dashed }
.key.box::before { width: 11px; height: 11px; border: 0; border-radius: 2px; background: var(--c);
  opacity: .55; vertical-align: -1px }
svg { display: block; width: 100%; height: auto }
svg text { font-size: 12px; fill: var(--soft); font-variant-numeric: tabular-nums }
svg .strong { fill: var(--ink) }
svg .inside { fill: var(--ink); pointer-events: none }
.grid, .axis, .moment, .line { fill: none; stroke-width: 1 }
.grid { stroke: var(--grid) }
.axis { stroke: var(--axis) }
.moment { stroke: var(--soft); stroke-dasharray: 2 3 }
.line { stroke: var(--c); stroke-width: 1.3; stroke-linejoin: round }
.dashed { stroke-dasharray: 5 4 }
.pointer { fill: transparent }
.pointer:hover { fill: var(--soft); opacity: .18 }
.state { fill: var(--c); fill-opacity: .32 }
.state:hover { fill-opacity: .5 }
.event path { stroke: var(--c); stroke-width: 1.3 }
.event rect { fill: transparent }
.event:hover path { stroke-width: 4 }
)";

std::string key(std::string_view classes, std::string_view name) {
  return fmt::format("<span class=\"key {}\">{}</span>", classes, escape_xml(name));
}

std::string figure(std::string_view title, std::string_view keys, std::string_view svg) {
  return fmt::format(
      "<figure>\n<figcaption><h2>{}</h2><span class=\"keys\">{}</span></figcaption>\n{}"
      "</figure>\n",
      escape_xml(title), keys, svg);
}

std::string draw(const TimeAxis& axis, const LinePlot& plot, bool first) {
  std::string keys;
  for (const Line& line : plot.lines) {
    keys +=
        key(fmt::format("{}{}", css_class(line.color), line.dashed ? " dashed" : ""), line.name);
  }
  return figure(plot.title, keys, line_svg(axis, plot, first));
}

std::string draw(const TimeAxis& axis, const BandPlot& plot, bool) {
  std::string keys;
  for (std::size_t i = 0; i < plot.states.size(); ++i) {
    if (std::ranges::find(plot.values, static_cast<double>(i)) == plot.values.end()) continue;
    keys += key(fmt::format("box {}", css_class(plot.states[i].color)), plot.states[i].name);
  }
  return figure(plot.title, keys, band_svg(axis, plot));
}

std::string draw(const TimeAxis& axis, const EventPlot& plot, bool) {
  return figure(plot.title, "", event_svg(axis, plot));
}

}  // namespace

std::string html_page(std::string_view title, std::string_view style, std::string_view body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n"
      "<style>{}{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      escape_xml(title), kStyle, style, body);
}

std::string html(const std::vector<Fact>& facts) {
  std::string list = "<dl>\n";
  for (const Fact& fact : facts) {
    list += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", escape_xml(fact.name),
                        escape_xml(fact.value));
  }
  return list + "</dl>\n";
}

std::string html(const TimeAxis& axis, const std::vector<Plot>& plots) {
  std::string figures;
  if (axis.time_s.size() < 2) return figures;
  for (const Plot& plot : plots) {
    const bool first = figures.empty();
    figures += std::visit([&](const auto& drawn) { return draw(axis, drawn, first); }, plot);
  }
  return figures;
}

std::string html(const Report& report) {
  return html_page(
      report.title, "",
      fmt::format("<h1>{}</h1>\n<p>{}</p>\n{}{}", escape_xml(report.title),
                  escape_xml(report.summary), html(report.facts), html(report.axis, report.plots)));
}

}  // namespace virtdrive
