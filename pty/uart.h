// What a UART makes of the level of a wire.
//
//   idle ‾‾‾‾\__start__/ d0 X d1 X ... X d7 X parity /‾stop‾‾‾
//            ^ edge      ^ sampled in the middle of each bit
//
// It waits for a falling edge, samples in the middle of each of its own bits, and after a low stop
// bit waits for a high line. A start bit that is over before its middle is noise.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "core/sim_time.h"
#include "pty/line_settings.h"

namespace virtdrive {

/// Who drives a wire: devices have their numbers, from 0.
inline constexpr int kHostTalker = -1;
inline constexpr int kNoTalker = -2;  // noise, or wires that are held at a level

/// The level of a wire over time: high, as when nobody talks, until told otherwise.
class Levels {
 public:
  /// From `t` on, which is not before the last one. `talker` is who drives it.
  void append(SimTime t, bool high, int talker = kNoTalker);
  bool high_at(SimTime t) const;
  int talker_at(SimTime t) const;
  bool high() const { return changes_.empty() ? high_before_ : changes_.back().high; }

  struct Fall {
    SimTime time = kNever;
    int talker = kNoTalker;
  };
  /// The first fall from high to low after `t`; kNever if none is known.
  Fall next_fall(SimTime t) const;

  void forget_before(SimTime t);
  void clear();

 private:
  struct Change {
    SimTime time;
    bool high;
    int talker;
  };
  std::deque<Change>::const_iterator after(SimTime t) const;

  bool high_before_ = true;  // the first change
  std::deque<Change> changes_;
};

/// A byte on a wire, as a receiver reads it.
struct WireByte {
  std::uint8_t byte = 0;
  SimTime begin = kSimStart;  // of its start bit
  SimTime end = kSimStart;    // of its first stop bit; where the talker is understood, of the last
  bool error = false;         // stop bit low or parity wrong
  int talker = kNoTalker;     // who made the falling edge
  bool collided = false;      // several drove the wires meanwhile

  friend bool operator==(const WireByte&, const WireByte&) = default;
};

class Uart {
 public:
  /// Begins anew at `t`; a level that is low then is taken for a start bit.
  void listen_from(SimTime t);
  /// The next character that is complete at `until`, up to which the levels must be known.
  std::optional<WireByte> read(const Levels& levels, const LineSettings& settings, SimTime until);
  /// When the character that has begun will be complete; kNever if none has.
  SimTime due(const Levels& levels, const LineSettings& settings) const;
  /// Levels before that do not matter any more.
  SimTime from() const { return from_; }

 private:
  Levels::Fall start(const Levels& levels) const;

  SimTime from_ = kSimStart;
  bool anew_ = true;
};

/// How long a receiver is busy with a character: up to the end of its first stop bit. An ideal line
/// makes no difference.
SimDuration reading_time(const LineSettings& settings);

/// What is said: the level of each bit time of a character; bit 0 is the start bit, the last ones
/// are stop bits.
std::uint16_t character_levels(std::uint8_t byte, const LineSettings& settings,
                               bool wrong_parity = false);

/// What a UART set as `listener` makes of a burst that starts at kSimStart, sent by one set as
/// `sender`, on a line that is idle before and after. Baud rates up to about 5 % apart give the
/// bytes back unchanged.
std::vector<WireByte> resample(std::span<const std::uint8_t> bytes, const LineSettings& sender,
                               const LineSettings& listener);

}  // namespace virtdrive
