// What the drive is asked to do, from all who may ask: command word, terminals and panel, by their
// priorities.
#pragma once

#include "firmware_models/asd7/ac_drive.h"

namespace virtdrive::asd7 {

/// FD46 beyond FrequencySource.
inline constexpr std::uint16_t kSourcePreset = 10, kSourceJog = 11;

struct Asked {
  std::uint16_t command = 0, command2 = 0;  // FA00, FA20
  std::uint16_t frequency = 0;              // FA01
  std::uint16_t panel_frequency = 0;        // FA03
  bool panel_run = false;
  Terminals terminals;
};

struct Request {
  bool run = false;
  bool reverse = false;
  bool jog = false;
  bool dc_brake = false;
  bool coast = false;
  bool second_ramp = false;
  bool second_motor = false;
  bool pi_off = false;
  bool fastest_stop = false;
  CommandSource command_source{};
  std::uint16_t frequency_source = 0;
  double hz = 0;  // magnitude, within LL..UL, out of the jumps
};

Request request_of(const Asked& asked, const Settings& settings);

/// An analog input by its two points, Hz.
double analog_hz(std::uint16_t hundredths_percent, std::uint16_t point1, std::uint16_t frequency1,
                 std::uint16_t point2, std::uint16_t frequency2);
double via_hz(const Terminals& terminals, const Settings& settings);
double vib_hz(const Terminals& terminals, const Settings& settings);

/// Within LL..UL (and FH), out of the jump bands: within one, its lower edge.
double limited_hz(double hz, const Settings& settings);

}  // namespace virtdrive::asd7
