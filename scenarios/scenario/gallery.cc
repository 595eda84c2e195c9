#include "scenarios/scenario/gallery.h"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <sstream>

#include "core/check.h"

namespace virtdrive {
namespace {

std::string contents(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) throw SetupError(fmt::format("{}: cannot be read", path));
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// The file's steps: the rest has been told.
std::string steps_of(const std::string& text) {
  const std::size_t at = text.find("\nsteps:\n");
  return at == std::string::npos ? text : text.substr(at + 1);
}

std::string folder_of(const Scenario& scenario) {
  return std::filesystem::path(scenario.file).parent_path().filename();
}

std::string path_of(const Scenario& scenario) {
  const std::size_t at = scenario.file.find("scenarios/library");
  return at == std::string::npos ? scenario.file : scenario.file.substr(at);
}

std::string section(const Scenario& scenario) {
  std::string text = fmt::format("\n### {}\n\n{}\n", scenario.name, scenario.about);
  std::string facts = fmt::format("[{0}](../{0})", path_of(scenario));
  if (!scenario.tags.empty()) facts += fmt::format("; {}", fmt::join(scenario.tags, ", "));
  if (!scenario.source.empty()) facts += fmt::format("; source: {}", scenario.source);
  return text + fmt::format("\n{}\n\n```yaml\n{}```\n", facts, steps_of(contents(scenario.file)));
}

}  // namespace

std::string gallery(const std::vector<std::shared_ptr<const Scenario>>& scenarios) {
  std::map<std::string, std::vector<const Scenario*>> folders;
  for (const auto& scenario : scenarios) folders[folder_of(*scenario)].push_back(scenario.get());
  std::string page =
      "# Scenarios that come with virtdrive\n\n"
      "They are examples, tests and documentation at once: `./virtdrive test scenarios/library` "
      "plays "
      "them, [scenarios.md](scenarios.md)\ntells the language. This page is made from them "
      "(`./dev docs`).\n";
  for (const auto& [folder, members] : folders) {
    page += fmt::format("\n## {}\n\n| scenario | shows |\n|---|---|\n", folder);
    for (const Scenario* scenario : members) {
      page += fmt::format("| [{}](../{}) | {} |\n",
                          std::filesystem::path(scenario->file).filename().string(),
                          path_of(*scenario), scenario->name);
    }
    for (const Scenario* scenario : members) page += section(*scenario);
  }
  return page;
}

}  // namespace virtdrive
