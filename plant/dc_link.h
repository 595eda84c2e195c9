// The DC supply: a source that cannot absorb (a diode behind its resistance) and the link
// capacitor.
//
//   C dV/dt = i_source - i_bridge,   i_source = (E - V) / R while the diode conducts, else 0
//
// Regeneration pumps the link up and nothing brings it down but the bridge. Resistance 0 means an
// ideal source: V = E always, and it absorbs.
#pragma once

#include "core/check.h"

namespace virtdrive {

struct DcLinkParameters {
  double source_v = 24;         // open-circuit voltage, >= 0
  double resistance_ohm = 0.1;  // of source and leads; 0: ideal source
  double capacitance_f = 1e-3;  // > 0 (without effect behind an ideal source)
};

/// The diode switches this far beyond the source voltage, so that rounding cannot make it chatter.
inline constexpr double kSourceHysteresisV = 1e-6;

/// Throws SetupError unless every value is in its range.
void validate(const DcLinkParameters& link);

inline bool is_ideal(const DcLinkParameters& link) {
  return link.resistance_ohm == 0;
}

}  // namespace virtdrive
