// Frames of the MD protocol from a seed, each with what our decoder makes of it, a line each:
//
//   request b7ac018202e8032d frame 172 1 130 1000
//   reply acb701... bad_sum
//
// usage: virtdrive_md485_frames COUNT SEED
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "core/random.h"
#include "devices/md485/codec.h"
#include "devices/md485/model_table.h"

namespace virtdrive::md485 {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Values;

constexpr std::uint8_t kHosts[] = {172, 184, 128};

// Half of the bytes sit on an edge: signs, and what begins a frame.
std::uint8_t random_byte(RandomStream& random) {
  constexpr std::uint8_t kEdges[] = {0x00, 0x01, 0x7F, 0x80, 0xFE, 0xFF, kController, kHost};
  const std::uint64_t bits = random.bits();
  return (bits & 0x100) != 0 ? kEdges[bits % std::size(kEdges)] : static_cast<std::uint8_t>(bits);
}

Values random_values(std::span<const Field> fields, RandomStream& random) {
  Bytes bytes(protocol::width(fields));
  for (std::uint8_t& byte : bytes) byte = random_byte(random);
  return protocol::unpack(fields, kTable.framing.order, bytes);
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
    std::string text = fmt::format("frame {} {} {}", got.route.host, got.route.id, got.pid);
    for (std::size_t i = 0; i < got.values.size(); ++i) text += fmt::format(" {}", got.values[i]);
    return text;
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

bool parse(std::string_view text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace
}  // namespace virtdrive::md485

int main(int argc, char** argv) {
  std::uint64_t count = 0;
  std::uint64_t seed = 0;
  if (argc != 3 || !virtdrive::md485::parse(argv[1], count) ||
      !virtdrive::md485::parse(argv[2], seed)) {
    fmt::print(stderr, "usage: virtdrive_md485_frames COUNT SEED\n");
    return 2;
  }
  virtdrive::RandomStream random = virtdrive::Seed{seed}.stream("frames");
  for (std::uint64_t i = 0; i < count; ++i) fmt::print("{}", virtdrive::md485::line(random));
}
