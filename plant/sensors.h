// What the drive's electronics make of the machine: ADC counts, Hall bits, encoder counts. A
// firmware model sees nothing else. Values are those of the sampling instant.
#pragma once

#include <cstdint>

#include "core/random.h"

namespace virtdrive {

/// An analogue-to-digital converter: 0 .. reference_v in 2^bits steps, clipping at both ends.
struct Adc {
  int bits = 12;             // 1..24
  double reference_v = 3.3;  // full scale, > 0

  /// The highest count.
  std::int32_t full_scale() const { return (std::int32_t{1} << bits) - 1; }
  /// Count k covers [k, k + 1) steps of reference_v / 2^bits.
  std::int32_t counts(double input_v) const;
};

/// Phase current through a shunt and its amplifier, around mid-scale.
struct CurrentSensor {
  Adc adc{};
  double volts_per_amp = 0;  // shunt times gain; negative if it inverts
  double offset_a = 0;       // zero error, as a current
  double gain_error = 0;     // 0.01: reads 1 % too much
  double noise_a = 0;        // standard deviation at the input

  /// Counts for a current; draws from `noise` only if noise_a is above 0.
  std::int32_t counts(double current_a, RandomStream& noise) const;
  /// Counts with no current through an ideal sensor.
  std::int32_t zero_counts() const { return std::int32_t{1} << (adc.bits - 1); }
};

/// Link voltage through a divider.
struct VoltageSensor {
  Adc adc{};
  double volts_per_volt = 0;  // divider ratio, e.g. 0.091
  double noise_v = 0;         // standard deviation, at the link

  std::int32_t counts(double voltage_v, RandomStream& noise) const;
};

/// Three Hall sensors 120 degrees (electrical) apart, bit 0 = A, bit 1 = B, bit 2 = C: A is high
/// over [0, 180), B over [120, 300), C over [240, 60) degrees. Forward: 5, 1, 3, 2, 6, 4.
/// `offset_rad` (electrical) is where the magnet's pattern starts.
std::uint8_t hall_bits(double electrical_angle_rad, double offset_rad = 0);

/// An incremental encoder: two tracks of `lines` periods and one index per turn.
struct Encoder {
  std::int32_t lines = 1000;  // per turn; four counts each

  /// Quadrature counts since angle 0: the edges passed, floor of the exact count, so negative
  /// angles count down. Mechanical angle in rad, any number of turns.
  std::int64_t count(double angle_rad) const;
  /// Index pulses passed: whole turns, rounded down.
  std::int64_t index_count(double angle_rad) const;
};

}  // namespace virtdrive
