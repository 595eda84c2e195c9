// The position as the firmware has it (6.1): a 16-bit counter of quadrature edges extended to 32
// bits, with the index latched in hardware, or an absolute encoder's word, polled in one 50 us slot
// and used in the next.
#pragma once

#include <cstdint>

#include "firmware_models/rzt1/hardware.h"
#include "plant/position_sensors.h"

namespace virtdrive::rzt1 {

/// What the encoder interface holds at a PWM slot.
struct ShaftReading {
  // Incremental: edges since the power came, and those at the index that was passed since the last
  // slot. The counter has 16 bits of them; no motor passes half of that within 50 us.
  std::int64_t edges = 0;
  bool index = false;
  std::int64_t index_edges = 0;
  // Absolute.
  enum class Answer : std::uint8_t { kNotYet, kNone, kWord } answer = Answer::kNotYet;
  AbsoluteEncoder::Reading word{};
  int single_turn_bits = 16;
};

/// Bits of ESTATUS. Assumed: the document does not give them.
enum EncoderStatusBit : std::uint8_t {
  kEncoderSilent = 1 << 0,
  kEncoderCrc = 1 << 1,
  kEncoderBatteryLow = 1 << 2,
  kEncoderBatteryLost = 1 << 3,
};

class PositionInput {
 public:
  /// Power-up, or another encoder: an incremental one starts at 0.
  void start(EncoderType type, bool inverted);
  void set_inverted(bool inverted);
  EncoderType type() const { return type_; }
  bool absolute() const { return type_ != EncoderType::kIncremental; }

  void read(const ShaftReading& reading);
  /// Simulated: where it is told to be.
  void simulate(std::int32_t position);

  std::int32_t position() const { return position_; }
  /// By which POS differs from what an absolute encoder says.
  std::int32_t offset() const { return offset_; }
  void shift(std::int32_t counts);
  /// Passed the end of 32 bits.
  bool wrapped() const { return wrapped_; }
  void clear_wrapped() { wrapped_ = false; }

  bool captured() const { return captured_; }
  std::int32_t index() const { return index_; }
  /// Armed for the next one.
  void clear_captured() { captured_ = false; }

  std::uint16_t status() const { return status_; }
  bool answers() const { return absolute() && answered_ && (status_ & kEncoderSilent) == 0; }

 private:
  void move_to(std::int32_t position);
  std::int32_t signed_counts(std::int64_t edges) const;
  void read_edges(const ShaftReading& reading);
  void read_word(const ShaftReading& reading);

  EncoderType type_ = EncoderType::kIncremental;
  bool inverted_ = false;
  std::int32_t position_ = 0, offset_ = 0;
  bool started_ = false;  // there was a reading
  std::int64_t edges_ = 0;
  bool captured_ = false;
  std::int32_t index_ = 0;
  bool wrapped_ = false;

  bool answered_ = false;
  std::int32_t polled_ = 0;  // the word of the slot before
  bool has_polled_ = false;
  std::uint16_t status_ = 0;
};

}  // namespace virtdrive::rzt1
