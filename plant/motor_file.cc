#include "plant/motor_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

using std::numbers::pi;
using std::numbers::sqrt2;
using std::numbers::sqrt3;

constexpr std::string_view kFormatKey = "virtdrive_motor";
constexpr double kRadpsPerKrpm = 1000 * pi / 30;

std::vector<std::string_view> names_of(const std::vector<MotorKey>& keys) {
  std::vector<std::string_view> names;
  for (const MotorKey& key : keys) names.push_back(key.name);
  return names;
}

const MotorKey& find_key(const std::vector<MotorKey>& keys, std::string_view name) {
  const auto it = std::ranges::find(keys, name, &MotorKey::name);
  VIRTDRIVE_CHECK(it != keys.end(), "{}", name);
  return *it;
}

// The values of a mapping behind their keys.
class Sheet {
 public:
  Sheet(const YamlValue& value, const std::vector<MotorKey>& keys)
      : keys_(&keys), map_(value.map(names_of(keys))) {}

  /// Refuses what does not fit together for this kind of machine.
  void check(MachineKind kind) const {
    for (const std::string_view name : map_.keys()) {
      if ((find_key(*keys_, name).kinds & only(kind)) == 0) {
        map_.fail_at_key(name, fmt::format("{} does not belong to kind {}", name, kind_name(kind)));
      }
    }
    for (const MotorKey& each : *keys_) {
      if ((each.kinds & only(kind)) == 0) continue;
      if (each.required && !has(each.name)) {
        map_.self().fail(fmt::format("{} is missing: {}", each.name, each.doc));
      }
      if (!each.with.empty() && has(each.name) && !has(each.with)) {
        map_.fail_at_key(each.name, fmt::format("{} needs {} beside it", each.name, each.with));
      }
      if (!each.group.empty()) check_group(each.group, &MotorKey::group, kind, true);
      if (!each.excludes.empty()) check_group(each.excludes, &MotorKey::excludes, kind, false);
    }
  }

  bool has(std::string_view name) const { return map_.has(name); }
  YamlValue operator[](std::string_view name) const { return map_[name]; }
  const MotorKey& key(std::string_view name) const { return find_key(*keys_, name); }

  double number(std::string_view name) const { return map_[name].number(key(name).range); }
  double number_or(std::string_view name, double otherwise) const {
    return has(name) ? number(name) : otherwise;
  }
  int integer(std::string_view name) const {
    return static_cast<int>(map_[name].integer(key(name).range));
  }
  std::size_t word_or(std::string_view name, std::size_t otherwise) const {
    return has(name) ? map_[name].word(key(name).words) : otherwise;
  }
  std::string text_or(std::string_view name, std::string otherwise) const {
    if (!has(name)) return otherwise;
    std::string text = map_[name].text();
    if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; })) {
      map_[name].fail(fmt::format("{}: expected one line of text", name));
    }
    return text;
  }
  std::vector<double> numbers(std::string_view name) const {
    const MotorKey& row = key(name);
    std::vector<double> values;
    for (const YamlValue& value : map_[name].list(row.least, row.most)) {
      values.push_back(value.number(row.range));
    }
    return values;
  }
  /// Row by row.
  std::vector<double> table(std::string_view name, std::size_t rows, std::size_t columns) const {
    std::vector<double> values;
    for (const YamlValue& row : map_[name].list(rows, rows)) {
      for (const YamlValue& value : row.list(columns, columns)) {
        values.push_back(value.number(key(name).range));
      }
    }
    return values;
  }
  Sheet sheet(std::string_view name) const { return {map_[name], key(name).keys}; }

 private:
  void check_group(std::string_view group, std::string_view MotorKey::* member, MachineKind kind,
                   bool needed) const {
    std::string choices;
    std::string_view given;
    for (const MotorKey& each : *keys_) {
      if (each.*member != group || (each.kinds & only(kind)) == 0) continue;
      choices += (choices.empty() ? "" : ", ") + std::string(each.name);
      if (!has(each.name)) continue;
      if (!given.empty()) {
        map_.fail_at_key(each.name, fmt::format("{} and {} say the same; expected one of them",
                                                each.name, given));
      }
      given = each.name;
    }
    if (needed && given.empty()) {
      map_.self().fail(fmt::format("{} is missing; expected one of {}", group, choices));
    }
  }

  const std::vector<MotorKey>* keys_;
  YamlMap map_;
};

std::string read_name(const Sheet& sheet) {
  constexpr std::size_t kMost = 40;
  std::string name = sheet["name"].text(kMost);
  const bool good = std::ranges::all_of(
      name, [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '-'; });
  if (!good) sheet["name"].fail("name: expected lower-case letters, digits and hyphens only");
  return name;
}

MotorRating read_rating(const Sheet& sheet, MachineKind kind) {
  const bool three_phases = (kThreePhase & only(kind)) != 0;
  const MotorRating rating{
      .voltage_v = sheet.number("rated_voltage_v"),
      .current_a = sheet.number("rated_current_a"),
      .counted_as = three_phases ? static_cast<CurrentRating>(sheet.word_or("rated_current_as", 0))
                                 : CurrentRating::kDc,
      .peak_current_a = sheet.number_or("peak_current_a", 0),
      .speed_rpm = sheet.number_or("rated_speed_rpm", 0),
      .torque_nm = kind == MachineKind::kVoiceCoil ? sheet.number_or("rated_force_n", 0)
                                                   : sheet.number_or("rated_torque_nm", 0),
      .power_w = sheet.number_or("rated_power_w", 0),
      .maximum_speed_rpm = sheet.number_or("maximum_speed_rpm", 0),
      .frequency_hz = kind == MachineKind::kInduction ? sheet.number("rated_frequency_hz") : 0};
  if (rating.peak_current_a > 0 && rating.peak_current_a < rating.current_a) {
    sheet["peak_current_a"].fail(fmt::format("peak_current_a is {}, below rated_current_a of {} A",
                                             rating.peak_current_a, rating.current_a));
  }
  if (rating.maximum_speed_rpm > 0 && rating.maximum_speed_rpm < rating.speed_rpm) {
    sheet["maximum_speed_rpm"].fail(
        fmt::format("maximum_speed_rpm is {}, below rated_speed_rpm of {} rpm",
                    rating.maximum_speed_rpm, rating.speed_rpm));
  }
  const double product_w = rating.torque_nm * rating.speed_rpm * pi / 30;
  if (rating.power_w > 0 && product_w > 0 && std::abs(rating.power_w / product_w - 1) > 0.25) {
    sheet["rated_power_w"].fail(
        fmt::format("rated_power_w is {}, but rated torque times rated speed is {:.4g} W",
                    rating.power_w, product_w));
  }
  return rating;
}

double phase_flux_wb(const Sheet& sheet, MachineKind kind, int pole_pairs) {
  if (sheet.has("magnet_flux_wb")) return sheet.number("magnet_flux_wb");
  // Torque = 1.5 p psi iq.
  if (sheet.has("torque_constant_nm_per_a")) {
    return sheet.number("torque_constant_nm_per_a") / (1.5 * pole_pairs);
  }
  if (sheet.has("torque_constant_nm_per_arms")) {
    return sheet.number("torque_constant_nm_per_arms") / (1.5 * sqrt2 * pole_pairs);
  }
  // Two flat tops in series.
  if (sheet.has("torque_constant_nm_per_adc")) {
    return sheet.number("torque_constant_nm_per_adc") / (2 * pole_pairs);
  }
  // A phase has an EMF of p w psi; two in series sqrt(3) of a sine's peak, or twice a flat top.
  const double peak_v = sheet.has("line_emf_vpk_per_krpm")
                            ? sheet.number("line_emf_vpk_per_krpm")
                            : sheet.number("line_emf_vrms_per_krpm") * sqrt2;
  const double phases = kind == MachineKind::kBldc ? 2 : sqrt3;
  return peak_v / (phases * pole_pairs * kRadpsPerKrpm);
}

std::shared_ptr<const AnalyticSaturation> read_saturation(const Sheet& sheet) {
  const Sheet s = sheet.sheet("saturation");
  s.check(MachineKind::kPmsm);
  return std::make_shared<AnalyticSaturation>(AnalyticSaturation{.d0 = s.number("d0"),
                                                                 .dd = s.number("dd"),
                                                                 .q0 = s.number("q0"),
                                                                 .qq = s.number("qq"),
                                                                 .dq = s.number("dq"),
                                                                 .s = s.integer("s"),
                                                                 .t = s.integer("t"),
                                                                 .u = s.integer("u"),
                                                                 .v = s.integer("v")});
}

std::vector<double> read_ascending(const Sheet& sheet, std::string_view name) {
  const std::vector<double> axis = sheet.numbers(name);
  const std::vector<YamlValue> values = sheet[name].list();
  for (std::size_t i = 1; i < axis.size(); ++i) {
    if (axis[i] > axis[i - 1]) continue;
    values[i].fail(fmt::format("{}: expected ascending values, but {} follows {}", name, axis[i],
                               axis[i - 1]));
  }
  return axis;
}

std::shared_ptr<const FluxMap> read_flux_map(const Sheet& sheet) {
  const Sheet s = sheet.sheet("flux_map");
  s.check(MachineKind::kPmsm);
  std::vector<double> d = read_ascending(s, "current_d_a"), q = read_ascending(s, "current_q_a");
  std::vector<double> flux_d = s.table("flux_d_wb", d.size(), q.size());
  std::vector<double> flux_q = s.table("flux_q_wb", d.size(), q.size());
  // Each flux along its own current, with the place of the value that does not grow.
  const auto require_growth = [&](std::string_view name, const std::vector<double>& flux,
                                  std::size_t row_step, std::size_t column_step) {
    for (std::size_t i = row_step; i < d.size(); ++i) {
      for (std::size_t k = column_step; k < q.size(); ++k) {
        const double before = flux[(i - row_step) * q.size() + k - column_step];
        const double value = flux[i * q.size() + k];
        if (value > before) continue;
        s[name].list()[i].list()[k].fail(fmt::format(
            "{}: not monotonic, {} follows {} at {} A, {} A", name, value, before, d[i], q[k]));
      }
    }
  };
  require_growth("flux_d_wb", flux_d, 1, 0);
  require_growth("flux_q_wb", flux_q, 0, 1);
  try {
    return std::make_shared<FluxMap>(std::move(d), std::move(q), std::move(flux_d),
                                     std::move(flux_q));
  } catch (const SetupError& error) {
    sheet["flux_map"].fail(error.what());
  }
}

void read_inductances(const Sheet& sheet, PmsmParameters& motor, MachineEffects& effects) {
  if (sheet.has("saturation")) {
    effects.saturation = read_saturation(sheet);
    // Those without current: at the magnets' flux.
    const AnalyticSaturation& a = *effects.saturation;
    const double magnets = std::pow(motor.flux_wb, a.s);
    motor.inductance_d_h = 1 / (a.d0 + (a.s + 1) * a.dd * magnets);
    motor.inductance_q_h =
        1 / (a.q0 + (a.v == 0 ? a.dq / (a.u + 2) * std::pow(motor.flux_wb, a.u + 2) : 0));
  } else if (sheet.has("flux_map")) {
    effects.flux_map = read_flux_map(sheet);
    const FluxMap::Point none = effects.flux_map->at({0, 0});
    motor.inductance_d_h = none.dd;
    motor.inductance_q_h = none.qq;
    if (std::abs(none.flux_wb.d - motor.flux_wb) > 0.02 * motor.flux_wb + 1e-9) {
      sheet["flux_map"].fail(fmt::format(
          "flux_map has {:.4g} Wb on the d axis without current, but the magnets give {:.4g} Wb",
          none.flux_wb.d, motor.flux_wb));
    }
  } else if (sheet.has("d_axis_inductance_h")) {
    motor.inductance_d_h = sheet.number("d_axis_inductance_h");
    motor.inductance_q_h = sheet.number("q_axis_inductance_h");
  } else {
    motor.inductance_d_h = sheet.has("line_inductance_h") ? sheet.number("line_inductance_h") / 2
                                                          : sheet.number("phase_inductance_h");
    motor.inductance_q_h = motor.inductance_d_h;
  }
}

EmfShape read_emf(const Sheet& sheet, MachineKind kind) {
  if (sheet.has("emf_shape")) {
    std::vector<double> samples = sheet.numbers("emf_shape");
    if (samples.size() % 3 != 0) {
      sheet["emf_shape"].fail(
          fmt::format("emf_shape: {} samples; expected a multiple of 3", samples.size()));
    }
    return {PeriodicTable(std::move(samples), Interpolation::kCubic)};
  }
  if (sheet.has("emf_harmonics")) {
    const MotorKey& key = sheet.key("emf_harmonics");
    std::vector<EmfShape::Harmonic> harmonics;
    for (const YamlValue& row : sheet["emf_harmonics"].list(1, 50)) {
      const std::vector<YamlValue> pair = row.list(2, 2);
      harmonics.push_back(
          {.order = static_cast<int>(pair[0].integer({.minimum = 1, .maximum = 100})),
           .amplitude = pair[1].number(key.range)});
    }
    return EmfShape::harmonics(harmonics);
  }
  if (kind != MachineKind::kBldc) return {};
  return EmfShape::trapezoid(sheet.number_or("emf_flat_deg", 120) * pi / 180);
}

CageParameters read_cage(const Sheet& sheet) {
  CageParameters cage{.rotor_resistance_ohm = sheet.number("rotor_resistance_ohm"),
                      .stator_leakage_h = sheet.number("stator_leakage_h"),
                      .rotor_leakage_h = sheet.number("rotor_leakage_h"),
                      .main_inductance_h = sheet.number("main_inductance_h"),
                      .saturation_flux_wb = sheet.number_or("saturation_flux_wb", 0)};
  cage.rotor_resistance_per_k =
      sheet.number_or("rotor_resistance_per_k", cage.rotor_resistance_per_k);
  if (sheet.has("saturation_exponent")) {
    cage.saturation_exponent = sheet.integer("saturation_exponent");
    if (cage.saturation_exponent % 2 != 0) {
      sheet["saturation_exponent"].fail(fmt::format(
          "saturation_exponent is {}; expected an even number", cage.saturation_exponent));
    }
  }
  return cage;
}

void read_windings(const Sheet& sheet, Motor& motor) {
  const double rated_a = sheet.number("rated_current_a");
  if (motor.kind == MachineKind::kBrushedDc || motor.kind == MachineKind::kVoiceCoil) {
    const double constant = sheet.has("force_constant_n_per_a")
                                ? sheet.number("force_constant_n_per_a")
                            : sheet.has("torque_constant_nm_per_adc")
                                ? sheet.number("torque_constant_nm_per_adc")
                                : sheet.number("line_emf_vpk_per_krpm") / kRadpsPerKrpm;
    motor.electrical = brushed_dc(sheet.number("line_resistance_ohm"),
                                  sheet.number("line_inductance_h"), constant, rated_a);
    motor.effects.commutator = true;
    return;
  }
  PmsmParameters& e = motor.electrical;
  e.pole_pairs = sheet.integer("pole_pairs");
  e.resistance_ohm = sheet.has("line_resistance_ohm") ? sheet.number("line_resistance_ohm") / 2
                                                      : sheet.number("phase_resistance_ohm");
  if (motor.kind == MachineKind::kInduction) {
    motor.effects.cage = read_cage(sheet);
    e = induction_stator(e.pole_pairs, e.resistance_ohm, *motor.effects.cage, rated_a);
    return;
  }
  e.flux_wb = phase_flux_wb(sheet, motor.kind, e.pole_pairs);
  e.rated_current_a = rated_a;
  read_inductances(sheet, e, motor.effects);
  motor.effects.emf = read_emf(sheet, motor.kind);
  // A reluctance machine needs no magnets, but then its axes must differ.
  if (e.flux_wb == 0 && e.inductance_d_h == e.inductance_q_h) {
    sheet["magnet_flux_wb"].fail(
        "magnet_flux_wb is 0 and both axes have the same inductance: such a machine has no torque");
  }
}

PeriodicTable read_cogging(const Sheet& sheet) {
  if (sheet.has("cogging_nm")) return {sheet.numbers("cogging_nm"), Interpolation::kCubic};
  if (!sheet.has("cogging_peak_nm")) return {};
  constexpr int kSamplesPerPeriod = 24;
  const int periods = sheet.integer("cogging_periods_per_turn");
  const double peak_nm = sheet.number("cogging_peak_nm");
  std::vector<double> samples(static_cast<std::size_t>(kSamplesPerPeriod * periods));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = peak_nm * std::sin(2 * pi * static_cast<double>(i) / kSamplesPerPeriod);
  }
  return {std::move(samples), Interpolation::kCubic};
}

ThermalParameters read_thermal(const Sheet& sheet) {
  ThermalParameters t;
  t.winding_housing_k_per_w = sheet.number_or("winding_housing_k_per_w", 0);
  t.housing_ambient_k_per_w = sheet.number_or("housing_ambient_k_per_w", 0);
  t.winding_j_per_k = sheet.number_or("winding_heat_capacity_j_per_k", 0);
  t.housing_j_per_k = sheet.number_or("housing_heat_capacity_j_per_k", 0);
  t.ambient_degc = sheet.number_or("ambient_degc", t.ambient_degc);
  t.reference_degc = sheet.number_or("reference_degc", t.reference_degc);
  t.resistance_per_k = sheet.number_or("resistance_per_k", t.resistance_per_k);
  t.flux_per_k = sheet.number_or("magnet_flux_per_k", t.flux_per_k);
  return t;
}

MechanicsParameters read_mechanics(const Sheet& sheet, MachineKind kind) {
  if (kind == MachineKind::kVoiceCoil) {
    return {.inertia_kgm2 = sheet.number("moving_mass_kg"),
            .viscous_nm_per_radps = sheet.number_or("viscous_friction_n_per_mps", 0),
            .coulomb_nm = sheet.number_or("coulomb_friction_n", 0)};
  }
  const MechanicsParameters mechanics{
      .inertia_kgm2 = sheet.number("rotor_inertia_kgm2"),
      .viscous_nm_per_radps = sheet.number_or("viscous_friction_nm_per_radps", 0),
      .coulomb_nm = sheet.number_or("coulomb_friction_nm", 0),
      .stiction_nm = sheet.number_or("breakaway_friction_nm", 0),
      .stribeck_radps = sheet.number_or("stribeck_speed_radps", 0)};
  if (sheet.has("breakaway_friction_nm") && mechanics.stiction_nm < mechanics.coulomb_nm) {
    sheet["breakaway_friction_nm"].fail(
        fmt::format("breakaway_friction_nm is {}, below coulomb_friction_nm of {} Nm",
                    mechanics.stiction_nm, mechanics.coulomb_nm));
  }
  return mechanics;
}

}  // namespace

Motor parse_motor(const YamlFile& file) {
  const Sheet sheet(file.root(), motor_keys());
  sheet.integer(kFormatKey);  // first: another version, other rules
  Motor motor;
  motor.kind = static_cast<MachineKind>(sheet["kind"].word(sheet.key("kind").words));
  sheet.check(motor.kind);
  motor.name = read_name(sheet);
  motor.description = sheet.text_or("description", "");
  motor.source = sheet.text_or("source", "");
  motor.assumed = sheet.text_or("assumed", "");
  motor.rating = read_rating(sheet, motor.kind);
  read_windings(sheet, motor);
  motor.effects.cogging_nm = read_cogging(sheet);
  motor.effects.iron_eddy_w_per_v2 = sheet.number_or("iron_eddy_w_per_v2", 0);
  motor.effects.iron_hysteresis_w = sheet.number_or("iron_hysteresis_ws_per_wb2", 0);
  motor.effects.thermal = read_thermal(sheet);
  motor.mechanics = read_mechanics(sheet, motor.kind);
  return motor;
}

}  // namespace virtdrive
