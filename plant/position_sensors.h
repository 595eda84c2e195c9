// What tells a drive where its rotor is: Hall sensors, incremental and absolute encoders, as they
// are at the sampling instant. All members may be changed at run time: that is how a sensor slips,
// sticks or loses its battery.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace virtdrive {

/// Three Hall sensors 120 degrees (electrical) apart, bit 0 = A, bit 1 = B, bit 2 = C: A is high
/// over [0, 180), B over [120, 300), C over [240, 60) degrees. Forward: 5, 1, 3, 2, 6, 4.
struct HallSensors {
  enum class Output : std::uint8_t { kWorking, kStuckLow, kStuckHigh };

  double offset_rad = 0;  // electrical, of the whole pattern
  /// Electrical, of each sensor: positive switches late. Makers place them within a few degrees;
  /// mechanical errors count times the pole pairs.
  std::array<double, 3> placement_error_rad{};
  std::array<Output, 3> output{};

  bool operator==(const HallSensors&) const = default;

  std::uint8_t bits(double electrical_angle_rad) const;
  /// Edges that the working ones of these sensors (bits as above) have passed since some angle,
  /// counted down backwards: what hardware that decodes them counts.
  std::int64_t edges(double electrical_angle_rad, std::uint8_t of = 7) const;
  /// The electrical angle of the next change of bits() beyond this one, when it turns forwards or
  /// backwards; none if all sensors are stuck.
  std::optional<double> next_edge_rad(double electrical_angle_rad, bool forwards) const;
};

/// Ideal sensors whose pattern starts at `offset_rad` (electrical).
std::uint8_t hall_bits(double electrical_angle_rad, double offset_rad = 0);

/// An incremental encoder: two tracks of `lines` periods and one index per turn. Angles are
/// mechanical, in rad, over any number of turns.
struct Encoder {
  std::int32_t lines = 1000;   // per turn; four counts each
  double index_angle_rad = 0;  // where the index mark lies on the disc
  double slip_rad = 0;         // by how much the disc has slipped behind the shaft
  /// Edges that the counter has missed, disturbed as it was: the index comes at a wrong count.
  std::int64_t missed_counts = 0;
  bool index_dead = false;    // the index never comes
  bool cable_broken = false;  // whoever counts edges gets none: see EdgeCounter

  /// Quadrature counts since angle 0: the edges passed, floor of the exact count, so negative
  /// angles count down.
  std::int64_t count(double angle_rad) const;
  /// Index pulses passed: whole turns from the mark, rounded down.
  std::int64_t index_count(double angle_rad) const;
  /// What a capture unit latches between two samples: the count at the last index mark that was
  /// passed, in either direction; none if none was.
  std::optional<std::int64_t> index_capture(double from_rad, double to_rad) const;
  /// Bit 0 = A, bit 1 = B, bit 2 = index. A leads B by a quarter of a line when it turns forwards;
  /// the index is high over the one count that begins at its mark.
  std::uint8_t tracks(double angle_rad) const;

 private:
  std::int64_t edges(double angle_rad) const;
  std::int64_t index_edge(std::int64_t turn) const;
};

/// A counter in hardware, which does not know how the shaft turned while it heard nothing.
class EdgeCounter {
 public:
  /// The sensor stands at `edges` now, and what it passed since the last call was `heard`.
  void see(std::int64_t edges, bool heard = true) {
    if (heard) count_ += edges - edges_;
    edges_ = edges;
  }
  std::int64_t count() const { return count_; }

 private:
  std::int64_t count_ = 0, edges_ = 0;
};

/// An absolute encoder: position within a turn, and turns counted with the help of a battery.
struct AbsoluteEncoder {
  enum class Battery : std::uint8_t {
    kGood,
    kLow,   // flagged; still counts
    kLost,  // flagged; the turns were lost and read 0
  };

  struct Reading {
    std::uint32_t position = 0;  // 0 .. 2^single_turn_bits - 1
    std::int32_t turns = 0;      // two's complement of multi_turn_bits
    bool crc_good = true;
    bool battery_low = false;
    bool battery_lost = false;
  };

  int single_turn_bits = 17;  // 1..32
  int multi_turn_bits = 16;   // 0 (none) .. 32
  double zero_rad = 0;        // the shaft's angle at position 0 of turn 0
  bool reversed = false;      // counts up when the shaft turns backwards
  Battery battery = Battery::kGood;
  bool crc_fault = false;  // the frame's check fails; its data are not to be used

  /// Floor of the exact position, like any converter.
  Reading read(double angle_rad) const;
};

}  // namespace virtdrive
