#include "scenarios/replay.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "scenarios/cli/commands.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;

std::string hex(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, " "));
}

std::string shown(const std::optional<DriveByte>& byte) {
  if (!byte) return "nothing";
  return fmt::format("{:02x} at {:.9f} s in {}  {}", byte->byte, seconds(byte->last_bit),
                     hex(byte->packet), byte->text);
}

Json as_json(const std::optional<DriveByte>& byte) {
  if (!byte) return nullptr;
  return {{"byte", byte->byte},
          {"time_ns", byte->last_bit.time_since_epoch().count()},
          {"packet", hex(byte->packet)},
          {"text", byte->text}};
}

bool identical(const ReplayResult& result) {
  return !result.divergence && !result.signal_divergence;
}

void print_json(const ReplayResult& result, const WireRecording& recording) {
  Json json = {{"event", "replayed"},
               {"identical", identical(result)},
               {"host_bytes", result.host_bytes},
               {"drive_bytes", result.drive_bytes},
               {"simulated_s", seconds(result.end)},
               {"complete", recording.cut_short.empty()}};
  if (result.divergence) {
    json["divergence"] = {{"line", result.divergence->line},
                          {"drive_byte", result.divergence->index},
                          {"recorded", as_json(result.divergence->recorded)},
                          {"replayed", as_json(result.divergence->replayed)}};
  }
  if (result.rows > 0) json["rows"] = result.rows;
  if (const auto& signal = result.signal_divergence) {
    json["signal_divergence"] = {{"signal", signal->signal},
                                 {"time_ns", signal->time.time_since_epoch().count()},
                                 {"recorded", signal->recorded},
                                 {"replayed", signal->replayed}};
  }
  fmt::print("{}\n", json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void print_text(const ReplayResult& result) {
  const double time_s = seconds(result.end);
  if (const auto& signal = result.signal_divergence) {
    fmt::print(
        "diverged: {} at {:.9f} s, after {} rows that are the same\n  recorded  {}\n"
        "  replayed  {}\n",
        signal->signal, seconds(signal->time), result.rows - 1, signal->recorded, signal->replayed);
  }
  if (identical(result)) {
    fmt::print("identical: {} host bytes, {} drive bytes, {}{:.3f} s\n", result.host_bytes,
               result.drive_bytes,
               result.rows > 0 ? fmt::format("{} rows of signals, ", result.rows) : "", time_s);
  }
  if (!result.divergence) return;
  const Divergence& divergence = *result.divergence;
  fmt::print(
      "diverged: drive byte {} on {}, after {} that are the same\n  recorded  {}\n"
      "  replayed  {}\n",
      divergence.index, divergence.line, result.drive_bytes, shown(divergence.recorded),
      shown(divergence.replayed));
}

}  // namespace

int replay(const ReplayCommand& command) {
  const WireRecording recording = read_wire_recording(command.file);
  ReplayOptions options = command.options;
  options.notes = [](std::string_view text) { fmt::print(stderr, "note: {}\n", text); };
  const ReplayResult result = replay(recording, command.file, options);
  if (!recording.cut_short.empty()) {
    fmt::print(stderr, "note: {}; replayed up to {:.6f} s\n", recording.cut_short,
               seconds(recording.end));
  }
  if (command.json)
    print_json(result, recording);
  else
    print_text(result);
  return identical(result) ? kExitOk : kExitFailed;
}

}  // namespace virtdrive
