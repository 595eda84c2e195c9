// What is screwed to the board and stays as it is over a reset: sensors on the motor's shaft, the
// connectors' pins, DIP switches, converters. The bench owns it; all members may be changed at any
// time, after which ServoDrive::hardware_changed() is to be called.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>

#include "plant/sensors.h"

namespace virtdrive::rzt1 {

/// ETYPE (6.1).
enum class EncoderType : std::uint8_t {
  kIncremental = 0,
  kEndat = 1,
  kBiss = 2,
  kFaCoder = 3,
  kAFormat = 4,
  kHiperfaceDsl = 5,
};

/// An absolute encoder on the shaft. Assumed: it speaks whichever protocol ETYPE selects, and the
/// motor's maker has aligned it: PORIGIN 0 is right for 5 pole pairs.
struct FittedAbsoluteEncoder {
  AbsoluteEncoder sensor{
      .single_turn_bits = 16, .multi_turn_bits = 16, .zero_rad = -std::numbers::pi / 10};
  bool silent = false;            // it answers no more
  std::uint32_t id = 0x17160001;  // EID
  std::array<std::uint16_t, 256> eeprom{};
};

/// A switch that the load passes: active while the rotor's angle is within [from, to).
struct HomeSwitch {
  int input = 0;  // of the axis, 1..4; 0: there is none
  double from_rad = 0, to_rad = 0;
};

struct AxisHardware {
  Encoder incremental{.lines = 32768};  // 131072 counts a turn
  bool incremental_cut = false;         // the counter gets no edges
  FittedAbsoluteEncoder absolute;
  /// Offset as the drive's table wants it: code 2 while the d axis is within -30..30 degrees.
  HallSensors halls{.offset_rad = std::numbers::pi * 5 / 6};
  enum class HallPlug : std::uint8_t { kNone, kEncoder, kP5 };
  HallPlug hall_plug = HallPlug::kEncoder;  // P1 or P2, or P5
  /// Which channel (0 U, 1 V, 2 W) each of the motor's phases is wired to.
  std::array<int, 3> wiring{0, 1, 2};
  HomeSwitch home_switch;
  /// The other pins, INP1..4 (axis 1) or INP5..8 (axis 2), bit 0 first.
  std::uint8_t input_pins = 0;
  bool amplifier_fault = false;  // the inverter's fault signal
  double inverter_degc = 35;
  std::array<double, 2> current_offset_a{};
};

struct Hardware {
  std::array<AxisHardware, 2> axis;
  /// S2-1, S2-2: ON (factory) reads the Halls of channel 1, 2 at the encoder's connector, else P5.
  std::array<bool, 2> dip_halls_at_encoder{true, true};
  bool dip_rs232 = true;  // S2-8

  // Converters, as built: +-20 A over 12 bits, 8 counts/V, 20 counts/degC.
  double current_full_scale_a = 20;
  double current_noise_a = 0.005;  // assumed: half a count
  /// Of the half bridges, as far as it is not compensated. The factory's PIOUT presumes that it is:
  /// 1 us would take 5.6 V of the 5.6 V that it puts on the motor.
  double dead_time_s = 0;
};

}  // namespace virtdrive::rzt1
