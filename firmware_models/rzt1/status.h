// The status word.
#pragma once

#include <cstdint>

namespace virtdrive::rzt1 {

/// Bits of STA (B.2).
enum StatusBit : std::uint16_t {
  kMotionComplete = 1 << 0,
  kServoOn = 1 << 1,
  kAmplifierOn = 1 << 2,
  kIndexCaptured = 1 << 3,
  kEncoderFault = 1 << 4,
  kEncoderWarning = 1 << 5,
  kPvtLow = 1 << 6,
  kPhased = 1 << 7,
  kBusy = 1 << 8,  // homing, phasing or the search of SETUP; the document reserves it
  kOverCurrent = 1 << 9,
  kInputInhibit = 1 << 10,
  kPvtStarved = 1 << 11,
  kMotorOverheat = 1 << 12,
  kAmplifierFault = 1 << 13,
  kPositionErrorBit = 1 << 14,
  kPositionWrapped = 1 << 15,
};

}  // namespace virtdrive::rzt1
