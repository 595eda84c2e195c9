// Loads as a user writes them: "brake:20mNm", "quadratic:2e-8,inertia:1e-5", "brake:20mNm@1.5s".
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/sim_time.h"
#include "plant/mechanics.h"

namespace virtdrive {

/// From `at` on, one quantity of the load has another value.
struct LoadStep {
  SimTime at = kSimStart;
  std::optional<std::size_t> channel;  // none: all
  double Load::* quantity = nullptr;
  double value = 0;
};

/// A comma-separated list of [CHANNEL.]KIND:VALUE[UNIT][@TIME[s|ms]], or "none"; without a channel
/// a part is for all `channels` of them. Kinds and their units: brake (Nm, mNm), constant (Nm,
/// mNm), quadratic (Nm/(rad/s)^2), viscous (Nm/(rad/s)), inertia (kgm2, gcm2). SetupError names the
/// part that is wrong. Sorted by time.
std::vector<LoadStep> parse_load(std::string_view text, std::size_t channels);

/// For --help.
extern const std::string kLoadHelp;

}  // namespace virtdrive
