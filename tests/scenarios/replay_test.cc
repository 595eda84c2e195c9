#include "scenarios/replay.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/check.h"
#include "devices/framers.h"
#include "scenarios/recording/wire_recorder.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

const Bytes kVersionRequest = {0x11, 0x14, 0x00, 0x6c, 0x13};

class ReplayTest : public testing::Test {
 protected:
  ~ReplayTest() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(again_);
  }

  WireRecording record(const BenchOptions& options, const std::function<void(Bench&)>& talk) {
    Bench bench(options);
    WireRecorder recorder(path_, bench, {.options = options});
    talk(bench);
    recorder.close();
    return read_wire_recording(path_);
  }
  static std::string contents(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  const std::string path_ =
      testing::TempDir() + "virtdrive_replay_test." + std::to_string(getpid()) + ".pcapng";
  const std::string again_ = path_ + ".again";
};

TEST(RecordableDrives, EachDriveOfTheCatalogueHasAFramer) {
  for (const DriveKind& kind : drive_catalogue()) {
    EXPECT_NE(make_framer(kind.table.name), nullptr) << kind.name;
  }
}

TEST_F(ReplayTest, AHostInsideTheSimulationIsReplayedToTheBit) {
  const BenchOptions options{.drives = {{.kind = "toshiba-mcu", .load = "brake:5mNm@50ms"}},
                             .seed = 3};
  const WireRecording recording = record(options, [](Bench& bench) {
    bench.host()->start_motor(1, 1500);
    for (int i = 0; i < 200; ++i) {
      bench.line().host_send(Bytes{0x11, 0x02, 0x01, 0x05, 0x13});
      bench.run_for(3ms);
    }
  });
  EXPECT_GT(recording.packets.size(), 200U);
  const ReplayResult result = replay(recording, path_, {.wire = again_});
  EXPECT_FALSE(result.divergence);
  EXPECT_EQ(result.end, recording.end);
  EXPECT_GT(result.drive_bytes, 200U * 5);
  EXPECT_EQ(contents(again_), contents(path_));
}

TEST_F(ReplayTest, TwoDrivesOnTwoLinesAreHeldApart) {
  const BenchOptions options{.drives = {{.kind = "toshiba-mcu", .name = "left", .line = "a"},
                                        {.kind = "toshiba-mcu", .name = "right", .line = "b"}},
                             .lines = {{.name = "a"}, {.name = "b", .timing = LineTiming::kIdeal}}};
  const WireRecording recording = record(options, [](Bench& bench) {
    bench.line("b").host_send(kVersionRequest);
    bench.line("a").host_send(kVersionRequest);
    bench.run_for(5ms);
    bench.line("b").host_send(kVersionRequest);
    bench.run_for(5ms);
  });
  ASSERT_EQ(recording.lines.size(), 2U);
  EXPECT_EQ(recording.lines[1].name, "b");
  const ReplayResult result = replay(recording, path_, {.wire = again_});
  EXPECT_FALSE(result.divergence);
  EXPECT_EQ(result.host_bytes, 15U);
  EXPECT_EQ(result.drive_bytes, 18U);
  EXPECT_EQ(contents(again_), contents(path_));
}

TEST_F(ReplayTest, AByteThatDiffersComesLateIsMissingOrTooManyIsTheDivergence) {
  const BenchOptions options{.drives = {{.kind = "toshiba-mcu"}}};
  const WireRecording recording = record(options, [](Bench& bench) {
    bench.line().host_send(kVersionRequest);
    bench.run_for(10ms);
  });
  ASSERT_EQ(recording.packets.size(), 2U);
  ASSERT_EQ(recording.packets[1].bytes.size(), 6U);
  const auto divergence_of = [&](const std::function<void(WireRecording&)>& change) {
    WireRecording changed = recording;
    change(changed);
    return replay(changed, path_).divergence.value_or(Divergence{.index = 999});
  };
  EXPECT_EQ(divergence_of([](WireRecording&) {}).index, 999U);

  const Divergence differs = divergence_of([](WireRecording& r) { r.packets[1].bytes[2] = 9; });
  EXPECT_EQ(differs.index, 2U);
  EXPECT_EQ(differs.recorded->byte, 9);
  EXPECT_EQ(differs.replayed->byte, 3);
  EXPECT_EQ(differs.replayed->text, "GetFWVersion major=3 minor=10");

  const Divergence late = divergence_of([](WireRecording& r) { r.packets[1].last_bits[4] -= 1ns; });
  EXPECT_EQ(late.index, 4U);
  EXPECT_EQ(late.replayed->last_bit - late.recorded->last_bit, 1ns);

  const Divergence extra = divergence_of([](WireRecording& r) { r.packets.pop_back(); });
  EXPECT_EQ(extra.index, 0U);
  EXPECT_FALSE(extra.recorded);
  EXPECT_EQ(extra.replayed->byte, 0x11);

  const Divergence missing =
      divergence_of([](WireRecording& r) { r.packets.push_back(r.packets[1]); });
  EXPECT_EQ(missing.index, 6U);
  EXPECT_EQ(missing.recorded->byte, 0x11);
  EXPECT_FALSE(missing.replayed);
}

TEST_F(ReplayTest, ARecordingThatWasCutShortIsHeldAgainstWhatThereIs) {
  const BenchOptions options{.drives = {{.kind = "toshiba-mcu"}}};
  WireRecording recording = record(options, [](Bench& bench) {
    bench.line().host_send(kVersionRequest);
    bench.run_for(10ms);
  });
  recording.packets.pop_back();
  recording.cut_short = "killed";
  const ReplayResult result = replay(recording, path_);
  EXPECT_FALSE(result.divergence);
  EXPECT_EQ(result.drive_bytes, 0U);
}

TEST_F(ReplayTest, ADescriptionOfOtherLinesIsRefused) {
  const BenchOptions options{.drives = {{.kind = "toshiba-mcu"}}};
  WireRecording recording = record(options, [](Bench&) {});
  recording.lines[0].baud = 9600;
  EXPECT_THROW(replay(recording, path_), SetupError);
  recording.lines[0].baud = 115200;
  recording.files.push_back({.drive = 1});
  EXPECT_THROW(replay(recording, path_), SetupError);
}

}  // namespace
}  // namespace virtdrive
