#include "scenarios/recording/frame_cutter.h"

#include <utility>

#include "core/check.h"
#include "devices/framers.h"

namespace virtdrive {

using protocol::Run;
using protocol::Verdict;

FrameCutter::FrameCutter(std::string_view protocol, Listener listener)
    : framer_(make_framer(protocol)), listener_(std::move(listener)) {}

void FrameCutter::finish() {
  for (Lane* const lane : {&from_host_, &to_host_}) {
    expire(*lane);
    end_noise(*lane);
  }
}

// Gives up what the silence has ended.
void FrameCutter::pass_silence(Lane& lane, SimTime until) {
  const SimDuration silence = framer_->silence();
  if (silence > SimDuration{} && !lane.held.empty() && until - lane.held.back().end >= silence) {
    expire(lane);
  }
  if (!lane.noise.empty() && until - lane.noise.back().end >= kNoiseGap) end_noise(lane);
}

void FrameCutter::hear(protocol::Direction direction, const WireByte& byte) {
  Lane& lane = direction == protocol::Direction::kRequest ? from_host_ : to_host_;
  pass_silence(lane, byte.begin);
  lane.held.push_back(byte);
  runs_.clear();
  framer_->push(direction, byte.byte, runs_);
  take_runs(lane);
}

void FrameCutter::expire(Lane& lane) {
  runs_.clear();
  framer_->expire(lane.direction, runs_);
  take_runs(lane);
}

void FrameCutter::take_runs(Lane& lane) {
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
      listener_({lane.direction, bytes, run.verdict, run.text});
    }
  }
  lane.held.erase(lane.held.begin(), lane.held.begin() + static_cast<std::ptrdiff_t>(taken));
  VIRTDRIVE_CHECK(lane.held.size() <= protocol::Framer::kMostHeld, "{} bytes held",
                  lane.held.size());
}

void FrameCutter::add_noise(Lane& lane, std::span<const WireByte> bytes, std::string_view text) {
  for (const WireByte& byte : bytes) {
    if (lane.noise.empty()) lane.noise_text = text;
    lane.noise.push_back(byte);
    if (lane.noise.size() == kLongestNoise) end_noise(lane);
  }
}

void FrameCutter::end_noise(Lane& lane) {
  if (lane.noise.empty()) return;
  listener_({lane.direction, lane.noise, Verdict::kNoise, lane.noise_text});
  lane.noise.clear();
}

}  // namespace virtdrive
