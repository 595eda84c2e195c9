// Test results for people: a folder with index.html and a page for each case, which tells step by
// step what was done, what happened to the bench, what went over the line, and draws it. The pages
// need nothing from outside and carry no date: equal runs give equal folders.
#pragma once

#include <string>
#include <vector>

#include "scenarios/scenario/result.h"

namespace virtdrive {

class TestReport {
 public:
  /// Into `folder`, which is there.
  explicit TestReport(std::string folder) : folder_(std::move(folder)) {}

  /// Writes a case's page; SetupError if it cannot.
  void add(const ScenarioResult& result);
  /// Writes index.html.
  void close();

 private:
  struct Row {
    std::string page;
    ScenarioResult result;  // without what its page shows
  };

  std::string folder_;
  std::vector<Row> rows_;
};

/// One case's page; its way back is index.html.
std::string case_page(const ScenarioResult& result);

}  // namespace virtdrive
