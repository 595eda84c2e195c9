// What can be wrong with a line, in one direction. All of it comes from a seeded stream: the same
// seed and the same traffic give the same faults.
#pragma once

#include <cstdint>

#include "core/sim_time.h"

namespace virtdrive {

/// On a two-wire line the direction is that of who talks: the host, or a device.
enum class LineDirection : std::uint8_t { kToDevices, kToHost };

enum class LineStuck : std::uint8_t { kNo, kLow, kHigh };

struct LineFaults {
  // Probabilities (0 to 1), drawn for each byte as it is handed to the line.
  double lost = 0;        // its character time passes in silence
  double flipped = 0;     // one data or parity bit, chosen at random
  double duplicated = 0;  // heard twice; what follows is later by a character
  double delayed = 0;     // begins later by `delay`, and so does what follows
  SimDuration delay{};

  double noise_per_s = 0;            // characters of noise per second while nobody talks, >= 0
  LineStuck stuck = LineStuck::kNo;  // the wires are held at a level, whoever talks
  bool cut = false;                  // nothing that is said gets anywhere

  friend bool operator==(const LineFaults&, const LineFaults&) = default;
};

}  // namespace virtdrive
