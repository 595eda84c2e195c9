// What makes a controller stop by itself (p. 23). A cause that lasts long enough sets its bit and
// ALARM; both stay until they are reset.
//
//   bit         cause                                                            for
//   CTRL_FAIL   speed more than 30 % of the reference away from it               15 s
//   OVER_VOLT   DC link above the board's limit                                  10 ms *
//   OVER_TEMP   heat sink above 65 degC                                          1 ms
//   OVER_LOAD   current above MAX_LOAD, or above 150 % of it                     4 s, 1 ms
//   HALL_FAIL   Hall code 0 or 7                                                 10 ms *
//   INV_VEL     speed against the output: |output| > 50, above 5 % of MAX_RPM    1 s *
//   STALL       |output| > 100, below 1 rpm; CTRL_FAIL beside it in speed mode   2 s
//   ENC_FAIL    (status 2) output, no encoder counts                             0.6 s *
//
// Times with * and the numbers of INV_VEL and STALL are assumed: the document has none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace virtdrive::md {

enum Status : std::uint8_t {
  kAlarm = 1,
  kCtrlFail = 2,
  kOverVolt = 4,
  kOverTemp = 8,
  kOverLoad = 16,
  kHallFail = 32,
  kInvVel = 64,
  kStall = 128,
};
/// Bits of the second status byte.
inline constexpr std::uint8_t kEncFail = 2;

inline constexpr double kDeratingFromDegc = 55;
inline constexpr double kOverTempDegc = 65;

/// Share of MAX_LOAD that the limiter allows at a heat sink temperature: 1 up to 55 degC, half at
/// 65 degC (the half is assumed: "limited proportionally").
double derating(double heat_sink_degc);

/// What the protections look at, once a millisecond.
struct Watched {
  double rpm = 0;
  double reference_rpm = 0;   // 0 unless the speed is controlled
  double output = 0;          // -1023 .. 1023
  double current_a = 0;       // magnitude, mean of the millisecond
  double mean_current_a = 0;  // of 50 ms, as it is reported
  double max_load_a = 0;
  double max_rpm = 0;
  double bus_v = 0;
  double over_v = 0;
  double heat_sink_degc = 0;
  std::uint8_t hall = 0;
  bool speed_control = false;
  bool watches_stall = false;  // not under torque control, not while 0 is held
  bool encoder_expected = false;
  bool encoder_moves = false;
};

class Protections {
 public:
  /// One millisecond. True if an alarm came.
  bool watch(const Watched& now);
  void reset();

  std::uint8_t status() const { return status_; }
  std::uint8_t status2() const { return status2_; }
  /// Bits of the last alarm, also after it was reset.
  std::uint8_t last_alarm() const { return last_; }

 private:
  enum Cause : std::size_t {
    kSpeedOff,
    kLinkHigh,
    kHot,
    kLoaded,
    kOverCurrent,
    kNoHall,
    kAgainst,
    kStanding,
    kNoEncoder,
    kCauses
  };
  bool lasts(Cause cause, bool there);

  std::uint8_t status_ = 0;
  std::uint8_t status2_ = 0;
  std::uint8_t last_ = 0;
  std::array<std::int32_t, kCauses> there_ms_{};
};

}  // namespace virtdrive::md
