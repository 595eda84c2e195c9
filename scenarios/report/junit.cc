#include "scenarios/report/junit.h"

#include <fmt/format.h>

#include "scenarios/report/svg_plot.h"

namespace virtdrive {
namespace {

// XML 1.0 has no characters for most control codes, not even escaped.
std::string xml(std::string_view text) {
  std::string clean;
  for (const char c : text) {
    const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
    clean += control ? '?' : c;
  }
  return escape_xml(clean);
}

}  // namespace

std::string junit(const std::vector<JunitCase>& cases) {
  SimDuration time{};
  std::size_t failed = 0;
  for (const JunitCase& one : cases) {
    time += one.time;
    failed += one.summary.empty() ? 0 : 1;
  }
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuites name=\"virtdrive\" tests=\"{0}\" failures=\"{1}\" errors=\"0\" "
      "time=\"{2:.6f}\">\n"
      "<testsuite name=\"virtdrive\" tests=\"{0}\" failures=\"{1}\" errors=\"0\" skipped=\"0\" "
      "time=\"{2:.6f}\">\n",
      cases.size(), failed, seconds(time));
  for (const JunitCase& one : cases) {
    text += fmt::format(
        "<testcase name=\"{}\" classname=\"{}\"{} time=\"{:.6f}\"", xml(one.name), xml(one.group),
        one.file.empty() ? "" : fmt::format(" file=\"{}\"", xml(one.file)), seconds(one.time));
    if (one.summary.empty()) {
      text += "/>\n";
      continue;
    }
    text +=
        fmt::format(">\n<failure message=\"{}\" type=\"expectation\">{}</failure>\n</testcase>\n",
                    xml(one.summary), xml(one.text));
  }
  return text + "</testsuite>\n</testsuites>\n";
}

std::string junit(const std::vector<ScenarioResult>& results) {
  std::vector<JunitCase> cases;
  for (const ScenarioResult& result : results) {
    cases.push_back({fmt::format("{} (seed {})", result.name, result.seed), case_class(result),
                     result.file, result.simulated,
                     result.passed() ? "" : one_line(*result.failure), explain(result)});
  }
  return junit(cases);
}

}  // namespace virtdrive
