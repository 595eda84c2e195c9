// Telegrams of MCU Motor Studio from a seed, each with what our decoder makes of it, a line each:
//
//   request 1100010713 telegram 0 1
//   reply 11ee01 ... bad_crc
//
// usage: virtdrive_oracle_frames COUNT SEED
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <string_view>

#include "core/random.h"
#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Values;

// Half of the bytes are such as sit on an edge: signs, starts and ends in the payload.
std::uint8_t random_byte(RandomStream& random) {
  constexpr std::uint8_t kEdges[] = {0x00, 0x01, 0x7F, 0x80, 0xFE, 0xFF, kBot, kEot};
  const std::uint64_t bits = random.bits();
  return (bits & 0x100) != 0 ? kEdges[bits % std::size(kEdges)] : static_cast<std::uint8_t>(bits);
}

Values random_values(std::span<const Field> fields, RandomStream& random) {
  Bytes bytes(protocol::width(fields));
  for (std::uint8_t& byte : bytes) byte = random_byte(random);
  return protocol::unpack(fields, kTable.framing.order, bytes);
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
    std::string text = fmt::format("telegram {}", telegram.row->code);
    for (std::size_t i = 0; i < telegram.values.size(); ++i) {
      text += fmt::format(" {}", telegram.values[i]);
    }
    return text;
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

bool parse(std::string_view text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu

int main(int argc, char** argv) {
  std::uint64_t count = 0;
  std::uint64_t seed = 0;
  if (argc != 3 || !virtdrive::toshiba_mcu::parse(argv[1], count) ||
      !virtdrive::toshiba_mcu::parse(argv[2], seed)) {
    fmt::print(stderr, "usage: virtdrive_oracle_frames COUNT SEED\n");
    return 2;
  }
  virtdrive::RandomStream random = virtdrive::Seed{seed}.stream("frames");
  for (std::uint64_t i = 0; i < count; ++i) {
    fmt::print("{}", virtdrive::toshiba_mcu::line(random));
  }
}
