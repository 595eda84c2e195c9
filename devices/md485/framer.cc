#include "devices/md485/framer.h"

#include <fmt/format.h>

#include "devices/md485/codec.h"

namespace virtdrive::md485 {
namespace {

using protocol::Direction;
using protocol::Run;
using protocol::Verdict;
using Event = Decoder::Event;

std::string text(const Frame& frame) {
  if (frame.command != nullptr) {
    return fmt::format("{} {}", frame.command->name,
                       protocol::describe(frame.command->request, frame.values));
  }
  return fmt::format("{} {}", frame.parameter->name,
                     protocol::describe(protocol::value_fields(*frame.parameter), frame.values));
}

class FrameFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    Lane& lane = this->lane(direction);
    ++lane.held;
    drain(lane, lane.decoder.push(byte), ended);
    if (direction == Direction::kRequest) follow_host(lane.decoder.frame().route.host);
  }

  void expire(Direction direction, std::vector<Run>& ended) override {
    Lane& lane = this->lane(direction);
    while (lane.held > 0) drain(lane, lane.decoder.expire(), ended);
  }

  SimDuration silence() const override { return kTable.framing.silence; }

 private:
  struct Lane {
    Decoder decoder;
    std::size_t held = 0;
  };

  static void drain(Lane& lane, Event event, std::vector<Run>& ended) {
    for (; event != Event::kNone; event = lane.decoder.next()) take(lane, event, ended);
    const std::size_t dropped = lane.held - lane.decoder.pending();
    if (dropped > 0) ended.push_back({dropped, Verdict::kNoise, "outside of a frame"});
    lane.held -= dropped;
  }

  static void take(Lane& lane, Event event, std::vector<Run>& ended) {
    const std::size_t done = lane.held - lane.decoder.pending();
    lane.held -= done;
    const bool whole =
        event == Event::kFrame || event == Event::kUnknownPid || event == Event::kTooShort;
    const std::size_t size = whole ? lane.decoder.bytes().size() : 0;
    if (done > size) {
      ended.push_back({done - size, Verdict::kNoise,
                       event == Event::kBadSum ? "no frame: wrong sum" : "outside of a frame"});
    }
    if (event == Event::kFrame) {
      ended.push_back({size, Verdict::kFrame, text(lane.decoder.frame())});
    } else if (whole) {
      ended.push_back({size, Verdict::kMalformed,
                       event == Event::kTooShort ? "data are missing" : "unknown PID"});
    }
  }

  // Replies go to the number that the last request came from.
  void follow_host(std::uint8_t host) {
    if (host == host_ || replies_.held > 0) return;
    host_ = host;
    replies_.decoder = Decoder(Direction::kReply, host);
  }

  Lane& lane(Direction direction) {
    return direction == Direction::kRequest ? requests_ : replies_;
  }

  std::uint8_t host_ = kHost;
  Lane requests_{Decoder(Direction::kRequest)};
  Lane replies_{Decoder(Direction::kReply)};
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<FrameFramer>();
}

}  // namespace virtdrive::md485
