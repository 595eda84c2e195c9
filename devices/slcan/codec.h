// Lines of an SLCAN adapter to commands and CAN frames, and back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "devices/can_port.h"
#include "devices/slcan/table.h"

namespace virtdrive::slcan {

/// Collects a line. More than kLongest characters are one line that is too long.
class Decoder {
 public:
  enum class Event : std::uint8_t { kNone, kLine, kTooLong };
  Event push(std::uint8_t byte);
  /// The line that just ended, without its CR.
  std::string_view line() const { return line_; }

 private:
  std::string line_;
  bool ended_ = false;
  bool too_long_ = false;
};

struct Line {
  const Command* command = nullptr;
  std::uint32_t number = 0;  // its digits
  CanFrame frame = {};       // of t, T, r and R
};
/// Nothing for an unknown letter, wrong digits, or digits too many or too few.
std::optional<Line> parse(std::string_view line);

/// "T00B7AC01382E803", without CR.
std::string text_of(const CanFrame& frame);

/// Bit rate of the SJA1000 at 16 MHz, BTR0 in the upper byte.
int bit_rate_of(std::uint32_t btr);

/// The SJA1000's two acceptance filters (its data sheet, 6.4.15): of code and mask AC0..AC3 and
/// AM0..AM3, the first byte uppermost.
struct AcceptanceFilter {
  std::uint32_t code = 0;
  std::uint32_t mask = 0xFFFF'FFFF;
  bool passes(const CanFrame& frame) const;
};

}  // namespace virtdrive::slcan
