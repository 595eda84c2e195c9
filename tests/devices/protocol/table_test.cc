#include "devices/protocol/table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "devices/protocol/binding.h"
#include "devices/protocol/document.h"
#include "devices/toshiba_mcu/table.h"

namespace virtdrive::protocol {
namespace {

constexpr UnitCode kUnits[] = {{0, "A"}, {-3, "mA"}};
constexpr ParameterRow kRows[] = {
    {.id = 1, .name = "Gain", .range = {0, 9}, .factory = {5}, .source = "1", .doc = "A gain."},
    {.id = 2,
     .name = "Limit",
     .range = {1, 5},
     .factory = {2, -3},
     .units = kUnits,
     .source = "1",
     .doc = "A limit."},
    {.id = 4,
     .name = "Serial",
     .access = Access::kReadOnly,
     .range = {0, 9},
     .source = "1",
     .doc = "A number."},
    {.id = 7,
     .name = "Command",
     .access = Access::kWriteOnly,
     .range = {0, 9},
     .source = "1",
     .doc = "A command."},
    {.id = 9, .name = "Absent", .support = Support::kRejected, .source = "1", .doc = "Not there."}};
constexpr ProtocolTable kTable = {.name = "t", .framing = {.longest = 8}, .parameters = kRows};
static_assert(well_formed(kTable));

TEST(ProtocolTable, FindsRowsByIdAndNothingElse) {
  EXPECT_EQ(find(kTable.parameters, 4), &kRows[2]);
  EXPECT_EQ(find(kTable.parameters, 3), nullptr);
  EXPECT_EQ(find(kTable.parameters, 0), nullptr);
  EXPECT_EQ(find(kTable.parameters, 10), nullptr);
}

TEST(ProtocolTable, RefusesWhatTheRowDoesNotAllow) {
  const auto write = [](std::uint16_t id, std::int64_t value, std::int8_t unit = 0) {
    return check_write(find(kTable.parameters, id), value, unit);
  };
  EXPECT_EQ(write(1, 9), Refusal::kNone);
  EXPECT_EQ(write(1, 10), Refusal::kOutOfRange);
  EXPECT_EQ(write(1, 5, 99), Refusal::kNone);  // no unit codes: the unit is not looked at
  EXPECT_EQ(write(2, 1, -3), Refusal::kNone);
  EXPECT_EQ(write(2, 1, -6), Refusal::kUnit);
  EXPECT_EQ(write(4, 1), Refusal::kReadOnly);
  EXPECT_EQ(write(9, 0), Refusal::kUnknown);
  EXPECT_EQ(write(3, 0), Refusal::kUnknown);
  EXPECT_EQ(check_read(find(kTable.parameters, 7)), Refusal::kWriteOnly);
  EXPECT_EQ(check_read(find(kTable.parameters, 4)), Refusal::kNone);
  EXPECT_EQ(check_read(find(kTable.parameters, 9)), Refusal::kUnknown);
}

TEST(ProtocolTable, WellFormedRejectsWhatWouldBreakTheLookUp) {
  ParameterRow rows[] = {kRows[0], kRows[1]};
  const ProtocolTable table = {.name = "t", .framing = {.longest = 8}, .parameters = rows};
  EXPECT_TRUE(well_formed(table));
  rows[1].id = 1;
  EXPECT_FALSE(well_formed(table)) << "an id twice";
  rows[1] = kRows[1];
  rows[1].factory = {6, -3};
  EXPECT_FALSE(well_formed(table)) << "a factory value out of range";
  rows[1].factory = {2, -6};
  EXPECT_FALSE(well_formed(table)) << "a factory unit that is not listed";
  rows[1] = kRows[1];
  rows[1].source = "";
  EXPECT_FALSE(well_formed(table)) << "a row that does not say where it is from";
}

// A binding too few, too many or out of place does not compile in a device; here the check itself.
TEST(ProtocolTable, BindingsMustCoverWhatIsNotRejected) {
  constexpr std::array<Binding<int>, 4> kAll = {{{1, 0}, {2, 0}, {4, 0}, {7, 0}}};
  constexpr std::array<Binding<int>, 3> kOneMissing = {{{1, 0}, {2, 0}, {7, 0}}};
  constexpr std::array<Binding<int>, 5> kRejectedToo = {{{1, 0}, {2, 0}, {4, 0}, {7, 0}, {9, 0}}};
  static_assert(covers(kTable.parameters, kAll));
  static_assert(!covers(kTable.parameters, kOneMissing));
  static_assert(!covers(kTable.parameters, kRejectedToo));
  EXPECT_EQ(find(kAll, 9), nullptr);
  EXPECT_NE(find(kAll, 7), nullptr);
}

TEST(ProtocolDocument, HasALineForEveryRow) {
  const std::string page = document(toshiba_mcu::kTable);
  for (const CommandRow& row : toshiba_mcu::kTable.commands) {
    EXPECT_NE(page.find(std::string(row.name)), std::string::npos) << row.name;
  }
  for (const ParameterRow& row : toshiba_mcu::kTable.parameters) {
    EXPECT_NE(page.find(fmt::format("| {:02X} | {} |", row.id, row.name)), std::string::npos)
        << row.name;
  }
}

}  // namespace
}  // namespace virtdrive::protocol
