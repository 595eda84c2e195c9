// What converters make of currents, voltages and temperatures: counts, with the errors of shunt,
// amplifier, divider and converter. Values are those of the sampling instant; who samples decides
// when that is. All members may be changed at run time: that is how a sensor drifts or breaks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/random.h"
#include "plant/transforms.h"

namespace virtdrive {

/// An analogue-to-digital converter: 0 .. reference_v in 2^bits steps, clipping at both ends.
struct Adc {
  int bits = 12;             // 1..24
  double reference_v = 3.3;  // full scale, > 0
  /// A dead input or converter reads this whatever comes in, within 0 .. full_scale().
  std::optional<std::int32_t> stuck_counts{};

  /// The highest count.
  std::int32_t full_scale() const { return (std::int32_t{1} << bits) - 1; }
  /// Count k covers [k, k + 1) steps of reference_v / 2^bits.
  std::int32_t counts(double input_v) const;
};

/// How a sensor has come to read wrong, on top of what its kind is off by.
struct SensorFault {
  enum class Stuck : std::uint8_t { kNo, kLow, kHigh };  // reads an end of the converter's range

  double offset = 0;  // in what it measures
  double gain = 0;    // 0.1: reads 10 % too much; -1: reads nothing
  Stuck stuck = Stuck::kNo;

  double distorted(double value) const { return value * (1 + gain) + offset; }
};

/// Phase or DC-link current through a shunt and its amplifier, around mid-scale.
struct CurrentSensor {
  Adc adc{};
  double volts_per_amp = 0;  // shunt times gain; negative if it inverts
  double offset_a = 0;       // zero error, as a current
  double gain_error = 0;     // 0.01: reads 1 % too much
  double noise_a = 0;        // standard deviation at the input
  SensorFault fault{};

  /// Counts for a current; draws from `noise` only if noise_a is above 0.
  std::int32_t counts(double current_a, RandomStream& noise) const;
  /// Counts with no current through an ideal sensor.
  std::int32_t zero_counts() const { return std::int32_t{1} << (adc.bits - 1); }
};

/// Link voltage through a divider.
struct VoltageSensor {
  Adc adc{};
  double volts_per_volt = 0;  // divider ratio, e.g. 0.091
  double offset_v = 0;        // zero error, at the link
  double gain_error = 0;
  double noise_v = 0;  // standard deviation, at the link
  SensorFault fault{};

  std::int32_t counts(double voltage_v, RandomStream& noise) const;
};

/// A thermistor with a negative temperature coefficient in a divider: R = R25 exp(B (1/T - 1/298.15
/// K)), the two-parameter equation that data sheets give B25/50 or B25/85 for. The converter is fed
/// by the divider's own supply unless supply_v differs from its reference.
struct NtcSensor {
  enum class Fault { kNone, kOpen, kShorted };  // of the thermistor's leads

  Adc adc{};
  double r25_ohm = 10e3;
  double beta_k = 3380;
  double fixed_ohm = 10e3;  // the divider's other resistor
  double supply_v = 3.3;
  bool ntc_to_supply = false;  // else to ground: hotter reads lower
  Fault fault = Fault::kNone;

  /// Above -273.15 degC.
  double resistance_ohm(double degc) const;
  double voltage_v(double degc) const;
  std::int32_t counts(double degc) const { return adc.counts(voltage_v(degc)); }
  /// What a drive that knows the circuit makes of a count (its middle); without fault.
  double temperature_degc(std::int32_t counts) const;
};

/// One bit a phase, bit 0 = a: the switches (or diodes) of one side that conduct.
using PhaseBits = std::uint8_t;

/// The upper switches that are on at a share 0..1 of a PWM period whose pulses lie around its
/// middle (up-down counter, period from valley to valley of the carrier), without dead time.
PhaseBits upper_on(const PhaseValues& duty, double period_share);

/// What a shunt in the DC link's return sees: the sum of the phase currents (A, into the motor)
/// whose upper switch conducts.
double link_current_a(const PhaseValues& current_a, PhaseBits upper);

/// What the shunt below a phase's lower switch sees: its current (A, into the motor) while the
/// lower switch conducts, else nothing.
double leg_shunt_current_a(const PhaseValues& current_a, PhaseBits lower, int phase);

}  // namespace virtdrive
