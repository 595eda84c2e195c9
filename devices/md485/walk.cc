#include "devices/md485/walk.h"

#include <algorithm>
#include <array>

#include "core/check.h"
#include "devices/md485/codec.h"

namespace virtdrive::md485 {
namespace {

using protocol::Answer;
using protocol::Bytes;
using protocol::Damage;
using protocol::Effect;
using protocol::Setting;
using protocol::Values;

constexpr std::uint8_t kDefaultSet = 3, kRequestData = 4, kCommandNumber = 10,
                       kRequestIndexed = 164;
constexpr std::uint8_t kAlarmReset = 8;  // of kCommandNumber: harmless
constexpr std::uint8_t kVersion = 1, kStepInput = 225, kId = 133, kReturnType = 149;
constexpr std::array<std::uint8_t, 3> kUnknownIds = {0, 2, 255};
constexpr std::uint8_t kOwnId = 1;

const CommandRow& command_row(std::uint8_t pid) {
  const CommandRow* row = protocol::find(kTable.commands, pid);
  VIRTDRIVE_CHECK(row != nullptr, "no command {}", pid);
  return *row;
}

}  // namespace

// --- Requests ------------------------------------------------------------------------------------

std::optional<Values> WalkDialect::sample(const CommandRow& row, std::uint8_t) const {
  Values values;
  if (row.code == kDefaultSet) values = {kDefaultCheck};
  if (row.code == kRequestData) values = {kVersion};
  if (row.code == kRequestIndexed) values = {kStepInput, 1};
  if (row.code == kCommandNumber) values = {kAlarmReset};
  values.pad(row.request);
  return values;
}

Bytes WalkDialect::command(const CommandRow& row, const Values& request) const {
  return encode_request({.id = kOwnId}, row, request);
}

Bytes WalkDialect::read(const ParameterRow& row, std::uint8_t channel) const {
  return encode_request({.id = channel}, command_row(kRequestData), {row.id});
}

// Where a row has several numbers only the first one is walked; the others are the model's own.
Values WalkDialect::values_of(const ParameterRow& row, std::int64_t first) const {
  const md::Settings own = md::default_settings(model_.model());
  switch (row.id) {
    case 203:
      return {first, own.p_gain, own.i_gain};
    case 222:
      return {first, own.high_speed_limit};
    case 225:
      return {first, md::step_rpm(own, 1)};
    case 235:
      return {first, own.tq_i_gain};
    case 239:
      return {first, own.func_delay};
    case 250:
      return {first, own.func_posi_increment};
    default:
      break;
  }
  Values values;
  if (is_checked(row.id)) values.push(kWriteCheck);
  values.push(first);
  values.pad(write_fields(row));
  return values;
}

Bytes WalkDialect::write(const ParameterRow& row, std::uint8_t channel, Setting setting) const {
  return encode_request({.id = channel}, row, values_of(row, setting.value));
}

Bytes WalkDialect::probe() const {
  return encode_request({.id = kOwnId}, command_row(kRequestData), {kVersion});
}

std::optional<Bytes> WalkDialect::spoil(const Bytes& request, Damage damage) const {
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
  return {0x00, 0x55, 0xFF};  // neither a controller nor a host
}

// --- Answers -------------------------------------------------------------------------------------

std::optional<Answer> WalkDialect::decode(std::span<const std::uint8_t> request,
                                          std::span<const std::uint8_t> reply) const {
  Decoder decoder(protocol::Direction::kReply);
  for (const std::uint8_t byte : reply) {
    const Decoder::Event event = decoder.push(byte);
    if (event == Decoder::Event::kNone) continue;
    const bool asked = request.size() > 6 && decoder.frame().pid == request[5];
    if (event != Decoder::Event::kFrame || !asked) return Answer{.kind = Answer::Kind::kDamaged};
    return Answer{.kind = Answer::Kind::kValues, .values = decoder.frame().values};
  }
  return std::nullopt;
}

std::optional<Setting> WalkDialect::setting(const Values& reply) const {
  return Setting{reply[0], 0};
}

// Numbers of one byte are names of things: others are not taken. Larger ones go to the nearest end.
std::optional<Setting> WalkDialect::settles(const ParameterRow& row, Setting setting) const {
  if (protocol::width(row.type) == 1) return std::nullopt;
  return Setting{std::clamp(setting.value, row.range.minimum, row.range.maximum), 0};
}

// --- Where and in what order ---------------------------------------------------------------------

std::span<const std::uint8_t> WalkDialect::unknown_channels() const {
  return kUnknownIds;
}

Effect WalkDialect::effect(const CommandRow& row) const {
  return row.code == kDefaultSet ? Effect::kLast : Effect::kNone;
}

std::vector<Bytes> WalkDialect::before(const CommandRow& row, std::uint8_t) const {
  if (row.code != kDefaultSet) return {};
  return {probe()};
}

Effect WalkDialect::effect(const ParameterRow& row) const {
  return row.id == kId || row.id == kReturnType ? Effect::kSkip : Effect::kNone;
}

bool WalkDialect::moves(const ParameterRow& row) const {
  constexpr std::uint16_t kMoving[] = {16, 18, 22, 23, 25, 36, 37, 44, 46, 78, 155, 160, 180, 183};
  return std::ranges::find(kMoving, row.id) != std::end(kMoving);
}

}  // namespace virtdrive::md485
