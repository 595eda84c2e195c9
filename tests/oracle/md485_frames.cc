// Frames of the MD protocol from a seed, each with what our decoder makes of it, a line each:
//
//   request b7ac018202e8032d frame 172 1 130 1000
//   reply acb701... bad_sum
//
// usage: virtdrive_md485_frames COUNT SEED
#include <cstring>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "devices/md485/codec.h"
#include "devices/md485/model_table.h"
#include "tests/oracle/frames.h"

namespace virtdrive::md485 {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Values;

constexpr std::uint8_t kHosts[] = {172, 184, 128};

constexpr std::uint8_t kMarks[] = {kController, kHost};

Values random_values(std::span<const Field> fields, RandomStream& random) {
  return virtdrive::random_values(fields, kTable.framing.order, kMarks, random);
}

// Each tenth frame is spoilt in one of three ways.
void spoil(Bytes& frame, RandomStream& random) {
  const std::uint64_t bits = random.bits();
  switch (bits % 30) {
    case 0:
      frame.back() ^= static_cast<std::uint8_t>(1U << (bits >> 8) % 8);
      break;
    case 1:
      frame[5 % frame.size()] ^= static_cast<std::uint8_t>(1U << (bits >> 8) % 8);
      break;
    case 2:
      frame.resize(1 + (bits >> 16) % (frame.size() - 1));
      break;
    default:
      break;
  }
}

// The verdict on the first frame.
std::string decoded(protocol::Direction direction, std::uint8_t host, const Bytes& frame) {
  using Event = Decoder::Event;
  Decoder decoder(direction, host);
  for (const std::uint8_t byte : frame) {
    switch (decoder.push(byte)) {
      case Event::kNone:
        continue;
      case Event::kNoise:
        return "noise";
      case Event::kUnknownPid:
        return "unknown_pid";
      case Event::kTooShort:
        return "too_short";
      case Event::kBadSum:
        return "bad_sum";
      case Event::kFrame:
        break;
    }
    const Frame& got = decoder.frame();
    return fmt::format("frame {} {} {}{}", got.route.host, got.route.id, got.pid, text(got.values));
  }
  return "incomplete";
}

std::string line(RandomStream& random) {
  const bool request = (random.bits() & 1) != 0;
  const Route route{.host = kHosts[random.bits() % std::size(kHosts)],
                    .id = static_cast<std::uint8_t>(random.bits())};
  Bytes frame;
  if (request && (random.bits() & 1) != 0) {
    const CommandRow& row = kCommands[random.bits() % std::size(kCommands)];
    frame = encode_request(route, row, random_values(row.request, random));
  } else {
    const ParameterRow& row = kParameters[random.bits() % std::size(kParameters)];
    frame = request ? encode_request(route, row, random_values(write_fields(row), random))
                    : encode_reply(route, row, random_values(protocol::value_fields(row), random));
  }
  spoil(frame, random);
  const auto direction = request ? protocol::Direction::kRequest : protocol::Direction::kReply;
  return fmt::format("{} {:02x} {}\n", request ? "request" : "reply", fmt::join(frame, ""),
                     decoded(direction, route.host, frame));
}

}  // namespace
}  // namespace virtdrive::md485

int main(int argc, char** argv) {
  return virtdrive::print_frames(argc, argv, virtdrive::md485::line);
}
