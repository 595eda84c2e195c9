#include "plant/position_sensors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace virtdrive {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// 0 <= share < 1 of a turn.
double share_of_turn(double angle_rad) {
  const double turns = angle_rad / kTurn;
  const double share = turns - std::floor(turns);
  return std::min(share, std::nextafter(1.0, 0.0));  // rounding may reach the whole turn
}

}  // namespace

std::uint8_t HallSensors::bits(double electrical_angle_rad) const {
  std::uint8_t bits = 0;
  for (unsigned sensor = 0; sensor < 3; ++sensor) {
    const double rises_rad = offset_rad + placement_error_rad[sensor] + sensor * kTurn / 3;
    const bool high = output[sensor] == Output::kStuckHigh ||
                      (output[sensor] == Output::kWorking &&
                       share_of_turn(electrical_angle_rad - rises_rad) < 0.5);
    if (high) bits |= static_cast<std::uint8_t>(1U << sensor);
  }
  return bits;
}

std::int64_t HallSensors::edges(double electrical_angle_rad, std::uint8_t of) const {
  std::int64_t passed = 0;
  for (unsigned sensor = 0; sensor < 3; ++sensor) {
    if ((of >> sensor & 1U) == 0 || output[sensor] != Output::kWorking) continue;
    const double rises_rad = offset_rad + placement_error_rad[sensor] + sensor * kTurn / 3;
    passed +=
        static_cast<std::int64_t>(std::floor((electrical_angle_rad - rises_rad) / (kTurn / 2)));
  }
  return passed;
}

std::optional<double> HallSensors::next_edge_rad(double electrical_angle_rad, bool forwards) const {
  std::optional<double> nearest;
  for (unsigned sensor = 0; sensor < 3; ++sensor) {
    if (output[sensor] != Output::kWorking) continue;
    const double edge_rad = offset_rad + placement_error_rad[sensor] + sensor * kTurn / 3;
    // Edges repeat each half turn. Rounding must not return the edge that it stands on.
    const double step = forwards ? 1 : -1;
    double half = std::round((electrical_angle_rad - edge_rad) / (kTurn / 2)) - step;
    double at_rad = 0;
    do {
      half += step;
      at_rad = edge_rad + half * (kTurn / 2);
    } while ((at_rad - electrical_angle_rad) * step <= 0);
    if (!nearest || (forwards ? at_rad < *nearest : at_rad > *nearest)) nearest = at_rad;
  }
  return nearest;
}

std::uint8_t hall_bits(double electrical_angle_rad, double offset_rad) {
  return HallSensors{.offset_rad = offset_rad}.bits(electrical_angle_rad);
}

std::int64_t Encoder::count(double angle_rad) const {
  return edges(angle_rad) - missed_counts;
}

std::int64_t Encoder::edges(double angle_rad) const {
  return static_cast<std::int64_t>(std::floor((angle_rad - slip_rad) / kTurn * 4 * lines));
}

// The edge at which the index begins; no rounding may move it to the one before.
std::int64_t Encoder::index_edge(std::int64_t turn) const {
  const double turns = static_cast<double>(turn) + index_angle_rad / kTurn;
  return static_cast<std::int64_t>(std::floor(turns * 4 * lines + 1e-6));
}

std::int64_t Encoder::index_count(double angle_rad) const {
  return static_cast<std::int64_t>(std::floor((angle_rad - slip_rad - index_angle_rad) / kTurn));
}

std::optional<std::int64_t> Encoder::index_capture(double from_rad, double to_rad) const {
  if (index_dead) return {};
  const std::int64_t before = index_count(from_rad), after = index_count(to_rad);
  if (before == after) return {};
  // Backwards the mark that was passed last is that of the turn above.
  const std::int64_t turn = after > before ? after : after + 1;
  return index_edge(turn) - missed_counts;
}

std::uint8_t Encoder::tracks(double angle_rad) const {
  const std::int64_t edge = edges(angle_rad);
  const auto quarter = static_cast<unsigned>(edge & 3);
  const bool a = quarter == 1 || quarter == 2, b = quarter >= 2;
  const bool index = !index_dead && (edge - index_edge(0)) % (std::int64_t{4} * lines) == 0;
  return static_cast<std::uint8_t>((a ? 1 : 0) | (b ? 2 : 0) | (index ? 4 : 0));
}

AbsoluteEncoder::Reading AbsoluteEncoder::read(double angle_rad) const {
  const double turns = (reversed ? zero_rad - angle_rad : angle_rad - zero_rad) / kTurn;
  const double whole = std::floor(turns);
  const double steps = std::ldexp(1.0, single_turn_bits);
  Reading reading;
  reading.position =
      static_cast<std::uint32_t>(std::min(std::floor((turns - whole) * steps), steps - 1));
  if (multi_turn_bits > 0 && battery != Battery::kLost) {
    // Sign-extended from the lowest multi_turn_bits.
    const int unused = 64 - multi_turn_bits;
    const auto bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole)) << unused;
    reading.turns = static_cast<std::int32_t>(static_cast<std::int64_t>(bits) >> unused);
  }
  reading.crc_good = !crc_fault;
  reading.battery_low = battery != Battery::kGood;
  reading.battery_lost = battery == Battery::kLost;
  return reading;
}

}  // namespace virtdrive
