// Every decoder and framer takes any bytes: no crash, bounded buffers, what a decoder decodes
// encodes to what it read, and a framer's runs hold each byte once.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/check.h"
#include "devices/asd7/codec.h"
#include "devices/asd7_modbus/codec.h"
#include "devices/framers.h"
#include "devices/md485/codec.h"
#include "devices/rzt1/codec.h"
#include "devices/slcan/codec.h"
#include "devices/slcan/framer.h"
#include "devices/toshiba_mcu/codec.h"
#include "tests/devices/vectors.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

using protocol::Direction;

void toshiba_mcu_round_trip(Direction direction, std::span<const std::uint8_t> bytes) {
  toshiba_mcu::Decoder decoder(direction);
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) != toshiba_mcu::Decoder::Event::kTelegram) continue;
    const toshiba_mcu::Telegram& telegram = decoder.telegram();
    const auto again = direction == Direction::kRequest
                           ? toshiba_mcu::encode_request(*telegram.row, telegram.values)
                           : toshiba_mcu::encode_reply(*telegram.row, telegram.values);
    VIRTDRIVE_CHECK(std::ranges::equal(again, decoder.bytes()), "{}", telegram.row->name);
  }
}

void md485_rescans(Direction direction, std::span<const std::uint8_t> bytes) {
  md485::Decoder decoder(direction);
  for (const std::uint8_t byte : bytes) {
    for (auto event = decoder.push(byte); event != md485::Decoder::Event::kNone;) {
      event = decoder.next();
    }
  }
  for (auto event = decoder.expire(); event != md485::Decoder::Event::kNone;)
    event = decoder.next();
}

// What is a message encodes to what was read, but for data that were shorter than they may be and
// the case of hexadecimal digits.
void asd7_round_trip(bool ascii_wide, std::span<const std::uint8_t> bytes) {
  asd7::Decoder decoder(Direction::kRequest, ascii_wide);
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) != asd7::Decoder::Event::kMessage) continue;
    const asd7::Message& message = decoder.message();
    if (message.error || asd7::is_ascii(message.format)) continue;
    const auto again = asd7::encode_request(message);
    VIRTDRIVE_CHECK(std::ranges::equal(again, decoder.bytes()), "{}", message.row->name);
  }
}

void modbus_round_trip(Direction direction, std::span<const std::uint8_t> bytes) {
  using namespace asd7_modbus;
  Frame frame;
  expected_size(direction, bytes);
  if (decode(direction, bytes, frame) != FrameError::kNone || !frame.values) return;
  const auto again = direction == Direction::kRequest
                         ? encode_request(frame.unit, *frame.row, *frame.values)
                         : encode_reply(frame.unit, *frame.row, *frame.values);
  VIRTDRIVE_CHECK(std::ranges::equal(again, bytes), "{}", frame.row->name);
}

// What is understood is written the same way again, but for the case of its digits.
void slcan_round_trip(std::span<const std::uint8_t> bytes) {
  slcan::Decoder decoder;
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) != slcan::Decoder::Event::kLine) continue;
    const auto line = slcan::parse(decoder.line());
    if (!line || line->command->when != slcan::When::kSending) continue;
    const auto again = slcan::parse(slcan::text_of(line->frame));
    VIRTDRIVE_CHECK(again && again->frame == line->frame, "{}", decoder.line());
  }
}

void rzt1_round_trip(std::span<const std::uint8_t> bytes) {
  rzt1::Decoder decoder;
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) != rzt1::Decoder::Event::kPacket) continue;
    const rzt1::Packet& packet = decoder.packet();
    if (packet.status != rzt1::Status::kOk) continue;
    VIRTDRIVE_CHECK(std::ranges::equal(rzt1::encode_request(packet), decoder.bytes()), "{}",
                    packet.row->name);
  }
}

template <class Decoder>
void push_all(Decoder decoder, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) decoder.push(byte);
}

// The first bit of each byte's predecessor tells whose the byte is.
void frames_each_byte_once(std::string_view protocol, std::span<const std::uint8_t> bytes) {
  const auto framer = make_framer(protocol);
  std::size_t held[2] = {};
  std::uint8_t before = 0;
  std::vector<protocol::Run> runs;
  const auto take_runs = [&](std::size_t& lane) {
    for (const protocol::Run& run : runs) {
      VIRTDRIVE_CHECK(run.size > 0 && run.size <= lane, "{}: {} of {}", protocol, run.size, lane);
      lane -= run.size;
    }
    VIRTDRIVE_CHECK(lane <= protocol::Framer::kMostHeld, "{}: holds {}", protocol, lane);
    runs.clear();
  };
  for (const std::uint8_t byte : bytes) {
    const Direction direction = (before & 1) != 0 ? Direction::kReply : Direction::kRequest;
    std::size_t& lane = held[static_cast<std::size_t>(direction)];
    ++lane;
    framer->push(direction, byte, runs);
    take_runs(lane);
    before = byte;
  }
  for (const Direction direction : {Direction::kRequest, Direction::kReply}) {
    std::size_t& lane = held[static_cast<std::size_t>(direction)];
    framer->expire(direction, runs);
    take_runs(lane);
    VIRTDRIVE_CHECK(lane == 0, "{}: {} bytes in no run", protocol, lane);
  }
}

void decode(std::span<const std::uint8_t> bytes) {
  for (const Direction direction : {Direction::kRequest, Direction::kReply}) {
    toshiba_mcu_round_trip(direction, bytes);
    md485_rescans(direction, bytes);
    push_all(asd7::Decoder(direction), bytes);
    modbus_round_trip(direction, bytes);
  }
  asd7_round_trip(false, bytes);
  asd7_round_trip(true, bytes);
  rzt1_round_trip(bytes);
  slcan_round_trip(bytes);
  push_all(rzt1::LineReplyDecoder(), bytes);
  for (const std::string_view protocol :
       {toshiba_mcu::kTable.name, md485::kTable.name, rzt1::kTable.name, asd7::kTable.name,
        asd7_modbus::kTable.name, slcan::kName}) {
    frames_each_byte_once(protocol, bytes);
  }
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  std::vector<std::vector<std::uint8_t>> seeds;
  for (const char* file : {"vectors_toshiba_mcu.csv", "vectors_rzt1.csv", "vectors_md485.csv",
                           "vectors_asd7.csv", "vectors_asd7_modbus.csv"}) {
    for (const Vector& vector : read_vectors(file)) seeds.push_back(vector.bytes);
  }
  for (const std::string_view line :
       {"S5\rO\r", "T00B7AC01382E803\r", "t7FF81122334455667788\r", "R1FFFFFFF8\rF\rC\r"}) {
    seeds.emplace_back(line.begin(), line.end());
  }
  return seeds;
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  virtdrive::decode({data, size});
  return 0;
}
