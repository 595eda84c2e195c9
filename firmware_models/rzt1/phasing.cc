#include "firmware_models/rzt1/phasing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "firmware_models/rzt1/counts.h"
#include "firmware_models/rzt1/inputs.h"

namespace virtdrive::rzt1 {
namespace {

constexpr double kSixthRad = std::numbers::pi / 3;
constexpr double kTurnRad = 2 * std::numbers::pi;
constexpr int kDitherWindows = 128;  // of PITIME
constexpr double kDitherShrink = 0.75;
constexpr double kDitherEnd = 10;  // counts
constexpr int kDitherSettle = 16;  // of PITIME
// A rotor that moved less than this share of an electrical turn did not follow the vector.
constexpr int kSetupLeast = 24;

// So many times 30 degrees (electrical) in counts.
std::int32_t thirty_degrees(int times, const Settings& settings) {
  return static_cast<std::int32_t>(static_cast<std::int64_t>(settings.pcounts) * times / 12);
}

}  // namespace

void Phasing::set_phased(bool phased) {
  phased_ = phased;
  rough_ = false;
}

void Phasing::start(Search search) {
  search_ = last_search_ = search;
  cycle_ = 0;
  failed_ = false;
  rough_ = false;
}

void Phasing::end(bool found) {
  search_ = Search::kNone;
  failed_ = !found;
}

void Phasing::abort() {
  if (busy()) end(false);
  rough_ = false;
}

void Phasing::align(const Settings& settings, std::int32_t position, std::uint8_t halls,
                    bool may_turn) {
  phased_ = false;
  last_halls_ = halls;
  const auto sector = hall_sector(halls);
  if (settings.pimode == 1 && sector) {
    start(Search::kHall);
    if (may_turn) return;
    search_ = Search::kNone;
    rough_ = true;
    set_direct_axis(difference(position, thirty_degrees(2 * *sector, settings)), settings);
    return;
  }
  if (settings.pimode == 2) {
    start(Search::kDither);
    delta_ = settings.pcounts / 2.0;
    window_cycle_ = 0;
    second_window_ = false;
    return;
  }
  start(Search::kForced);
}

void Phasing::start_setup() {
  start(Search::kSetup);
  setup_swapped_ = false;
}

void Phasing::shift(std::int32_t counts) {
  estimate_ = sum(estimate_, counts);
  window_start_ = sum(window_start_, counts);
  setup_position_ = sum(setup_position_, counts);
}

std::int32_t Phasing::angle(std::int32_t position, const Settings& s) const {
  const std::int32_t from = difference(position, origin_);
  // Within the revolution first (PORIGIN, Appendix A): PCOUNTS is rarely a divisor's whole number.
  const bool derived =
      std::abs(static_cast<std::int64_t>(s.pcounts) * s.pole_pairs - s.ecpr) < s.pole_pairs;
  return within(derived ? within(from, s.ecpr) : from, s.pcounts);
}

// `position` is where the d axis lies on phase U.
void Phasing::set_direct_axis(std::int32_t position, const Settings& settings) {
  origin_ = difference(position, settings.pcounts / 4);
}

std::optional<VectorDemand> Phasing::step(std::int32_t position, std::uint8_t halls,
                                          Settings& settings) {
  switch (search_) {
    case Search::kNone:
      if (rough_) see_halls(position, halls, settings);
      return {};
    case Search::kForced:
      return step_forced(position, settings);
    case Search::kHall:
      return step_hall(position, halls, settings);
    case Search::kDither:
      return step_dither(position, settings);
    case Search::kSetup:
      return step_setup(position, halls, settings);
  }
  return {};
}

VectorDemand Phasing::step_forced(std::int32_t position, const Settings& settings) {
  if (++cycle_ <= settings.pitime / 2) return {settings.piout, kSixthRad};
  if (cycle_ <= settings.pitime) return {settings.piout, 0};
  set_direct_axis(sum(position, settings.pioffs), settings);
  phased_ = true;
  end(true);
  return {};
}

// True once it is phased. Sector s begins with the d axis at 60 s - 30 degrees.
bool Phasing::see_halls(std::int32_t position, std::uint8_t halls, const Settings& settings) {
  const auto before = hall_sector(last_halls_), now = hall_sector(halls);
  last_halls_ = halls;
  if (!before || !now) return false;
  const int moved = (*now - *before + 6) % 6;
  if (moved != 1 && moved != 5) return false;
  const int edge = moved == 1 ? *now : *before;
  set_direct_axis(
      sum(difference(position, thirty_degrees(2 * edge - 1, settings)), settings.pioffs), settings);
  phased_ = true;
  rough_ = false;
  return true;
}

VectorDemand Phasing::step_hall(std::int32_t position, std::uint8_t halls,
                                const Settings& settings) {
  const auto sector = hall_sector(halls);
  if (see_halls(position, halls, settings)) {
    end(true);
    return {};
  }
  if (!sector || ++cycle_ > settings.pitime) {
    end(false);
    return {};
  }
  return {settings.piout, (*sector + 1.5) * kSixthRad};
}

VectorDemand Phasing::step_dither(std::int32_t position, const Settings& settings) {
  const std::int32_t window = std::max(1, settings.pitime / kDitherWindows);
  if (cycle_++ == 0) {
    estimate_ = position;
    window_start_ = position;
  }
  const bool settling = delta_ <= kDitherEnd;
  const std::int32_t length = settling ? std::max(1, settings.pitime / kDitherSettle) : window;
  if (++window_cycle_ > length) {
    window_cycle_ = 1;
    if (settling) {
      set_direct_axis(sum(estimate_, settings.pioffs), settings);
      phased_ = true;
      end(true);
      return {};
    }
    if (second_window_) {
      // Forward drift: the vector lies ahead of the d axis, so that the estimate is too low.
      const std::int32_t drift = difference(position, window_start_);
      const auto step = static_cast<std::int32_t>(delta_);
      const bool none = drift == 0 && delta_ < settings.pcounts / 8.0;
      if (!none) estimate_ = drift < 0 ? difference(estimate_, step) : sum(estimate_, step);
      delta_ *= kDitherShrink;
    }
    second_window_ = !second_window_;
    window_start_ = position;
  }
  const double turns =
      static_cast<double>(within(difference(position, estimate_), settings.pcounts)) /
      settings.pcounts;
  return {settings.piout, turns * kTurnRad};
}

// Vectors 1, 0, 1: at the second the rotor surely stands, at the third it has gone 60 degrees on or
// back. If back the phases are swapped and it is done once more for the Halls.
VectorDemand Phasing::step_setup(std::int32_t position, std::uint8_t halls, Settings& settings) {
  const std::int32_t third = std::max(1, settings.pitime / 3);
  if (cycle_ == 0 && !setup_swapped_) settings.pmap = 0;
  ++cycle_;
  if (cycle_ <= third) return {settings.piout, kSixthRad};
  if (cycle_ <= 2 * third) {
    setup_position_ = position;
    setup_halls_ = halls;
    return {settings.piout, 0};
  }
  if (cycle_ <= 3 * third) return {settings.piout, kSixthRad};
  const std::int32_t moved = difference(position, setup_position_);
  if (std::abs(moved) < settings.pcounts / kSetupLeast) {
    end(false);
    return {};
  }
  if (moved < 0 && !setup_swapped_) {
    setup_swapped_ = true;
    settings.pmap = 1;
    cycle_ = 0;
    return {settings.piout, kSixthRad};
  }
  // Codes 2 and 6 as they are; 5 and 1 are their inverses.
  if (setup_halls_ == 5 && halls == 1) settings.hinvert = settings.hinvert == 0 ? 1 : 0;
  end(moved > 0);
  return {};
}

}  // namespace virtdrive::rzt1
