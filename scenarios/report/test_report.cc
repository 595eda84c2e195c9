#include "scenarios/report/test_report.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "scenarios/output_file.h"
#include "scenarios/report/html_report.h"
#include "scenarios/scenario/quantity.h"
#include "scenarios/scenario/suite.h"

namespace virtdrive {
namespace {

constexpr std::string_view kStyle = R"(
h2 { margin: 30px 0 8px; font-size: 17px }
figcaption h2 { margin: 0; font-size: 15px }
a { color: var(--blue); text-decoration: none }
a:hover { text-decoration: underline }
nav { font-size: 13px; margin: 0 0 14px }
.passed { --c: var(--green) } .failed { --c: var(--red) }
.badge { display: inline-block; padding: 1px 9px; border-radius: 9px; font-size: 13px;
  font-weight: 600; color: var(--page); background: var(--c); vertical-align: 4px;
  margin-left: 10px }
.failure { border-left: 4px solid var(--red); padding: 12px 18px; margin: 0 0 24px;
  background: color-mix(in srgb, var(--red) 7%, var(--page)) }
.failure table { border: 0 } .failure td { border: 0; padding: 2px 14px 2px 0 }
.failure td:first-child { color: var(--soft) }
code, .bytes { font: 13px/1.5 ui-monospace, "DejaVu Sans Mono", monospace }
td.text { white-space: pre-wrap }
table { border-collapse: collapse; width: 100% }
th { text-align: left; font-size: 12px; font-weight: 400; color: var(--soft) }
th, td { padding: 4px 14px 4px 0; border-bottom: 1px solid var(--grid); vertical-align: top }
td.time { white-space: nowrap; font-variant-numeric: tabular-nums; color: var(--soft);
  text-align: right }
th.time { text-align: right }
tr.failed td.text { color: var(--red); font-weight: 600 }
tr.event td.text { color: var(--orange) }
tr.armed td.text { color: var(--soft) }
td.detail { color: var(--soft); white-space: pre-wrap; overflow-wrap: anywhere }
summary { cursor: pointer; color: var(--soft); font-size: 13px }
details table { margin: 4px 0 8px } details td { border: 0; padding: 1px 14px 1px 0 }
.request { color: var(--blue) } .reply { color: var(--green) } .bad { color: var(--red) }
)";

constexpr double kAroundFailure_s = 1;

constexpr Color kColors[] = {Color::kBlue, Color::kOrange, Color::kGreen, Color::kPurple,
                             Color::kTeal, Color::kRed,    Color::kGrey};

std::string duration(const ScenarioResult& result) {
  return fmt::format("{:.3f} s", seconds(result.simulated));
}

std::string badge(const ScenarioResult& result) {
  return fmt::format("<span class=\"badge {0}\">{0}</span>", result.passed() ? "passed" : "failed");
}

// --- Plots ---------------------------------------------------------------------------------------

std::string title_of(std::string_view unit) {
  constexpr std::pair<std::string_view, std::string_view> kTitles[] = {
      {"rpm", "Speed"}, {"A", "Current"},        {"Nm", "Torque"},    {"V", "Voltage"},
      {"deg", "Angle"}, {"degC", "Temperature"}, {"kgm2", "Inertia"}, {"", "Values"}};
  for (const auto& [known, title] : kTitles) {
    if (known == unit) return std::string(title);
  }
  return std::string(unit);
}

// A band of the states that occur, numbered in the order of their values.
BandPlot band(const History::Column& column, const std::vector<double>& values) {
  std::map<double, std::size_t> numbers;
  for (const double value : values) numbers.emplace(value, 0);
  BandPlot plot{column.name, {}, {}};
  for (auto& [value, number] : numbers) {
    number = plot.states.size();
    std::string name = show_value(value, column.unit, column.words, column.bits);
    name = name.substr(0, name.rfind(" ("));
    const Color color = column.bits && value == 0
                            ? Color::kGrey
                            : kColors[static_cast<std::size_t>(value) % std::size(kColors)];
    plot.states.push_back({std::move(name), column.bits && value != 0 ? Color::kRed : color});
  }
  for (const double value : values) plot.values.push_back(static_cast<double>(numbers.at(value)));
  return plot;
}

EventPlot frame_plot(const ScenarioResult& result) {
  EventPlot plot{"Frames on the line",
                 {{"requests", Color::kBlue}, {"replies", Color::kGreen}, {"errors", Color::kRed}},
                 {}};
  const auto add = [&](const FrameRecord& frame) {
    const std::size_t lane = frame.kind == WireEvent::Kind::kRequest ? 0
                             : frame.kind == WireEvent::Kind::kReply ? 1
                                                                     : 2;
    plot.events.push_back({seconds(frame.time), lane, frame.text});
  };
  for (const FrameRecord& frame : result.frames.first()) add(frame);
  for (const FrameRecord& frame : result.frames.last()) add(frame);
  return plot;
}

std::string figures(const ScenarioResult& result, const History::Rows& rows) {
  const auto& columns = result.history.columns();
  std::vector<Plot> lines, bands;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!columns[i].words.empty()) {
      bands.emplace_back(band(columns[i], rows.values[i]));
      continue;
    }
    const auto same_unit = [&](const Plot& plot) {
      return std::get<LinePlot>(plot).unit == columns[i].unit;
    };
    auto plot = std::ranges::find_if(lines, same_unit);
    if (plot == lines.end()) {
      lines.emplace_back(LinePlot{title_of(columns[i].unit), columns[i].unit, {}});
      plot = std::prev(lines.end());
    }
    auto& drawn = std::get<LinePlot>(*plot);
    const std::size_t number = drawn.lines.size();
    drawn.lines.push_back({columns[i].name, rows.values[i], kColors[number % std::size(kColors)],
                           number >= std::size(kColors)});
  }
  std::vector<Plot> plots;
  if (!lines.empty()) {
    plots.push_back(std::move(lines.front()));
    for (Plot& plot : bands) plots.push_back(std::move(plot));
    for (std::size_t i = 1; i < lines.size(); ++i) plots.push_back(std::move(lines[i]));
  }
  plots.emplace_back(frame_plot(result));
  TimeAxis axis{.time_s = rows.time_s, .moments = {}};
  const auto mark = [&](const BenchEvent& event) {
    axis.moments.push_back({seconds(event.time), event.text});
  };
  for (const BenchEvent& event : result.events.first()) mark(event);
  for (const BenchEvent& event : result.events.last()) mark(event);
  if (result.failure) axis.moments.push_back({seconds(result.failure->at), "failed"});
  return html(axis, plots);
}

// The samples from `begin_s` on.
History::Rows since(History::Rows rows, double begin_s) {
  const auto first = std::ranges::lower_bound(rows.time_s, begin_s) - rows.time_s.begin();
  rows.time_s.erase(rows.time_s.begin(), rows.time_s.begin() + first);
  for (auto& column : rows.values) column.erase(column.begin(), column.begin() + first);
  return rows;
}

// --- What was done -------------------------------------------------------------------------------

std::string failure_box(const ScenarioResult& result) {
  if (!result.failure) return {};
  const Failure& failure = *result.failure;
  std::string rows;
  const auto row = [&](std::string_view name, std::string_view value) {
    if (value.empty()) return;
    rows +=
        fmt::format("<tr><td>{}</td><td class=\"text\">{}</td></tr>\n", name, escape_xml(value));
  };
  row("step", failure.step);
  row("expected", failure.expected);
  row("got", failure.got);
  row("off by", failure.off);
  row("at", show_instant(failure.at));
  row("where", failure.place);
  return fmt::format(
      "<div class=\"failure\">\n<table>\n{}<tr><td>again</td><td><code>{}</code></td></tr>\n"
      "</table>\n</div>\n",
      rows, escape_xml(again(result)));
}

std::string frame_table(std::span<const FrameRecord* const> frames) {
  if (frames.empty()) return {};
  constexpr std::string_view kClasses[] = {"request", "reply", "bad", "bad"};
  constexpr std::string_view kMarks[] = {"&gt;", "&lt;", "!", "!"};
  std::string table = fmt::format("<details><summary>{} frame{}</summary><table>\n", frames.size(),
                                  frames.size() == 1 ? "" : "s");
  for (const FrameRecord* frame : frames) {
    const auto kind = static_cast<std::size_t>(frame->kind);
    table += fmt::format(
        "<tr class=\"{}\"><td class=\"time\">{}</td><td>{}{}</td><td class=\"bytes\">{}</td>"
        "<td>{}</td></tr>\n",
        kClasses[kind], show_instant(frame->time), escape_xml(frame->drive), kMarks[kind],
        frame->bytes, escape_xml(frame->text));
  }
  return table + "</table></details>";
}

class Timeline {
 public:
  explicit Timeline(const ScenarioResult& result) {
    for (const FrameRecord& frame : result.frames.first()) frames_.push_back(&frame);
    for (const FrameRecord& frame : result.frames.last()) frames_.push_back(&frame);
    for (const BenchEvent& event : result.events.first()) events_.push_back(&event);
    for (const BenchEvent& event : result.events.last()) events_.push_back(&event);
    for (const StepResult& step : result.steps.first()) add(step);
    if (result.steps.left_out() > 0) {
      rows_ += fmt::format(
          "<tr><td></td><td></td><td class=\"text\">... {} steps more ...</td><td></td></tr>\n",
          result.steps.left_out());
    }
    for (const StepResult& step : result.steps.last()) add(step);
    add_events(kNever);
  }

  std::string table() const {
    return "<table>\n<tr><th class=\"time\">time</th><th>line</th><th>step</th><th></th></tr>\n" +
           rows_ + "</table>\n";
  }

 private:
  // What happened before `end` and was not told yet.
  void add_events(SimTime end) {
    for (; event_ < events_.size() && events_[event_]->time <= end; ++event_) {
      rows_ += fmt::format(
          "<tr class=\"event\"><td class=\"time\">{}</td><td></td><td class=\"text\">{}</td>"
          "<td></td></tr>\n",
          show_instant(events_[event_]->time), escape_xml(events_[event_]->text));
    }
  }
  void add(const StepResult& step) {
    constexpr std::string_view kClasses[] = {"done", "failed", "armed"};
    if (event_ < events_.size() && events_[event_]->time < step.begin) add_events(step.begin);
    while (frame_ < frames_.size() && frames_[frame_]->time < step.begin) ++frame_;
    std::vector<const FrameRecord*> frames;
    for (; frame_ < frames_.size() && frames_[frame_]->time <= step.end; ++frame_) {
      frames.push_back(frames_[frame_]);
    }
    rows_ += fmt::format(
        "<tr class=\"{}\"><td class=\"time\">{}</td><td class=\"time\">{}</td>"
        "<td class=\"text\" style=\"padding-left:{}px\">{}{}</td><td class=\"detail\">{}{}</td>"
        "</tr>\n",
        kClasses[static_cast<std::size_t>(step.status)], show_instant(step.begin), step.line,
        20 * step.depth, escape_xml(step.text),
        step.label.empty() ? "" : fmt::format(" <b>[{}]</b>", escape_xml(step.label)),
        escape_xml(step.detail), frame_table(frames));
    add_events(step.end);
  }

  std::vector<const FrameRecord*> frames_;
  std::vector<const BenchEvent*> events_;
  std::size_t frame_ = 0;
  std::size_t event_ = 0;
  std::string rows_;
};

std::vector<Fact> facts_of(const ScenarioResult& result) {
  std::vector<Fact> facts = {{"File", result.file},
                             {"Bench", result.bench},
                             {"Seed", fmt::format("{}", result.seed)},
                             {"Simulated", duration(result)}};
  if (!result.tags.empty())
    facts.push_back({"Tags", fmt::format("{}", fmt::join(result.tags, ", "))});
  if (!result.source.empty()) facts.push_back({"Source", result.source});
  facts.push_back({"Play it again", again(result)});
  for (const std::string& note : result.notes) facts.push_back({"Note", note});
  return facts;
}

}  // namespace

std::string case_page(const ScenarioResult& result) {
  std::string body = fmt::format(
      "<nav><a href=\"index.html\">all scenarios</a></nav>\n<h1>{}{}</h1>\n<p>{}</p>\n{}{}",
      escape_xml(result.name), badge(result), escape_xml(result.about), failure_box(result),
      html(facts_of(result)));
  const auto& whole = result.history.whole();
  if (result.failure) {
    const double begin_s = seconds(result.failure->at) - kAroundFailure_s;
    if (begin_s > 0) {
      body += fmt::format("<h2>The last {} s before it failed</h2>\n{}", kAroundFailure_s,
                          figures(result, since(result.history.end(), begin_s)));
    }
  }
  body += "<h2>The whole run</h2>\n" + figures(result, whole);
  body += "<h2>Step by step</h2>\n" + Timeline(result).table();
  return html_page(result.name, kStyle, body);
}

void TestReport::add(const ScenarioResult& result) {
  const std::string page = fmt::format("{}.seed{}.html", case_class(result), result.seed);
  OutputFile file("--html", folder_ + "/" + page);
  file.write(case_page(result));
  file.close();
  ScenarioResult light = result;
  light.history = {};
  light.frames = {};
  light.steps = {};
  rows_.push_back({page, std::move(light)});
}

void TestReport::close() {
  std::vector<ScenarioResult> results;
  for (const Row& row : rows_) results.push_back(row.result);
  const Totals total = totals(results);
  std::string table =
      "<table>\n<tr><th></th><th>scenario</th><th class=\"time\">simulated</th>"
      "<th class=\"time\">seed</th><th></th></tr>\n";
  const auto add = [&](const Row& row) {
    const ScenarioResult& result = row.result;
    table += fmt::format(
        "<tr><td>{}</td><td><a href=\"{}\">{}</a><br><span class=\"bytes\">{}</span></td>"
        "<td class=\"time\">{}</td><td class=\"time\">{}</td><td class=\"detail\">{}</td></tr>\n",
        badge(result), escape_xml(row.page), escape_xml(result.name), escape_xml(result.file),
        duration(result), result.seed, result.failure ? escape_xml(one_line(*result.failure)) : "");
  };
  for (const Row& row : rows_) {
    if (!row.result.passed()) add(row);
  }
  for (const Row& row : rows_) {
    if (row.result.passed()) add(row);
  }
  OutputFile file("--html", folder_ + "/index.html");
  file.write(html_page(
      "virtdrive scenarios", kStyle,
      fmt::format("<h1>Scenarios<span class=\"badge {}\">{} of {} passed</span></h1>\n"
                  "<p>{:.1f} s simulated. Those that failed come first.</p>\n{}</table>\n",
                  total.failed == 0 ? "passed" : "failed", total.passed, rows_.size(),
                  total.simulated_s, table)));
  file.close();
}

}  // namespace virtdrive
