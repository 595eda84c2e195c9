// The RZ/T1 kit as a bench sees it: words, options, and several boards on one line.
#include <gtest/gtest.h>

#include "core/check.h"
#include "devices/rzt1/client.h"
#include "scenarios/bench.h"
#include "scenarios/drives/rzt1_words.h"
#include "scenarios/line_transport.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using namespace rzt1;

std::string error_of(const std::vector<std::string>& set) {
  try {
    const Bench bench({.drives = {{.kind = "rzt1", .set = set}}});
  } catch (const SetupError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Rzt1Words, NameAVariableItsAddressOrAxisAndTheProtocol) {
  const Rzt1Name plain = parse_rzt1_name("KP");
  EXPECT_EQ(plain.name, "KP");
  EXPECT_FALSE(plain.in_lines || plain.number);
  const Rzt1Name addressed = parse_rzt1_name("255.ENABLE");
  EXPECT_EQ(addressed.number, 255);
  const Rzt1Name typed = parse_rzt1_name("ascii.2.POS");
  EXPECT_TRUE(typed.in_lines);
  EXPECT_EQ(typed.number, 2);
  EXPECT_EQ(typed.name, "POS");
  EXPECT_FALSE(parse_rzt1_name("ascii.POS").number);
  EXPECT_THROW(parse_rzt1_name("256.KP"), SetupError);
  EXPECT_THROW(parse_rzt1_name("two.KP"), SetupError);
}

TEST(Rzt1Words, AValueIsANumberAsTheBoardTakesIt) {
  EXPECT_EQ(parse_rzt1_assignment("ERRMASK=0x1E").value, 0x1E);
  EXPECT_EQ(parse_rzt1_assignment("2.ABS=-5").value, -5);
  EXPECT_EQ(parse_rzt1_assignment("kp=010").row->name, "KP");
  EXPECT_THROW(parse_rzt1_assignment("KP=ten"), SetupError);
  EXPECT_THROW(parse_rzt1_assignment("KP"), SetupError);
  EXPECT_THROW(parse_rzt1_assignment("KPP=1"), SetupError);
}

TEST(Rzt1Drive, TakesVariablesOfBothAxesOrOneAndSaysWhatItWillNot) {
  Bench bench({.drives = {{.kind = "rzt1", .set = {"KP=1500", "2.KI=7"}}}});
  LineTransport transport(bench.loop(), bench.line());
  Client axis1(transport, 1);
  Client axis2(transport, 2);
  EXPECT_EQ(axis1.get("KP"), 1500);
  EXPECT_EQ(axis2.get("KP"), 1500);
  EXPECT_EQ(axis1.get("KI"), 0);
  EXPECT_EQ(axis2.get("KI"), 7);
  EXPECT_EQ(error_of({"STA=1"}), "--set STA=1: STA cannot be written");
  EXPECT_TRUE(error_of({"PRO=4"}).starts_with("--set PRO=4: refused on axis 1; PRO is 0 ... 3"));
  EXPECT_EQ(error_of({"3.KP=1"}), "--set 3.KP=1: axis 3 is not 1 or 2");
}

TEST(Rzt1Drive, AnOptionKeepsWhatWasSetBefore) {
  Bench bench({.drives = {{.kind = "rzt1",
                           .set = {"KP=1500", "prompt_axis=on", "homing=literal",
                                   "homing_index_turns=2.5", "gear=successor"}}}});
  LineTransport transport(bench.loop(), bench.line());
  EXPECT_EQ(Client(transport).line("KP"), "1500");
  EXPECT_TRUE(error_of({"gear=reverse"}).starts_with("--set gear=reverse: "));
  EXPECT_TRUE(error_of({"homing_stop_turns=0"}).starts_with("--set homing_stop_turns=0: "));
}

TEST(Rzt1Drive, IsOnASharedLineWithS28Off) {
  std::vector<std::string> notes;
  Bench bench({.drives = {{.kind = "rzt1", .name = "a"},
                          {.kind = "rzt1", .name = "b", .set = {"1.ADDR=3", "2.ADDR=4"}}},
               .notes = [&](std::string_view note) { notes.emplace_back(note); }});
  LineTransport transport(bench.loop(), bench.line());
  Client client(transport, 3, 20ms);
  EXPECT_THROW(client.get("KP"), DriveSilent);
  ASSERT_FALSE(notes.empty());
  EXPECT_TRUE(notes[0].starts_with("S2-8 is ON"));
  bench.set("a.board.s2_8", 0);
  bench.set("b.board.s2_8", 0);
  for (std::uint8_t address = 1; address <= 4; ++address) {
    client.set_address(address);
    EXPECT_EQ(client.get("ADDR"), address);
  }
}

TEST(Rzt1Drive, StartsAtItsOwnBitRateAfterAPowerLoss) {
  Bench bench({.drives = {{.kind = "rzt1"}}});
  LineTransport transport(bench.loop(), bench.line());
  Client client(transport);
  client.send(*protocol::find(kTable.commands, 15), {5});
  EXPECT_EQ(client.get("KP"), 2000);  // the line, and with it this host, follow
  EXPECT_EQ(bench.line().settings().baud, 921600);
  bench.drive().power_off();
  bench.drive().power_on();
  EXPECT_EQ(bench.line().settings().baud, 115200);
}

}  // namespace
}  // namespace virtdrive
