#include "plant/dc_link.h"

#include <cmath>

namespace virtdrive {

void validate(const DcLinkParameters& link) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("DC link: {}, not {}", what, value));
  };
  require(std::isfinite(link.source_v) && link.source_v >= 0, "source_v must be 0 or more",
          link.source_v);
  require(std::isfinite(link.resistance_ohm) && link.resistance_ohm >= 0,
          "resistance_ohm must be 0 or more", link.resistance_ohm);
  require(std::isfinite(link.capacitance_f) && link.capacitance_f > 0,
          "capacitance_f must be above 0", link.capacitance_f);
}

}  // namespace virtdrive
