// RZ/T1: two ways to talk on one line, told apart by the first byte.
//
//   packet  AA address length code data[length] sum   ->  status data sum
//   line    [axis]NAME[ argument] CR                  ->  [text] CR LF > (accepted) or ? (refused)
//
// A packet's reply has neither start nor length: only the one who asked can tell where it ends.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/protocol/binding.h"
#include "devices/protocol/frame_buffer.h"
#include "devices/protocol/payload.h"
#include "devices/rzt1/table.h"

namespace virtdrive::rzt1 {

/// First byte of a packet's reply (8.2.3); kErrors tells what they mean.
enum class Status : std::uint8_t {
  kOk = 0,
  kBadCode = 1,
  kBadIndex = 2,
  kBadSize = 3,
  kOutOfRange = 4,
  kReadOnly = 5,
  kInterlock = 6,
  kFault = 7,
  kInvalidState = 8,
  kOverflow = 9,
  kExecution = 10,
  kBadSum = 255,
};

Status status_of(protocol::Refusal refusal);

struct Packet {
  std::uint8_t address = 1;
  const CommandRow* row = nullptr;
  const CommandRow* function = nullptr;     // of FunctionCall, and of SetParameter for SETUP
  const ParameterRow* parameter = nullptr;  // of SetParameter and GetParameter
  protocol::Values values = {};             // with the number of function or parameter in front
  bool counted = true;                      // of StreamPVT: values begin with the points' count
  Status status = Status::kOk;              // if not: with what to refuse it; no values then
};

struct Line {
  std::uint32_t axis = 0;                   // 0: none told, it is the console's default axis
  const CommandRow* function = nullptr;     // neither function nor parameter: an empty line, or an
  const ParameterRow* parameter = nullptr;  // axis alone, which becomes the default
  std::optional<std::int64_t> argument = {};
  bool accepted = true;  // false: no such axis or name, or an argument that is no number
};

std::vector<std::uint8_t> encode_request(const Packet& packet);
std::vector<std::uint8_t> encode_request(const Line& line);

/// Where the document says two things, or firmware is known to differ.
struct ReplyFormat {
  std::size_t status_bytes = 1;  // 1 (drawings of Appendix B) or 2 (8.2 and the tables of sizes)
  bool raw_trace = false;        // GetTrace: samples and nothing else, as drawn
};

/// `values` are those that the request asked for.
std::vector<std::uint8_t> encode_reply(const Packet& request, const protocol::Values& values,
                                       const ReplyFormat& format = {});
enum class TraceWidth : std::uint8_t { kTwoBytes = 2, kFourBytes = 4 };
/// The answer to GetTrace.
std::vector<std::uint8_t> encode_trace(std::span<const std::int32_t> samples, TraceWidth width,
                                       const ReplyFormat& format = {});
std::vector<std::uint8_t> encode_refusal(Status status, const ReplyFormat& format = {});
/// Of a line; `axis` goes before the prompt unless it is 0.
std::vector<std::uint8_t> encode_reply(std::string_view text, bool accepted,
                                       std::uint32_t axis = 0);

/// As C does with base 0: decimal, 0x hexadecimal, 0 octal, with or without a sign; nothing if the
/// text is no number.
std::optional<std::int64_t> parse_number(std::string_view text);
/// A variable's value as a line shows it: decimal, or so many hexadecimal digits.
std::string to_text(const ParameterRow& row, std::int64_t value);
/// Its reverse; nothing if the text is no number.
std::optional<std::int64_t> from_text(const ParameterRow& row, std::string_view text);

/// The module's receiver. A packet that is cut short waits for its missing bytes for ever; a wrong
/// sum costs the whole packet; of a line too long the rest is lost.
class Decoder {
 public:
  enum class Event : std::uint8_t {
    kNone,    // in the middle of a packet or a line
    kLine,    // complete: see line()
    kPacket,  // complete: see packet()
    kBadSum,  // see packet().address
  };

  Event push(std::uint8_t byte);
  const Packet& packet() const { return packet_; }
  const Line& line() const { return line_; }
  /// The bytes of the packet or line under way, or of the last one ended; a line without its LF.
  std::span<const std::uint8_t> bytes() const { return buffer_.bytes(); }
  bool idle() const { return ended_ || buffer_.empty(); }
  void reset();

 private:
  Event push_line(std::uint8_t byte);

  protocol::FrameBuffer<kLines[0].longest> buffer_;
  bool ended_ = false;
  Packet packet_;
  Line line_;
};

/// The host's receiver of one packet's reply.
class PacketReplyDecoder {
 public:
  enum class Event : std::uint8_t {
    kNone,
    kReply,  // complete: see status() and, if it is kOk, values()
    kBadSum,
  };

  explicit PacketReplyDecoder(const Packet& request, const ReplyFormat& format = {});

  Event push(std::uint8_t byte);
  Status status() const { return static_cast<Status>(buffer_[0]); }
  const protocol::Values& values() const { return values_; }
  /// Of GetTrace, in the layout that tells its count.
  std::span<const std::int32_t> samples() const { return samples_; }
  std::span<const std::uint8_t> bytes() const { return buffer_.bytes(); }

 private:
  std::size_t data_size() const;

  std::vector<Field> fields_;
  bool trace_;
  ReplyFormat format_;
  protocol::FrameBuffer<kTable.framing.longest + 1> buffer_;  // a second byte of status
  bool ended_ = false;
  protocol::Values values_;
  std::vector<std::int32_t> samples_;
};

/// The host's receiver of replies to lines.
class LineReplyDecoder {
 public:
  enum class Event : std::uint8_t {
    kNone,
    kText,  // one line of data: see text(); a dump has many
    kAccepted,
    kRefused,
  };

  Event push(std::uint8_t byte);
  std::string_view text() const;

 private:
  protocol::FrameBuffer<kLines[0].longest> buffer_;
  bool cr_ = false;          // the last byte was CR
  bool line_ended_ = false;  // CR LF came: a prompt may follow
  bool after_end_ = false;   // one byte after it: an axis, if a prompt follows
};

}  // namespace virtdrive::rzt1
