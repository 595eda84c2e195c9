#include "firmware_models/rzt1/position_input.h"

#include "firmware_models/rzt1/counts.h"

namespace virtdrive::rzt1 {

void PositionInput::start(EncoderType type, bool inverted) {
  *this = {};
  type_ = type;
  inverted_ = inverted;
}

void PositionInput::set_inverted(bool inverted) {
  if (inverted == inverted_) return;
  inverted_ = inverted;
  if (absolute()) {
    has_polled_ = answered_ = false;
  } else {
    position_ = difference(0, position_);
  }
}

std::int32_t PositionInput::signed_counts(std::int64_t edges) const {
  return static_cast<std::int32_t>(inverted_ ? -edges : edges);
}

void PositionInput::move_to(std::int32_t position) {
  const std::int32_t moved = difference(position, position_);
  // It went up and the number fell, or the reverse.
  if ((moved > 0) != (position > position_) && moved != 0) wrapped_ = true;
  position_ = position;
}

void PositionInput::read(const ShaftReading& reading) {
  if (absolute()) {
    read_word(reading);
  } else {
    read_edges(reading);
  }
}

void PositionInput::read_edges(const ShaftReading& reading) {
  if (!started_) edges_ = reading.edges;
  started_ = true;
  move_to(sum(position_, signed_counts(reading.edges - edges_)));
  edges_ = reading.edges;
  if (reading.index) {
    index_ = difference(position_, signed_counts(reading.edges - reading.index_edges));
    captured_ = true;
  }
}

void PositionInput::read_word(const ShaftReading& reading) {
  if (reading.answer == ShaftReading::Answer::kNotYet) return;
  const bool silent = reading.answer == ShaftReading::Answer::kNone;
  status_ = static_cast<std::uint16_t>(
      (silent ? kEncoderSilent : 0) | (!silent && !reading.word.crc_good ? kEncoderCrc : 0) |
      (!silent && reading.word.battery_low ? kEncoderBatteryLow : 0) |
      (!silent && reading.word.battery_lost ? kEncoderBatteryLost : 0));
  if (silent || !reading.word.crc_good) return;
  const auto turns = static_cast<std::uint32_t>(reading.word.turns);
  const auto raw =
      static_cast<std::int32_t>((turns << reading.single_turn_bits) + reading.word.position);
  const std::int32_t word = inverted_ ? difference(0, raw) : raw;
  if (!has_polled_) polled_ = word;
  has_polled_ = true;
  const std::int32_t position = sum(polled_, offset_);
  if (!answered_) position_ = position;
  answered_ = true;
  move_to(position);
  polled_ = word;
}

void PositionInput::simulate(std::int32_t position) {
  move_to(position);
}

void PositionInput::shift(std::int32_t counts) {
  position_ = sum(position_, counts);
  offset_ = sum(offset_, counts);
  index_ = sum(index_, counts);
}

}  // namespace virtdrive::rzt1
