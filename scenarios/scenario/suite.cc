#include "scenarios/scenario/suite.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <thread>

#include "core/check.h"
#include "scenarios/scenario/loader.h"

namespace virtdrive {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw SetupError(fmt::format("{}: no such file or folder", path));
  if (!fs::is_directory(status)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(path, error)) {
    const std::string extension = entry.path().extension();
    if ((extension == ".yaml" || extension == ".yml") && entry.is_regular_file()) {
      files.push_back(entry.path().lexically_normal());
    }
  }
  if (error) throw SetupError(fmt::format("{}: {}", path, error.message()));
  if (files.empty()) throw SetupError(fmt::format("{}: no scenario (*.yaml) in this folder", path));
  std::ranges::sort(files);
  return files;
}

bool chosen(const Scenario& scenario, const SuiteOptions& options) {
  if (scenario.is_long() && !options.with_long) return false;
  if (options.pattern.empty()) return true;
  const auto has = [&](const std::string& text) {
    return text.find(options.pattern) != std::string::npos;
  };
  return has(scenario.file) || has(scenario.name) || std::ranges::any_of(scenario.tags, has);
}

}  // namespace

std::vector<std::shared_ptr<const Scenario>> find_scenarios(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    for (const std::string& file : files_in(path)) {
      if (std::ranges::find(files, file) == files.end()) files.push_back(file);
    }
  }
  std::vector<std::shared_ptr<const Scenario>> scenarios;
  for (const std::string& file : files) {
    scenarios.push_back(std::make_shared<const Scenario>(load_scenario(file)));
  }
  return scenarios;
}

std::vector<Case> choose_cases(const std::vector<std::shared_ptr<const Scenario>>& scenarios,
                               const SuiteOptions& options) {
  std::vector<Case> cases;
  std::size_t number = 0;
  for (const auto& scenario : scenarios) {
    if (!chosen(*scenario, options)) continue;
    const std::uint64_t seed = options.seed.value_or(scenario->seed.value_or(1));
    for (std::size_t i = 0; i < options.repeat; ++i) {
      if (number++ % options.shards == options.shard - 1) cases.push_back({scenario, seed + i});
    }
  }
  return cases;
}

std::vector<ScenarioResult> play_all(const std::vector<Case>& cases, std::size_t jobs,
                                     const CaseListener& listener) {
  std::vector<std::optional<ScenarioResult>> done(cases.size());
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;  // of `done`, `told` and `failure`
  std::size_t told = 0;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t i = 0; (i = next++) < cases.size();) {
      try {
        ScenarioResult result = play(*cases[i].scenario, cases[i].seed);
        const std::lock_guard lock(mutex);
        done[i] = std::move(result);
        for (; told < done.size() && done[told]; ++told) {
          if (listener) listener(told, *done[told]);
          done[told]->history = {};
          done[told]->frames = {};
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = cases.size();
      }
    }
  };
  if (jobs == 0) jobs = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < std::min(jobs, cases.size()); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  std::vector<ScenarioResult> results;
  for (auto& result : done) results.push_back(std::move(*result));
  return results;
}

Totals totals(const std::vector<ScenarioResult>& results) {
  Totals totals;
  for (const ScenarioResult& result : results) {
    ++(result.passed() ? totals.passed : totals.failed);
    totals.simulated_s += seconds(result.simulated);
  }
  return totals;
}

}  // namespace virtdrive
