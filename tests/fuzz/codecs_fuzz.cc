// Every decoder takes any bytes: no crash, bounded buffers, and what it decodes encodes to what it
// read.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/check.h"
#include "devices/asd7/codec.h"
#include "devices/md485/codec.h"
#include "devices/rzt1/codec.h"
#include "devices/toshiba_mcu/codec.h"

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

template <class Decoder>
void push_all(Decoder decoder, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) decoder.push(byte);
}

void decode(std::span<const std::uint8_t> bytes) {
  for (const Direction direction : {Direction::kRequest, Direction::kReply}) {
    toshiba_mcu_round_trip(direction, bytes);
    md485_rescans(direction, bytes);
    push_all(asd7::Decoder(direction), bytes);
  }
  push_all(rzt1::Decoder(), bytes);
  push_all(rzt1::LineReplyDecoder(), bytes);
}

}  // namespace
}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  virtdrive::decode({data, size});
  return 0;
}
