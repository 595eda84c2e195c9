// The direction of the dependencies and a few rules of the house, read off the sources.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace virtdrive {
namespace {

namespace fs = std::filesystem;

// Each folder may include from itself and from those before it.
const std::vector<std::string> kFolders = {"core",    "plant", "firmware_models",
                                           "devices", "pty",   "scenarios"};

struct Line {
  std::string where;
  std::string text;
};

std::vector<Line> lines_of(const std::string& folder) {
  std::vector<Line> lines;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(VIRTDRIVE_SOURCE_DIR) / folder)) {
    const std::string extension = entry.path().extension();
    if (extension != ".h" && extension != ".cc") continue;
    std::ifstream stream(entry.path());
    int number = 0;
    for (std::string text; std::getline(stream, text);) {
      lines.push_back({entry.path().string() + ":" + std::to_string(++number), text});
    }
  }
  return lines;
}

bool mentions(const std::string& text, std::initializer_list<const char*> words) {
  return std::ranges::any_of(
      words, [&](const char* word) { return text.find(word) != std::string::npos; });
}

TEST(Layering, IncludesGoOneWay) {
  for (std::size_t own = 0; own < kFolders.size(); ++own) {
    const auto lines = lines_of(kFolders[own]);
    ASSERT_FALSE(lines.empty()) << kFolders[own];
    for (const Line& line : lines) {
      for (std::size_t other = own + 1; other < kFolders.size(); ++other) {
        EXPECT_FALSE(line.text.starts_with("#include \"" + kFolders[other] + "/")) << line.where;
      }
      EXPECT_FALSE(line.text.starts_with("#include \"tests/")) << line.where;
    }
  }
}

TEST(Layering, OnlyPtyKnowsAWallClock) {
  for (const std::string& folder : kFolders) {
    if (folder == "pty") continue;
    for (const Line& line : lines_of(folder)) {
      EXPECT_FALSE(mentions(line.text, {"steady_clock", "system_clock", "gettimeofday", "nanosleep",
                                        "sleep_for", "clock_gettime"}))
          << line.where;
    }
  }
}

TEST(Layering, OnlyPlantKnowsSundialsAndOnlyTheProgramKnowsCli11) {
  for (const std::string& folder : kFolders) {
    for (const Line& line : lines_of(folder)) {
      if (folder != "plant") {
        EXPECT_FALSE(mentions(line.text, {"#include <arkode", "#include <sundials"})) << line.where;
      }
      if (line.where.find("/cli/main.cc") == std::string::npos) {
        EXPECT_FALSE(mentions(line.text, {"#include <CLI/"})) << line.where;
      }
      EXPECT_FALSE(mentions(line.text, {"#include <regex>"})) << line.where;
    }
  }
}

}  // namespace
}  // namespace virtdrive
