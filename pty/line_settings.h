// How an end of a serial line is set: what a character looks like and how long it takes.
#pragma once

#include <cstdint>
#include <optional>

#include "core/sim_time.h"
#include "devices/serial_port.h"

namespace virtdrive {

enum class LineTiming : std::uint8_t { kReal, kIdeal };  // kIdeal: no character times

struct LineSettings {
  LineTiming timing = LineTiming::kReal;
  int baud = 115200;  // bit/s, > 0
  int data_bits = 8;  // 5..8
  Parity parity = Parity::kNone;
  int stop_bits = 1;  // 1 or 2

  /// Bit times from start to stop bit: 10 for 8N1.
  int character_bits() const {
    return 1 + data_bits + (parity == Parity::kNone ? 0 : 1) + stop_bits;
  }
  /// How long `count` characters take, rounded down to 1 ns; 0 on an ideal line.
  SimDuration time_of(std::int64_t count) const;
  SimDuration character_time() const { return time_of(1); }

  friend bool operator==(const LineSettings&, const LineSettings&) = default;
};

/// What the host has set its own end to; 0 or nothing: the same as the line. A pseudo-terminal lets
/// only the first two be seen, RFC 2217 all of them.
struct HostSettings {
  int baud = 0;
  int stop_bits = 0;
  int data_bits = 0;
  std::optional<Parity> parity = std::nullopt;

  friend bool operator==(const HostSettings&, const HostSettings&) = default;
};

/// Baud rates this close are taken as equal: crystals and divisors differ by that much.
inline constexpr double kBaudTolerance = 0.03;

/// Whether what one says is what the other hears. Stop bits do not matter: a receiver looks at the
/// first one only.
bool understand_each_other(const LineSettings& a, const LineSettings& b);

}  // namespace virtdrive
