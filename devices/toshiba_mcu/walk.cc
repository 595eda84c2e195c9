#include "devices/toshiba_mcu/walk.h"

#include <algorithm>
#include <array>

#include "core/check.h"
#include "devices/toshiba_mcu/codec.h"
#include "firmware_models/toshiba_mcu/scaling.h"

namespace virtdrive::toshiba_mcu {
namespace {

using protocol::Answer;
using protocol::Bytes;
using protocol::Damage;
using protocol::Effect;
using protocol::Refusal;
using protocol::Setting;
using protocol::Values;

constexpr std::uint8_t kStart = 0x00;
constexpr std::uint8_t kStop = 0x01;
constexpr std::uint8_t kStore = 0x03;
constexpr std::uint8_t kClear = 0x04;
constexpr std::uint8_t kArmScope = 0x05;
constexpr std::uint8_t kScopeData = 0x06;
constexpr std::uint8_t kDoTurn = 0x08;
constexpr std::uint8_t kGetOne = 0x09;
constexpr std::uint8_t kSetOne = 0x0A;
constexpr std::uint8_t kGetMany = 0x0B;
constexpr std::uint8_t kSetMany = 0x0C;
constexpr std::uint8_t kDoLinearMotion = 0x0D;
constexpr std::uint8_t kStartTorque = 0x10;
constexpr std::uint8_t kSetMethod = 0x12;
constexpr std::uint8_t kGetVersion = 0x14;

constexpr std::uint8_t kPolePairsId = 0x10;
constexpr std::uint8_t kSpeedLimitId = 0x16;
constexpr std::uint8_t kSpeedChangeId = 0x17;
constexpr std::uint8_t kSpeedId = 0xE5;
constexpr std::uint8_t kTorqueId = 0xE6;

constexpr std::array kActing = {kStart,  kStop,           kStore,       kClear,    kScopeData,
                                kDoTurn, kDoLinearMotion, kStartTorque, kSetMethod};
constexpr std::array kStarting = {kStart, kScopeData, kDoTurn, kDoLinearMotion, kStartTorque};

// Sixteen signals: the oscilloscope is full after 20 PWM periods.
constexpr std::int64_t kSixteenSignals = 0xFFFF;
constexpr std::int64_t kSlowRpm = 30;
constexpr std::array<std::uint8_t, 3> kUnknownChannels = {3, 7, 0xFE};
constexpr std::size_t kTrailer = 2;  // CRC, end

Answer error(std::string_view name) {
  const auto it = std::ranges::find(kTable.errors, name, &CodeRow::name);
  VIRTDRIVE_CHECK(it != kTable.errors.end(), "no error {}", name);
  return {.kind = Answer::Kind::kRefused, .code = it->code};
}

const CommandRow& command_row(std::uint8_t code) {
  const CommandRow* row = protocol::find(kTable.commands, code);
  VIRTDRIVE_CHECK(row != nullptr, "no command {:#x}", code);
  return *row;
}

// What stands behind the first number where zeros would not do.
struct Rest {
  std::uint8_t code;
  Values values;
};

const std::array<Rest, 8>& rests() {
  static const std::array<Rest, 8> rests = {{{kArmScope, {kSixteenSignals}},
                                             {kDoTurn, {1, kSlowRpm}},
                                             {kDoLinearMotion, {1, kSlowRpm}},
                                             {kGetOne, {kPolePairsId}},
                                             {kSetOne, {kSpeedId}},
                                             {kGetMany, {1, kPolePairsId}},
                                             {kSetMany, {1, kSpeedId}},
                                             {kSetMethod, {1}}}};  // by speed
  return rests;
}

}  // namespace

// --- Requests ------------------------------------------------------------------------------------

std::optional<Values> WalkDialect::sample(const CommandRow& row, std::uint8_t channel) const {
  Values values;
  if (!row.request.empty()) values.push(names_channel(row) ? channel : 0);
  const auto rest = std::ranges::find(rests(), row.code, &Rest::code);
  if (rest != rests().end()) {
    for (std::size_t i = 0; i < rest->values.size(); ++i) values.push(rest->values[i]);
  }
  values.pad(row.request);
  return values;
}

Bytes WalkDialect::command(const CommandRow& row, const Values& request) const {
  return encode_request(row, request);
}

Bytes WalkDialect::read(const ParameterRow& row, std::uint8_t channel) const {
  return encode_request(command_row(kGetOne), {channel, row.id, 0});
}

Bytes WalkDialect::write(const ParameterRow& row, std::uint8_t channel, Setting setting) const {
  return encode_request(command_row(kSetOne), {channel, row.id, setting.unit, setting.value});
}

Bytes WalkDialect::probe() const {
  return encode_request(command_row(kGetVersion), {0});
}

std::optional<Bytes> WalkDialect::spoil(const Bytes& request, Damage damage) const {
  Bytes spoilt = request;
  std::uint8_t& crc = *(spoilt.end() - kTrailer);
  switch (damage) {
    case Damage::kChecksum:
      crc ^= 0x01;
      break;
    case Damage::kEnd:
      spoilt.back() ^= 0x01;
      break;
    case Damage::kByteTooMany:
      if (crc == kEot || crc == kBot) return std::nullopt;  // it would stand where the end belongs
      spoilt.insert(spoilt.end() - kTrailer, 0x00);
      break;
    case Damage::kByteTooFew:
      spoilt.erase(spoilt.end() - kTrailer - 1);
      break;
  }
  return spoilt;
}

Bytes WalkDialect::noise() const {
  return {0x00, kEot, 0xFF, 0x55};  // all but a start
}

// No command, no end: a drive that waits takes them in until an end byte is due.
Bytes WalkDialect::resynchronise() const {
  return Bytes(kTable.framing.longest, 0xFF);
}

// --- Answers -------------------------------------------------------------------------------------

std::optional<Answer> WalkDialect::decode(std::span<const std::uint8_t> request,
                                          std::span<const std::uint8_t> reply) const {
  using Kind = Answer::Kind;
  Decoder decoder(Direction::kReply);
  for (std::size_t i = 0; i < reply.size(); ++i) {
    switch (decoder.push(reply[i])) {
      case Decoder::Event::kNone:
        break;
      case Decoder::Event::kTelegram: {
        const Telegram& telegram = decoder.telegram();
        if (telegram.row == &kErrorReply) {
          return Answer{.kind = Kind::kRefused, .code = telegram.values[0]};
        }
        if (request.size() < 2 || telegram.row->code != request[1]) {
          return Answer{.kind = Kind::kDamaged};
        }
        return Answer{.kind = Kind::kValues, .values = telegram.values};
      }
      default:
        return Answer{.kind = Kind::kDamaged};
    }
  }
  return std::nullopt;
}

std::optional<Setting> WalkDialect::setting(const Values& reply) const {
  if (reply.size() != protocol::values(kValueEntry)) return std::nullopt;
  return Setting{reply[0], static_cast<std::int8_t>(reply[1])};
}

// --- What to expect ------------------------------------------------------------------------------

Answer WalkDialect::refusal(Refusal) const {
  return error("refused");
}

Answer WalkDialect::reaction(Damage damage) const {
  return damage == Damage::kChecksum ? error("crc") : Answer{};
}

// --- Where and in what order ---------------------------------------------------------------------

std::span<const std::uint8_t> WalkDialect::unknown_channels() const {
  return kUnknownChannels;
}

bool WalkDialect::names_channel(const CommandRow& row) const {
  return !row.request.empty() && row.request.front().name == kMotorNr[0].name;
}

Effect WalkDialect::effect(const CommandRow& row) const {
  return std::ranges::find(kActing, row.code) != kActing.end() ? Effect::kLast : Effect::kNone;
}

std::vector<Bytes> WalkDialect::before(const CommandRow& row, std::uint8_t channel) const {
  const Bytes start = encode_request(command_row(kStart), {channel});
  if (row.code == kStop) return {start};  // only a motor that runs can be stopped
  if (row.code != kScopeData) return {};
  protocol::Values arm = {channel, kSixteenSignals};
  arm.pad(command_row(kArmScope).request);
  return {encode_request(command_row(kArmScope), arm), start, probe()};
}

std::vector<Bytes> WalkDialect::after(const CommandRow& row, std::uint8_t channel) const {
  if (std::ranges::find(kStarting, row.code) == kStarting.end()) return {};
  return {encode_request(command_row(kStop), {channel})};
}

// Up to the TorqueLimit, which follows from IqLimit and TorqueFactor (5.1.71).
protocol::Range WalkDialect::range(const ParameterRow& row) const {
  if (row.id != kTorqueId) return row.range;
  const Scaling scaling = scale(kFactorySettings);
  const double limit_mnm = scaling.iq_limit_a * scaling.torque_nm_per_a * 1000;
  return {row.range.minimum, static_cast<std::int64_t>(limit_mnm + 0.5)};
}

std::vector<protocol::Dialect::Need> WalkDialect::needs(const ParameterRow& row) const {
  if (row.id != kSpeedChangeId) return {};
  return {{kSpeedLimitId, {kSpeedRange.maximum, 0}}};  // SpeedChange goes up to it, plus 1 (5.1.8)
}

}  // namespace virtdrive::toshiba_mcu
