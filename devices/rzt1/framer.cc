#include "devices/rzt1/framer.h"

#include <fmt/format.h>
#include <utility>
#include <variant>

#include "devices/rzt1/codec.h"

namespace virtdrive::rzt1 {
namespace {

using protocol::Direction;
using protocol::Run;
using protocol::Verdict;

// What a packet or a line is about: its command's name and, where it has one, its object's.
std::string text(const Packet& packet) {
  if (packet.row == nullptr) return "unknown code";
  std::string text(packet.row->name);
  if (packet.function != nullptr) text += fmt::format(" {}", packet.function->name);
  if (packet.parameter != nullptr) text += fmt::format(" {}", packet.parameter->name);
  return text;
}

std::string printable(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += byte >= ' ' && byte <= '~' ? static_cast<char>(byte) : '.';
  }
  return text;
}

class TwoWayFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    if (direction == Direction::kRequest)
      push_request(byte, ended);
    else
      push_reply(byte, ended);
  }

  void expire(Direction direction, std::vector<Run>& ended) override {
    const bool request = direction == Direction::kRequest;
    end(request ? request_held_ : reply_held_, Verdict::kCutShort, "cut short", ended);
    if (request)
      requests_.reset();
    else
      awaited_ = {};
  }

  SimDuration silence() const override { return kTable.framing.silence; }

 private:
  void push_request(std::uint8_t byte, std::vector<Run>& ended) {
    using Event = Decoder::Event;
    ++request_held_;
    switch (requests_.push(byte)) {
      case Event::kNone: {
        // A line feed, a line that a packet's start cut off, or what is too much of a long line.
        const std::size_t pending = requests_.idle() ? 0 : requests_.bytes().size();
        const std::size_t dropped = request_held_ - pending;
        if (dropped > 0)
          ended.push_back({dropped, Verdict::kNoise, "outside of packets and lines"});
        request_held_ = pending;
        return;
      }
      case Event::kLine:
        end(request_held_, requests_.line().accepted ? Verdict::kFrame : Verdict::kMalformed,
            printable(requests_.bytes()), ended);
        await(LineReplyDecoder());
        return;
      case Event::kPacket: {
        const Packet& packet = requests_.packet();
        const bool good = packet.status == Status::kOk;
        end(request_held_, good ? Verdict::kFrame : Verdict::kMalformed, text(packet), ended);
        await(PacketReplyDecoder(good ? packet : refused()));
        return;
      }
      case Event::kBadSum:
        end(request_held_, Verdict::kBadChecksum, "wrong sum", ended);
        await(PacketReplyDecoder(refused()));
        return;
    }
  }

  void push_reply(std::uint8_t byte, std::vector<Run>& ended) {
    ++reply_held_;
    if (auto* packet = std::get_if<PacketReplyDecoder>(&awaited_)) {
      push_packet_reply(*packet, byte, ended);
    } else if (auto* line = std::get_if<LineReplyDecoder>(&awaited_)) {
      push_line_reply(*line, byte, ended);
    } else {
      end(reply_held_, Verdict::kNoise, "nobody asked", ended);
    }
  }

  void push_packet_reply(PacketReplyDecoder& decoder, std::uint8_t byte, std::vector<Run>& ended) {
    using Event = PacketReplyDecoder::Event;
    const Event event = decoder.push(byte);
    if (event == Event::kNone) {
      // A recorder's buffer is longer than what may be held.
      if (reply_held_ == kMostHeld) end(reply_held_, Verdict::kFrame, "samples", ended);
      return;
    }
    const auto status = static_cast<unsigned>(decoder.status());
    if (event == Event::kReply)
      end(reply_held_, Verdict::kFrame, fmt::format("status={}", status), ended);
    else
      end(reply_held_, Verdict::kBadChecksum, "wrong sum", ended);
    awaited_ = {};
  }

  void push_line_reply(LineReplyDecoder& decoder, std::uint8_t byte, std::vector<Run>& ended) {
    using Event = LineReplyDecoder::Event;
    switch (decoder.push(byte)) {
      case Event::kNone:
        if (reply_held_ == kMostHeld) end(reply_held_, Verdict::kMalformed, "line too long", ended);
        return;
      case Event::kText:
        return end(reply_held_, Verdict::kFrame, std::string(decoder.text()), ended);
      case Event::kAccepted:
        return end(reply_held_, Verdict::kFrame, "accepted", ended);
      case Event::kRefused:
        return end(reply_held_, Verdict::kFrame, "refused", ended);
    }
  }

  // A reply without data is all that a packet that cannot be taken gets.
  static Packet refused() { return {.row = &kTable.commands.front()}; }

  // What was still awaited will not come any more.
  void await(std::variant<std::monostate, PacketReplyDecoder, LineReplyDecoder> next) {
    if (reply_held_ == 0) awaited_ = std::move(next);
  }

  static void end(std::size_t& held, Verdict verdict, std::string text, std::vector<Run>& ended) {
    if (held > 0) ended.push_back({std::exchange(held, 0), verdict, std::move(text)});
  }

  Decoder requests_;
  std::variant<std::monostate, PacketReplyDecoder, LineReplyDecoder> awaited_;
  std::size_t request_held_ = 0;
  std::size_t reply_held_ = 0;
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<TwoWayFramer>();
}

}  // namespace virtdrive::rzt1
