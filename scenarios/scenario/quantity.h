// Numbers with units as people write them: "2000 rpm", "20 mNm", "1.5 s", "10 %".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/sim_time.h"

namespace virtdrive {

struct Quantity {
  double value = 0;
  std::string unit;  // as written; "" for none
};

/// A decimal number and what follows it; nothing if `text` does not begin with a finite number, has
/// a leading zero before digits, or goes on with another number.
std::optional<Quantity> parse_quantity(std::string_view text);

/// `value` in another unit of the same kind (rpm and rad/s, mNm and Nm, ms and s, % and "");
/// nothing if the units do not measure the same. Equal units always convert.
std::optional<double> convert(double value, std::string_view from, std::string_view to);

/// The units that convert to `unit`: "rpm or rad/s".
std::string units_like(std::string_view unit);

/// A time of 0 up to 1000 days, e.g. "1.5 s", "20 ms", "24 h"; nothing if `text` is none.
std::optional<SimDuration> parse_time(std::string_view text);
/// "1.5 s", "20 ms": the shortest text that parse_time() gives back.
std::string show_time(SimDuration duration);
/// "2.413 s", always in seconds, to the microsecond at most.
std::string show_instant(SimTime time);
/// "2000 rpm", "0.02 Nm": six significant digits.
std::string show_quantity(double value, std::string_view unit);

}  // namespace virtdrive
