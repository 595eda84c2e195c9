#include "firmware_models/toshiba_mcu/current_control.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive::toshiba_mcu {
namespace {

constexpr int kZeroCurrentPeriods = 4;

// MeasurementType (5.1.49).
constexpr std::int32_t kOneShunt = 1;
constexpr std::int32_t kTwoSensors = 2;

// What one shunt in the link does not show: with the highest and the lowest phase sampled in their
// windows, the current of the phase between them follows from the other two.
std::size_t middle(const PhaseValues& duty) {
  const auto low = std::ranges::min_element(duty) - duty.begin();
  const auto high = std::ranges::max_element(duty) - duty.begin();
  return low == high ? 2 : static_cast<std::size_t>(3 - low - high);
}

PhaseValues space_vector(double v_alpha, double v_beta, double bus_v) {
  const double scale = bus_v > 0 ? 1 / bus_v : 0;
  const double half_beta = std::numbers::sqrt3 / 2 * v_beta;
  const PhaseValues phase = {v_alpha * scale, (-v_alpha / 2 + half_beta) * scale,
                             (-v_alpha / 2 - half_beta) * scale};
  // The zero sequence that centres the three duties.
  const auto [low, high] = std::ranges::minmax(phase);
  const double centre = 0.5 - (low + high) / 2;
  PhaseValues duty{};
  for (std::size_t i = 0; i < 3; ++i) duty[i] = std::clamp(phase[i] + centre, 0.0, 1.0);
  return duty;
}

}  // namespace

void CurrentControl::begin_zero_current() {
  zero_periods_ = 0;
  zero_sum_ = {};
}

bool CurrentControl::zero_current(const Reading& reading) {
  for (std::size_t i = 0; i < 3; ++i) zero_sum_[i] += reading.current_counts[i];
  if (++zero_periods_ < kZeroCurrentPeriods) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    zero_counts_[i] = static_cast<double>(zero_sum_[i]) / kZeroCurrentPeriods;
  }
  return true;
}

void CurrentControl::measure(const Reading& reading, const ChannelSettings& settings,
                             const Scaling& scaling, LoopState& now) const {
  const double sign = settings.sensor_direction.value == 1 ? -1 : 1;
  const double gain = sign * scaling.current_a_per_count;
  PhaseValues& i = now.current_a;
  for (std::size_t x = 0; x < 3; ++x) i[x] = gain * (reading.current_counts[x] - zero_counts_[x]);
  if (settings.measurement_type.value == kTwoSensors) {
    i[2] = -i[0] - i[1];
  } else if (settings.measurement_type.value == kOneShunt) {
    const std::size_t hidden = middle(now.duty);
    i[hidden] = -i[(hidden + 1) % 3] - i[(hidden + 2) % 3];
  }
  now.i_alpha_a = (2 * i[0] - i[1] - i[2]) / 3;
  now.i_beta_a = (i[1] - i[2]) / std::numbers::sqrt3;
  now.id_a = now.cosine * now.i_alpha_a + now.sine * now.i_beta_a;
  now.iq_a = now.cosine * now.i_beta_a - now.sine * now.i_alpha_a;
  now.bus_v = reading.bus_counts * scaling.bus_v_per_count;
}

void CurrentControl::control(const Scaling& scaling, LoopState& now) const {
  const double error_d = now.id_ref_a - now.id_a;
  const double error_q = now.iq_ref_a - now.iq_a;
  now.vd_integral_v += scaling.id_ki * error_d;
  now.vq_integral_v += scaling.iq_ki * error_q;
  now.vd_v = now.vd_integral_v + scaling.id_kp * error_d;
  now.vq_v = now.vq_integral_v + scaling.iq_kp * error_q;

  const double limit = now.bus_v / std::numbers::sqrt3;
  const double square = now.vd_v * now.vd_v + now.vq_v * now.vq_v;
  if (square > limit * limit) {
    const double share = limit / std::sqrt(square);
    now.vd_v *= share;
    now.vq_v *= share;
    now.vd_integral_v = now.vd_v - scaling.id_kp * error_d;
    now.vq_integral_v = now.vq_v - scaling.iq_kp * error_q;
  }
  now.v_alpha_v = now.cosine * now.vd_v - now.sine * now.vq_v;
  now.v_beta_v = now.sine * now.vd_v + now.cosine * now.vq_v;
  now.duty = space_vector(now.v_alpha_v, now.v_beta_v, now.bus_v);
}

}  // namespace virtdrive::toshiba_mcu
