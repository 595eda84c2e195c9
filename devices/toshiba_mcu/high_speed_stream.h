// The high-speed oscilloscope's frames on the second serial line (4.2.8), 5 Mbit/s 8N1:
//
//   11 | CRC8 of all that follows, start 0 | missed frames, u8 | PWM periods, u16 | values, i16 ...
//
// No end byte, all little-endian. A frame that is due while the one before is still leaving is lost
// and counted: at 12.5 kHz the line carries 17 signals of each period. The document's formula for
// the last byte takes missed values off the frame; the maker's published firmware does not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/event_loop.h"
#include "devices/serial_port.h"

namespace virtdrive::toshiba_mcu {

/// Of the second line.
inline constexpr int kStreamBaud = 5'000'000;

std::vector<std::uint8_t> encode_stream_frame(std::uint8_t missed, std::uint16_t timestamp,
                                              std::span<const std::int16_t> values);

class HighSpeedStream {
 public:
  HighSpeedStream(const EventLoop& loop, SerialPort& port) : loop_(loop), port_(port) {}

  void send(std::uint16_t timestamp, std::span<const std::int16_t> values);

  std::uint64_t frames() const { return frames_; }
  std::uint64_t missed() const { return all_missed_; }

 private:
  const EventLoop& loop_;
  SerialPort& port_;
  SimTime free_ = kSimStart;  // when the frame on its way is out
  std::uint8_t missed_ = 0;   // since the last frame; stays at 255
  std::uint64_t frames_ = 0;
  std::uint64_t all_missed_ = 0;
};

}  // namespace virtdrive::toshiba_mcu
