// The words of a CAN adapter on a serial port in ASCII (SLCAN), as the Lawicel CANUSB has them:
// a letter, hexadecimal digits, CR. Source: CANUSB manual, LAWICEL AB; section numbers are its
// chapter on commands. Linux's slcand and python-can's slcan speak a part of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace virtdrive::slcan {

inline constexpr std::uint8_t kOk = 0x0D;     // CR; ends a command as well
inline constexpr std::uint8_t kError = 0x07;  // BELL

/// Characters before the CR: T, eight digits, a length, sixteen digits.
inline constexpr std::size_t kLongest = 1 + 8 + 1 + 16;

/// In which state of the channel a command is taken.
enum class When : std::uint8_t { kAlways, kClosed, kOpen, kSending };

struct Command {
  char letter;
  std::size_t digits;  // behind the letter; of a frame: those of its identifier
  When when;
  std::string_view doc;  // one line
};

// clang-format off
inline constexpr Command kCommands[] = {
    {'S', 1, When::kClosed,  "Bit rate: 0..8 for 10, 20, 50, 100, 125, 250, 500, 800 kbit/s, 1 Mbit/s"},
    {'s', 4, When::kClosed,  "Bit rate by the SJA1000's BTR0 and BTR1 at 16 MHz"},
    {'O', 0, When::kClosed,  "Opens the channel, once a bit rate is set"},
    {'L', 0, When::kClosed,  "Opens it to listen only"},
    {'C', 0, When::kOpen,    "Closes it"},
    {'t', 3, When::kSending, "Sends a standard frame: tiiiLDD..; answered with z"},
    {'T', 8, When::kSending, "Sends an extended frame: TiiiiiiiiLDD..; answered with Z"},
    {'r', 3, When::kSending, "Sends a standard remote frame"},
    {'R', 8, When::kSending, "Sends an extended remote frame"},
    {'F', 0, When::kOpen,    "Status flags: Fxx"},
    {'M', 8, When::kClosed,  "Acceptance code, AC0 to AC3 of the SJA1000 with two filters"},
    {'m', 8, When::kClosed,  "Acceptance mask: bits that are 1 do not matter"},
    {'V', 0, When::kAlways,  "Version of hardware and software: Vhhss"},
    {'N', 0, When::kAlways,  "Serial number: Nxxxx"},
    {'Z', 1, When::kClosed,  "1: frames are followed by four digits of milliseconds, up to EA5F"},
};
// clang-format on

/// Of command S.
inline constexpr std::array kBitRates = {10'000,  20'000,  50'000,  100'000,  125'000,
                                         250'000, 500'000, 800'000, 1'000'000};

/// Bits of the status flags. Full queues and lost frames are none of them here: what a program
/// sends faster than the bus takes it is refused, and what it does not read is the terminal's loss.
enum Flag : std::uint8_t {
  kErrorWarning = 1 << 2,
  kErrorPassive = 1 << 5,
  kBusError = 1 << 7,  // bus off
};

}  // namespace virtdrive::slcan
