// Where the rotor's flux is (7.5): forced, from the Halls, or by dithering; and SETUP's search for
// the wiring.
//
// The origin is the position at which PANGLE is 0: PCOUNTS / 4 below the one at which the d axis
// lies on phase U, so that PANGLE is the angle of the flux that makes torque (7.5: "90 degrees
// back").
//
//   forced  PIOUT along vector 1, then along vector 0, half of PITIME each: a rotor that stands
//           opposite to the one is moved by the other
//   Hall    a change from one code to the next tells the angle. ON takes the middle of the present
//           sector meanwhile and waits for the first motion; ALIGN turns the rotor to the next code
//           with PIOUT, within PITIME. Without Halls it is forced
//   dither  PIOUT along the estimated d axis, which turns with the rotor. While the rotor drifts
//   the
//           estimate is moved against the drift, by 3/4 less each time, two windows of PITIME / 128
//           each: the first lets the current follow, in the second the drift is measured
#pragma once

#include <cstdint>
#include <optional>

#include "firmware_models/rzt1/settings.h"

namespace virtdrive::rzt1 {

/// What a search puts on the motor: a vector along a direction of the stator, 32767 = Vdc / 3.
struct VectorDemand {
  std::int32_t amplitude = 0;
  double angle_rad = 0;
};

class Phasing {
 public:
  enum class Search : std::uint8_t { kNone, kForced, kHall, kDither, kSetup };

  std::int32_t origin() const { return origin_; }
  void set_origin(std::int32_t position) { origin_ = position; }
  bool phased() const { return phased_; }
  void set_phased(bool phased);
  /// A search moves the rotor.
  bool busy() const { return search_ != Search::kNone; }
  Search search() const { return search_; }
  bool failed() const { return failed_; }
  /// The last one, ended or not.
  Search last_search() const { return last_search_; }
  /// There is an angle to commutate with, though perhaps only that of the Halls' sector.
  bool usable() const { return phased_ || rough_; }

  /// ALIGN by PIMODE, or what ON needs.
  void align(const Settings& settings, std::int32_t position, std::uint8_t halls, bool may_turn);
  void start_setup();
  /// Gives up: unphased as before.
  void abort();
  /// POS was written; the origin is the caller's.
  void shift(std::int32_t counts);

  /// Each loop cycle; the vector while a search is on. SETUP writes its result to the settings.
  std::optional<VectorDemand> step(std::int32_t position, std::uint8_t halls, Settings& settings);

  /// PANGLE, 0 .. PCOUNTS - 1.
  std::int32_t angle(std::int32_t position, const Settings& settings) const;

 private:
  void start(Search search);
  void end(bool found);
  void set_direct_axis(std::int32_t position, const Settings& settings);
  bool see_halls(std::int32_t position, std::uint8_t halls, const Settings& settings);
  VectorDemand step_forced(std::int32_t position, const Settings& settings);
  VectorDemand step_hall(std::int32_t position, std::uint8_t halls, const Settings& settings);
  VectorDemand step_dither(std::int32_t position, const Settings& settings);
  VectorDemand step_setup(std::int32_t position, std::uint8_t halls, Settings& settings);

  std::int32_t origin_ = 0;
  bool phased_ = false;
  bool rough_ = false;  // the Halls' sector, until one passes
  bool failed_ = false;
  Search search_ = Search::kNone, last_search_ = Search::kNone;
  std::int32_t cycle_ = 0;
  std::uint8_t last_halls_ = 0;

  // Dither.
  std::int32_t estimate_ = 0;  // position at which the d axis would lie on phase U
  double delta_ = 0;
  std::int32_t window_start_ = 0;
  std::int32_t window_cycle_ = 0;
  bool second_window_ = false;

  // SETUP.
  std::int32_t setup_position_ = 0;
  std::uint8_t setup_halls_ = 0;
  bool setup_swapped_ = false;
};

}  // namespace virtdrive::rzt1
