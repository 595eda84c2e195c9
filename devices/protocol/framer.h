// Cuts what passes on a wire into frames, as an analyser beside the line sees it: both directions
// of one protocol, byte by byte, with the protocol's own decoders.
//
//   framer->push(Direction::kRequest, byte, runs);   // runs: what ended with this byte
//
// Each byte of a direction ends up in exactly one run, in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/sim_time.h"
#include "devices/protocol/table.h"

namespace virtdrive::protocol {

enum class Verdict : std::uint8_t {
  kFrame,
  kBadChecksum,
  kMalformed,  // begins as a frame and is none: end byte, unknown command, digits
  kNoise,      // outside of any frame
  kCutShort,   // the line fell silent in the middle of a frame, or the recording ended
};

struct Run {
  std::size_t size = 0;  // bytes, > 0
  Verdict verdict = Verdict::kFrame;
  std::string text;  // decoded, or what is wrong
};

class Framer {
 public:
  /// Bytes that a framer holds back at most in each direction.
  static constexpr std::size_t kMostHeld = 1024;

  virtual ~Framer() = default;

  /// Takes a byte; appends the runs that ended with it, oldest first.
  virtual void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) = 0;
  /// The direction was silent for this->silence(): gives up what was held back, if anything.
  virtual void expire(Direction direction, std::vector<Run>& ended) = 0;
  /// After how long without a byte a frame is given up; 0: never.
  virtual SimDuration silence() const = 0;
};

}  // namespace virtdrive::protocol
