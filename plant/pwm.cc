#include "plant/pwm.h"

#include <algorithm>

namespace virtdrive {

void PwmEdges::start_period(SimTime now, const BridgeCommand& command) {
  dead_time_ = command.dead_time;
  end_ = now + command.pwm_period;
  const double period_s = seconds(command.pwm_period);
  for (std::size_t x = 0; x < 3; ++x) {
    Half& leg = legs_[x];
    leg.rise = leg.fall = kNever;
    const double duty = command.duty[x];
    switch (command.legs[x]) {
      case Leg::kHiZ:
        leg.wanted = gates_[x] = Gate::kOff;
        leg.turn_on = kNever;
        break;
      case Leg::kHigh:
        want(x, Gate::kHigh, now);
        break;
      case Leg::kLow:
        want(x, Gate::kLow, now);
        break;
      case Leg::kDuty: {
        const SimDuration low = from_seconds((1 - duty) / 2 * period_s);
        const bool rises = low > SimDuration{0}, pulses = 2 * low < command.pwm_period;
        want(x, rises ? Gate::kLow : Gate::kHigh, now);
        if (rises && pulses) {
          leg.rise = now + low;
          leg.fall = end_ - low;
        }
        break;
      }
    }
  }
}

void PwmEdges::want(std::size_t x, Gate gate, SimTime now) {
  Half& leg = legs_[x];
  if (leg.wanted == gate) return;
  leg.wanted = gate;
  if (gates_[x] == gate) {
    leg.turn_on = kNever;  // back before the other switch came on
    return;
  }
  const bool other_was_on = gates_[x] != Gate::kOff || leg.turn_on != kNever;
  if (dead_time_ > SimDuration{0} && other_was_on) {
    gates_[x] = Gate::kOff;
    leg.turn_on = now + dead_time_;
  } else {
    gates_[x] = gate;
    leg.turn_on = kNever;
  }
}

SimTime PwmEdges::next() const {
  SimTime first = kNever;
  for (const Half& leg : legs_) first = std::min({first, leg.rise, leg.fall, leg.turn_on});
  return first;
}

void PwmEdges::run(SimTime now) {
  for (std::size_t x = 0; x < 3; ++x) {
    Half& leg = legs_[x];
    if (leg.turn_on <= now) {
      gates_[x] = leg.wanted;
      leg.turn_on = kNever;
    }
    if (leg.rise <= now) {
      leg.rise = kNever;
      want(x, Gate::kHigh, now);
    }
    if (leg.fall <= now) {
      leg.fall = kNever;
      want(x, Gate::kLow, now);
    }
  }
}

void PwmEdges::stop() {
  legs_ = {};
  gates_ = {};
  end_ = kNever;
}

}  // namespace virtdrive
