#include "scenarios/recording/mat_writer.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <matio.h>

#include "core/check.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

struct Closed {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

class MatWriterTest : public testing::Test {
 protected:
  ~MatWriterTest() override { std::filesystem::remove(path_); }

  using Variable = std::unique_ptr<matvar_t, Closed>;
  Variable read(const char* name) const {
    const std::unique_ptr<mat_t, Closed> file(Mat_Open(path_.c_str(), MAT_ACC_RDONLY));
    return Variable(file ? Mat_VarRead(file.get(), name) : nullptr);
  }
  std::vector<double> numbers(const char* name) const {
    const Variable variable = read(name);
    if (!variable || variable->class_type != MAT_C_DOUBLE || variable->rank != 2 ||
        variable->dims[1] != 1) {
      return {};
    }
    const auto* data = static_cast<const double*>(variable->data);
    return {data, data + variable->dims[0]};
  }
  std::string unit(const char* name) const {
    const Variable units = read("units");
    const matvar_t* field = units ? Mat_VarGetStructFieldByName(units.get(), name, 0) : nullptr;
    if (field == nullptr || field->class_type != MAT_C_CHAR) return "none";
    return {static_cast<const char*>(field->data), field->nbytes};
  }

  std::string path_ = testing::TempDir() + "virtdrive_mat_writer_test." +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".mat";
};

TEST_F(MatWriterTest, AReaderFindsTimeSignalsAndUnits) {
  MatWriter writer(path_, {{"motor1.speed", "rpm"}, {"drive1.stage", ""}});
  writer.write(kSimStart, std::vector{0.1, 5.0});
  writer.write(kSimStart + 500ms, std::vector{-2e-300, 6.0});
  writer.close();
  EXPECT_EQ(numbers("time"), (std::vector{0.0, 0.5}));
  EXPECT_EQ(numbers("motor1_speed"), (std::vector{0.1, -2e-300}));
  EXPECT_EQ(numbers("drive1_stage"), (std::vector{5.0, 6.0}));
  EXPECT_EQ(unit("time"), "s");
  EXPECT_EQ(unit("motor1_speed"), "rpm");
  EXPECT_EQ(unit("drive1_stage"), "");
}

TEST_F(MatWriterTest, NamesAreMadeValidAndKeptApart) {
  EXPECT_EQ(mat_names({{"motor1.speed", ""}, {"motor1_speed", ""}, {"time", ""}, {"2.x", ""}}),
            (std::vector<std::string>{"motor1_speed", "motor1_speed_", "time_", "s2_x"}));
}

TEST_F(MatWriterTest, BeyondItsMaximumTheRowsSoFarAreKeptAndTheErrorSaysWhatToDo) {
  MatWriter writer(path_, {{"x", ""}}, 4);
  writer.write(kSimStart, std::vector{1.0});
  writer.write(kSimStart + 1ms, std::vector{2.0});
  try {
    writer.write(kSimStart + 2ms, std::vector{3.0});
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_EQ(std::string(error.what()),
              "--record " + path_ +
                  ": full at 0.002 s: a MAT file is limited to 4 numbers; record to .csv or .vcd, "
                  "fewer signals, or at a longer --interval");
  }
  EXPECT_EQ(numbers("x"), (std::vector{1.0, 2.0}));
}

TEST_F(MatWriterTest, ARecordingWithoutARowIsAFileWithEmptyVectors) {
  MatWriter writer(path_, {{"x", "V"}});
  writer.close();
  ASSERT_NE(read("x"), nullptr);
  EXPECT_EQ(read("x")->nbytes, 0U);
  EXPECT_EQ(unit("x"), "V");
}

}  // namespace
}  // namespace virtdrive
