#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>

#include "core/check.h"
#include "scenarios/cli/commands.h"
#include "scenarios/output_file.h"
#include "scenarios/report/junit.h"
#include "scenarios/report/test_json.h"
#include "scenarios/report/test_report.h"

namespace virtdrive {
namespace {

constexpr std::string_view kEraseLine = "\r\x1b[K";

// What happens, on standard output: a line for each case; on a terminal with colours, and the
// count of those done below them.
class Progress {
 public:
  explicit Progress(std::size_t cases) : cases_(cases), terminal_(isatty(STDOUT_FILENO) == 1) {}

  void begin() { show_count(0); }
  void add(std::size_t index, const ScenarioResult& result) {
    if (terminal_) fmt::print("{}", kEraseLine);
    fmt::print("{} {}  {} ({:.3f} s, seed {})\n",
               coloured(result.passed() ? "passed" : "FAILED", result), result.file, result.name,
               seconds(result.simulated), result.seed);
    if (!result.passed()) fmt::print("{}", explain(result));
    show_count(index + 1);
  }
  void end() {
    if (terminal_) fmt::print("{}", kEraseLine);
  }

 private:
  std::string coloured(std::string_view text, const ScenarioResult& result) const {
    if (!terminal_) return std::string(text);
    return fmt::format("\x1b[{}m{}\x1b[0m", result.passed() ? 32 : 31, text);
  }
  void show_count(std::size_t done) {
    if (terminal_ && done < cases_) fmt::print("{} of {}", done, cases_);
    std::fflush(stdout);
  }

  std::size_t cases_;
  bool terminal_;
};

void write_file(std::string_view option, const std::string& path, const std::string& text) {
  OutputFile file(option, path);
  file.write(text);
  file.close();
}

int list_cases(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    const Scenario& scenario = *one.scenario;
    fmt::print("{}  {} (seed {}){}\n", scenario.file, scenario.name, one.seed,
               scenario.tags.empty() ? "" : fmt::format("  [{}]", fmt::join(scenario.tags, ", ")));
  }
  return kExitOk;
}

// Before minutes are spent on playing.
void check_outputs(const TestOptions& options) {
  if (!options.junit.empty()) OutputFile("--junit", options.junit);
  if (!options.json.empty()) OutputFile("--json", options.json);
  if (options.html.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(options.html, error);
  if (!std::filesystem::is_directory(options.html)) {
    throw SetupError(fmt::format("--html {}: no folder can be made there", options.html));
  }
}

}  // namespace

int test(const TestOptions& options) {
  const auto scenarios = find_scenarios(options.suite.paths);
  const std::vector<Case> cases = choose_cases(scenarios, options.suite);
  if (options.list) return list_cases(cases);
  if (cases.empty()) {
    throw SetupError("no scenario is left to be played: look at -k, --shard and --long");
  }
  check_outputs(options);
  Progress progress(cases.size());
  std::optional<TestReport> report;
  if (!options.html.empty()) report.emplace(options.html);
  progress.begin();
  const auto results =
      play_all(cases, options.suite.jobs, [&](std::size_t index, const ScenarioResult& result) {
        progress.add(index, result);
        if (report) report->add(result);
      });
  progress.end();
  if (report) report->close();
  if (!options.junit.empty()) write_file("--junit", options.junit, junit(results));
  if (!options.json.empty()) write_file("--json", options.json, test_json(results));
  const Totals total = totals(results);
  fmt::print("{} passed, {} failed; {:.1f} s simulated\n", total.passed, total.failed,
             total.simulated_s);
  return total.failed == 0 ? kExitOk : kExitFailed;
}

}  // namespace virtdrive
