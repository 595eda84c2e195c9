#include "devices/asd7/walk.h"

#include <algorithm>
#include <iterator>

#include "core/check.h"
#include "devices/asd7/codec.h"
#include "devices/protocol/checksum.h"

namespace virtdrive::asd7 {
namespace {

using protocol::Answer;
using protocol::Bytes;
using protocol::Damage;
using protocol::Effect;
using protocol::Refusal;
using protocol::Setting;
using protocol::Values;

constexpr std::uint16_t kNote = 0x0880, kFrequency = 0xFA01;
// tYP takes all back to the factory; the command words reset and trip; F806 makes a master.
constexpr std::uint16_t kActing[] = {0x0007, 0x0806, 0xFA00, 0xFA04};
// What FH and UL limit; both begin at 80.00 Hz.
constexpr std::int64_t kFactoryLimit = 8000;
constexpr std::uint16_t kLimited[] = {0x0012, 0x0013, 0x0018, 0x0019, 0x0020, 0x0021, 0x0022,
                                      0x0023, 0x0024, 0x0287, 0x0288, 0x0289, 0x0290, 0x0291,
                                      0x0292, 0x0293, 0x0294, 0xFA01, 0xFA03, 0xFA05};
constexpr std::uint16_t kTimeOutAction = 0x0804;

const CommandRow& command_row(char code) {
  const CommandRow* row = protocol::find(kTable.commands, static_cast<std::uint8_t>(code));
  VIRTDRIVE_CHECK(row != nullptr, "no command {}", code);
  return *row;
}

Bytes encode(const CommandRow& row, const Values& values) {
  const auto number = static_cast<std::uint16_t>(values[0]);
  return encode_request({.format = Format::kBinary32,
                         .row = &row,
                         .parameter = protocol::find(kTable.parameters, number),
                         .values = values});
}

Answer error(Error code) {
  return {.kind = Answer::Kind::kRefused, .code = static_cast<std::int64_t>(code)};
}

}  // namespace

// --- Requests ------------------------------------------------------------------------------------

std::optional<Values> WalkDialect::sample(const CommandRow& row, std::uint8_t) const {
  if (!row.replies) return Values{kFrequency, 0};
  Values values = {kNote};
  values.pad(row.request);
  return values;
}

// A command that is none is cut to what cannot be mistaken for another frame.
Bytes WalkDialect::command(const CommandRow& row, const Values& request) const {
  if (request.size() > 0) return encode(row, request);
  return {kBinaryStart, static_cast<std::uint8_t>(row.code), 0, 0};
}

Bytes WalkDialect::read(const ParameterRow& row, std::uint8_t) const {
  return encode(command_row('R'), {row.id});
}

Bytes WalkDialect::write(const ParameterRow& row, std::uint8_t, Setting setting) const {
  return encode(command_row('W'), {row.id, setting.value});
}

Bytes WalkDialect::probe() const {
  return encode(command_row('R'), {kNote});
}

// What is never answered is not answered either when it is spoilt.
std::optional<Bytes> WalkDialect::spoil(const Bytes& request, Damage damage) const {
  const CommandRow* row = protocol::find(kTable.commands, request[2]);
  if (row == nullptr || !row->replies) return std::nullopt;
  Bytes spoilt = request;
  switch (damage) {
    case Damage::kChecksum:
      spoilt.back() ^= 0x01;
      break;
    case Damage::kEnd:
      return std::nullopt;  // there is none
    case Damage::kByteTooMany:
      spoilt.insert(spoilt.end() - 1, static_cast<std::uint8_t>(~spoilt.back()));
      break;
    case Damage::kByteTooFew:
      spoilt.erase(spoilt.end() - 2);
      break;
  }
  return spoilt;
}

Bytes WalkDialect::noise() const {
  return {0x00, 0x55, 0xFF};
}

// More than a frame of bytes that end any: 13 is also a number, and no command.
Bytes WalkDialect::resynchronise() const {
  return Bytes(2 * kBinaryFramings[1].longest, static_cast<std::uint8_t>(kAsciiEnd));
}

// --- Answers -------------------------------------------------------------------------------------

std::optional<Answer> WalkDialect::decode(std::span<const std::uint8_t>,
                                          std::span<const std::uint8_t> reply) const {
  Decoder decoder(protocol::Direction::kReply);
  for (const std::uint8_t byte : reply) {
    const Decoder::Event event = decoder.push(byte);
    if (event == Decoder::Event::kNone) continue;
    const Message& message = decoder.message();
    if (event != Decoder::Event::kMessage || message.error) {
      return Answer{.kind = Answer::Kind::kDamaged};
    }
    if (message.row == &kErrorReply) {
      return Answer{.kind = Answer::Kind::kRefused, .code = message.values[0]};
    }
    return Answer{.kind = Answer::Kind::kValues, .values = message.values};
  }
  return std::nullopt;
}

std::optional<Setting> WalkDialect::setting(const Values& reply) const {
  if (reply.size() < 2) return std::nullopt;
  return Setting{reply[1], 0};
}

Answer WalkDialect::refusal(Refusal refusal) const {
  switch (refusal) {
    case Refusal::kReadOnly:
      return error(Error::kCannotExecute);
    case Refusal::kOutOfRange:
      return error(Error::kRange);
    default:
      return error(Error::kNumber);
  }
}

Answer WalkDialect::reaction(Damage damage) const {
  return damage == Damage::kByteTooFew ? Answer{} : error(Error::kSum);
}

// --- Where and in what order ---------------------------------------------------------------------

Effect WalkDialect::effect(const ParameterRow& row) const {
  const bool acts = std::ranges::find(kActing, row.id) != std::end(kActing);
  return acts ? Effect::kSkip : Effect::kNone;
}

protocol::Range WalkDialect::range(const ParameterRow& row) const {
  protocol::Range range = row.range;
  if (std::ranges::find(kLimited, row.id) != std::end(kLimited)) range.maximum = kFactoryLimit;
  if (row.id == kTimeOutAction) range.maximum = 2;
  return range;
}

}  // namespace virtdrive::asd7
