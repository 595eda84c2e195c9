// Distances: so many turns (DoTurn, 4.2.9), or to a position (DoLinearMotion, 4.2.14).
//
//   speed ^      ______________
//         |     /              \           the ramps are MaxAngAcc's
//         |    /                \______    approach: the last turn at 10 rpm, or the last 5 % of
//         the
//         +---+-----------------------+->  way at EncoderLMApproach
//
// The controller tells a speed for the distance that is left; how far that is, is the channel's
// business.
#pragma once

#include <cstdint>
#include <optional>

namespace virtdrive::toshiba_mcu {

class Motion {
 public:
  enum class Kind : std::uint8_t { kNone, kTurn, kLinear };

  struct Profile {
    double max_rpm = 0;
    double approach_rpm = 0;
    double approach_turns = 0;  // the length of the last stretch
  };

  /// Distances are turns of the motor, signed.
  void begin(Kind kind, double distance_turns, const Profile& profile);
  void abort() { kind_ = Kind::kNone; }
  Kind kind() const { return kind_; }
  bool running() const { return kind_ != Kind::kNone; }

  /// The speed to run with; 0 once the end is reached or passed, and the motion is over.
  /// `acceleration_turns_per_s2` is the ramps'; `resolution_turns` what counts as there.
  double speed_rpm(double left_turns, double acceleration_turns_per_s2, double resolution_turns);

 private:
  Kind kind_ = Kind::kNone;
  Profile profile_;
  double sign_ = 1;  // of the distance: the side that the end is approached from
};

}  // namespace virtdrive::toshiba_mcu
