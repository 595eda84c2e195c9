// A recording may hold anything: it is loaded, or refused with one line; what is loaded keeps what
// the rest of the program relies on, and written again it is loaded as the same.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <span>
#include <string_view>
#include <unistd.h>

#include "core/check.h"
#include "scenarios/recording/bench_description.h"
#include "scenarios/recording/wire_recorder.h"
#include "scenarios/recording/wire_recording.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

void check(const WireRecording& recording) {
  SimTime before = kSimStart;
  for (const HostAction& action : recording.actions) {
    VIRTDRIVE_CHECK(action.line < recording.lines.size(), "line {}", action.line);
    VIRTDRIVE_CHECK(action.when.time >= before && action.when.time <= recording.end, "its time");
    before = action.when.time;
  }
  for (const RecordedPacket& packet : recording.packets) {
    VIRTDRIVE_CHECK(packet.line < recording.lines.size(), "line {}", packet.line);
    VIRTDRIVE_CHECK(!packet.bytes.empty() && packet.last_bits.size() == packet.bytes.size(),
                    "{} bytes, {} times", packet.bytes.size(), packet.last_bits.size());
    VIRTDRIVE_CHECK(packet.last_bits.back() <= recording.end, "its time");
  }
}

void load(std::span<const std::uint8_t> bytes) {
  try {
    const WireRecording recording = parse_wire_recording(bytes, "fuzz.pcapng");
    check(recording);
    const RecordedBench bench = parse_bench(recording.bench, "fuzz.pcapng");
    const std::string text = describe(bench);
    VIRTDRIVE_CHECK(describe(parse_bench(text, "fuzz.pcapng")) == text, "{}", text);
  } catch (const SetupError& error) {
    VIRTDRIVE_CHECK(std::string_view(error.what()).find("fuzz.pcapng") != std::string_view::npos,
                    "an error that names no file: {}", error.what());
  }
}

// A host that asks, talks garbage, changes its settings and stops in the middle.
std::vector<std::uint8_t> record(const BenchOptions& options) {
  using namespace std::chrono_literals;
  constexpr std::uint8_t kTalk[] = {0x55, 0x11, 0x14, 0x00, 0x6c, 0x13, 0x11, 0x0a};
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("virtdrive-wire-fuzz-{}", getpid());
  Bench bench(options);
  WireRecorder recorder(path.string(), bench, {.options = options});
  bench.line().host_send(kTalk);
  bench.run_for(10ms);
  bench.line().set_host({.baud = 9600, .stop_bits = 2});
  bench.line().host_send(kTalk);
  bench.run_for(10ms);
  recorder.close();
  std::ifstream stream(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  std::filesystem::remove(path);
  return bytes;
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  return {record({.drives = {{.kind = "toshiba-mcu"}}}),
          record({.drives = {{.kind = "toshiba-mcu", .load = "brake:5mNm", .set = {"PolePairs=4"}}},
                  .lines = {{.timing = LineTiming::kIdeal}},
                  .seed = 7})};
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  virtdrive::load({data, size});
  return 0;
}
