#include "devices/protocol/walk.h"

#include <algorithm>
#include <deque>
#include <gtest/gtest.h>
#include <map>

#include "devices/protocol/checksum.h"

namespace virtdrive::protocol {
namespace {

// --- A protocol of our own -----------------------------------------------------------------------
// Requests of seven bytes: operation, channel, id, unit, value (two), sum. Answers of five:
// operation + 0x80, unit, value, sum; or FF, code, 0, 0, sum. EE between requests is noise.

constexpr std::uint8_t kRead = 0x41;
constexpr std::uint8_t kWrite = 0x42;
constexpr std::uint8_t kNoise = 0xEE;
constexpr std::uint8_t kError = 0xFF;
constexpr std::size_t kRequestSize = 7;
constexpr std::size_t kAnswerSize = 5;
constexpr std::int64_t kUnknownCommandCode = 99;
constexpr std::uint8_t kOnlyChannel = 0;

constexpr Field kOperand[] = {{.name = "operand", .type = WireType::kI16}};
constexpr UnitCode kVolts[] = {{0, "V"}, {-3, "mV"}};

constexpr CommandRow kCommands[] = {
    {.code = 0x10, .name = "Ping", .request = kOperand, .source = "-", .doc = "-"},
    {.code = 0x11, .name = "Reset", .request = kOperand, .source = "-", .doc = "-"},
    {.code = 0x12,
     .name = "Mute",
     .request = kOperand,
     .replies = false,
     .source = "-",
     .doc = "-"},
    {.code = 0x13,
     .name = "Gone",
     .request = kOperand,
     .support = Support::kRejected,
     .source = "-",
     .doc = "-"}};

constexpr ParameterRow kParameters[] = {{.id = 1,
                                         .name = "Gain",
                                         .type = WireType::kI16,
                                         .range = {0, 10},
                                         .factory = {3, -3},
                                         .units = kVolts,
                                         .source = "-",
                                         .doc = "-"},
                                        {.id = 2,
                                         .name = "Status",
                                         .type = WireType::kI16,
                                         .access = Access::kReadOnly,
                                         .range = {0, 1},
                                         .source = "-",
                                         .doc = "-"},
                                        {.id = 3,
                                         .name = "Go",
                                         .type = WireType::kI16,
                                         .access = Access::kWriteOnly,
                                         .range = {-32768, 32767},
                                         .source = "-",
                                         .doc = "-"},
                                        {.id = 4,
                                         .name = "Gone",
                                         .type = WireType::kI16,
                                         .support = Support::kRejected,
                                         .source = "-",
                                         .doc = "-"},
                                        {.id = 6,
                                         .name = "Limit",
                                         .type = WireType::kI16,
                                         .range = {-5, 5},
                                         .factory = {1},
                                         .support = Support::kStored,
                                         .source = "-",
                                         .doc = "-"}};

constexpr ProtocolTable kTable = {
    .name = "toy",
    .framing = {.checksum = Checksum::kSum8, .longest = kRequestSize},
    .commands = kCommands,
    .parameters = kParameters,
};
static_assert(well_formed(kTable));

Bytes frame(std::initializer_list<std::int64_t> head, std::int64_t value) {
  Bytes bytes;
  for (const std::int64_t byte : head) bytes.push_back(static_cast<std::uint8_t>(byte));
  bytes.resize(bytes.size() + 2);
  store(std::span(bytes).last(2), WireType::kI16, ByteOrder::kLittleEndian, value);
  bytes.push_back(sum8(bytes));
  return bytes;
}

std::int64_t value_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return load(bytes.subspan(at, 2), WireType::kI16, ByteOrder::kLittleEndian);
}

class ToyDialect final : public Dialect {
 public:
  const ProtocolTable& table() const override { return kTable; }
  std::optional<Values> sample(const CommandRow&, std::uint8_t) const override { return Values{0}; }
  Bytes command(const CommandRow& row, const Values&) const override {
    return frame({row.code, kOnlyChannel, 0, 0}, 0);
  }
  Bytes read(const ParameterRow& row, std::uint8_t channel) const override {
    return frame({kRead, channel, row.id, 0}, 0);
  }
  Bytes write(const ParameterRow& row, std::uint8_t channel, Setting setting) const override {
    return frame({kWrite, channel, row.id, setting.unit}, setting.value);
  }
  Bytes probe() const override { return command(kCommands[0], {0}); }
  std::optional<Bytes> spoil(const Bytes& request, Damage damage) const override {
    Bytes spoilt = request;
    if (damage == Damage::kChecksum)
      ++spoilt.back();
    else if (damage == Damage::kByteTooFew)
      spoilt.pop_back();
    else
      return std::nullopt;
    return spoilt;
  }
  Bytes noise() const override { return {kNoise, kNoise}; }
  Bytes resynchronise() const override { return Bytes(kRequestSize, kNoise); }

  std::optional<Answer> decode(std::span<const std::uint8_t> request,
                               std::span<const std::uint8_t> reply) const override {
    if (reply.size() < kAnswerSize) return std::nullopt;
    if (sum8(reply.first(kAnswerSize - 1)) != reply.back()) {
      return Answer{.kind = Answer::Kind::kDamaged};
    }
    if (reply[0] == kError) return Answer{.kind = Answer::Kind::kRefused, .code = reply[1]};
    if (reply[0] != (request[0] | 0x80)) return Answer{.kind = Answer::Kind::kDamaged};
    return Answer{.kind = Answer::Kind::kValues,
                  .values = {static_cast<std::int8_t>(reply[1]), value_at(reply, 2)}};
  }
  std::optional<Setting> setting(const Values& reply) const override {
    return Setting{reply[1], static_cast<std::int8_t>(reply[0])};
  }
  Answer refusal(Refusal refusal) const override {
    return {.kind = Answer::Kind::kRefused, .code = static_cast<std::int64_t>(refusal)};
  }
  Answer reaction(Damage) const override { return {}; }
  Answer to_unknown_command() const override {
    return {.kind = Answer::Kind::kRefused, .code = kUnknownCommandCode};
  }
  std::uint16_t highest_id() const override { return 20; }
  std::uint16_t highest_command() const override { return 0x14; }
  std::span<const std::uint8_t> unknown_channels() const override { return kUnknownChannels; }
  bool names_channel(const CommandRow&) const override { return false; }
  Effect effect(const CommandRow& row) const override {
    return row.code == 0x11 ? Effect::kSkip : Effect::kNone;
  }
  using Dialect::effect;

 private:
  static constexpr std::uint8_t kUnknownChannels[] = {1};
};

class ToyDrive final : public HostTransport {
 public:
  void write(std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) {
      if (heard_.empty() && byte == kNoise) continue;
      heard_.push_back(byte);
      if (heard_.size() < kRequestSize) continue;
      if (sum8(std::span(heard_).first(kRequestSize - 1)) == heard_.back()) answer();
      heard_.clear();
    }
  }
  std::optional<std::uint8_t> read(SimDuration) override {
    if (said_.empty()) return std::nullopt;
    const std::uint8_t byte = said_.front();
    said_.pop_front();
    return byte;
  }

  std::map<std::uint16_t, Setting> settings = {{1, {3, -3}}, {2, {1, 0}}, {3, {0, 0}}, {6, {1, 0}}};
  std::map<std::uint8_t, int> asked;           // requests by operation
  std::optional<Refusal> always_refuses_with;  // a defect: one code for every refusal

 private:
  void answer() {
    const std::uint8_t operation = heard_[0];
    ++asked[operation];
    if (operation == kRead || operation == kWrite) {
      parameter(operation == kWrite);
      return;
    }
    const CommandRow* row = find(kTable.commands, operation);
    if (row == nullptr)
      say({kError, kUnknownCommandCode}, 0);
    else if (row->support == Support::kRejected)
      refuse(Refusal::kUnknown);
    else if (row->replies)
      say({operation | 0x80, 0}, 0);
  }

  void parameter(bool write) {
    const ParameterRow* row =
        heard_[1] == kOnlyChannel ? find(kTable.parameters, heard_[2]) : nullptr;
    const Setting setting{value_at(heard_, 4), static_cast<std::int8_t>(heard_[3])};
    const Refusal refusal = write ? check_write(row, setting.value, setting.unit) : check_read(row);
    if (refusal != Refusal::kNone) {
      refuse(refusal);
      return;
    }
    if (write) settings[row->id] = setting;
    say({heard_[0] | 0x80, settings[row->id].unit}, settings[row->id].value);
  }

  void refuse(Refusal refusal) {
    say({kError, static_cast<std::int64_t>(always_refuses_with.value_or(refusal))}, 0);
  }
  void say(std::initializer_list<std::int64_t> head, std::int64_t value) {
    const Bytes bytes = frame(head, value);
    said_.insert(said_.end(), bytes.begin(), bytes.end());
  }

  Bytes heard_;
  std::deque<std::uint8_t> said_;
};

std::vector<std::string> failed_rows(const WalkReport& report) {
  std::vector<std::string> rows;
  for (const Check& check : report.checks) {
    if (!check.passed && (rows.empty() || rows.back() != check.row)) rows.push_back(check.row);
  }
  return rows;
}

// --- Tests ---------------------------------------------------------------------------------------

TEST(Walk, KnowsNoProtocolAndPassesADriveThatKeepsToItsTable) {
  ToyDrive drive;
  const WalkReport report = walk(ToyDialect(), drive, {});
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_GT(report.checks.size(), 200U);
  EXPECT_GT(drive.asked[kWrite], 0);
}

TEST(Walk, NeverSendsARowThatTheDialectLeavesOut) {
  ToyDrive drive;
  const WalkReport report = walk(ToyDialect(), drive, {});
  EXPECT_EQ(report.skipped, std::vector<std::string>{"command 11 Reset"});
  EXPECT_EQ(drive.asked[0x11], 0);
  EXPECT_NE(text(report).find("left out command 11 Reset"), std::string::npos);
}

TEST(Walk, TellsTheRefusalsApart) {
  ToyDrive drive;
  drive.always_refuses_with = Refusal::kUnknown;
  const WalkReport report = walk(ToyDialect(), drive, {});
  EXPECT_EQ(failed_rows(report),
            (std::vector<std::string>{"parameter 01 Gain", "parameter 02 Status", "parameter 03 Go",
                                      "parameter 06 Limit"}));
}

TEST(Walk, LeavesTheSettingsAsTheyWere) {
  ToyDrive drive;
  drive.settings[1] = {7, 0};
  drive.settings[6] = {-2, 0};
  const WalkReport report = walk(ToyDialect(), drive, {.at_factory = false});
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_EQ(drive.settings[1], (Setting{7, 0}));
  EXPECT_EQ(drive.settings[6], (Setting{-2, 0}));
}

TEST(Walk, FindsASettingThatIsNotTheFactorys) {
  ToyDrive drive;
  drive.settings[1] = {7, 0};
  const WalkReport report = walk(ToyDialect(), drive, {});
  EXPECT_EQ(report.failures(), 1U);
  EXPECT_NE(text(report).find("FAILED parameter 01 Gain: has its factory setting: 7 unit 0 instead "
                              "of 3 unit -3"),
            std::string::npos)
      << text(report);
}

TEST(Walk, TheSameDriveGivesTheSameReport) {
  ToyDrive one;
  ToyDrive other;
  one.always_refuses_with = other.always_refuses_with = Refusal::kReadOnly;
  EXPECT_EQ(text(walk(ToyDialect(), one, {})), text(walk(ToyDialect(), other, {})));
}

}  // namespace
}  // namespace virtdrive::protocol
