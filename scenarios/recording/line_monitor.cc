#include "scenarios/recording/line_monitor.h"

#include <utility>

#include "core/check.h"
#include "devices/framers.h"

namespace virtdrive {

using protocol::Run;
using protocol::Verdict;

LineMonitor::LineMonitor(EventLoop& loop, SerialLine& line, std::size_t line_number,
                         std::string_view protocol, std::vector<WireSink*> sinks)
    : loop_(loop),
      line_(line),
      number_(line_number),
      framer_(make_framer(protocol)),
      sinks_(std::move(sinks)) {
  host_acted({}, line.host());
  line_.on_host_send(
      [this](auto bytes, const HostSettings& settings, SimTime) { host_acted(bytes, settings); });
  line_.on_wire([this](const WireByte& byte) { hear(byte); });
}

LineMonitor::~LineMonitor() {
  line_.on_host_send(nullptr);
  line_.on_wire(nullptr);
}

void LineMonitor::finish() {
  for (Lane* const lane : {&from_host_, &to_host_}) {
    expire(*lane);
    end_noise(*lane);
  }
}

HostInstant LineMonitor::instant() const {
  return {.time = loop_.now(), .before_events = loop_.next() <= loop_.now()};
}

void LineMonitor::host_acted(std::span<const std::uint8_t> bytes, const HostSettings& settings) {
  if (settings != settings_) {
    settings_ = settings;
    for (WireSink* const sink : sinks_) sink->host_settings(number_, instant(), settings);
  }
  if (bytes.empty()) return;
  for (WireSink* const sink : sinks_) sink->host_write(number_, instant(), bytes);
}

void LineMonitor::hear(const WireByte& byte) {
  Lane& lane = byte.talker == kHostTalker ? from_host_ : to_host_;
  const SimDuration silence = framer_->silence();
  if (silence > SimDuration{} && !lane.held.empty() &&
      byte.begin - lane.held.back().end >= silence) {
    expire(lane);
  }
  if (!lane.noise.empty() && byte.begin - lane.noise.back().end >= kNoiseGap) {
    end_noise(lane);
  }
  lane.held.push_back(byte);
  runs_.clear();
  framer_->push(lane.direction, byte.byte, runs_);
  take_runs(lane);
}

void LineMonitor::expire(Lane& lane) {
  runs_.clear();
  framer_->expire(lane.direction, runs_);
  take_runs(lane);
}

void LineMonitor::take_runs(Lane& lane) {
  std::size_t taken = 0;
  for (const Run& run : runs_) {
    VIRTDRIVE_CHECK(run.size > 0 && taken + run.size <= lane.held.size(), "a run of {}, {} held",
                    run.size, lane.held.size() - taken);
    const auto bytes = std::span(lane.held).subspan(taken, run.size);
    taken += run.size;
    if (run.verdict == Verdict::kNoise) {
      add_noise(lane, bytes, run.text);
    } else {
      end_noise(lane);
      tell({lane.direction, bytes, run.verdict, run.text});
    }
  }
  lane.held.erase(lane.held.begin(), lane.held.begin() + static_cast<std::ptrdiff_t>(taken));
  VIRTDRIVE_CHECK(lane.held.size() <= protocol::Framer::kMostHeld, "{} bytes held",
                  lane.held.size());
}

void LineMonitor::add_noise(Lane& lane, std::span<const WireByte> bytes, std::string_view text) {
  for (const WireByte& byte : bytes) {
    if (lane.noise.empty()) lane.noise_text = text;
    lane.noise.push_back(byte);
    if (lane.noise.size() == kLongestNoise) end_noise(lane);
  }
}

void LineMonitor::end_noise(Lane& lane) {
  if (lane.noise.empty()) return;
  tell({lane.direction, lane.noise, Verdict::kNoise, lane.noise_text});
  lane.noise.clear();
}

void LineMonitor::tell(const WirePacket& packet) {
  for (WireSink* const sink : sinks_) sink->packet(number_, packet);
}

}  // namespace virtdrive
