#include "scenarios/nvm_file.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/check.h"
#include "core/random.h"
#include "devices/toshiba_mcu/client.h"
#include "scenarios/bench.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using Bytes = std::vector<std::uint8_t>;
namespace fs = std::filesystem;

class NvmFileTest : public testing::Test {
 protected:
  NvmFileTest() { fs::create_directories(folder_); }
  ~NvmFileTest() override { fs::remove_all(folder_); }

  void put(const std::string& text) { std::ofstream(path_, std::ios::binary) << text; }
  std::string text() {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  NvmFile open(std::string_view drive = "toshiba-mcu") {
    return NvmFile(path_, drive, [this](std::string_view note) { notes_.emplace_back(note); });
  }
  std::string error_of_open(std::string_view drive = "toshiba-mcu") {
    try {
      open(drive);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "opened";
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / ("virtdrive-nvm-" + std::to_string(getpid()));
  const std::string path_ = folder_ / "drive.nvm";
  std::vector<std::string> notes_;
};

TEST_F(NvmFileTest, KeepsBlocksFromOneProgramToTheNext) {
  {
    NvmFile memory = open();
    EXPECT_EQ(memory.read("channel0"), std::nullopt);
    EXPECT_TRUE(memory.write("channel0", Bytes{1, 2, 0xFF}));
    EXPECT_TRUE(memory.write("channel1", Bytes{4}));
    EXPECT_TRUE(memory.write("channel0", Bytes{1, 2, 3}));
  }
  NvmFile memory = open();
  EXPECT_EQ(memory.read("channel0"), (Bytes{1, 2, 3}));
  EXPECT_EQ(memory.read("channel1"), (Bytes{4}));
  EXPECT_TRUE(memory.erase());
  EXPECT_EQ(open().read("channel0"), std::nullopt);
  EXPECT_TRUE(notes_.empty());
}

TEST_F(NvmFileTest, WithoutAStoreThereIsNoFile) {
  open();
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(NvmFileTest, ADamagedOrCutFileIsToldAndCountsAsEmpty) {
  open().write("channel0", Bytes{1, 2, 3});
  const std::string good = text();
  for (std::size_t size = good.find('\n') + 1; size < good.size(); ++size) {
    put(good.substr(0, size));
    notes_.clear();
    EXPECT_EQ(open().read("channel0"), std::nullopt) << size;
    EXPECT_EQ(notes_.size(), 1U) << size;
  }
  for (std::size_t i = good.find('\n') + 1; i < good.size(); ++i) {
    std::string flipped = good;
    flipped[i] = static_cast<char>(flipped[i] ^ 1);
    put(flipped);
    EXPECT_EQ(open().read("channel0"), std::nullopt) << i;
  }
  EXPECT_NE(notes_.back().find(path_), std::string::npos);
}

TEST_F(NvmFileTest, AFileThatIsNotOursIsRefusedAndNotTouched) {
  put("# my notes\n");
  EXPECT_NE(error_of_open().find("is not a memory of virtdrive"), std::string::npos);
  EXPECT_EQ(text(), "# my notes\n");
}

TEST_F(NvmFileTest, AnotherDrivesMemoryIsRefused) {
  open("md400").write("all", Bytes{1});
  EXPECT_NE(error_of_open().find("is the memory of 'md400'"), std::string::npos);
}

TEST_F(NvmFileTest, AFolderOrAMissingFolderIsAClearError) {
  fs::create_directory(path_);
  EXPECT_NE(error_of_open().find("is not a file"), std::string::npos);
  EXPECT_THROW(NvmFile("/nonexistent/drive.nvm", "toshiba-mcu", nullptr), SetupError);
}

TEST_F(NvmFileTest, AFailedWriteIsToldAndTheOldSetStays) {
  NvmFile memory = open();
  memory.write("channel0", Bytes{1});
  fs::create_directory(path_ + ".new");  // the new file cannot be made
  EXPECT_FALSE(memory.write("channel0", Bytes{2}));
  EXPECT_EQ(memory.read("channel0"), (Bytes{1}));
  EXPECT_EQ(open().read("channel0"), (Bytes{1}));
}

TEST_F(NvmFileTest, ADriveFindsWhatItStoredAfterARestart) {
  using toshiba_mcu::UnitValue;
  {
    Bench bench({.drives = {{.kind = "toshiba-mcu", .nvm = path_}}});
    LineTransport transport(bench.loop(), bench.line());
    toshiba_mcu::Client client(transport);
    client.set(1, "MaxAngAcc", {800, 0});
    client.call(0x03, {1});
    client.set(1, "MaxAngAcc", {900, 0});
  }
  Bench bench({.drives = {{.kind = "toshiba-mcu", .nvm = path_}}});
  LineTransport transport(bench.loop(), bench.line());
  EXPECT_EQ(toshiba_mcu::Client(transport).get(1, "MaxAngAcc"), (UnitValue{800, 0}));
}

// A child stores two sets by turns, for ever, and is killed at a random moment: after some stores,
// counted through a pipe, and a random way into the next one.
void kill_a_writer(const std::string& path, RandomStream& random) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    NvmFile memory(path, "toshiba-mcu", nullptr);
    for (std::uint8_t i = 0;; i ^= 1) {
      memory.write("channel0", Bytes(200, i));
      [[maybe_unused]] const ssize_t told = ::write(ends[1], &i, 1);
    }
  }
  std::uint8_t stored = 0;
  for (std::uint64_t stores = 1 + random.bits() % 4; stores > 0; --stores) {
    ASSERT_EQ(::read(ends[0], &stored, 1), 1);
  }
  const std::uint64_t turns = random.bits() % 300'000;
  for (std::uint64_t i = 0; i < turns; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ends[0]);
  close(ends[1]);
}

void expect_the_old_or_the_new_set(const std::string& path, int kills) {
  RandomStream random = Seed{1}.stream("kill");
  NvmFile(path, "toshiba-mcu", nullptr).write("channel0", Bytes(200, 0));
  for (int i = 0; i < kills; ++i) {
    kill_a_writer(path, random);
    std::vector<std::string> notes;
    NvmFile memory(path, "toshiba-mcu", [&](std::string_view note) { notes.emplace_back(note); });
    ASSERT_TRUE(notes.empty()) << notes.front();
    const auto set = memory.read("channel0");
    ASSERT_TRUE(set == Bytes(200, 0) || set == Bytes(200, 1)) << i;
  }
}

TEST_F(NvmFileTest, AKillAtAnyMomentLeavesTheOldOrTheNewSet) {
  expect_the_old_or_the_new_set(path_, VIRTDRIVE_KILLS);
}

}  // namespace
}  // namespace virtdrive
