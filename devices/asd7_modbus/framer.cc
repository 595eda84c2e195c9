#include "devices/asd7_modbus/framer.h"

#include <fmt/format.h>
#include <utility>

#include "devices/asd7_modbus/codec.h"
#include "devices/protocol/frame_buffer.h"

namespace virtdrive::asd7_modbus {
namespace {

using protocol::Direction;
using protocol::Run;
using protocol::Verdict;

/// Longer than a character at 1200 baud, so that a slow line is not taken to pieces.
constexpr SimDuration kFrameSilence = std::chrono::milliseconds(32);

std::string text(const Frame& frame, Direction direction) {
  if (frame.exception) return fmt::format("exception {}", *frame.exception);
  if (frame.row == nullptr) return fmt::format("function {:02x}", frame.function);
  if (!frame.values) return fmt::format("{} of another length", frame.row->name);
  const auto fields = direction == Direction::kRequest ? frame.row->request : frame.row->reply;
  return fmt::format("{} {}", frame.row->name, protocol::describe(fields, *frame.values));
}

class RtuFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    Lane& lane = lanes_[static_cast<std::size_t>(direction)];
    lane.push(byte);
    const std::size_t size = expected_size(direction, lane.bytes());
    if (lane.size() == size || lane.full()) end(direction, ended);
  }
  void expire(Direction direction, std::vector<Run>& ended) override {
    if (!lanes_[static_cast<std::size_t>(direction)].empty()) end(direction, ended);
  }
  SimDuration silence() const override { return kFrameSilence; }

 private:
  using Lane = protocol::FrameBuffer<kLongestFrame>;

  void end(Direction direction, std::vector<Run>& ended) {
    Lane& lane = lanes_[static_cast<std::size_t>(direction)];
    Frame frame;
    switch (decode(direction, lane.bytes(), frame)) {
      case FrameError::kNone:
        ended.push_back({lane.size(), Verdict::kFrame, text(frame, direction)});
        break;
      case FrameError::kTooShort:
        ended.push_back({lane.size(), Verdict::kCutShort, "cut short"});
        break;
      case FrameError::kCrc:
        ended.push_back({lane.size(), Verdict::kBadChecksum, "wrong CRC"});
        break;
    }
    lane.clear();
  }

  Lane lanes_[2];
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<RtuFramer>();
}

}  // namespace virtdrive::asd7_modbus
