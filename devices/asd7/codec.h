// Messages of the 7-Series: one content, three formats, told apart message by message.
//
//   16-bit ASCII   ( [NN] C XXXX [D..DDDD] [& SS] [)] CR
//   16-bit binary  /  [no] C hi lo [data 2]  sum
//   32-bit binary  /  [no] L C hi lo [data 4]  sum
//   32-bit ASCII   ( [NN] L C XXXX [D..DDDDDDDD] [& SS] [)] CR     a guess, off unless asked for
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

enum class Format : std::uint8_t { kAscii, kBinary16, kBinary32, kAscii32 };

constexpr bool is_ascii(Format format) {
  return format == Format::kAscii || format == Format::kAscii32;
}
constexpr bool is_wide(Format format) {
  return format == Format::kBinary32 || format == Format::kAscii32;
}

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

/// What a reply depends on besides its request.
struct ReplyStyle {
  bool tripped = false;
  bool error_sum_always = false;  // ASCII errors carry a sum even where the request had none
  Error mode_error = kModeError;  // to a value that the format is too narrow for
};

std::vector<std::uint8_t> encode_request(const Message& message);
/// The value read or written. One that the format is too narrow for is answered with the mode
/// error.
std::vector<std::uint8_t> encode_reply(const Message& request, std::int64_t value,
                                       const ReplyStyle& style);
std::vector<std::uint8_t> encode_error(const Message& request, Error error,
                                       const ReplyStyle& style);

/// A receiver of all three formats. Positions rule, not delimiters; `(` starts anew inside of an
/// ASCII message. An unfinished message waits for its bytes: when the line was silent for kSilence,
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

  explicit Decoder(protocol::Direction direction, bool ascii_wide = false)
      : direction_(direction), ascii_wide_(ascii_wide) {}

  Event push(std::uint8_t byte);
  const Message& message() const { return message_; }
  /// The bytes of the message under way, or of the last one ended.
  std::span<const std::uint8_t> bytes() const { return buffer_.bytes(); }
  bool idle() const { return ended_ || buffer_.empty(); }
  void reset();
  /// Whether L is taken in ASCII; else it is an unknown command.
  void set_ascii_wide(bool on) { ascii_wide_ = on; }

 private:
  Event push_ascii(std::uint8_t byte);
  Event push_binary(std::uint8_t byte);
  Event end(Event event);

  protocol::Direction direction_;
  bool ascii_wide_;
  protocol::FrameBuffer<kTable.framing.longest> buffer_;
  bool ended_ = false;
  Message message_;
};

}  // namespace virtdrive::asd7
