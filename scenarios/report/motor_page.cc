#include "scenarios/report/motor_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <numbers>
#include <vector>

#include "plant/induction_curves.h"
#include "plant/motor_curves.h"
#include "scenarios/report/chart.h"
#include "scenarios/report/svg_plot.h"

namespace virtdrive {
namespace {

constexpr double kRpmPerRadps = 30 / std::numbers::pi;

// Pixels.
constexpr double kWidth = 960;
constexpr double kMargin = 24;
constexpr double kLeft = 74;  // of a plot, for its numbers
constexpr double kHalf = (kWidth - 2 * kMargin) / 2;
constexpr double kTorqueHeight = 240;
constexpr double kSmallHeight = 170;
constexpr double kMapHeight = 290;
constexpr double kGap = 74;                 // between a plot and the next one's frame
constexpr double kCell = 2;                 // of the map as drawn
constexpr double kNodeX = 8, kNodeY = 5.8;  // between two computed points of it
constexpr int kSpeeds = 240;

// Efficiency in bands, each with the colour that begins at its lower end: equal steps of viridis.
struct Band {
  double from;  // %
  std::string_view color;
};
constexpr auto kBands = std::to_array<Band>({{0, "#440154"},
                                             {30, "#481b6d"},
                                             {50, "#46327e"},
                                             {60, "#3f4788"},
                                             {70, "#365c8d"},
                                             {75, "#2e6e8e"},
                                             {80, "#277f8e"},
                                             {85, "#21918c"},
                                             {88, "#1fa187"},
                                             {90, "#2db27d"},
                                             {92, "#4ac16d"},
                                             {94, "#73d056"},
                                             {95, "#a0da39"},
                                             {96, "#d0e11c"},
                                             {97, "#fde725"},
                                             {98, "#fff7b0"}});

std::size_t band_of(double efficiency) {
  std::size_t band = 0;
  while (band + 1 < kBands.size() && efficiency * 100 >= kBands[band + 1].from) ++band;
  return band;
}

using Curve = std::vector<OperatingPoint>;
using Value = std::function<double(const OperatingPoint&)>;

double torque_of(const OperatingPoint& point) {
  return std::max(0.0, point.torque_nm);
}

double greatest(const Curve& curve, const Value& value) {
  double most = 0;
  for (const OperatingPoint& point : curve) most = std::max(most, value(point));
  return most;
}

// The most torque from standstill to where none is left, or the end of the plot.
Curve envelope(const SteadyMotor& motor, const DriveLimits& limits, double last_radps) {
  Curve curve;
  for (int i = 0; i <= kSpeeds; ++i) {
    const auto point = most_torque(motor, limits, last_radps * i / kSpeeds);
    if (!point || point->torque_nm < 0) break;
    curve.push_back(*point);
  }
  return curve;
}

using Facts = std::vector<std::pair<std::string, std::string>>;

// What is above the plots, in four columns; where the first plot begins.
double put_table(Chart& chart, const Facts& facts) {
  constexpr int kColumns = 4;
  constexpr double kTop = 92, kRow = 42;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    const double x =
        kMargin + static_cast<double>(i % kColumns) * (kWidth - 2 * kMargin) / kColumns;
    const double y = kTop + static_cast<double>(i / kColumns) * kRow;
    chart.put(
        "<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text><text class=\"value\" x=\"{:.1f}\" "
        "y=\"{:.1f}\">{}</text>\n",
        x, y, facts[i].first, x, y + 18, facts[i].second);
  }
  return kTop + 3 * kRow + 46;
}

class Page {
 public:
  explicit Page(const Motor& motor)
      : motor_(motor),
        steady_(motor),
        constants_(motor_constants(steady_)),
        has_peak_(motor.rating.peak_current_a > motor.rating.current_a),
        rated_limits_(limits_of(motor)),
        outer_limits_(limits_of(motor, true)),
        chart_(motor.name, kWidth) {
    // With a strong field weakening there is no end by itself.
    constexpr double kWeakening = 2.5, kFastest = 5e4;
    const double no_load_radps =
        std::isfinite(constants_.no_load_radps) ? constants_.no_load_radps : constants_.base_radps;
    double last_radps = std::min(kWeakening * no_load_radps, kFastest);
    if (motor.rating.maximum_speed_rpm > 0) {
      last_radps = std::min(last_radps, motor.rating.maximum_speed_rpm / kRpmPerRadps);
    }
    outer_ = envelope(steady_, outer_limits_, last_radps);
    if (outer_.size() > 1) last_radps = outer_.back().speed_radps;
    outer_ = envelope(steady_, outer_limits_, last_radps);
    rated_ = envelope(steady_, rated_limits_, last_radps);
    speed_axis_ = speed_axis(last_radps, 12);
  }

  std::string svg() {
    put_facts();
    put_torque();
    put_power_and_current();
    put_map();
    return chart_.svg(y_ + 14);
  }

 private:
  bool coil() const { return motor_.kind == MachineKind::kVoiceCoil; }
  /// What of the axis of speeds is a rad/s: rpm, or m/s of what moves along a line.
  double per_radps() const { return coil() ? 1 : kRpmPerRadps; }
  Scale speed_axis(double last_radps, int ticks) const {
    return scale_up_to(last_radps * per_radps(), ticks, coil() ? "m/s" : "rpm");
  }
  std::vector<Point> points_of(const Curve& curve, const Value& value) const {
    std::vector<Point> points;
    for (const OperatingPoint& p : curve) points.push_back({p.speed_radps * per_radps(), value(p)});
    return points;
  }
  void put_curve(const Plot& plot, const Curve& curve, const Value& value,
                 std::string_view classes) {
    chart_.curve(plot, points_of(curve, value), classes);
  }
  std::string area_of(const Plot& plot, const Curve& curve) const {
    std::vector<Point> points = points_of(curve, torque_of);
    if (points.empty()) return {};
    points.push_back({points.back().x, 0});
    points.push_back({0, 0});
    return path_of(plot, points) + "Z";
  }
  std::string torque_unit() const { return coil() ? "N" : "Nm"; }

  void put_facts() {
    constexpr std::size_t kLongTitle = 70;
    chart_.put("<text class=\"{}\" x=\"{}\" y=\"40\">{}</text>\n",
               motor_.description.size() > kLongTitle ? "head" : "title", kMargin,
               escape_xml(motor_.description));
    std::string source = motor_.source;
    constexpr std::size_t kMost = 130;
    if (source.size() > kMost) source = source.substr(0, kMost) + " ...";
    chart_.put("<text x=\"{}\" y=\"62\">{}: {}</text>\n", kMargin, escape_xml(motor_.name),
               escape_xml(source));
    const MotorRating& r = motor_.rating;
    const PmsmParameters& e = steady_.machine();
    constexpr std::string_view kCounted[] = {"peak", "rms", "DC"};
    const auto shown = [](double value, std::string_view unit) {
      return std::isfinite(value) ? fmt::format("{:.4g} {}", value, unit) : std::string("none");
    };
    const bool phases = !steady_.two_terminals();
    const std::string newton = torque_unit();
    Facts facts = {
        {"Rated voltage", shown(r.voltage_v, "V")},
        {"Rated current",
         fmt::format("{:.4g} A {}", r.current_a, kCounted[static_cast<std::size_t>(r.counted_as)])},
        {coil() ? "Force at rated current" : "Torque at rated current",
         shown(constants_.rated_torque_nm, newton)},
        {"No-load speed", coil() ? shown(constants_.no_load_radps, "m/s")
                                 : shown(constants_.no_load_radps * kRpmPerRadps, "rpm")},
        {coil() ? "Force constant" : "Torque constant",
         fmt::format("{:.4g} {}/A{}", constants_.torque_constant_nm_per_a, newton,
                     phases ? " peak" : "")},
        {phases ? "Phase resistance" : "Resistance", shown(steady_.resistance_ohm(), "Ohm")},
        {phases ? "Inductance d, q" : "Inductance",
         phases ? fmt::format("{:.4g}, {:.4g} mH", e.inductance_d_h * 1e3, e.inductance_q_h * 1e3)
                : shown(e.inductance_q_h * 1e3, "mH")},
        {coil() ? "Moving mass" : "Rotor inertia",
         shown(motor_.mechanics.inertia_kgm2, coil() ? "kg" : "kg m2")},
        {"Electrical time constant", shown(constants_.electrical_time_constant_s * 1e3, "ms")},
        {"Mechanical time constant", shown(constants_.mechanical_time_constant_s * 1e3, "ms")},
        {"Stall current", shown(constants_.stall_current_a, phases ? "A peak" : "A")}};
    if (phases) facts.emplace_back("Pole pairs", fmt::format("{}", e.pole_pairs));
    y_ = put_table(chart_, facts);
  }

  std::string at_current(const DriveLimits& limits) const {
    return fmt::format("{:.4g} A{}", limits.current_a,
                       steady_.two_terminals() ? "" : " peak of a phase");
  }

  void put_rated_point(const Plot& f) {
    const MotorRating& r = motor_.rating;
    double torque_nm = r.torque_nm;
    if (torque_nm == 0 && r.power_w > 0 && r.speed_rpm > 0) {
      torque_nm = r.power_w * kRpmPerRadps / r.speed_rpm;
    }
    if (torque_nm == 0 || r.speed_rpm == 0 || r.speed_rpm > f.x.high || torque_nm > f.y.high) {
      return;
    }
    chart_.put(
        "<circle class=\"rated\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\"><title>Rated: {:.4g} Nm at "
        "{:.4g} rpm</title></circle>\n",
        f.px(r.speed_rpm), f.py(torque_nm), torque_nm, r.speed_rpm);
  }

  void put_torque() {
    const Plot f{kMargin + kLeft,
                 y_,
                 kWidth - 2 * kMargin - kLeft,
                 kTorqueHeight,
                 speed_axis_,
                 scale_up_to(greatest(outer_, torque_of) * 1.02, 7, torque_unit())};
    chart_.heading(f, coil() ? "Force over speed" : "Torque over speed");
    std::vector<Chart::Key> keys = {{"blue", "rated current: " + at_current(rated_limits_)}};
    if (has_peak_) keys.push_back({"orange", "for a short time: " + at_current(outer_limits_)});
    chart_.keys(f, keys);
    chart_.axes(f);
    if (has_peak_) {
      chart_.put("<path class=\"fill-orange\" d=\"{}\"/>\n", area_of(f, outer_));
      put_curve(f, outer_, torque_of, "orange");
    }
    chart_.put("<path class=\"fill-blue\" d=\"{}\"/>\n", area_of(f, rated_));
    put_curve(f, rated_, torque_of, "blue");
    const double no_load_x = f.px(constants_.no_load_radps * per_radps());
    if (no_load_x <= f.left + f.width && !steady_.two_terminals()) {
      const bool right = no_load_x < f.left + f.width * 0.8;
      chart_.put(
          "<path class=\"mark\" d=\"M{:.1f} {:.1f}v{:.1f}\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
          "text-anchor=\"{}\">no load, id = 0</text>\n",
          no_load_x, f.top, f.height, no_load_x + (right ? 6 : -6), f.top + 14,
          right ? "start" : "end");
    }
    put_rated_point(f);
    y_ += kTorqueHeight + kGap;
  }

  void put_power_and_current() {
    const auto power = [](const OperatingPoint& p) { return std::max(0.0, p.output_w); };
    const double most_w = greatest(outer_, power);
    const bool kilowatts = most_w >= 2000;
    const double per_unit = kilowatts ? 1e-3 : 1;
    const auto shown_power = [&](const OperatingPoint& p) { return power(p) * per_unit; };
    const Scale speed = speed_axis(speed_axis_.high / per_radps(), 6);
    const double width = kHalf - kLeft - 8;
    const Plot left{
        kMargin + kLeft, y_,    width,
        kSmallHeight,    speed, scale_up_to(most_w * per_unit * 1.02, 6, kilowatts ? "kW" : "W")};
    chart_.heading(left, "Power at the shaft");
    chart_.axes(left);
    if (has_peak_) {
      put_curve(left, outer_, shown_power, "orange");
    }
    put_curve(left, rated_, shown_power, "blue");

    const double bus_v = motor_.rating.voltage_v;
    const Value phase = [](const OperatingPoint& p) { return p.current_peak_a(); };
    const Value link = [bus_v](const OperatingPoint& p) {
      return std::max(0.0, p.input_w) / bus_v;
    };
    const double most_a = std::max(greatest(rated_, phase), greatest(rated_, link));
    const Plot right{kMargin + kHalf + kLeft + 8,       y_, width, kSmallHeight, speed,
                     scale_up_to(most_a * 1.05, 6, "A")};
    chart_.heading(right, "Current at the rated limit");
    chart_.keys(right, {{"blue", steady_.two_terminals() ? "motor" : "phase, peak"},
                        {"green dashed", "DC link"}});
    chart_.axes(right);
    put_curve(right, rated_, phase, "blue");
    put_curve(right, rated_, link, "green dashed");
    y_ += kSmallHeight + kGap;
  }

  void put_map() {
    constexpr double kScale = 92;  // for the colours' key
    const Plot f{kMargin + kLeft,
                 y_,
                 kWidth - 2 * kMargin - kLeft - kScale,
                 kMapHeight,
                 speed_axis_,
                 scale_up_to(greatest(outer_, torque_of) * 1.02, 7, torque_unit())};
    chart_.heading(f, "Efficiency: shaft power over electrical power, copper and friction");
    chart_.axes(f);
    chart_.put(
        "<clipPath id=\"reach\"><path d=\"{}\"/></clipPath>\n<g clip-path=\"url(#reach)\">\n",
        area_of(f, outer_));
    const OperatingPoint best = put_cells(f);
    chart_.put("</g>\n");
    if (has_peak_) {
      chart_.put("<path class=\"rim dashed\" d=\"{}\"/>\n",
                 path_of(f, points_of(rated_, torque_of)));
    }
    chart_.put("<path class=\"rim\" d=\"{}\"/>\n", path_of(f, points_of(outer_, torque_of)));
    put_rated_point(f);
    put_scale(f, band_of(best.efficiency()));
    chart_.put("<text x=\"{:.1f}\" y=\"{:.1f}\">best {:.1f} % at {:.3g} {}, {:.4g} {}{}{}</text>\n",
               f.left, f.top + f.height + 34, best.efficiency() * 100, best.torque_nm,
               torque_unit(), best.speed_radps * per_radps(), f.x.unit,
               has_peak_ ? "; dashed: rated current" : "",
               friction_free() ? "; the set has no friction" : "");
    y_ += kMapHeight + 40;
  }

  bool friction_free() const {
    return motor_.mechanics.coulomb_nm == 0 && motor_.mechanics.viscous_nm_per_radps == 0;
  }

  // The efficiency at nodes over the frame; a node beyond the reach has that of the rim below it.
  struct Nodes {
    int columns, rows;
    std::vector<double> efficiency;
    OperatingPoint best;

    double at(double column, double row) const {
      const int i = std::clamp(static_cast<int>(column), 0, columns - 2);
      const int k = std::clamp(static_cast<int>(row), 0, rows - 2);
      const auto node = [&](int x, int y) {
        return efficiency[static_cast<std::size_t>(y * columns + x)];
      };
      return std::lerp(std::lerp(node(i, k), node(i + 1, k), column - i),
                       std::lerp(node(i, k + 1), node(i + 1, k + 1), column - i), row - k);
    }
  };

  Nodes compute_nodes(const Plot& f) const {
    Nodes nodes{.columns = static_cast<int>(f.width / kNodeX) + 2,
                .rows = static_cast<int>(f.height / kNodeY) + 2,
                .efficiency = {},
                .best = {}};
    const double last_radps = outer_.empty() ? 0 : outer_.back().speed_radps;
    nodes.efficiency.resize(static_cast<std::size_t>(nodes.columns * nodes.rows));
    for (int column = 0; column < nodes.columns; ++column) {
      const double speed_radps = column * kNodeX / f.width * f.x.high / per_radps();
      const auto rim = most_torque(steady_, outer_limits_, speed_radps);
      const double rim_efficiency = rim ? rim->efficiency() : 0;
      for (int row = 0; row < nodes.rows; ++row) {
        const double torque_nm = row * kNodeY / f.height * f.y.high;
        const auto point = least_current(steady_, outer_limits_, torque_nm, speed_radps);
        if (point && speed_radps <= last_radps && point->efficiency() > nodes.best.efficiency())
          nodes.best = *point;
        nodes.efficiency[static_cast<std::size_t>(row * nodes.columns + column)] =
            point ? point->efficiency() : rim_efficiency;
      }
    }
    return nodes;
  }

  // A path a band; cells of one band in a row are one rectangle of it. Returns the best point.
  OperatingPoint put_cells(const Plot& f) {
    const Nodes nodes = compute_nodes(f);
    std::array<std::string, kBands.size()> paths;
    const int columns = static_cast<int>(f.width / kCell),
              rows = static_cast<int>(f.height / kCell);
    for (int row = 0; row < rows; ++row) {
      const auto band_at = [&](int column) {
        return band_of(nodes.at((column + 0.5) * kCell / kNodeX, (row + 0.5) * kCell / kNodeY));
      };
      for (int first = 0, next = 0; first < columns; first = next) {
        const std::size_t band = band_at(first);
        while (next < columns && band_at(next) == band) ++next;
        fmt::format_to(std::back_inserter(paths[band]), "M{:.0f} {:.0f}h{:.0f}v{:.0f}h-{:.0f}z",
                       f.left + first * kCell, f.top + f.height - (row + 1) * kCell,
                       (next - first) * kCell, kCell, (next - first) * kCell);
      }
    }
    for (std::size_t band = 0; band < kBands.size(); ++band) {
      if (paths[band].empty()) continue;
      chart_.put("<path fill=\"{0}\" stroke=\"{0}\" stroke-width=\"0.4\" d=\"{1}\"/>\n",
                 kBands[band].color, paths[band]);
    }
    return nodes.best;
  }

  void put_scale(const Plot& f, std::size_t highest) {
    const double height = std::min(18.0, f.height / static_cast<double>(highest + 1));
    const double x = f.left + f.width + 26;
    for (std::size_t band = 0; band <= highest; ++band) {
      const double y = f.top + f.height - static_cast<double>(band + 1) * height;
      chart_.put(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"16\" height=\"{:.1f}\" fill=\"{}\"/>"
          "<text x=\"{:.1f}\" y=\"{:.1f}\">{} %</text>\n",
          x, y, height + 0.4, kBands[band].color, x + 24, y + height + 4, kBands[band].from);
    }
  }

  const Motor& motor_;
  SteadyMotor steady_;
  MotorConstants constants_;
  bool has_peak_;
  DriveLimits rated_limits_, outer_limits_;
  Curve rated_, outer_;
  Scale speed_axis_;
  Chart chart_;
  double y_ = 0;  // where the next plot's frame begins
};

// An induction machine: what it does on its rated supply from standstill to synchronism, and with
// the same flux at lower frequencies.
class InductionPage {
 public:
  explicit InductionPage(const Motor& motor)
      : motor_(motor),
        supply_(rated_supply(motor)),
        rated_(induction_at_power(motor, supply_, rated_power_w(motor.rating))),
        synchronous_rpm_(60 * supply_.frequency_hz / motor.electrical.pole_pairs),
        chart_(motor.name, kWidth) {
    for (const double share : {1.0, 0.75, 0.5, 0.25}) {
      const InductionSupply supply{share * supply_.line_v, share * supply_.frequency_hz};
      Points points;
      for (int i = 0; i <= kSpeeds; ++i) {
        // Denser towards synchronism, where the curve is steep.
        const double slip = std::pow(1 - static_cast<double>(i) / kSpeeds, 2);
        points.push_back(induction_point(motor, supply, slip));
      }
      curves_.push_back(std::move(points));
    }
  }

  std::string svg() {
    put_texts();
    put_torque();
    put_current();
    return chart_.svg(y_ + 14);
  }

 private:
  using Points = std::vector<InductionPoint>;
  using PointValue = std::function<double(const InductionPoint&)>;

  void put_curve(const Plot& plot, const Points& points, const PointValue& value,
                 std::string_view classes) {
    std::vector<Point> shown;
    for (const InductionPoint& point : points) {
      shown.push_back({point.speed_radps * kRpmPerRadps, std::max(0.0, value(point))});
    }
    chart_.curve(plot, shown, classes);
  }
  double most(const PointValue& value) const {
    double most = 0;
    for (const InductionPoint& point : curves_.front()) most = std::max(most, value(point));
    return most;
  }

  void put_texts() {
    const CageParameters& c = *motor_.effects.cage;
    const InductionPoint idle = induction_no_load(motor_, supply_);
    const InductionPoint breakdown = induction_breakdown(motor_, supply_);
    const InductionPoint locked = induction_point(motor_, supply_, 1);
    chart_.put("<text class=\"title\" x=\"{:.1f}\" y=\"38\">{}</text>\n", kMargin,
               escape_xml(motor_.name));
    chart_.put("<text x=\"{:.1f}\" y=\"60\">{}</text>\n", kMargin, escape_xml(motor_.description));
    y_ = put_table(
        chart_,
        {{"Supply", fmt::format("{:.4g} V, {:.4g} Hz", supply_.line_v, supply_.frequency_hz)},
         {"Rated power", fmt::format("{:.4g} W", rated_.output_w)},
         {"Speed at rated power", fmt::format("{:.4g} rpm", rated_.speed_radps * kRpmPerRadps)},
         {"Torque at rated power", fmt::format("{:.4g} Nm", rated_.torque_nm)},
         {"Current at rated power", fmt::format("{:.4g} A rms", rated_.current_a)},
         {"Power factor, efficiency",
          fmt::format("{:.2f}, {:.1f} %", rated_.power_factor, 100 * rated_.efficiency())},
         {"No-load current", fmt::format("{:.4g} A rms", idle.current_a)},
         {"Locked-rotor current", fmt::format("{:.4g} A rms", locked.current_a)},
         {"Breakdown torque", fmt::format("{:.4g} Nm at {:.4g} rpm", breakdown.torque_nm,
                                          breakdown.speed_radps * kRpmPerRadps)},
         {"Rs, Rr", fmt::format("{:.4g}, {:.4g} Ohm", motor_.electrical.resistance_ohm,
                                c.rotor_resistance_ohm)},
         {"Leakage, stator and rotor",
          fmt::format("{:.4g}, {:.4g} mH", c.stator_leakage_h * 1e3, c.rotor_leakage_h * 1e3)},
         {"Main inductance", fmt::format("{:.4g} mH unsaturated", c.main_inductance_h * 1e3)}});
  }

  void put_torque() {
    const PointValue torque = [](const InductionPoint& p) { return p.torque_nm; };
    const Plot f{kMargin + kLeft,
                 y_,
                 kWidth - 2 * kMargin - kLeft,
                 kTorqueHeight,
                 scale_up_to(synchronous_rpm_, 10, "rpm"),
                 scale_up_to(most(torque) * 1.02, 7, "Nm")};
    chart_.heading(f, "Torque over speed");
    chart_.keys(f,
                {{"blue", fmt::format("{:.4g} V, {:.4g} Hz", supply_.line_v, supply_.frequency_hz)},
                 {"orange dashed", "75, 50 and 25 % of both"}});
    chart_.axes(f);
    for (std::size_t i = curves_.size(); i-- > 0;) {
      put_curve(f, curves_[i], torque, i == 0 ? "blue" : "orange dashed");
    }
    const double rated_rpm = rated_.speed_radps * kRpmPerRadps;
    chart_.put(
        "<circle class=\"rated\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\"><title>Rated: {:.4g} Nm at "
        "{:.4g} rpm</title></circle>\n",
        f.px(rated_rpm), f.py(rated_.torque_nm), rated_.torque_nm, rated_rpm);
    y_ += kTorqueHeight + kGap;
  }

  void put_current() {
    const double width = kHalf - kLeft - 8;
    const Scale speed = scale_up_to(synchronous_rpm_, 5, "rpm");
    const PointValue current = [](const InductionPoint& p) { return p.current_a; };
    const Plot left{kMargin + kLeft, y_,    width,
                    kSmallHeight,    speed, scale_up_to(most(current) * 1.02, 6, "A")};
    chart_.heading(left, "Current (rms) on the rated supply");
    chart_.axes(left);
    put_curve(left, curves_.front(), current, "blue");
    const Plot right{kMargin + kHalf + kLeft + 8, y_, width, kSmallHeight, speed,
                     scale_up_to(100, 6, "%")};
    chart_.heading(right, "Efficiency and power factor");
    chart_.keys(right, {{"green", "efficiency"}, {"blue dashed", "power factor"}});
    chart_.axes(right);
    put_curve(
        right, curves_.front(), [](const InductionPoint& p) { return 100 * p.efficiency(); },
        "green");
    put_curve(
        right, curves_.front(), [](const InductionPoint& p) { return 100 * p.power_factor; },
        "blue dashed");
    y_ += kSmallHeight + kGap - 30;
  }

  const Motor& motor_;
  InductionSupply supply_;
  InductionPoint rated_;
  double synchronous_rpm_;
  std::vector<Points> curves_;
  Chart chart_;
  double y_ = 0;
};

}  // namespace

std::string motor_svg(const Motor& motor) {
  if (motor.kind == MachineKind::kInduction) return InductionPage(motor).svg();
  return Page(motor).svg();
}

}  // namespace virtdrive
