// Every way in which a scenario file can be wrong: tests/data/scenarios_bad holds a file each, and
// errors.txt what is said of it. VIRTDRIVE_REFRESH=1 writes errors.txt anew, for review.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "core/check.h"
#include "scenarios/scenario/loader.h"

namespace virtdrive {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(VIRTDRIVE_TEST_DATA) / "scenarios_bad";

std::string error_of(const fs::path& file) {
  try {
    load_scenario(file);
  } catch (const SetupError& error) {
    std::string text = error.what();
    const std::string folder = kFolder.string() + "/";
    if (text.starts_with(folder)) text.erase(0, folder.size());
    return text;
  }
  return file.filename().string() + ": accepted";
}

// What is known grows with each drive; the rest of a message stays.
std::string without_lists(const std::string& text) {
  return text.substr(0, text.find(" (known: "));
}

std::vector<std::string> errors() {
  std::vector<std::string> errors;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".yaml") {
      errors.push_back(without_lists(error_of(entry.path())));
    }
  }
  std::ranges::sort(errors);
  return errors;
}

TEST(BadScenarios, EachIsRefusedWithOneLineThatNamesThePlace) {
  const auto found = errors();
  EXPECT_GE(found.size(), 50U);
  for (const std::string& error : found) {
    const std::size_t colon = error.find(':');
    int line = 0;
    int column = 0;
    EXPECT_EQ(std::sscanf(error.c_str() + colon, ":%d:%d: ", &line, &column), 2) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(BadScenarios, TheMessagesAreThoseReviewed) {
  const auto found = errors();
  const fs::path list = kFolder / "errors.txt";
  if (std::getenv("VIRTDRIVE_REFRESH") != nullptr) {
    std::ofstream stream(list);
    for (const std::string& error : found) stream << error << '\n';
  }
  std::vector<std::string> expected;
  std::ifstream stream(list);
  for (std::string line; std::getline(stream, line);) expected.push_back(line);
  EXPECT_EQ(found, expected);
}

TEST(BadScenarios, AFileThatIsNotThereOrTooLongIsRefused) {
  EXPECT_THROW(load_scenario((kFolder / "nowhere.yaml").string()), SetupError);
  const std::string long_text(2 << 20, '#');
  EXPECT_THROW(parse_scenario("long", long_text), SetupError);
}

}  // namespace
}  // namespace virtdrive
