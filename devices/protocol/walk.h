// The table walk: every row of a protocol's table put to a drive, and what the drive made of it.
//
//   const WalkReport report = walk(toshiba_mcu::WalkDialect(), transport, {.channel = 1});
//   fmt::print("{}", text(report));
//
// The walk knows tables, not protocols: a Dialect puts its questions into bytes and tells what the
// bytes that come back mean. What to expect is the table's: ranges, units, access, support.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/host_transport.h"
#include "devices/protocol/binding.h"
#include "devices/protocol/payload.h"
#include "devices/protocol/table.h"

namespace virtdrive::protocol {

using Bytes = std::vector<std::uint8_t>;

/// What a drive said to a request.
struct Answer {
  enum class Kind : std::uint8_t {
    kSilence,
    kValues,
    kRefused,
    kDamaged,  // nothing that answers this request, or more than one answer
  };
  Kind kind = Kind::kSilence;
  Values values = {};     // of kValues
  std::int64_t code = 0;  // of kRefused
};

/// A parameter's number and the unit it is in; unit 0 where the wire tells none.
struct Setting {
  std::int64_t value = 0;
  std::int8_t unit = 0;
  friend bool operator==(const Setting&, const Setting&) = default;
};

/// Ways to spoil a good request. Cuts and pauses need no help of the dialect.
enum class Damage : std::uint8_t { kChecksum, kEnd, kByteTooMany, kByteTooFew };

/// What a request does besides being answered.
enum class Effect : std::uint8_t {
  kNone,
  kLast,  // acts: asked after all others
  kSkip,  // never sent
};

/// What the walk must be told of a protocol.
class Dialect {
 public:
  virtual ~Dialect() = default;
  virtual const ProtocolTable& table() const = 0;

  // --- Requests ---
  /// Values with which a drive does what the row says; nothing if the walk shall leave it out.
  virtual std::optional<Values> sample(const CommandRow& row, std::uint8_t channel) const = 0;
  virtual Bytes command(const CommandRow& row, const Values& request) const = 0;
  /// Rows that no table has are asked for too: only their id counts.
  virtual Bytes read(const ParameterRow& row, std::uint8_t channel) const = 0;
  virtual Bytes write(const ParameterRow& row, std::uint8_t channel, Setting setting) const = 0;
  /// Harmless, and answered with values by any drive that listens.
  virtual Bytes probe() const = 0;
  /// Nothing where a request cannot be spoilt so.
  virtual std::optional<Bytes> spoil(const Bytes& request, Damage damage) const = 0;
  /// Bytes that a drive between two requests ignores.
  virtual Bytes noise() const = 0;
  /// Brings a drive that waits for the rest of any request back to where it listens.
  virtual Bytes resynchronise() const = 0;

  // --- Answers ---
  /// Nothing while `reply` is the beginning of an answer. It must come to an end at the latest when
  /// `reply` has the length of the table's longest frame.
  virtual std::optional<Answer> decode(std::span<const std::uint8_t> request,
                                       std::span<const std::uint8_t> reply) const = 0;
  /// Of the values that answer read(); nothing if they are none.
  virtual std::optional<Setting> setting(const Values& reply) const = 0;

  // --- What to expect ---
  virtual Answer refusal(Refusal refusal) const = 0;
  virtual Answer reaction(Damage damage) const = 0;
  /// To a good write of a parameter.
  virtual Answer written() const { return {.kind = Answer::Kind::kValues}; }
  /// What a row holds after a number out of its range; nothing: what it held before.
  virtual std::optional<Setting> settles(const ParameterRow&, Setting) const { return {}; }
  virtual Answer to_unknown_command() const = 0;

  // --- Where and in what order ---
  virtual std::uint16_t highest_id() const = 0;
  virtual std::uint16_t highest_command() const = 0;
  virtual std::span<const std::uint8_t> unknown_channels() const = 0;
  virtual bool names_channel(const CommandRow& row) const = 0;
  virtual Effect effect(const CommandRow&) const { return Effect::kNone; }
  virtual Effect effect(const ParameterRow&) const { return Effect::kNone; }
  /// Sent before and after each good request of a row; what is answered to them is not judged.
  virtual std::vector<Bytes> before(const CommandRow&, std::uint8_t) const { return {}; }
  virtual std::vector<Bytes> after(const CommandRow&, std::uint8_t) const { return {}; }

  /// A write alone starts a motor, or changes what one does.
  virtual bool moves(const ParameterRow&) const { return false; }
  /// What a row takes, where another setting narrows what the table says.
  virtual Range range(const ParameterRow& row) const { return row.range; }
  /// What another parameter has to be while a row is walked.
  struct Need {
    std::uint16_t id;
    Setting setting;
  };
  virtual std::vector<Need> needs(const ParameterRow&) const { return {}; }
};

/// What a walk may do to a drive and what hangs on it.
enum class Allow : std::uint8_t {
  kReads,   // nothing is changed
  kWrites,  // settings are changed, to their limits too, and written back
  kMoves,   // commands as well: motors start and stop
};

struct WalkOptions {
  std::uint8_t channel = 0;
  Allow allow = Allow::kMoves;
  /// The drive has its factory settings: they are compared with the table's.
  bool at_factory = true;
  /// How long an answer that must come may take.
  SimDuration patience = std::chrono::milliseconds(500);
  /// After how long without a byte the drive is taken to be silent, and an answer to be over.
  SimDuration silence = std::chrono::milliseconds(20);
  /// Between the two halves of a request.
  SimDuration pause = std::chrono::milliseconds(5);
  /// The walk is given up after so many: a silent drive costs `patience` each time.
  std::size_t most_failures = 100;
};

/// One expectation, met or not.
struct Check {
  std::string row;  // "parameter 10 PolePairs"
  std::string what;
  std::string_view source = {};  // section of the document; empty: its part on framing
  bool passed = false;
  std::string detail = {};  // of a failure: what was sent, expected, and heard
};

struct WalkReport {
  std::vector<Check> checks;
  std::vector<std::string> skipped;  // rows that the dialect leaves out, or that are not allowed
  bool given_up = false;
  std::size_t failures() const;
};

/// Puts every row to the drive on `transport`. Never throws, whatever the drive sends. The same
/// drive gives the same report. Settings are left as they were found; those that cannot be read, at
/// their factory value.
WalkReport walk(const Dialect& dialect, HostTransport& transport, const WalkOptions& options);

/// One line of sums, then each failure.
std::string text(const WalkReport& report);

}  // namespace virtdrive::protocol
