#include "devices/rzt1/walk.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "core/check.h"
#include "devices/protocol/text.h"
#include "devices/rzt1/codec.h"

namespace virtdrive::rzt1 {
namespace {

using protocol::Answer;
using protocol::Bytes;
using protocol::Damage;
using protocol::Effect;
using protocol::Refusal;
using protocol::Setting;
using protocol::Values;

constexpr std::uint8_t kReportPacket = 1, kCallPacket = 2, kInitPacket = 3, kStreamPacket = 4,
                       kSetPacket = 5, kGetPacket = 6;
constexpr std::uint16_t kReset = 88, kOn = 89, kDisable = 92, kHome = 95, kAlign = 96, kSetup = 113,
                        kErrorReset = 142;
constexpr std::uint16_t kOut1 = 98, kOut2 = 99;  // brakes
constexpr std::uint16_t kBias = 24, kPwm = 100, kIqpkt = 101, kIdpkt = 102;
constexpr std::uint16_t kU = 57, kV = 58, kW = 59, kData0 = 63, kTraceMode = 73, kTimer = 77,
                        kPosition = 82, kVersionId = 97, kEncoderType = 117, kEncoderId = 118,
                        kEncoderWord = 120, kAddress = 123;

// What moves the rotor comes last; before and after, the amplifier goes off, and what limits that
// were walked have latched is cleared.
constexpr std::array kMoving = {kOn, kAlign, kSetup};
bool turns_rotor(const CommandRow& row) {
  return std::ranges::find(kMoving, row.code) != kMoving.end();
}

const CommandRow& packet_row(std::uint8_t code) {
  const CommandRow* row = protocol::find(kTable.commands, code);
  VIRTDRIVE_CHECK(row != nullptr, "no packet {}", code);
  return *row;
}
const CommandRow& function_row(std::uint16_t code) {
  const CommandRow* row = protocol::find(kTable.functions, code);
  VIRTDRIVE_CHECK(row != nullptr, "no function {}", code);
  return *row;
}
const ParameterRow& variable_row(std::uint16_t id) {
  const ParameterRow* row = protocol::find(kTable.parameters, id);
  VIRTDRIVE_CHECK(row != nullptr, "no variable {}", id);
  return *row;
}

Answer refused(Status status) {
  return {.kind = Answer::Kind::kRefused, .code = static_cast<std::int64_t>(status)};
}
// A question mark tells no code.
constexpr Answer kQuestionMark{.kind = Answer::Kind::kRefused, .code = 0};

constexpr ProtocolTable with_commands(std::span<const CommandRow> commands) {
  ProtocolTable table = kTable;
  table.commands = commands;
  table.functions = {};
  return table;
}
// Packet codes end below the functions' numbers.
constexpr auto kPacketsAndFunctions = [] {
  std::array<CommandRow, std::size(kPackets) + std::size(kFunctions)> rows;
  std::ranges::copy(kFunctions, std::ranges::copy(kPackets, rows.begin()).out);
  return rows;
}();
constexpr ProtocolTable kPacketTable = with_commands(kPacketsAndFunctions);
constexpr ProtocolTable kLineTable = with_commands(kFunctions);
static_assert(well_formed(kPacketTable) && well_formed(kLineTable));

bool is_function(const CommandRow& row) {
  return protocol::find(kTable.functions, row.code) != nullptr;
}

Bytes line_of(std::string_view text) {
  Bytes bytes(text.begin(), text.end());
  bytes.push_back('\r');
  return bytes;
}

}  // namespace

// --- Both ----------------------------------------------------------------------------------------

std::optional<Setting> CommonDialect::setting(const Values& reply) const {
  if (reply.size() != 1) return std::nullopt;
  return Setting{reply[0], 0};
}

// A reset makes the board deaf; homing wants a servo that is on and phased.
Effect CommonDialect::effect(const CommandRow& row) const {
  if (row.code == kReset || row.code == kHome) return Effect::kSkip;
  return turns_rotor(row) ? Effect::kLast : Effect::kNone;
}

// Not kept as they are written: a timer, outputs and states that the board overwrites, and what an
// incremental encoder has not.
Effect CommonDialect::effect(const ParameterRow& row) const {
  constexpr std::array kNotKept = {kU,     kV,           kW,         kTraceMode,
                                   kTimer, kEncoderType, kEncoderId, kEncoderWord};
  return std::ranges::find(kNotKept, row.id) != kNotKept.end() ? Effect::kSkip : Effect::kNone;
}

// Outputs of an amplifier that is on, and brakes.
bool CommonDialect::moves(const ParameterRow& row) const {
  constexpr std::array kOutputs = {kBias, kOut1, kOut2, kPwm, kIqpkt, kIdpkt};
  return std::ranges::find(kOutputs, row.id) != kOutputs.end();
}

std::vector<Bytes> CommonDialect::before(const CommandRow& row, std::uint8_t) const {
  if (!turns_rotor(row)) return {};
  return {command(function_row(kDisable), {}), command(function_row(kErrorReset), {})};
}
std::vector<Bytes> CommonDialect::after(const CommandRow& row, std::uint8_t channel) const {
  return before(row, channel);
}

// --- Packets -------------------------------------------------------------------------------------

const ProtocolTable& PacketDialect::table() const {
  return kPacketTable;
}

std::optional<Values> PacketDialect::sample(const CommandRow& row, std::uint8_t) const {
  switch (row.code) {
    case kReportPacket:
      return Values{0xFF};
    case kCallPacket:
      return Values{kErrorReset};
    case kInitPacket:
      return Values{200};
    case kStreamPacket:
      return Values{1, 0, 0};
    case kSetPacket:
      return Values{kData0, 0};
    case kGetPacket:
      return Values{kPosition};
    default:
      break;
  }
  Values zeros;
  if (!is_function(row)) zeros.pad(row.request);
  return zeros;
}

Bytes PacketDialect::command(const CommandRow& row, const Values& request) const {
  if (is_function(row)) {
    return encode_request(Packet{.row = &packet_row(kCallPacket), .values = {row.code}});
  }
  Packet packet{.row = &row, .values = request};
  if (row.code == kSetPacket || row.code == kGetPacket) {
    packet.parameter = protocol::find(kTable.parameters, static_cast<std::uint16_t>(request[0]));
  }
  return encode_request(packet);
}

Bytes PacketDialect::read(const ParameterRow& row, std::uint8_t) const {
  return encode_request(
      Packet{.row = &packet_row(kGetPacket), .parameter = &row, .values = {row.id}});
}

Bytes PacketDialect::write(const ParameterRow& row, std::uint8_t, Setting setting) const {
  return encode_request(
      Packet{.row = &packet_row(kSetPacket), .parameter = &row, .values = {row.id, setting.value}});
}

Bytes PacketDialect::probe() const {
  return read(variable_row(kPosition), 0);
}

std::optional<Bytes> PacketDialect::spoil(const Bytes& request, Damage damage) const {
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

Bytes PacketDialect::noise() const {
  return {0x00, 0x55, 0xFF};  // a line that nobody ends
}

// Any packet ends within so many noughts, and the CR ends the line that the rest of them are.
Bytes PacketDialect::resynchronise() const {
  Bytes bytes(300, 0x00);
  bytes.push_back('\r');
  return bytes;
}

std::optional<Answer> PacketDialect::decode(std::span<const std::uint8_t> request,
                                            std::span<const std::uint8_t> reply) const {
  Decoder decoder;
  Packet asked{.row = &kTable.commands.front()};
  for (const std::uint8_t byte : request) {
    const bool whole = decoder.push(byte) == Decoder::Event::kPacket;
    if (whole && decoder.packet().status == Status::kOk) asked = decoder.packet();
  }
  PacketReplyDecoder replies(asked);
  for (std::size_t i = 0; i < reply.size(); ++i) {
    switch (replies.push(reply[i])) {
      case PacketReplyDecoder::Event::kNone:
        break;
      case PacketReplyDecoder::Event::kBadSum:
        return Answer{.kind = Answer::Kind::kDamaged};
      case PacketReplyDecoder::Event::kReply:
        if (i + 1 < reply.size()) return Answer{.kind = Answer::Kind::kDamaged};
        if (replies.status() != Status::kOk) return refused(replies.status());
        return Answer{.kind = Answer::Kind::kValues, .values = replies.values()};
    }
  }
  return std::nullopt;
}

Answer PacketDialect::refusal(Refusal refusal) const {
  return refused(status_of(refusal));
}

Answer PacketDialect::reaction(Damage damage) const {
  return damage == Damage::kByteTooFew ? Answer{} : refused(Status::kBadSum);
}

Answer PacketDialect::to_unknown_command() const {
  return refused(Status::kBadCode);
}

// Addresses are given in lines.
Effect PacketDialect::effect(const ParameterRow& row) const {
  return row.id == kAddress ? Effect::kSkip : CommonDialect::effect(row);
}

// --- Lines ---------------------------------------------------------------------------------------

const ProtocolTable& LineDialect::table() const {
  return kLineTable;
}

Bytes LineDialect::command(const CommandRow& row, const Values&) const {
  return line_of(row.name);
}

Bytes LineDialect::read(const ParameterRow& row, std::uint8_t) const {
  return line_of(row.name);
}

Bytes LineDialect::write(const ParameterRow& row, std::uint8_t, Setting setting) const {
  return line_of(fmt::format("{} {}", row.name, setting.value));
}

Bytes LineDialect::probe() const {
  return line_of("POS");
}

std::optional<Bytes> LineDialect::spoil(const Bytes& request, Damage damage) const {
  Bytes spoilt = request;
  switch (damage) {
    case Damage::kChecksum:
      return std::nullopt;  // there is none
    case Damage::kEnd:
      spoilt.back() ^= 0x01;
      break;
    case Damage::kByteTooMany:
      spoilt.insert(spoilt.end() - 1, 'x');
      break;
    case Damage::kByteTooFew:
      spoilt.erase(spoilt.end() - 2);
      break;
  }
  return spoilt;
}

Bytes LineDialect::noise() const {
  return {'\n', ' ', '\t'};  // blanks in front of a name
}

Bytes LineDialect::resynchronise() const {
  return line_of("");
}

std::optional<Answer> LineDialect::decode(std::span<const std::uint8_t> request,
                                          std::span<const std::uint8_t> reply) const {
  const std::string_view asked = protocol::as_text(request);
  const auto row = std::ranges::find_if(kTable.parameters, [&](const ParameterRow& r) {
    return asked.substr(0, asked.find_first_of(" \r")) == r.name;
  });
  LineReplyDecoder decoder;
  Answer answer{.kind = Answer::Kind::kValues};
  for (std::size_t i = 0; i < reply.size(); ++i) {
    switch (decoder.push(reply[i])) {
      case LineReplyDecoder::Event::kNone:
        break;
      case LineReplyDecoder::Event::kText: {
        const auto value =
            row != kTable.parameters.end() ? from_text(*row, decoder.text()) : std::nullopt;
        if (value) answer.values.push(*value);
        break;
      }
      case LineReplyDecoder::Event::kAccepted:
      case LineReplyDecoder::Event::kRefused:
        if (i + 1 < reply.size()) return Answer{.kind = Answer::Kind::kDamaged};
        return reply[i] == kAcceptedPrompt ? answer : kQuestionMark;
    }
  }
  return std::nullopt;
}

Answer LineDialect::refusal(Refusal) const {
  return kQuestionMark;
}

Answer LineDialect::reaction(Damage damage) const {
  return damage == Damage::kEnd ? Answer{} : kQuestionMark;
}

Answer LineDialect::to_unknown_command() const {
  return kQuestionMark;
}

// VER is a text.
Effect LineDialect::effect(const ParameterRow& row) const {
  return row.id == kVersionId ? Effect::kSkip : CommonDialect::effect(row);
}

}  // namespace virtdrive::rzt1
