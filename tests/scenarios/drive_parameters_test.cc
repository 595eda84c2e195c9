#include <gtest/gtest.h>

#include "core/check.h"
#include "devices/toshiba_mcu/client.h"
#include "scenarios/bench.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using toshiba_mcu::UnitValue;

UnitValue after_setting(const std::string& assignment, std::uint8_t channel,
                        std::string_view parameter) {
  Bench bench({.drives = {{.kind = "toshiba-mcu", .set = {assignment}}}});
  LineTransport transport(bench.loop(), bench.line());
  return toshiba_mcu::Client(transport).get(channel, parameter);
}

std::string error_of(const BenchOptions& options) {
  try {
    const Bench bench(options);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SetParameter, WritesAllChannelsOrOne) {
  EXPECT_EQ(after_setting("MaxAngAcc=800", 0, "MaxAngAcc"), (UnitValue{800, 0}));
  EXPECT_EQ(after_setting("MaxAngAcc=800", 2, "MaxAngAcc"), (UnitValue{800, 0}));
  EXPECT_EQ(after_setting("2.MaxAngAcc=800", 2, "MaxAngAcc"), (UnitValue{800, 0}));
  EXPECT_EQ(after_setting("2.MaxAngAcc=800", 1, "MaxAngAcc"), (UnitValue{300, 0}));
}

TEST(SetParameter, TakesTheUnitThatIsWrittenOrTheFactoryOne) {
  EXPECT_EQ(after_setting("IqStart=1A", 1, "IqStart"), (UnitValue{1, 0}));
  EXPECT_EQ(after_setting("iqstart=1200", 1, "IqStart"), (UnitValue{1200, -3}));
  EXPECT_EQ(after_setting("Overtemperature=-10degC", 1, "Overtemperature"), (UnitValue{-10, 0}));
}

TEST(SetParameter, SaysWhatIsWrong) {
  const auto set = [](const std::string& text) {
    return error_of({.drives = {{.kind = "toshiba-mcu", .set = {text}}}});
  };
  EXPECT_EQ(set("MaxAngAcc"), "--set MaxAngAcc: expected [CHANNEL.]NAME=VALUE[UNIT]");
  EXPECT_NE(set("MaxAngAc=1").find("did you mean MaxAngAcc?"), std::string::npos);
  EXPECT_EQ(
      set("MaxAngAcc=0"),
      "--set MaxAngAcc=0: refused; MaxAngAcc is 1 ... 10000: Limit of the acceleration, of the "
      "electrical angle in rad/s2 and Hz/s.");
  EXPECT_EQ(set("3.MaxAngAcc=1"), "--set 3.MaxAngAcc=1: channel '3' is not 0 ... 2");
  EXPECT_EQ(set("MaxAngAcc=fast"),
            "--set MaxAngAcc=fast: 'fast' is not a whole number within 32 bits");
  EXPECT_NE(set("IqStart=1kA").find("unknown unit of IqStart 'kA'; did you mean"),
            std::string::npos);
  EXPECT_EQ(set("BoardRevision=2"), "--set BoardRevision=2: BoardRevision cannot be written");
}

TEST(BenchOptions, UnknownNamesAreErrorsThatOfferTheNearest) {
  EXPECT_EQ(
      error_of({.drives = {{.kind = "toshiba"}}}),
      "unknown drive 'toshiba'; did you mean toshiba-mcu? ('virtdrive list drives' shows them "
      "all)");
  EXPECT_NE(error_of({.drives = {{.kind = "toshiba-mcu", .motors = {"db42s30"}}}})
                .find("did you mean db42s03"),
            std::string::npos);
  EXPECT_NE(
      error_of({.drives = {{.kind = "toshiba-mcu", .load = "brick:1"}}}).find("--load brick:1"),
      std::string::npos);
}

}  // namespace
}  // namespace virtdrive
