#include "scenarios/recording/recorder.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

std::string contents(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const SetupError& error) {
    return error.what();
  }
  return "no error";
}

class RecorderTest : public testing::Test {
 protected:
  RecorderTest() {
    std::filesystem::create_directories(folder_);
    registry_.add(Signal{"motor0.speed", "rpm", "", [this] { return 0.1 * ++reads_; }});
    registry_.add(Signal{"drive0.stage", "", "", [this] { return reads_ < 3 ? 5.0 : 6.0; }});
    registry_.add(Signal{"bus0.voltage", "V", "", [] { return 24.0; }});
  }
  ~RecorderTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + name; }

  // Three rows, at 0, 1 and 2 ms.
  void record(const std::string& name, const std::vector<std::string>& signals) {
    EventLoop loop;
    reads_ = 0;
    Recorder recorder(loop, registry_, path(name), signals, 1ms);
    loop.run_until(kSimStart + 2ms);
    recorder.close();
  }

  std::string folder_ = testing::TempDir() + "virtdrive_recorder_test." +
                        testing::UnitTest::GetInstance()->current_test_info()->name() + "/";
  EventLoop loop_;
  Registry registry_;
  int reads_ = 0;
};

TEST_F(RecorderTest, CsvHasAHeaderWithUnitsAndARowEachInterval) {
  record("run.csv", {"motor0.speed", "drive0.stage"});
  EXPECT_EQ(contents(path("run.csv")),
            "time_s,motor0.speed[rpm],drive0.stage\n"
            "0.000000000,0.1,5\n"
            "0.001000000,0.2,5\n"
            "0.002000000,0.30000000000000004,6\n");
}

TEST_F(RecorderTest, VcdHasAScopeAComponentAnInitialDumpAndThenChangesOnly) {
  record("run.vcd", {"motor0.speed", "drive0.stage", "bus0.voltage"});
  EXPECT_EQ(contents(path("run.vcd")),
            "$version virtdrive $end\n"
            "$timescale 1 ns $end\n"
            "$comment motor0.speed in rpm $end\n"
            "$comment bus0.voltage in V $end\n"
            "$scope module motor0 $end\n"
            "$var real 64 ! speed $end\n"
            "$upscope $end\n"
            "$scope module drive0 $end\n"
            "$var real 64 \" stage $end\n"
            "$upscope $end\n"
            "$scope module bus0 $end\n"
            "$var real 64 # voltage $end\n"
            "$upscope $end\n"
            "$enddefinitions $end\n"
            "#0\n"
            "$dumpvars\n"
            "r0.1 !\n"
            "r5 \"\n"
            "r24 #\n"
            "$end\n"
            "#1000000\n"
            "r0.2 !\n"
            "#2000000\n"
            "r0.30000000000000004 !\n"
            "r6 \"\n");
}

TEST_F(RecorderTest, VcdEndsAtTheLastInstantEvenIfNothingChanged) {
  record("run.vcd", {"bus0.voltage"});
  const std::string text = contents(path("run.vcd"));
  EXPECT_TRUE(text.ends_with("#0\n$dumpvars\nr24 !\n$end\n#2000000\n")) << text;
}

TEST_F(RecorderTest, EqualRunsGiveEqualFiles) {
  for (const std::string ending : {".csv", ".vcd", ".mat"}) {
    record("first" + ending, {"motor0.speed", "drive0.stage"});
    record("second" + ending, {"motor0.speed", "drive0.stage"});
    EXPECT_FALSE(contents(path("first" + ending)).empty());
    EXPECT_EQ(contents(path("first" + ending)), contents(path("second" + ending))) << ending;
  }
}

TEST_F(RecorderTest, ARowHoldsTheStateAtTheEndOfItsInstant) {
  double value = 0;
  registry_.add(Signal{"x", "", "", [&] { return value; }});
  Recorder recorder(loop_, registry_, path("x.csv"), {"x"}, 1ms);
  Wakeup control = loop_.add(Phase::kControl, [&] { value = 1; });
  control.at(kSimStart + 1ms);
  loop_.run_until(kSimStart + 1ms);
  recorder.close();
  EXPECT_EQ(contents(path("x.csv")), "time_s,x\n0.000000000,0\n0.001000000,1\n");
}

TEST_F(RecorderTest, ErrorsNameTheOptionAndTheReason) {
  const auto open = [&](const std::string& file, const char* signal, SimDuration interval) {
    return error_of([&] { Recorder(loop_, registry_, file, {signal}, interval); });
  };
  EXPECT_NE(open(path("a.csv"), "motor0.sped", 1ms), "no error");
  EXPECT_EQ(open(path("a.csv"), "motor0.speed", 0ms), "--interval: must be above 0");
  for (const std::string file : {"/nonexistent/a.csv", "/nonexistent/a.vcd", "/nonexistent/a.mat"})
    EXPECT_EQ(open(file, "motor0.speed", 1ms),
              "--record " + file + ": cannot be written: No such file or directory");
  EXPECT_EQ(open("run.xls", "motor0.speed", 1ms),
            "--record run.xls: the file's name must end in one of .csv, .vcd, .mat");
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "nothing is left behind";
}

TEST_F(RecorderTest, AFullDiskIsReported) {
  for (const std::string name : {"full.csv", "full.vcd", "full.mat"}) {
    std::filesystem::create_symlink("/dev/full", path(name));
    EXPECT_EQ(error_of([&] { record(name, {"motor0.speed"}); }),
              "--record " + path(name) + ": not all of it could be written");
  }
}

}  // namespace
}  // namespace virtdrive
