#include "scenarios/report/junit.h"

#include <fmt/format.h>

#include "scenarios/report/svg_plot.h"
#include "scenarios/scenario/suite.h"

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

std::string junit(const std::vector<ScenarioResult>& results) {
  const Totals total = totals(results);
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuites name=\"virtdrive\" tests=\"{0}\" failures=\"{1}\" errors=\"0\" "
      "time=\"{2:.6f}\">\n"
      "<testsuite name=\"virtdrive\" tests=\"{0}\" failures=\"{1}\" errors=\"0\" skipped=\"0\" "
      "time=\"{2:.6f}\">\n",
      results.size(), total.failed, total.simulated_s);
  for (const ScenarioResult& result : results) {
    text +=
        fmt::format("<testcase name=\"{} (seed {})\" classname=\"{}\" file=\"{}\" time=\"{:.6f}\"",
                    xml(result.name), result.seed, xml(case_class(result)), xml(result.file),
                    seconds(result.simulated));
    if (result.passed()) {
      text += "/>\n";
      continue;
    }
    text +=
        fmt::format(">\n<failure message=\"{}\" type=\"expectation\">{}</failure>\n</testcase>\n",
                    xml(one_line(*result.failure)), xml(explain(result)));
  }
  return text + "</testsuite>\n</testsuites>\n";
}

}  // namespace virtdrive
