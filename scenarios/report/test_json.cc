#include "scenarios/report/test_json.h"

#include <nlohmann/json.hpp>

#include "scenarios/scenario/suite.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

Json steps_of(const ScenarioResult& result) {
  constexpr const char* kStatus[] = {"done", "failed", "armed"};
  Json steps = Json::array();
  const auto add = [&](const StepResult& step) {
    steps.push_back({{"line", step.line},
                     {"text", step.text},
                     {"status", kStatus[static_cast<std::size_t>(step.status)]},
                     {"begin_s", seconds(step.begin)},
                     {"end_s", seconds(step.end)},
                     {"detail", step.detail}});
  };
  for (const StepResult& step : result.steps.first()) add(step);
  for (const StepResult& step : result.steps.last()) add(step);
  return steps;
}

}  // namespace

std::string test_json(const std::vector<ScenarioResult>& results) {
  const Totals total = totals(results);
  Json cases = Json::array();
  for (const ScenarioResult& result : results) {
    Json one = {{"file", result.file},       {"name", result.name},
                {"tags", result.tags},       {"seed", result.seed},
                {"passed", result.passed()}, {"simulated_s", seconds(result.simulated)}};
    if (result.failure) {
      const Failure& failure = *result.failure;
      one["failure"] = {{"place", failure.place},       {"step", failure.step},
                        {"expected", failure.expected}, {"got", failure.got},
                        {"off", failure.off},           {"at_s", seconds(failure.at)},
                        {"again", again(result)}};
    }
    one["notes"] = result.notes;
    one["steps_left_out"] = result.steps.left_out();
    one["steps"] = steps_of(result);
    cases.push_back(std::move(one));
  }
  const Json all = {{"format", 1},
                    {"passed", total.passed},
                    {"failed", total.failed},
                    {"simulated_s", total.simulated_s},
                    {"cases", std::move(cases)}};
  // What a host program printed may be anything.
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace virtdrive
