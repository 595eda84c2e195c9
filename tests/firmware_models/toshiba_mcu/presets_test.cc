// Sensorless starts over the motor presets that the maker publishes with its 1.x firmware
// (MotorControlFW, Source/Motors and Source/Board/Powerboard), each with its own gains, supply and
// power board, in the telegrams' units: from standstill to 80 % of SpeedLimit, held there without a
// limit cycle, and gently back; both ways.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "firmware_models/toshiba_mcu/firmware.h"
#include "plant/motor_library.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;

struct Board {
  BoardHardware hardware;
  std::int32_t mv_per_a, mv_per_v, dead_time_ns;
  double supply_v;
};

constexpr Board kSigma{{}, 316, 91, 400, 24};
constexpr Board kM374Low{{.current_v_per_a = 0.313}, 313, 91, 1400, 24};
// Three lithium cells: the motor's own supply.
constexpr Board kM374LowLithium{kM374Low.hardware, 313, 91, 1400, 11.1};
constexpr Board kM374High{
    {.current_v_per_a = 0.298, .bus_v_per_v = 0.010, .over_voltage_pin_v = 400}, 298, 10, 500, 325};
constexpr Board kHitexHigh{
    {.current_v_per_a = 0.278, .bus_v_per_v = 0.012, .over_voltage_pin_v = 400},
    278,
    12,
    1400,
    325};

enum class Reach { kTarget, kVoltageEnds };

struct Preset {
  const char* name;
  const char* motor;
  const Board& board;
  std::int32_t pole_pairs, acceleration, torque_factor;
  UnitValue resistance, inductance;
  std::int32_t limit_hz, change_hz, init_ms, iq_start, id_start, iq_limit, id_limit;
  std::int32_t current_ki, current_kp, position_ki, position_kp, speed_ki, speed_kp;
  std::int32_t pwm_hz, stall;
  Reach reach = Reach::kTarget;
};

void PrintTo(const Preset& preset, std::ostream* out) {
  *out << preset.name;
}

// clang-format off
const Preset kPresets[] = {
    {"NanotecDb42s03", "db42s03", kSigma, 4, 300, 34, {750, -3}, {1050, -6},
     350, 25, 200, 1000, 1400, 1850, 1700, 200, 50, 0, 15, 200, 20, 12500, 600},
    {"NanotecDb42s03AsPublished", "db42s03", kSigma, 4, 8000, 34, {750, -3}, {1050, -6},
     350, 25, 200, 1000, 1400, 1850, 1700, 200, 50, 0, 15, 200, 10, 12500, 600},
    {"NanotecDb42s01", "db42s01", kM374Low, 4, 500, 57, {3500, -3}, {5800, -6},
     267, 25, 100, 500, 500, 800, 800, 100, 30, 2, 10, 20, 20, 12500, 0},
    {"ShinanoDr38312", "dr38312", kM374Low, 6, 200, 51, {1350, -3}, {1200, -6},
     200, 40, 100, 1000, 1000, 1800, 1700, 4, 3, 2, 10, 20, 40, 12500, 800},
    {"ShinanoPmba200fkHv", "pmba-200fk-hv", kHitexHigh, 5, 500, 330, {3460, -3}, {5000, -6},
     333, 40, 100, 800, 800, 1000, 1000, 10, 40, 5, 2, 13, 40, 12500, 0},
    {"MaxonEc", "maxon-ec", kM374Low, 4, 400, 51, {6850, -3}, {3865, -6},
     300, 25, 100, 500, 500, 1800, 1800, 30, 15, 2, 10, 5, 15, 12500, 620, Reach::kVoltageEnds},
    {"GefegEcs7140Hv", "ecs-7140-hv", kM374High, 2, 50, 330, {40, 0}, {34, -3},
     140, 20, 300, 100, 150, 500, 500, 20, 40, 2, 10, 18, 30, 12500, 1200},
    {"EmaxCf2805", "cf2805", kM374LowLithium, 7, 100, 0, {72, -3}, {6, -6},
     400, 100, 100, 2000, 2000, 2000, 2000, 20, 20, 100, 10, 100, 200, 16000, 0},
};
// clang-format on

ChannelSettings settings_of(const Preset& p) {
  ChannelSettings s;
  s.pole_pairs = {p.pole_pairs};
  s.max_angular_acceleration = {p.acceleration};
  s.torque_factor = {p.torque_factor, -3};
  s.resistance = p.resistance;
  s.inductance = p.inductance;
  s.speed_limit = {p.limit_hz};
  s.speed_change = {p.change_hz};
  s.position_delay = {p.init_ms};
  s.iq_start = {p.iq_start, -3};
  s.id_start = {p.id_start, -3};
  s.iq_limit = {p.iq_limit, -3};
  s.id_limit = {p.id_limit, -3};
  s.pi_id_ki = s.pi_iq_ki = {p.current_ki};
  s.pi_id_kp = s.pi_iq_kp = {p.current_kp};
  s.position_ki = {p.position_ki};
  s.position_kp = {p.position_kp};
  s.speed_ki = {p.speed_ki};
  s.speed_kp = {p.speed_kp};
  s.pwm_frequency = {p.pwm_hz};
  s.stall_detect_value = {p.stall};
  s.over_voltage = s.under_voltage = s.over_current = {0};  // off in the presets
  s.dead_time = {p.board.dead_time_ns};
  s.current_sensitivity = {p.board.mv_per_a, -3};
  s.voltage_sensitivity = {p.board.mv_per_v, -3};
  return s;
}

AxisParameters axis_of(const Preset& preset) {
  const Motor motor = find_motor(preset.motor);
  return {.motor = motor.electrical,
          .link = {.source_v = preset.board.supply_v, .capacitance_f = 1e-3},
          .mechanics = motor.mechanics};
}

class PresetRun {
 public:
  PresetRun(const Preset& preset, int direction)
      : axis_(axis_of(preset), Integrator::kFast),
        firmware_(loop_, axes_, Seed{1}, preset.board.hardware),
        target_rpm_(direction * 0.8 * preset.limit_hz * 60 / preset.pole_pairs),
        ramp_s_(0.8 * preset.limit_hz * 2 * std::numbers::pi / preset.acceleration) {
    board().set_settings(settings_of(preset));
    board().set_speed_rpm(static_cast<std::int32_t>(target_rpm_));
    EXPECT_EQ(board().start(), Outcome::kDone);
    run_for(ramp_s_ + 8);
  }

  PowerBoard& board() { return firmware_.board(0); }
  const MotorChannel& channel() { return board().channel(); }
  double target_rpm() const { return target_rpm_; }
  double ramp_s() const { return ramp_s_; }
  double rpm() const { return axis_.state().speed_radps * 30 / std::numbers::pi; }
  void run_for(double s) {
    loop_.run_until(loop_.now() + from_seconds(s));
    axis_.advance_to(loop_.now());
  }
  bool stop() {
    EXPECT_EQ(board().stop(), Outcome::kDone);
    const SimTime until = loop_.now() + from_seconds(ramp_s_ + 3);
    return loop_.run_until(until, [&] { return channel().stage() == Stage::kStop; });
  }

 private:
  EventLoop loop_;
  Axis axis_;
  Axis* axes_[1] = {&axis_};
  Firmware firmware_;
  double target_rpm_;
  double ramp_s_;
};

class ToshibaMcuPresets : public testing::TestWithParam<std::tuple<Preset, int>> {};

TEST_P(ToshibaMcuPresets, StartToEightyPercentHoldAndComeBack) {
  const auto& [preset, direction] = GetParam();
  PresetRun run(preset, direction);
  double low = run.rpm(), high = run.rpm(), sum = 0;
  constexpr int kSamples = 2000;
  for (int i = 0; i < kSamples; ++i) {
    run.run_for(1e-3);
    low = std::min(low, run.rpm());
    high = std::max(high, run.rpm());
    sum += run.rpm();
  }
  const double share = sum / kSamples / run.target_rpm();
  const LoopState& now = run.channel().internals();
  const double voltage_used = std::hypot(now.vd_v, now.vq_v) / (now.bus_v / std::numbers::sqrt3);
  RecordProperty("share_of_target", std::to_string(share));
  RecordProperty("voltage_used", std::to_string(voltage_used));
  EXPECT_EQ(run.channel().stage(), Stage::kFoc);
  switch (preset.reach) {
    case Reach::kTarget:
      EXPECT_NEAR(share, 1, 0.01);
      EXPECT_LT((high - low) / std::abs(run.target_rpm()), 0.01) << "no limit cycle";
      EXPECT_EQ(run.channel().errors(), 0U);
      break;
    case Reach::kVoltageEnds:
      EXPECT_GT(share, 0.95);
      EXPECT_LT(share, 0.995);
      EXPECT_GT(voltage_used, 0.999) << "the supply ends, not the drive";
      EXPECT_LT((high - low) / std::abs(run.target_rpm()), 0.01);
      break;
  }
  EXPECT_TRUE(run.stop());
  run.run_for(2);
  EXPECT_NEAR(run.rpm(), 0, 1);
}

std::string preset_name(const testing::TestParamInfo<std::tuple<Preset, int>>& row) {
  const auto& [preset, direction] = row.param;
  return std::string(preset.name) + (direction > 0 ? "Forward" : "Backward");
}

INSTANTIATE_TEST_SUITE_P(All, ToshibaMcuPresets,
                         testing::Combine(testing::ValuesIn(kPresets), testing::Values(1, -1)),
                         preset_name);

}  // namespace
}  // namespace virtdrive::toshiba_mcu
