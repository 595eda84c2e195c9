#include "devices/toshiba_mcu/framer.h"

#include <fmt/format.h>

#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {
namespace {

using protocol::Run;
using protocol::Verdict;

class TelegramFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    using Event = Decoder::Event;
    Decoder& decoder = this->decoder(direction);
    const Event event = decoder.push(byte);
    const std::size_t size = decoder.bytes().size();
    switch (event) {
      case Event::kNone:
        return;
      case Event::kNoise:
        return ended.push_back({1, Verdict::kNoise, "outside of a telegram"});
      case Event::kUnknownCommand:
        return ended.push_back({size, Verdict::kMalformed, "unknown command"});
      case Event::kBadEnd:
        return ended.push_back({size, Verdict::kMalformed, "wrong end byte"});
      case Event::kBadCrc:
        return ended.push_back({size, Verdict::kBadChecksum, "wrong CRC"});
      case Event::kTelegram:
        return ended.push_back({size, Verdict::kFrame, text(direction, decoder.telegram())});
    }
  }

  void expire(Direction direction, std::vector<Run>& ended) override {
    Decoder& decoder = this->decoder(direction);
    if (decoder.idle()) return;
    ended.push_back({decoder.bytes().size(), Verdict::kCutShort, "cut short"});
    decoder.reset();
  }

  SimDuration silence() const override { return kTable.framing.silence; }

 private:
  static std::string text(Direction direction, const Telegram& telegram) {
    const CommandRow& row = *telegram.row;
    return fmt::format(
        "{} {}", row.name,
        protocol::describe(direction == Direction::kRequest ? row.request : row.reply,
                           telegram.values));
  }

  Decoder& decoder(Direction direction) {
    return direction == Direction::kRequest ? requests_ : replies_;
  }

  Decoder requests_{Direction::kRequest};
  Decoder replies_{Direction::kReply};
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<TelegramFramer>();
}

}  // namespace virtdrive::toshiba_mcu
