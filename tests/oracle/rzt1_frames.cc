// Requests and replies of the RZ/T1 protocols from a seed, each with what our decoders make of it,
// a line each:
//
//   packet aa010305 0edc05f8 packet 1 5 14 1500
//   packet aa01010860 refused 1 1
//   line 324b502035 line 2 KP 5
//   reply aa0101060e16 00dc05e1 reply 0 1500
//
// usage: virtdrive_rzt1_frames COUNT SEED
#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "devices/protocol/text.h"
#include "devices/rzt1/codec.h"
#include "tests/oracle/frames.h"

namespace virtdrive::rzt1 {
namespace {

using Bytes = std::vector<std::uint8_t>;
using protocol::Values;

constexpr std::uint8_t kMarks[] = {kStart, '\r'};

std::size_t below(RandomStream& random, std::size_t n) {
  return static_cast<std::size_t>(random.bits() % n);
}

// A request that is right.
Packet random_packet(RandomStream& random) {
  Packet packet{.address = static_cast<std::uint8_t>(random.bits())};
  packet.row = &kPackets[below(random, std::size(kPackets))];
  const auto values = [&](std::span<const Field> fields) {
    return random_values(fields, kTable.framing.order, kMarks, random);
  };
  if (packet.row->names == Names::kFunction) {
    packet.values = {kFunctions[below(random, std::size(kFunctions))].code};
  } else if (packet.row->names == Names::kParameter) {
    packet.parameter = &kParameters[below(random, std::size(kParameters))];
    packet.values = {packet.parameter->id};
    if (packet.row->reply.empty()) {
      packet.values.push(values(protocol::value_fields(*packet.parameter))[0]);
    }
  } else if (packet.row->request.data() == kPoints) {
    const std::size_t points = 1 + below(random, kMostPoints);
    packet.counted = (random.bits() & 1) != 0;
    if (packet.counted) packet.values.push(static_cast<std::int64_t>(points));
    for (std::size_t i = 0; i < points; ++i) {
      const Values point = values(kPoint);
      packet.values.push(point[0]);
      packet.values.push(point[1]);
    }
  } else {
    packet.values = values(packet.row->request);
  }
  return packet;
}

// Each fifth is not right.
void spoil(Bytes& frame, RandomStream& random) {
  const std::size_t last = frame.size() - 1;
  switch (below(random, 20)) {
    case 0:  // a bit
      frame[below(random, frame.size())] ^= static_cast<std::uint8_t>(1U << below(random, 8));
      break;
    case 1:
      frame.resize(1 + below(random, last));
      break;
    case 2:  // another code, id or size, with a sum that fits
    case 3:
      frame[last] = 0;
      frame[3 + below(random, std::min<std::size_t>(2, last - 3) + 1)] =
          static_cast<std::uint8_t>(random.bits());
      frame[last] = 0;
      for (std::size_t i = 1; i < last; ++i) {
        frame[last] = static_cast<std::uint8_t>(frame[last] + frame[i]);
      }
      break;
    default:
      break;
  }
}

std::string hex(const Bytes& bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

std::string decoded(const Bytes& bytes) {
  Decoder decoder;
  for (const std::uint8_t byte : bytes) {
    const Decoder::Event event = decoder.push(byte);
    if (event == Decoder::Event::kNone) continue;
    if (event == Decoder::Event::kBadSum) return "bad_sum";
    if (event == Decoder::Event::kLine) {
      const Line& line = decoder.line();
      if (!line.accepted) return "refused";
      const std::string_view name = line.function != nullptr    ? line.function->name
                                    : line.parameter != nullptr ? line.parameter->name
                                                                : "-";
      return fmt::format("line {} {} {}", line.axis, name,
                         line.argument ? fmt::format("{}", *line.argument) : "-");
    }
    const Packet& packet = decoder.packet();
    if (packet.status != Status::kOk) {
      return fmt::format("refused {} {}", packet.address, static_cast<int>(packet.status));
    }
    return fmt::format("packet {} {}{}", packet.address, packet.row->code, text(packet.values));
  }
  return "incomplete";
}

std::string packet_line(RandomStream& random) {
  Bytes frame = encode_request(random_packet(random));
  spoil(frame, random);
  return fmt::format("packet {} {}\n", hex(frame), decoded(frame));
}

std::string text_line(RandomStream& random) {
  constexpr std::string_view kAxesTyped[] = {"", "", "1", "2", "3", "0"};
  constexpr std::string_view kGaps[] = {"", " ", "  ", "\t", "=", " = ", "= "};
  constexpr std::string_view kNumbers[] = {"",  "5",          "-12", "+7", "0x1F", "017",  "089",
                                           "0", "4294967295", "x",   "0x", "-",    "12 3", "5  "};
  std::string typed(kAxesTyped[below(random, std::size(kAxesTyped))]);
  std::string name(below(random, 2) == 0 ? kFunctions[below(random, std::size(kFunctions))].name
                                         : kParameters[below(random, std::size(kParameters))].name);
  if (below(random, 4) == 0) std::ranges::transform(name, name.begin(), protocol::to_lower);
  if (below(random, 10) == 0) name += 'Q';
  if (below(random, 20) == 0) name.clear();
  typed += name;
  typed += kGaps[below(random, std::size(kGaps))];
  typed += kNumbers[below(random, std::size(kNumbers))];
  Bytes bytes(typed.begin(), typed.end());
  bytes.push_back('\r');
  if (below(random, 10) == 0) bytes.insert(bytes.begin(), '\n');
  return fmt::format("line {} {}\n", hex(bytes), decoded(bytes));
}

std::string reply_line(RandomStream& random) {
  Packet request = random_packet(random);
  while (request.row->reply.data() == kTrace) request = random_packet(random);
  std::vector<Field> fields(request.row->reply.begin(), request.row->reply.end());
  if (request.row->reply_by_mask) fields = protocol::masked(fields, request.values[0]);
  if (request.parameter != nullptr) {
    fields = protocol::with_value(fields, protocol::value_fields(*request.parameter));
  }
  constexpr Status kRefusals[] = {Status::kBadCode,    Status::kBadIndex,     Status::kBadSize,
                                  Status::kOutOfRange, Status::kReadOnly,     Status::kInterlock,
                                  Status::kFault,      Status::kInvalidState, Status::kOverflow,
                                  Status::kExecution,  Status::kBadSum};
  Bytes frame =
      below(random, 4) == 0
          ? encode_refusal(kRefusals[below(random, std::size(kRefusals))])
          : encode_reply(request, random_values(fields, kTable.framing.order, kMarks, random));
  if (below(random, 10) == 0) frame.back() ^= static_cast<std::uint8_t>(1U << below(random, 8));
  if (below(random, 10) == 0) frame.pop_back();
  PacketReplyDecoder decoder(request);
  std::string verdict = "incomplete";
  for (const std::uint8_t byte : frame) {
    const auto event = decoder.push(byte);
    if (event == PacketReplyDecoder::Event::kNone) continue;
    verdict =
        event == PacketReplyDecoder::Event::kBadSum
            ? "bad_sum"
            : fmt::format("reply {}{}", static_cast<int>(decoder.status()), text(decoder.values()));
    break;
  }
  return fmt::format("reply {} {} {}\n", hex(encode_request(request)), hex(frame), verdict);
}

std::string line(RandomStream& random) {
  switch (below(random, 3)) {
    case 0:
      return packet_line(random);
    case 1:
      return text_line(random);
    default:
      return reply_line(random);
  }
}

}  // namespace
}  // namespace virtdrive::rzt1

int main(int argc, char** argv) {
  return virtdrive::print_frames(argc, argv, virtdrive::rzt1::line);
}
