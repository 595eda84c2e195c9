#include "firmware_models/asd7/model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive::asd7 {
namespace {

constexpr LinkLevels k200{.off_below_v = 200,
                          .on_above_v = 215,
                          .resistor_on_v = 375,
                          .resistor_off_v = 365,
                          .limit_v = 385,
                          .trip_v = 410,
                          .control_v = 120};
constexpr LinkLevels k400{.off_below_v = 400,
                          .on_above_v = 430,
                          .resistor_on_v = 750,
                          .resistor_off_v = 730,
                          .limit_v = 798,
                          .trip_v = 820,
                          .control_v = 240};

constexpr std::array kModels = {
    Model{.name = "0.75",
          .power_w = 750,
          .class_v = 200,
          .supply_v = 230,
          .supply_hz = 60,
          .rated_current_a = 4.8,
          .motor = "asd-0-75kw",
          .capacitance_f = 560e-6,
          .standing_load_w = 15,
          .braking_ohm = 200,
          .braking_w = 120,
          .limit_raise_hz = 8,
          .stator_ohm = 3.11,
          .demagnetize_s = 0.3,
          .mains_ohm = 0.4,
          .mains_h = 2.8e-3,
          .charging_ohm = 40,
          .link = k200,
          .capacity_code = 2},
    Model{.name = "4",
          .power_w = 4000,
          .class_v = 400,
          .supply_v = 460,
          .supply_hz = 60,
          .rated_current_a = 7.6,
          .motor = "asd-4kw",
          .capacitance_f = 470e-6,
          .standing_load_w = 30,
          .braking_ohm = 160,
          .braking_w = 200,
          .limit_raise_hz = 6,
          .stator_ohm = 1.48,
          .demagnetize_s = 0.6,
          .mains_ohm = 0.3,
          .mains_h = 2.6e-3,
          .charging_ohm = 60,
          .link = k400,
          .capacity_code = 26},
    Model{.name = "22",
          .power_w = 22000,
          .class_v = 400,
          .supply_v = 460,
          .supply_hz = 60,
          .rated_current_a = 40.0,
          .motor = "asd-22kw",
          .capacitance_f = 2.2e-3,
          .standing_load_w = 100,
          .braking_ohm = 15,
          .braking_w = 3600,
          .limit_raise_hz = 3,
          .stator_ohm = 0.133,
          .demagnetize_s = 1.2,
          .mains_ohm = 0.06,
          .mains_h = 1.0e-3,
          .charging_ohm = 20,
          .link = k400,
          .capacity_code = 31},
};

// Of the switches and diodes: 1.2 % of link voltage times output current.
constexpr double kBridgeLoss = 0.012;
// Of the braking resistor: 300 K over ambient at its rating, with a time constant of 120 s.
constexpr double kResistorK = 300, kResistorS = 120;

std::uint16_t tenths(double value) {
  return static_cast<std::uint16_t>(std::lround(value * 10));
}

}  // namespace

std::span<const Model> models() {
  return kModels;
}

const Model& find_model(std::string_view name) {
  const auto found = std::ranges::find(kModels, name, &Model::name);
  if (found != kModels.end()) return *found;
  std::vector<std::string_view> names;
  for (const Model& model : kModels) names.push_back(model.name);
  throw SetupError(unknown_name("size of the 7-Series drive (kW)", name, names));
}

Settings default_settings(const Model& model) {
  Settings s;
  s.resistor_ohm = tenths(model.braking_ohm);
  s.resistor_power = static_cast<std::uint16_t>(std::lround(model.braking_w / 10));
  if (model.name == "4") {
    s.torque_boost1 = s.torque_boost2 = 40;
    s.boost_gain = 27;
    s.rated_current = 68;
    s.no_load_current = 50;
    s.rated_rpm = 1744;
  } else if (model.name == "22") {
    s.acceleration1 = s.deceleration1 = s.acceleration2 = s.deceleration2 = 300;
    s.torque_boost1 = s.torque_boost2 = 20;
    s.carrier = 80;
    s.boost_gain = 12;
    s.rated_current = 340;
    s.no_load_current = 39;
    s.rated_rpm = 1770;
  }
  return s;
}

DcLinkParameters mains_link(const Model& model, int phases, double voltage_v, double frequency_hz) {
  return {.source_v = std::numbers::sqrt2 * voltage_v,
          .mains = {.phases = phases,
                    .voltage_v = voltage_v,
                    .frequency_hz = frequency_hz,
                    .resistance_ohm = model.mains_ohm,
                    .inductance_h = model.mains_h,
                    .charging_ohm = model.charging_ohm},
          .capacitance_f = model.capacitance_f,
          .board_w = model.standing_load_w,
          .board_cutoff_v = model.link.control_v / 2,
          .chopper = {.on_v = model.link.resistor_on_v,
                      .off_v = model.link.resistor_off_v,
                      .resistance_ohm = model.braking_ohm,
                      .heat_capacity_j_per_k = model.braking_w * kResistorS / kResistorK,
                      .ambient_k_per_w = kResistorK / model.braking_w}};
}

DcLinkParameters mains_link(const Model& model) {
  return mains_link(model, 3, model.supply_v, model.supply_hz);
}

InverterParameters inverter_of(const Model&) {
  return {.loss_share = kBridgeLoss};
}

}  // namespace virtdrive::asd7
