#include "devices/asd7/walk.h"

#include <gtest/gtest.h>

#include "devices/asd7/size_table.h"
#include "tests/devices/asd7/line_rig.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

TEST(Asd7Walk, ADriveAnswersEveryRowAsTheTableSays) {
  LineRig rig({.reply_time = 1ms, .write_time = 2ms}, "4");
  const SizeTable size(kTable, factory_parameters(rig.model));
  const WalkDialect dialect(size.table());
  const protocol::WalkReport report =
      walk(dialect, rig, {.patience = 3s, .silence = 15ms, .pause = 4ms, .most_failures = 50});
  EXPECT_EQ(report.failures(), 0U) << text(report);
  EXPECT_GT(report.checks.size(), 2500U);
  EXPECT_EQ(report.skipped,
            (std::vector<std::string>{"parameter 07 tYP", "parameter 806 F806",
                                      "parameter FA00 command", "parameter FA04 command_rs485"}));
  EXPECT_FALSE(rig.drive.tripped());
}

TEST(Asd7Walk, NumbersThatNoRowHasAreUnknownAllOverTheRange) {
  LineRig rig;
  Registers& registers = rig.station.registers();
  std::size_t known = 0;
  for (unsigned number = 0; number <= 0xFFFF; ++number) {
    const auto id = static_cast<std::uint16_t>(number);
    const ParameterRow* row = protocol::find(kTable.parameters, id);
    const bool there = row != nullptr && row->support != Support::kRejected;
    known += there;
    ASSERT_EQ(registers.read(id).error, there ? std::nullopt : std::optional(Error::kNumber));
    if (there) continue;
    ASSERT_EQ(registers.write(id, 0, Keep::kRam).error, Error::kNumber);
  }
  EXPECT_GT(known, 180U);
}

TEST(Asd7Walk, EverySizesFactoryValuesAreInTheirRanges) {
  for (const Model& model : models()) {
    const SizeTable size(kTable, factory_parameters(model));
    EXPECT_TRUE(well_formed(size.table())) << model.name;
  }
  const SizeTable smallest(kTable, factory_parameters(models().front()));
  for (std::size_t i = 0; i < std::size(kParameters); ++i) {
    EXPECT_EQ(smallest.table().parameters[i].factory.value, kParameters[i].factory.value)
        << kParameters[i].name;
  }
}

}  // namespace
}  // namespace virtdrive::asd7
