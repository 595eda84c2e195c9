// Messages of the 7-Series: one content, three formats, told apart message by message.
//
//   16-bit ASCII   ( [NN] C XXXX [D..DDDD] [& SS] [)] CR
//   16-bit binary  /  [no] C hi lo [data 2]  sum
//   32-bit binary  /  [no] L C hi lo [data 4]  sum
//
// A reply has the request's format and those optional parts that the request had; its command is
// lower case while the drive is tripped. Errors are answered in the same way, with N and a code.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/asd7/table.h"
#include "devices/protocol/frame_buffer.h"
#include "devices/protocol/payload.h"

namespace virtdrive::asd7 {

/// An ASD number as addressed: two decimal digits, each of which may be a star for any digit.
struct AsdNumber {
  static constexpr std::uint8_t kAny = 0xFF;
  std::uint8_t tens = 0;
  std::uint8_t units = 0;

  constexpr bool is_broadcast() const { return tens == kAny || units == kAny; }
  constexpr bool matches(unsigned own) const {
    return (tens == kAny || tens == own / 10) && (units == kAny || units == own % 10);
  }
  /// The number that answers a broadcast: stars are zeros.
  constexpr AsdNumber representative() const {
    return {.tens = tens == kAny ? std::uint8_t{0} : tens,
            .units = units == kAny ? std::uint8_t{0} : units};
  }
  friend bool operator==(const AsdNumber&, const AsdNumber&) = default;
};

enum class Format : std::uint8_t { kAscii, kBinary16, kBinary32 };

struct Message {
  Format format = Format::kAscii;
  std::optional<AsdNumber> number = {};  // may be left out between two
  bool with_sum = true;                  // ASCII
  bool closed = true;                    // ASCII: with )
  const CommandRow* row = nullptr;
  const ParameterRow* parameter = nullptr;  // of the communication number
  protocol::Values values = {};     // communication number, data; of an error reply its code
  bool tripped = false;             // replies
  std::optional<Error> error = {};  // what is wrong with it, and a request's answer
};

std::vector<std::uint8_t> encode_request(const Message& message);
/// The value read or written. One that the format is too narrow for is answered with kModeError.
std::vector<std::uint8_t> encode_reply(const Message& request, std::int64_t value, bool tripped);
std::vector<std::uint8_t> encode_error(const Message& request, Error error, bool tripped);

/// A receiver of all three formats. Positions rule, not delimiters; `(` starts anew inside of an
/// ASCII message. A binary message waits for its bytes: when the line was silent for kSilence,
/// reset() it.
class Decoder {
 public:
  enum class Event : std::uint8_t {
    kNone,            // in the middle of a message, or CR or LF between two
    kNoise,           // a byte outside of a message
    kMessage,         // complete: see message(); its `error` tells if it can be taken
    kFormatError,     // ASCII that is no message: silence is the answer
    kUnknownCommand,  // binary: how long it is, nobody knows; dropped in silence
  };

  explicit Decoder(protocol::Direction direction) : direction_(direction) {}

  Event push(std::uint8_t byte);
  const Message& message() const { return message_; }
  /// The bytes of the message under way, or of the last one ended.
  std::span<const std::uint8_t> bytes() const { return buffer_.bytes(); }
  bool idle() const { return ended_ || buffer_.empty(); }
  void reset();

 private:
  Event push_ascii(std::uint8_t byte);
  Event push_binary(std::uint8_t byte);
  Event end(Event event);

  protocol::Direction direction_;
  protocol::FrameBuffer<kTable.framing.longest> buffer_;
  bool ended_ = false;
  Message message_;
};

}  // namespace virtdrive::asd7
