#include "firmware_models/rzt1/inputs.h"

namespace virtdrive::rzt1 {

std::optional<int> hall_sector(std::uint8_t code) {
  constexpr std::array<int, 8> kSectors{-1, 4, 0, 5, 2, 3, 1, -1};
  const int sector = kSectors[code & 7];
  if (sector < 0) return {};
  return sector;
}

void Inputs::sample(std::uint8_t pins, std::uint8_t halls) {
  const auto wired = static_cast<std::uint8_t>((inverted_ ? ~halls : halls) & 7);
  last_ = {last_[1], last_[2], static_cast<std::uint8_t>((pins & 15) | wired << 4)};
  word_ = static_cast<std::uint8_t>((last_[0] & last_[1]) | (last_[1] & last_[2]) |
                                    (last_[0] & last_[2]));
}

}  // namespace virtdrive::rzt1
