// The three sizes: what their power stages stand, and the motor and supply that a bench gives them.
// All numbers are one consistent set chosen for this bench; only the rated output currents are
// those of later drives of the family (E6581301).
#pragma once

#include <span>
#include <string_view>

#include "firmware_models/asd7/settings.h"
#include "plant/axis.h"

namespace virtdrive::asd7 {

/// Voltages of the DC link at which the drive acts.
struct LinkLevels {
  double off_below_v, on_above_v;  // MOFF
  double resistor_on_v, resistor_off_v;
  double limit_v;  // overvoltage limit
  double trip_v;
  double control_v;  // below it the CPU has no supply
};

struct Model {
  std::string_view name;  // as typed: "0.75"
  double power_w;
  double class_v;   // 200 or 400: FD04, FD05
  double supply_v;  // rms, between two lines
  double supply_hz;
  double rated_current_a;  // FE70, rms
  std::string_view motor;  // in the motor library
  double capacitance_f;
  double standing_load_w;
  double braking_ohm, braking_w;  // resistor, an option
  double limit_raise_hz;          // how far the overvoltage limit lifts the frequency
  double stator_ohm;              // as found by its tuning
  double demagnetize_s;           // until the motor's own field is gone
  double mains_ohm, mains_h;      // of the loop that feeds the link
  double charging_ohm;
  LinkLevels link;
  int capacity_code;  // FB05
};

/// In order of size.
std::span<const Model> models();
/// SetupError with the choices for an unknown name.
const Model& find_model(std::string_view name);

/// As it leaves the factory.
Settings default_settings(const Model& model);

/// How a bench feeds it: mains through a diode bridge. `phases` is 1 or 3; `voltage_v` between two
/// lines, rms.
DcLinkParameters mains_link(const Model& model, int phases, double voltage_v, double frequency_hz);
/// At its rated supply.
DcLinkParameters mains_link(const Model& model);
/// What the bridge loses.
InverterParameters inverter_of(const Model& model);

}  // namespace virtdrive::asd7
