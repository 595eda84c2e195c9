// What watches a channel: each check tells the fault it has found, and the channel reacts.
//
// Bits and limits: protocol 3.10, 5.1.36-5.1.42 and 5.1.66. Rules, counts and delays: the maker's
// published firmware 1.x, but for the stall rule, whose published form raises false alarms.
#pragma once

#include <optional>

#include "firmware_models/toshiba_mcu/loop_state.h"
#include "firmware_models/toshiba_mcu/reading.h"
#include "firmware_models/toshiba_mcu/settings.h"
#include "firmware_models/toshiba_mcu/stage.h"

namespace virtdrive::toshiba_mcu {

class Protections {
 public:
  /// The driver block's inputs: act in every stage with PWM.
  static std::optional<Fault> pins(const Reading& reading);
  /// The DC link against SwOvervoltage and SwUndervoltage.
  static std::optional<Fault> bus(const Reading& reading, const ChannelSettings& settings,
                                  const Scaling& scaling);
  /// Each PWM period with current: converters at their end, SwOvercurrent, in Force no motor.
  std::optional<Fault> currents(const Reading& reading, const LoopState& now,
                                const Scaling& scaling, Stage stage);

  enum class StallCheck { kNotDue, kGood, kSuspicious, kStalled };
  /// FOC was entered.
  void begin_foc();
  /// Each 100 ms: the back-EMF that the q integrator shows against StalldetectValue and against the
  /// last good check. The first is due 500 ms after FOC was entered; two bad ones are a stall.
  StallCheck stall(const LoopState& now, const Scaling& scaling, int ms_in_foc);

  /// The same with the speed that an encoder measures, against the least that is healthy.
  StallCheck stall_by_encoder(double hz, double least_hz, const Scaling& scaling, int ms_in_foc);

  enum class Heat { kBetween, kTooHot, kReleased };
  /// Once a second: too hot at the sixth reading at the limit in a row, released 5 degC below.
  Heat temperature(double degc, const ChannelSettings& settings);

 private:
  StallCheck judge(bool good);

  int disconnected_periods_ = 0;
  int hot_checks_ = 0;
  int bad_stall_checks_ = 0;
  double good_emf_per_hz_ = 0;
};

}  // namespace virtdrive::toshiba_mcu
