// One axis of the servo firmware, from its encoder to its duty cycles: what every protocol on top
// of it (lines, packets, EtherCAT) orders and asks.
//
//   axis.set_target(100000);
//   if (axis.on() == Result::kOk) axis.go();
//   axis.status();  axis.position();
//
// Orders are judged as the document's response codes say and act at once, in the foreground; the
// servo moves with the next 50 us task. Units: positions in encoder counts, velocities 16.16 counts
// per loop cycle (DS * 50 us), outputs +-32767, currents in AD counts.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "firmware_models/rzt1/current_loop.h"
#include "firmware_models/rzt1/hardware.h"
#include "firmware_models/rzt1/homing.h"
#include "firmware_models/rzt1/inputs.h"
#include "firmware_models/rzt1/interlocks.h"
#include "firmware_models/rzt1/phasing.h"
#include "firmware_models/rzt1/position_input.h"
#include "firmware_models/rzt1/profile.h"
#include "firmware_models/rzt1/regulators.h"
#include "firmware_models/rzt1/result.h"
#include "firmware_models/rzt1/settings.h"
#include "firmware_models/rzt1/status.h"

namespace virtdrive::rzt1 {

/// What the drive samples for an axis in one PWM slot.
struct SlotReading {
  ShaftReading shaft;
  std::array<std::int32_t, 2> current_counts{};  // channels U, V, around 0
  bool amplifier_fault = false;
  // With the loop cycle only.
  std::uint8_t input_pins = 0;  // bit 0 = first input of the axis
  std::uint8_t hall_pins = 0;
};

/// What it tells the inverter, from the next slot on; gates go off at once.
struct SlotOutput {
  enum class Mode : std::uint8_t { kOff, kThreePhase, kTwoPhase };
  Mode mode = Mode::kOff;
  std::array<double, 3> duty{0.5, 0.5, 0.5};  // of channels U, V, W
};

/// Ways in which reality goes beyond the maker's published example.
struct FirmwareOptions {
  /// Search distances of homing in turns; `literal` takes the example's counts (-50000, 5500,
  /// 1000000), which suit one encoder only.
  HomingDistances homing{};
  /// ETYPE 1..5 on axis 1 as well: the kit connects one absolute encoder, to channel 2 (5.3).
  bool absolute_on_both = false;
  /// ETIME and CTIME in ms instead of loop cycles.
  bool error_time_ms = false;
  /// GEAROUT / GEARIN, as the successor's published example computes.
  bool gear_inverted = false;
};

class ServoAxis {
 public:
  /// `number`: 0 or 1. `wake` is called when the axis is given something to do.
  ServoAxis(std::size_t number, const Settings& settings, AxisHardware& hardware,
            const FirmwareOptions& options, std::function<void()> wake);
  ServoAxis(const ServoAxis&) = delete;
  ServoAxis& operator=(const ServoAxis&) = delete;

  std::size_t number() const { return number_; }

  // --- Orders: Cmd of Appendix A ---
  /// Latches motion and gains; starts a motion, or changes the one under way (trapezoid and jog;
  /// others 8). With the servo off it only latches.
  Result go();
  /// Jogs with VEL, and starts if the servo is on.
  Result forward();
  Result reverse();
  /// Enables the amplifier, begins phasing where that is needed, holds the present position. kFault
  /// while an absolute encoder does not answer.
  Result on();
  Result off();
  Result enable();
  Result disable();
  Result stop();
  /// STOP with a deceleration of its own (16.16, > 0), as a fieldbus' quick stop has.
  Result quick_stop(std::int64_t deceleration);
  Result abort();
  Result home();
  Result align();
  /// Finds PMAP and HINVERT by moving the rotor; servo off.
  Result setup();
  /// ERESET.
  void reset_errors();

  // --- Set-points from elsewhere ---
  /// ABS, REL: where the next GO goes. Either ends jogging's hold on it. REL 0: none.
  void set_target(std::int32_t position);
  void set_distance(std::int32_t counts);
  std::int32_t target() const { return target_; }
  std::int32_t distance() const { return distance_; }

  /// Packet 3: the time between two points in loop cycles (1..), the queue emptied.
  Result init_pvt(std::int32_t time_slice, std::optional<std::int32_t> watermark = {});
  /// All or none; kOverflow if they do not fit.
  Result push_pvt(std::span<const PvtPoint> points);
  /// ADDP keeps, ADDV keeps and pushes.
  void set_pvt_position(std::int32_t position) { pending_.position = position; }
  Result push_pvt_velocity(std::int32_t velocity);
  PvtPoint pending_pvt() const { return pending_; }

  /// Cyclic synchronous: from now on the command goes straight to `position` within `cycles` loop
  /// cycles and stays there until the next call. Servo on, nothing else moving; ends by STOP.
  Result follow(std::int32_t position, std::int32_t cycles);
  /// Moves at this velocity (16.16, signed) until told otherwise, with ACC and DEC.
  Result jog(std::int32_t velocity);

  // --- Parameters ---
  const Settings& settings() const { return settings_; }
  /// Writes one parameter as a host does. kInvalidState where the state forbids it (ETYPE, and TYPE
  /// with a servo on), kOutOfRange for values that the firmware could not live with. Ranges as such
  /// are the protocol table's.
  Result set(std::int32_t Settings::* parameter, std::int32_t value);
  /// The set for SAVE: as settings(), PORIGIN as the encoder counts.
  Settings saved() const;
  /// RESTORE: what saved_settings() names. Servo off, else kInvalidState.
  Result restore(const Settings& saved);

  std::int32_t phase_origin() const { return phasing_.origin(); }  // PORIGIN
  void set_phase_origin(std::int32_t position);
  /// PWM and IQPKT: the q output while the servo is off, else kInvalidState.
  Result set_output(std::int32_t q);
  std::int32_t output() const { return output_q_; }
  Result set_output_d(std::int32_t d);  // IDPKT
  std::int32_t output_d() const { return output_d_; }
  /// U, V, W (0..2), 32767 = 100 %. Written with PCMODE 3, else kInvalidState.
  std::int32_t phase_output(std::size_t phase) const { return current_.duty_counts(phase); }
  Result set_phase_output(std::size_t phase, std::int32_t counts);

  // --- Encoder ---
  std::int32_t position() const { return position_.position(); }  // POS
  /// Shifts actual, command, target, the PVT queue and PORIGIN alike.
  /// kInvalidState for the gear's slave while its servo is on.
  Result set_position(std::int32_t position);
  std::int32_t index() const { return position_.index(); }  // IND
  /// IND as read by a host: clears STA bit 3.
  std::int32_t take_index();
  std::uint32_t encoder_id() const;
  std::uint16_t encoder_status() const { return position_.status(); }  // ESTATUS
  /// EDATA at EADDR: kOutOfRange with an incremental encoder or beyond its memory, kExecution if it
  /// does not answer.
  Result read_encoder_word(std::uint16_t& word) const;
  Result write_encoder_word(std::uint16_t word);

  // --- What is reported ---
  std::uint16_t status() const;  // STA
  bool servo_on() const { return servo_on_; }
  bool amplifier_on() const { return amplifier_on_; }
  bool phased() const { return phasing_.phased(); }
  bool busy() const;
  bool moving() const { return profile_.state() != ProfileState::kIdle; }
  ProfileState profile_state() const { return profile_.state(); }
  HomingState homing_state() const { return homing_.state(); }
  /// Whether the last SETUP or ALIGN found what it looked for.
  bool search_failed() const { return phasing_.failed(); }
  std::int32_t command_position() const { return profile_.position(); }
  std::int32_t command_velocity() const { return profile_.velocity(); }          // 16.16
  std::int32_t command_acceleration() const { return profile_.acceleration(); }  // 16.16
  std::int32_t position_error() const;                                           // ERR, clipped
  std::int32_t velocity() const { return regulators_.velocity(); }               // 16.16, measured
  std::int32_t velocity_counts() const;                                          // CV
  std::int32_t regulator_output() const { return regulators_.output(); }
  std::int32_t raw_current(std::size_t channel) const;               // ADC1, ADC2
  std::int32_t total_current() const;                                // TC
  std::int32_t direct_current() const { return current_.id(); }      // IDM
  std::int32_t quadrature_current() const { return current_.iq(); }  // IQM
  std::int32_t direct_error() const { return current_.id_error(); }
  std::int32_t quadrature_error() const { return current_.iq_error(); }  // IQERR
  std::int32_t direct_voltage() const { return current_.vd(); }
  std::int32_t quadrature_voltage() const { return current_.vq(); }
  /// PANGLE: 0 .. PCOUNTS - 1; -1 before the first 50 us task.
  std::int32_t phase_angle() const { return phase_angle_; }
  std::int32_t pvt_depth() const { return profile_.pvt_depth(); }  // PVT
  /// Set-points that wait for the loop: the generator keeps 40 ahead while it runs.
  std::int32_t scan_depth() const { return moving() ? kScanDepth : 0; }
  std::uint8_t halls() const { return inputs_.halls(); }  // after filter and HINVERT
  /// Bits 0..3 inputs, 4..6 Halls: what HMASK, EMASK and the recorder's masks are laid over.
  std::uint8_t digital_inputs() const { return inputs_.word(); }
  std::int32_t hall_position() const { return hall_position_; }  // HPOS
  void set_hall_position(std::int32_t position) { hall_position_ = position; }
  std::uint32_t errors() const { return interlocks_.errors(); }        // EQUERY
  const ErrorLatch& latched() const { return interlocks_.latched(); }  // ECP, ECV, EPO
  void set_latched(const ErrorLatch& latch) { interlocks_.set_latched(latch); }
  std::int32_t i2t() const { return interlocks_.i2t(); }
  std::int32_t bus_counts() const { return bus_counts_; }                  // EVOLT
  std::int32_t temperature_counts() const { return temperature_counts_; }  // ETEMP
  /// What a recorder's channel takes.
  std::int32_t trace(int source, std::int32_t timing) const;

 private:
  friend class ServoDrive;
  static constexpr std::int32_t kScanDepth = 40;

  // What the drive calls.
  void join(ServoAxis& partner) { partner_ = &partner; }
  void slot(const SlotReading& reading);
  /// The next slot ends a loop cycle, in which pins are read.
  bool reads_inputs() const { return slots_ + 1 >= regulators_.loop_slots(); }
  void millisecond(std::int32_t bus_counts, std::int32_t temperature_counts);
  const SlotOutput& slot_output() const { return slot_output_; }
  /// Nothing to do until somebody calls `wake` or the shaft turns.
  bool idle() const;
  void hardware_changed() { wake_(); }

  void start_encoder();
  Result ready() const;
  bool leads() const;
  bool follows() const { return partner_ != nullptr && partner_->leads(); }
  bool geared() const { return leads() || follows(); }
  std::int32_t geared_down(std::int64_t value) const;
  void preset_slave();
  template <class Order>
  Result both(Order order);

  Result switch_on();
  void switch_off();
  Result switch_power(bool on);
  void halt(std::int64_t deceleration);
  void latch();
  MotionLimits limits() const;
  std::int64_t deceleration() const;
  void begin_motion();
  Result start_jog(int direction);
  Result may_move() const;

  void loop_cycle(const SlotReading& reading);
  void end_search();
  void home_on();
  void carry_out(const HomingOrder& order);
  void carry_out(const InterlockOrder& order);
  void regulate();
  void commutate();
  void commutate_three();
  void shift(std::int32_t counts);
  Result set_encoder_type(std::int32_t type);
  bool over_range() const;

  std::size_t number_;
  Settings settings_;
  AxisHardware& hardware_;
  FirmwareOptions options_;
  std::function<void()> wake_;
  ServoAxis* partner_ = nullptr;

  PositionInput position_;
  Inputs inputs_;
  Profile profile_;
  Regulators regulators_;
  CurrentLoop current_;
  Phasing phasing_;
  Homing homing_;
  Interlocks interlocks_;

  bool servo_on_ = false, amplifier_on_ = false;
  bool off_after_stop_ = false;               // ASTOP 1
  bool pvt_announced_ = false;                // packet 3 came: STA bit 6 tells
  bool polled_last_ = false;                  // homing, with a loop cycle of 50 us
  std::optional<EncoderType> absolute_type_;  // of the interface, since the reset
  MotionLimits latched_limits_;
  std::int32_t target_ = 0, distance_ = 0;
  int jog_direction_ = 0;
  PvtPoint pending_;
  std::int32_t output_q_ = 0, output_d_ = 0;
  bool host_phases_ = false;
  std::array<std::int32_t, 3> host_counts_{};

  std::int32_t slots_ = 0;  // since the last loop cycle
  std::optional<VectorDemand> vector_;
  std::int32_t phase_angle_ = -1;
  std::array<std::int32_t, 2> current_counts_{};
  bool amplifier_fault_ = false;
  std::int32_t bus_counts_ = 0, temperature_counts_ = 0;
  std::int32_t hall_position_ = 0;
  SlotOutput slot_output_;
};

}  // namespace virtdrive::rzt1
