#include "scenarios/csv_recorder.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

std::string contents(const std::string& path) {
  std::ifstream stream(path);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

class CsvRecorderTest : public testing::Test {
 protected:
  CsvRecorderTest() {
    registry_.add(Signal{"motor0.speed", "rpm", "", [this] { return 0.1 * ++reads_; }});
    registry_.add(Signal{"drive0.stage", "", "", [] { return 6.0; }});
  }
  ~CsvRecorderTest() override { std::filesystem::remove(path_); }

  std::string path_ = testing::TempDir() + "virtdrive_csv_recorder_test.csv";
  EventLoop loop_;
  Registry registry_;
  int reads_ = 0;
};

TEST_F(CsvRecorderTest, WritesAHeaderWithUnitsAndARowEachInterval) {
  CsvRecorder recorder(loop_, registry_, path_, {"motor0.speed", "drive0.stage"}, 1ms);
  loop_.run_until(kSimStart + 2ms);
  recorder.close();
  EXPECT_EQ(contents(path_),
            "time_s,motor0.speed[rpm],drive0.stage\n"
            "0.000000000,0.1,6\n"
            "0.001000000,0.2,6\n"
            "0.002000000,0.30000000000000004,6\n");
}

TEST_F(CsvRecorderTest, ARowHoldsTheStateAtTheEndOfItsInstant) {
  double value = 0;
  registry_.add(Signal{"x", "", "", [&] { return value; }});
  CsvRecorder recorder(loop_, registry_, path_, {"x"}, 1ms);
  Wakeup control = loop_.add(Phase::kControl, [&] { value = 1; });
  control.at(kSimStart + 1ms);
  loop_.run_until(kSimStart + 1ms);
  recorder.close();
  EXPECT_EQ(contents(path_), "time_s,x\n0.000000000,0\n0.001000000,1\n");
}

TEST_F(CsvRecorderTest, ErrorsNameTheOptionAndTheReason) {
  EXPECT_THROW(CsvRecorder(loop_, registry_, path_, {"motor0.sped"}, 1ms), SetupError);
  EXPECT_THROW(CsvRecorder(loop_, registry_, path_, {"motor0.speed"}, 0ms), SetupError);
  try {
    CsvRecorder recorder(loop_, registry_, "/nonexistent/run.csv", {"motor0.speed"}, 1ms);
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_STREQ(error.what(),
                 "--record /nonexistent/run.csv: cannot be written: No such file or directory");
  }
  EXPECT_FALSE(std::filesystem::exists(path_)) << "nothing is left behind";
}

TEST_F(CsvRecorderTest, AFullDiskIsReported) {
  CsvRecorder recorder(loop_, registry_, "/dev/full", {"motor0.speed"}, 1ms);
  loop_.run_until(kSimStart + 10ms);
  EXPECT_THROW(recorder.close(), SetupError);
}

}  // namespace
}  // namespace virtdrive
