// Telegrams of MCU Motor Studio: 11 command payload CRC8 13, no length byte, no escaping.
//
// Both ends know a payload's length from the command and the direction: the tables tell it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/protocol/payload.h"
#include "devices/toshiba_mcu/table.h"

namespace virtdrive::toshiba_mcu {

/// Polynomial 0x07, not reflected; `start` is the command, the bytes are the payload (chapter 6).
std::uint8_t crc8(std::uint8_t start, std::span<const std::uint8_t> payload);

struct Telegram {
  const CommandRow* row = nullptr;
  protocol::Values values;
};

std::vector<std::uint8_t> encode_request(const CommandRow& row, const protocol::Values& values);
std::vector<std::uint8_t> encode_reply(const CommandRow& row, const protocol::Values& values);

using protocol::Direction;

/// A receiver as the firmware's: one byte at a time, no time-out, no look-ahead.
///
///   idle -> command -> payload -> crc -> end -> idle
///
/// An unknown command brings it back to idle. A telegram that is cut short swallows the bytes of
/// the next one as its own.
class Decoder {
 public:
  enum class Event : std::uint8_t {
    kNone,   // in the middle of a telegram
    kNoise,  // a byte outside of a telegram
    kUnknownCommand,
    kTelegram,  // complete: see telegram()
    kBadCrc,
    kBadEnd,
  };

  explicit Decoder(Direction direction) : direction_(direction) {}

  Event push(std::uint8_t byte);
  /// The last complete telegram.
  const Telegram& telegram() const { return telegram_; }
  /// The bytes of the telegram under way, or of the last one ended.
  std::span<const std::uint8_t> bytes() const { return std::span(buffer_).first(size_); }
  bool idle() const { return row_ == nullptr && !started_; }
  void reset();

 private:
  std::span<const Field> fields() const;

  Direction direction_;
  const CommandRow* row_ = nullptr;
  bool started_ = false;
  std::array<std::uint8_t, kTable.framing.longest> buffer_{};
  std::size_t size_ = 0;
  Telegram telegram_;
};

}  // namespace virtdrive::toshiba_mcu
