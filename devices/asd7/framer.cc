#include "devices/asd7/framer.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "devices/asd7/codec.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Direction;
using protocol::Run;
using protocol::Verdict;
using Event = Decoder::Event;

std::string text(const Message& message, Direction direction) {
  if (message.row == nullptr) return "unknown command";
  std::string text(message.row->name);
  if (message.parameter != nullptr) text += fmt::format(" {}", message.parameter->name);
  const auto fields = direction == Direction::kRequest ? message.row->request : message.row->reply;
  for (std::size_t i = 0; i < std::min(fields.size(), message.values.size()); ++i) {
    text += fmt::format(" {}={}", fields[i].name, message.values[i]);
  }
  return text;
}

class MessageFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    Lane& lane = this->lane(direction);
    ++lane.held;
    const Event event = lane.decoder.push(byte);
    const Message& message = lane.decoder.message();
    switch (event) {
      case Event::kNone:  // or CR or LF between two messages
        if (lane.decoder.idle()) end(lane, {1, Verdict::kNoise, "end of a line"}, ended);
        return;
      case Event::kNoise:
        return end(lane, {1, Verdict::kNoise, "outside of a message"}, ended);
      case Event::kUnknownCommand:
        return end(lane, {lane.held, Verdict::kMalformed, "unknown command"}, ended);
      case Event::kFormatError: {
        // A start inside of a message is the first byte of another.
        const std::size_t begun = lane.decoder.idle() ? 0 : 1;
        return end(lane, {lane.held - begun, Verdict::kMalformed, "no message"}, ended);
      }
      case Event::kMessage: {
        const Verdict verdict =
            message.error == Error::kSum ? Verdict::kBadChecksum : Verdict::kFrame;
        return end(lane, {lane.held, verdict, text(message, direction)}, ended);
      }
    }
  }

  void expire(Direction direction, std::vector<Run>& ended) override {
    Lane& lane = this->lane(direction);
    if (lane.held > 0) end(lane, {lane.held, Verdict::kCutShort, "cut short"}, ended);
    lane.decoder.reset();
  }

  SimDuration silence() const override { return kSilence; }

 private:
  struct Lane {
    Decoder decoder;
    std::size_t held = 0;
  };

  static void end(Lane& lane, Run run, std::vector<Run>& ended) {
    lane.held -= run.size;
    ended.push_back(std::move(run));
  }

  Lane& lane(Direction direction) {
    return direction == Direction::kRequest ? requests_ : replies_;
  }

  Lane requests_{Decoder(Direction::kRequest)};
  Lane replies_{Decoder(Direction::kReply)};
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<MessageFramer>();
}

}  // namespace virtdrive::asd7
