// The program of AcDrive, in the order in which a turn of it runs: measure, guard, decide, ramp,
// modulate. What it keeps between two turns is here; what it does, in drive_program.cc (life and
// decisions), drive_guards.cc (protections) and drive_output.cc (from ramp to voltage).
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "firmware_models/asd7/ac_drive.h"
#include "firmware_models/asd7/modulation.h"
#include "firmware_models/asd7/overload.h"
#include "firmware_models/asd7/pi_control.h"
#include "firmware_models/asd7/power_stage.h"
#include "firmware_models/asd7/ramp.h"
#include "firmware_models/asd7/reference.h"

namespace virtdrive::asd7 {

class AcDrive::Impl {
 public:
  Impl(EventLoop& loop, Axis& axis, const Model& model, const Settings& settings,
       const Memory& memory, const Seed& seed);

  // --- What AcDrive passes on ---
  void set_settings(const Settings& settings);
  CommandResult set_command(std::uint16_t word);
  void set_command2(std::uint16_t word);
  void set_terminals(const Terminals& terminals);
  void press(PanelKey key);
  void inject(Trip cause);
  void communication_lost();
  void trip(Trip cause);
  void wake();
  Monitor monitor() const;
  std::uint16_t status() const;
  bool tripped() const { return state_ == State::kTripped || state_ == State::kRetryWait; }
  bool alive() const { return life_ == Life::kAlive; }
  bool output_on() const { return state_ >= State::kSearching; }

  const Model& model_;
  Settings settings_;
  Memory memory_;
  Asked asked_;
  Request request_;
  bool asked_anew_ = true;
  double ambient_degc_ = 25;
  std::function<void()> on_start_, on_stop_;
  Trip trip_ = Trip::kNone;
  std::uint16_t alarms_ = 0;
  Monitor frozen_;
  bool communication_alarm_ = false;
  double heat_sink_degc_ = 25;
  double bus_v_ = 0;
  std::uint64_t ticks_ = 0;

  double output_hz() const;
  double process_hz() const { return (reverse_ ? -1 : 1) * wanted_hz_; }

 private:
  /// The modulator's, while the output is on. Assumed.
  static constexpr SimDuration kTurn = std::chrono::microseconds(250);
  static constexpr double kTurnS = 250e-6;
  static constexpr double kHundredth = 0.01;  // Hz, of a register

  /// kDead: no supply, or it starts; kResetting: the same after a reset.
  enum class Life : std::uint8_t { kDead, kResetting, kAlive };
  /// From kSearching on the output is on.
  enum class State : std::uint8_t {
    kReady,
    kTripped,
    kRetryWait,
    kDemagnetizing,  // until DC or a search may begin
    kSearching,      // flying start
    kRecovering,     // found: the voltage rises
    kRunning,
    kDcBraking,
  };
  enum class Stop : std::uint8_t { kNone, kRamp, kDcBrake };  // of an emergency or a time-out

  // drive_program.cc
  void tick();
  void look_at_supply();
  void die();
  void start_cpu();
  void restart();
  void measure(double step_s);
  void decide(double step_s);
  void decide_standing(double step_s);
  void begin_output();
  void begin_running(double hz);
  void begin_dc_brake(double duration_s);
  void switch_off();
  void end_stop();
  void emergency(EmergencyStop how, Trip then);
  void retry();
  void count(double step_s);
  bool may_run() const;
  bool pi_controls() const {
    return settings_.pi_control != 0 && !request_.pi_off && !request_.jog;
  }
  bool reset_allowed() const;
  SimDuration next_step() const;

  // drive_guards.cc
  void guard_fast();
  void guard_slow(double step_s);
  void guard_overload(double step_s);
  void guard_phases(double step_s);
  void guard_load(double step_s);
  void look_at_alarms();
  Trip by_motion(Trip accelerating, Trip decelerating, Trip else_) const;

  // drive_output.cc
  void run(double step_s);
  void ramp(double step_s);
  RampRate ramp_rate() const;
  double wanted_hz(double step_s);
  void search(double step_s);
  void recover(double step_s);
  void brake(double step_s);
  void modulate(double hz, double line_v, double step_s);
  VoltageCurve curve() const;
  void estimate(double step_s);
  void ride_through();

  EventLoop& loop_;
  Axis& axis_;
  PowerStage stage_;
  double motor_v_;
  double link_nominal_v_;

  Life life_ = Life::kDead;
  SimTime born_at_ = kNever;  // when the CPU will run
  State state_ = State::kReady;
  SimTime state_since_ = kSimStart;
  SimTime tripped_at_ = kSimStart;
  bool undervoltage_ = false;
  SimTime contact_at_ = kNever;
  SimTime retry_at_ = kNever;
  int retries_left_ = 0;
  Trip injected_ = Trip::kNone;
  Stop forced_stop_ = Stop::kNone;
  Trip trip_after_stop_ = Trip::kNone;
  bool power_lost_stop_ = false;
  SimTime panel_stop_at_ = kSimStart - std::chrono::seconds(10);
  bool reset_pin_ = false;

  Measured now_;
  SimTime last_tick_ = kSimStart;
  static constexpr std::size_t kWindow = 40;  // 10 ms of turns
  std::array<double, kWindow> squares_{};
  std::size_t square_at_ = 0;
  double square_sum_ = 0;
  double current_a_ = 0;        // rms over 10 ms
  double shown_current_a_ = 0;  // 100 ms
  double bus_shown_v_ = 0;
  double bus_high_v_ = 0, bus_low_v_ = 0, ripple_v_ = 0;
  double ripple_left_s_ = 0;
  PhaseValues phase_squares_{};

  Ramp ramp_;
  PiControl pi_;
  bool pi_runs_ = false;
  bool reverse_ = false;
  double wanted_hz_ = 0;
  double angle_rad_ = 0;
  double raise_hz_ = 0;  // by the overvoltage limit; below 0 by riding through
  double slip_hz_ = 0;
  double drop_v_ = 0;
  double output_hz_ = 0;
  AlphaBeta voltage_;
  double line_v_ = 0;                                                    // put out, rms
  double active_a_ = 0, reactive_a_ = 0, output_w_ = 0, torque_nm_ = 0;  // filtered
  double speed_hz_ = 0, filtered_hz_ = 0;
  double last_hz_ = 0;  // before the output went off
  bool last_reverse_ = false;
  bool search_wanted_ = false;
  double search_hz_ = 0, search_w_ = 0;
  bool search_driven_ = false;
  double recovery_ = 0;
  double dc_left_s_ = 0, dc_v_ = 0;
  bool dc_forced_ = false;
  double at_lower_limit_s_ = 0;
  bool lower_limit_stop_ = false;

  Overload inverter_, motor_;
  ResistorOverload resistor_;
  Lasting far_over_, input_phase_, output_phase_, low_current_, over_torque_, moff_;
  double running_s_ = 0, run_fraction_s_ = 0;

  Wakeup tick_wakeup_;
};

}  // namespace virtdrive::asd7
