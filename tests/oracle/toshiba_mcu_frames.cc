// Telegrams of MCU Motor Studio from a seed, each with what our decoder makes of it, a line each:
//
//   request 1100010713 telegram 0 1
//   reply 11ee01 ... bad_crc
//
// usage: virtdrive_toshiba_mcu_frames COUNT SEED
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <string_view>

#include "devices/toshiba_mcu/codec.h"
#include "tests/oracle/frames.h"

namespace virtdrive::toshiba_mcu {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Values;

constexpr std::uint8_t kMarks[] = {kBot, kEot};

Values random_values(std::span<const Field> fields, RandomStream& random) {
  return virtdrive::random_values(fields, kTable.framing.order, kMarks, random);
}

// Each tenth frame is spoilt in one of five ways.
void spoil(Bytes& frame, RandomStream& random) {
  const std::uint64_t bits = random.bits();
  const auto flip = static_cast<std::uint8_t>(1U << (bits >> 8) % 8);
  switch (bits % 50) {
    case 0:
      *(frame.end() - 2) ^= flip;  // the CRC
      break;
    case 1:
      frame.back() ^= flip;
      break;
    case 2:
      frame[2 + (bits >> 16) % (frame.size() - 4)] ^= flip;  // the payload
      break;
    case 3:
      frame[1] = static_cast<std::uint8_t>(bits >> 16);  // any command, most of them unknown
      break;
    case 4:
      frame.resize(1 + (bits >> 16) % (frame.size() - 1));
      break;
    default:
      break;
  }
}

// The verdict on the first telegram of the frame.
std::string decoded(Direction direction, const Bytes& frame) {
  using Event = Decoder::Event;
  Decoder decoder(direction);
  for (const std::uint8_t byte : frame) {
    switch (decoder.push(byte)) {
      case Event::kNone:
        continue;
      case Event::kNoise:
        return "noise";
      case Event::kUnknownCommand:
        return "unknown_command";
      case Event::kBadCrc:
        return "bad_crc";
      case Event::kBadEnd:
        return "bad_end";
      case Event::kTelegram:
        break;
    }
    const Telegram& telegram = decoder.telegram();
    return fmt::format("telegram {}{}", telegram.row->code, text(telegram.values));
  }
  return "incomplete";
}

std::string line(RandomStream& random) {
  constexpr std::size_t kRows = std::size(kCommands);
  const bool request = (random.bits() & 1) != 0;
  const std::size_t choice = random.bits() % (kRows + (request ? 0 : 1));
  const CommandRow& row = choice < kRows ? kCommands[choice] : kErrorReply;
  Bytes frame = request ? encode_request(row, random_values(row.request, random))
                        : encode_reply(row, random_values(row.reply, random));
  spoil(frame, random);
  return fmt::format("{} {:02x} {}\n", request ? "request" : "reply", fmt::join(frame, ""),
                     decoded(request ? Direction::kRequest : Direction::kReply, frame));
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu

int main(int argc, char** argv) {
  return virtdrive::print_frames(argc, argv, virtdrive::toshiba_mcu::line);
}
