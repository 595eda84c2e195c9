// Digital inputs of one axis (7.3): two of the last three samples decide; the Halls' polarity is
// remapped by HINVERT.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace virtdrive::rzt1 {

/// The sector 0..5 of a Hall code: 60 degrees each, sector 0 while the d axis is within -30..30.
/// None for the codes 0 and 7, which no rotor gives.
std::optional<int> hall_sector(std::uint8_t code);

class Inputs {
 public:
  /// Bits 0..3 of `pins`, bits 0..2 of `halls`.
  void sample(std::uint8_t pins, std::uint8_t halls);
  /// Bits 0..3 inputs, 4..6 Halls.
  std::uint8_t word() const { return word_; }
  std::uint8_t halls() const { return word_ >> 4; }
  void set_halls_inverted(bool inverted) { inverted_ = inverted; }
  /// The last three samples agree.
  bool settled() const { return last_[0] == last_[1] && last_[1] == last_[2]; }

 private:
  std::array<std::uint8_t, 3> last_{};
  std::uint8_t word_ = 0;
  bool inverted_ = false;
};

}  // namespace virtdrive::rzt1
