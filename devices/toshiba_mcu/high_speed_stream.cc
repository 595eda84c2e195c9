#include "devices/toshiba_mcu/high_speed_stream.h"

#include <utility>

#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {
namespace {

constexpr std::size_t kChecked = 2;  // the first byte that the CRC covers

}  // namespace

std::vector<std::uint8_t> encode_stream_frame(std::uint8_t missed, std::uint16_t timestamp,
                                              std::span<const std::int16_t> values) {
  std::vector<std::uint8_t> frame = {kBot, 0, missed};
  const auto push = [&](std::uint16_t word) {
    frame.push_back(static_cast<std::uint8_t>(word));
    frame.push_back(static_cast<std::uint8_t>(word >> 8));
  };
  push(timestamp);
  for (const std::int16_t value : values) push(static_cast<std::uint16_t>(value));
  frame[1] = crc8(0, std::span(frame).subspan(kChecked));
  return frame;
}

void HighSpeedStream::send(std::uint16_t timestamp, std::span<const std::int16_t> values) {
  if (loop_.now() < free_) {
    if (missed_ < 0xFF) ++missed_;
    ++all_missed_;
    return;
  }
  free_ = port_.send(encode_stream_frame(std::exchange(missed_, 0), timestamp, values));
  ++frames_;
}

}  // namespace virtdrive::toshiba_mcu
