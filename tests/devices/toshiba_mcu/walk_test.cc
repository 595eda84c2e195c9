#include "devices/toshiba_mcu/walk.h"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <iostream>

#include "core/nvm.h"
#include "devices/toshiba_mcu/codec.h"
#include "devices/toshiba_mcu/device.h"
#include "tests/devices/vectors.h"
#include "tests/devices/wire.h"
#include "tests/firmware_models/toshiba_mcu/rig.h"

namespace virtdrive::toshiba_mcu {
namespace {

using namespace std::chrono_literals;
using protocol::Bytes;
using protocol::WalkOptions;
using protocol::WalkReport;

constexpr SimDuration kCharacter = 86'806ns;  // 10 bits at 115200 baud

// The drive in this process.
struct InProcess {
  InProcess() { wire.attach(device); }
  Rig rig;
  Wire wire{rig.loop, kCharacter};
  MemoryInProcess memory;
  Device device{rig.loop, wire.port(), rig.firmware, memory, DeviceOptions{}};
};

constexpr WalkOptions kOptions{
    .channel = 1, .patience = 20ms, .silence = 3ms, .pause = 2ms, .most_failures = 10'000};

TEST(ToshibaMcuWalk, TheDriveAnswersEveryRowAsTheTableSays) {
  InProcess drive;
  const WalkReport report = protocol::walk(WalkDialect(), drive.wire, kOptions);
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_TRUE(report.skipped.empty());
  EXPECT_FALSE(report.given_up);
  EXPECT_GE(report.checks.size(), 30 * (std::size(kCommands) + std::size(kParameters)));
  std::cout << text(report);

  const auto checks_of = [&](const std::string& row) {
    return std::ranges::count(report.checks, row, &protocol::Check::row);
  };
  for (const CommandRow& row : kCommands) {
    EXPECT_GE(checks_of(fmt::format("command {:02X} {}", row.code, row.name)), 20) << row.name;
  }
  for (const ParameterRow& row : kParameters) {
    EXPECT_GE(checks_of(fmt::format("parameter {:02X} {}", row.id, row.name)), 8) << row.name;
  }
  EXPECT_GE(checks_of("parameter 0F (unknown)"), 2);
  EXPECT_GE(checks_of("command 7F (unknown)"), 2);
}

TEST(ToshibaMcuWalk, EveryChannelPasses) {
  for (const int channel : {0, 2}) {
    InProcess drive;
    WalkOptions options = kOptions;
    options.channel = static_cast<std::uint8_t>(channel);
    const WalkReport report = protocol::walk(WalkDialect(), drive.wire, options);
    EXPECT_EQ(report.failures(), 0U) << text(report);
  }
}

// --- Broken drives -------------------------------------------------------------------------------

// A good drive, but for the requests that `fault` answers in its place.
class Broken final : public HostTransport {
 public:
  /// Bytes that are said instead of the drive's answer; nothing: the drive answers.
  using Fault = std::function<std::optional<Bytes>(const Bytes& request)>;

  explicit Broken(Fault fault) : fault_(std::move(fault)) {}

  void write(std::span<const std::uint8_t> bytes) override {
    const auto instead = fault_({bytes.begin(), bytes.end()});
    if (instead)
      said_.insert(said_.end(), instead->begin(), instead->end());
    else
      drive_.wire.write(bytes);
  }
  std::optional<std::uint8_t> read(SimDuration patience) override {
    if (said_.empty()) return drive_.wire.read(patience);
    const std::uint8_t byte = said_.front();
    said_.pop_front();
    return byte;
  }

 private:
  InProcess drive_;
  Fault fault_;
  std::deque<std::uint8_t> said_;
};

WalkReport walk_broken(Broken::Fault fault, std::size_t most_failures = 10'000) {
  Broken drive(std::move(fault));
  WalkOptions options = kOptions;
  options.most_failures = most_failures;
  return protocol::walk(WalkDialect(), drive, options);
}

const Bytes kSetDone = from_hex("11 0a 00 36 13");

bool is_set_of(const Bytes& request, std::uint8_t id) {
  return request.size() == 11 && request[1] == 0x0A && request[2] == kOptions.channel &&
         request[3] == id;
}
bool is_get_of(const Bytes& request, std::uint8_t id) {
  return request.size() == 7 && request[1] == 0x09 && request[2] == kOptions.channel &&
         request[3] == id;
}

// All failures are of one row, and one of them is about `what`.
void expect_found(const WalkReport& report, const std::string& row, const std::string& what) {
  EXPECT_GT(report.failures(), 0U);
  bool found = false;
  for (const protocol::Check& check : report.checks) {
    if (check.passed) continue;
    EXPECT_EQ(check.row, row) << check.what;
    EXPECT_FALSE(check.detail.empty());
    found |= check.what.find(what) != std::string::npos;
  }
  EXPECT_TRUE(found) << text(report);
}

TEST(ToshibaMcuWalk, FindsADriveThatTakesAValueOutOfRange) {
  const Bytes too_many = WalkDialect().write(*find(kTable.parameters, 0x10), 1, {101, 0});
  const auto report = walk_broken([&](const Bytes& request) -> std::optional<Bytes> {
    return request == too_many ? std::optional(kSetDone) : std::nullopt;
  });
  expect_found(report, "parameter 10 PolePairs", "refuses above its maximum, 101");
  EXPECT_EQ(report.failures(), 1U);
}

TEST(ToshibaMcuWalk, FindsADriveThatChangesAValueAlthoughItRefuses) {
  bool changed = false;
  const auto report = walk_broken([&](const Bytes& request) -> std::optional<Bytes> {
    if (is_set_of(request, 0x11)) changed = request[5] == 3;
    return changed && is_get_of(request, 0x11)
               ? std::optional(encode_reply(*find(kTable.commands, 0x09), {3, 0}))
               : std::nullopt;
  });
  expect_found(report, "parameter 11 Direction", "is unchanged by above its maximum, 3");
}

TEST(ToshibaMcuWalk, FindsAWrongChecksum) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    if (!is_get_of(request, 0x92)) return std::nullopt;
    return from_hex("11 09 07 00 00 00 00 00 13");
  });
  expect_found(report, "parameter 92 Channels", "is read within its range");
}

TEST(ToshibaMcuWalk, FindsADriveThatDoesNotLookAtTheChecksum) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    if (request != from_hex("11 02 01 08 13")) return std::nullopt;  // 09 would be right
    return encode_reply(*find(kTable.commands, 0x02), {0, 0, 0, 0, 0});
  });
  expect_found(report, "command 02 GetMotorState", "with a wrong checksum gets refusal 1");
}

TEST(ToshibaMcuWalk, FindsAReadOnlyParameterThatIsWritten) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    return is_set_of(request, 0xB0) ? std::optional(kSetDone) : std::nullopt;
  });
  expect_found(report, "parameter B0 FirmwareVersion", "is read-only");
}

TEST(ToshibaMcuWalk, FindsAnAnswerThatIsTooLong) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    return is_set_of(request, 0x40) ? std::optional(from_hex("11 0a 00 36 13 00")) : std::nullopt;
  });
  expect_found(report, "parameter 40 PiIdKi", "takes maximum, 65535");
}

TEST(ToshibaMcuWalk, FindsAnUnlistedUnitThatIsTaken) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    return is_set_of(request, 0x19) && request[4] == 0x7F ? std::optional(kSetDone) : std::nullopt;
  });
  expect_found(report, "parameter 19 IqStart", "an unlisted unit");
}

TEST(ToshibaMcuWalk, FindsAnAnswerToAnUnknownCommandAndToAnUnknownParameter) {
  expect_found(walk_broken([](const Bytes& request) -> std::optional<Bytes> {
                 return request.size() > 1 && request[1] == 0x7F
                            ? std::optional(from_hex("11 ee ff 77 13"))
                            : std::nullopt;
               }),
               "command 7F (unknown)", "gets silence");
  expect_found(walk_broken([](const Bytes& request) -> std::optional<Bytes> {
                 return is_set_of(request, 0x0F) ? std::optional(kSetDone) : std::nullopt;
               }),
               "parameter 0F (unknown)", "is refused to be written");
}

TEST(ToshibaMcuWalk, FindsACommandThatIsNotAnswered) {
  const auto report = walk_broken([](const Bytes& request) -> std::optional<Bytes> {
    return request.size() == 5 && request[1] == 0x11 ? std::optional(Bytes{}) : std::nullopt;
  });
  expect_found(report, "command 11 GetMotorControlMethod", "is answered");
}

TEST(ToshibaMcuWalk, GivesASilentDriveUp) {
  const auto report = walk_broken([](const Bytes&) { return std::optional(Bytes{}); }, 25);
  EXPECT_TRUE(report.given_up);
  EXPECT_EQ(report.failures(), 25U);
  EXPECT_NE(text(report).find("given up"), std::string::npos);
}

TEST(ToshibaMcuWalk, StopsTheMotorBeforeItGivesUp) {
  const Bytes start = from_hex("11 00 01 07 13");
  std::vector<Bytes> requests;
  const auto report = walk_broken(
      [&](const Bytes& request) -> std::optional<Bytes> {
        requests.push_back(request);
        return request == start ? std::optional(from_hex("11 00")) : std::nullopt;
      },
      1);
  EXPECT_TRUE(report.given_up);
  ASSERT_GE(requests.size(), 2U);
  EXPECT_EQ(*(requests.end() - 2), start);
  EXPECT_EQ(requests.back(), from_hex("11 01 01 00 13"));
}

TEST(ToshibaMcuWalk, StandsADriveThatTalksWithoutEndAndOneThatTalksNonsense) {
  const Bytes flood(20'000, 0x11);
  EXPECT_TRUE(walk_broken([&](const Bytes&) { return std::optional(flood); }, 5).given_up);
  std::uint64_t seed = 1;
  const auto nonsense = [&](const Bytes& request) {
    Bytes bytes(request.size() % 60);
    for (std::uint8_t& byte : bytes) {
      seed = seed * 6364136223846793005U + 1442695040888963407U;
      byte = static_cast<std::uint8_t>(seed >> 56);
    }
    return std::optional(bytes);
  };
  EXPECT_TRUE(walk_broken(nonsense, 500).given_up);
}

}  // namespace
}  // namespace virtdrive::toshiba_mcu
