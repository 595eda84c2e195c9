#include "scenarios/cli/demo_report.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"
#include "firmware_models/toshiba_mcu/stage.h"

namespace virtdrive {
namespace {

using toshiba_mcu::Stage;

constexpr double kMilli = 1e3;
constexpr std::size_t kErrorLane = 2;

// In the order of the stages' numbers.
std::vector<State> stages() {
  constexpr Color kColors[] = {Color::kGrey,   Color::kTeal,   Color::kPurple, Color::kBlue,
                               Color::kPurple, Color::kOrange, Color::kGreen,  Color::kRed};
  std::vector<State> states;
  for (std::size_t i = 0; i < std::size(kColors); ++i) {
    states.push_back({std::string(toshiba_mcu::name(static_cast<Stage>(i))), kColors[i]});
  }
  return states;
}

}  // namespace

DemoReport::DemoReport(std::size_t channel) : channel_(channel) {
  for (const std::string_view name :
       {"motor{}.speed", "motor{}.torque", "motor{}.current_q", "bus{}.voltage", "load{}.torque",
        "drive{}.stage", "drive{}.speed", "drive{}.speed_command", "drive{}.current_q",
        "drive{}.current_q_ref"}) {
    signals_.push_back(fmt::format(fmt::runtime(name), channel_));
  }
  columns_.resize(signals_.size());
}

void DemoReport::add_row(SimTime time, std::span<const double> values) {
  if (axis_.time_s.size() >= kMaximumRows) return;
  axis_.time_s.push_back(seconds(time));
  for (std::size_t i = 0; i < values.size(); ++i) columns_[i].push_back(values[i]);
}

void DemoReport::add_frame(const WireEvent& event) {
  if (frames_.size() >= kMaximumFrames) return;
  const bool request = event.kind == WireEvent::Kind::kRequest;
  const std::size_t lane = request ? 0 : event.kind == WireEvent::Kind::kReply ? 1 : kErrorLane;
  frames_.push_back({seconds(event.time), lane, std::string(event.text)});
  if (request && event.text.starts_with("StartMotor")) {
    axis_.moments.push_back({seconds(event.time), "start"});
  }
  if (request && event.text.starts_with("StopMotor")) {
    axis_.moments.push_back({seconds(event.time), "stop"});
  }
}

void DemoReport::add_load(SimTime time, double brake_nm) {
  if (brake_nm == load_nm_) return;
  load_nm_ = brake_nm;
  axis_.moments.push_back({seconds(time), brake_nm == 0
                                              ? "load off"
                                              : fmt::format("load {:.0f} mNm", brake_nm * kMilli)});
}

std::vector<double> DemoReport::column(std::string_view name, double factor) const {
  const std::string full = fmt::format(fmt::runtime(name), channel_);
  const auto found = std::ranges::find(signals_, full);
  VIRTDRIVE_CHECK(found != signals_.end(), "{}", full);
  std::vector<double> values = columns_[static_cast<std::size_t>(found - signals_.begin())];
  for (double& value : values) value *= factor;
  return values;
}

Report DemoReport::make(Bench& bench, const std::string& firmware,
                        const std::string& result) const {
  BenchDrive& drive = bench.drive();
  const WireCounters wire = drive.controller().wire_counters();
  Report report;
  report.title = fmt::format("virtdrive demo: {}", drive.kind().table.title);
  report.summary = fmt::format(
      "An emulated drive turns a simulated motor, and a host program commands it over a "
      "pseudo-terminal as it would a real one: accelerate, hold the speed while a load is put on "
      "and taken off, stop. All times are simulated seconds. Point at a curve, a stage or a frame "
      "to read its values.");
  report.facts = {
      {"Drive", firmware.empty()
                    ? std::string(drive.kind().name)
                    : fmt::format("{}, tells firmware {}", drive.kind().name, firmware)},
      {"Motor", fmt::format("{} on channel {}: {}", drive.motor(channel_).name, channel_,
                            drive.motor(channel_).description)},
      {"Result", result},
      {"Simulated", fmt::format("{:.3f} s, sampled each ms", seconds(bench.loop().now()))},
      {"Line", fmt::format("{} baud", bench.line().settings().baud)},
      {"Frames", fmt::format("{} requests, {} replies, {} bad; {} bytes lost", wire.requests,
                             wire.replies, wire.bad_frames, wire.bytes_lost)},
      {"Seed", fmt::format("{}", bench.seed())},
      {"virtdrive", VIRTDRIVE_VERSION}};
  report.axis = axis_;
  report.plots = {
      LinePlot{"Speed",
               "rpm",
               {{"rotor", column("motor{}.speed"), Color::kBlue},
                {"as the drive reports it", column("drive{}.speed"), Color::kOrange},
                {"command, ramped", column("drive{}.speed_command"), Color::kGrey, true}}},
      BandPlot{"Stage of the drive", column("drive{}.stage"), stages()},
      LinePlot{"q current, which makes the torque",
               "A",
               {{"measured by the drive", column("drive{}.current_q"), Color::kOrange},
                {"in the motor", column("motor{}.current_q"), Color::kBlue},
                {"reference", column("drive{}.current_q_ref"), Color::kGrey, true}}},
      LinePlot{"Torque",
               "mNm",
               {{"of the motor, air gap", column("motor{}.torque", kMilli), Color::kBlue},
                {"of the load", column("load{}.torque", kMilli), Color::kOrange}}},
      // A tenth of a volt is what the drive's own telegrams resolve.
      LinePlot{"DC link", "V", {{"voltage", column("bus{}.voltage"), Color::kBlue}}, 0.5},
      EventPlot{"Frames on the line",
                {{"requests", Color::kBlue}, {"replies", Color::kGreen}, {"errors", Color::kRed}},
                frames_}};
  return report;
}

}  // namespace virtdrive
