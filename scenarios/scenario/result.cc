#include "scenarios/scenario/result.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "scenarios/scenario/quantity.h"

namespace virtdrive {

std::string case_class(const ScenarioResult& result) {
  std::string name;
  const auto path = std::filesystem::path(result.file).replace_extension();
  for (const auto& part : path) {
    if (part == "/" || part == "." || part == "..") continue;
    name += fmt::format("{}{}", name.empty() ? "" : ".", part.string());
  }
  return name;
}

std::string one_line(const Failure& failure) {
  return fmt::format("expected {}, got {}{}", failure.expected,
                     failure.got.substr(0, failure.got.find('\n')),
                     failure.off.empty() ? "" : fmt::format(" ({})", failure.off));
}

std::string explain(const ScenarioResult& result) {
  if (!result.failure) return {};
  const Failure& failure = *result.failure;
  return fmt::format(
      "  {}: {}\n    expected  {}\n    got       {}\n{}    at        {}\n    again     {}\n",
      failure.place, failure.step, failure.expected, failure.got,
      failure.off.empty() ? "" : fmt::format("    off       {}\n", failure.off),
      show_instant(failure.at), again(result));
}

std::string again(const ScenarioResult& result) {
  const bool is_long = std::ranges::find(result.tags, "long") != result.tags.end();
  return fmt::format("virtdrive test {} --seed {}{}", result.file, result.seed,
                     is_long ? " --long" : "");
}

}  // namespace virtdrive
