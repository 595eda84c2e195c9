// The seventeen controllers of the document's table (p. 2): what they have, what they stand, and
// the motor that a bench gives them.
#pragma once

#include <span>
#include <string_view>

#include "firmware_models/md/settings.h"

namespace virtdrive::md {

/// DC link voltages at which a board acts (V). Assumed: the document names no number.
struct BusLimits {
  double off_below;  // output off; on again 5 % higher
  double over;       // OVER_VOLT
};

struct Model {
  std::string_view name;       // as typed: "md400t"
  std::string_view title;      // as PID 205 has it: "MD400T"
  double lowest_v, highest_v;  // supply, as printed; AC (rms) where `ac`
  bool ac;
  double current_a;  // rated, each motor; MAX_LOAD by default
  std::size_t motors;

  // What the document's table marks. RS-485 is offered on all of them.
  bool rs485, ttl232, can, encoder, pulse, rc, clutch, power_switch;

  int baud_code;           // 1: 9600, 2: 19200 (p. 4)
  std::string_view motor;  // in the motor library
  double bus_v;            // the bench's supply, DC
  BusLimits bus;
  double capacitance_f;     // of the DC link
  bool temperature_sensor;  // without: reported as 0, no derating
  int hall_type;            // PID 21 for that motor
  int max_rpm;
  double rated_torque_nm;  // of that motor
};

std::span<const Model> models();

/// The settings that it leaves the factory with.
Settings default_settings(const Model& model);

/// MAX_LOAD in A: the setting, or the model's where that is 0; at most 150 % of the model's.
double max_load_a(const Model& model, const Settings& settings);

}  // namespace virtdrive::md
