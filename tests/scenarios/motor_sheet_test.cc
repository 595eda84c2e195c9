#include "scenarios/motor_sheet.h"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <nlohmann/json.hpp>

#include "plant/motor_file.h"

namespace virtdrive {
namespace {

std::string content(const std::string& path) {
  std::ifstream stream(path);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(MotorSheet, TextTellsTheSetItsSourceAndWhatFollowsFromIt) {
  const std::string text = motor_text(find_motor("db42s03"));
  for (const char* part : {"db42s03: Nanotec DB42S03", "source: Nanotec data sheet",
                           "assumed: ", "24 V", "1.85 A          peak", "750 mOhm", "1.05 mH",
                           "5.667 mWb", "34 mNm/A", "48.09 mNm/A", "1.4 ms", "5.397 A"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

TEST(MotorSheet, JsonHoldsSiValuesUnderTheFilesKeys) {
  const auto json = nlohmann::json::parse(motor_json(find_motor("md200t")));
  EXPECT_EQ(json["name"], "md200t");
  EXPECT_EQ(json["parameters"]["pole_pairs"], 10);
  EXPECT_EQ(json["parameters"]["phase_resistance_ohm"], 0.3);
  EXPECT_EQ(json["rating"]["rated_current_as"], "dc");
  EXPECT_EQ(json["kind"], "pmsm");
  // 10 A of block current: 11.0266 A peak; 0.455946 Nm/A; friction 0.15 Nm.
  EXPECT_NEAR(json["derived"]["rated_torque_nm"].get<double>(), 4.87754, 1e-4);
}

TEST(MotorSheet, EveryMotorHasASheet) {
  for (const Motor& motor : motor_library()) {
    EXPECT_NE(motor_text(motor).find(motor.description), std::string::npos);
    EXPECT_NO_THROW(nlohmann::json::parse(motor_json(motor)));
  }
}

// To refresh: virtdrive motor --schema > data/motors/motor.schema.json
TEST(MotorSheet, TheSchemaInTheRepositoryIsThatOfTheTable) {
  EXPECT_EQ(content(VIRTDRIVE_SOURCE_DIR "/data/motors/motor.schema.json"), motor_schema());
}

// To refresh: virtdrive motor --keys
TEST(MotorSheet, TheTableInTheDocumentsIsThatOfTheProgram) {
  const std::string page = content(VIRTDRIVE_SOURCE_DIR "/docs/motors.md");
  EXPECT_NE(page.find(motor_key_table()), std::string::npos);
}

// What the schema asks for beyond single keys: required ones, groups, keys in pairs.
TEST(MotorSheet, TheSchemaSaysWhatTheReaderAsksFor) {
  const auto schema = nlohmann::json::parse(motor_schema());
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["properties"].size(), motor_keys().size());
  EXPECT_EQ(schema["properties"]["rotor_inertia_kgm2"]["exclusiveMinimum"], 0);
  EXPECT_EQ(schema["allOf"].size(), 5U) << "a set of rules for each kind";
  EXPECT_EQ(schema["allOf"][0]["then"]["allOf"].size(), 3U) << "resistance, inductance, magnets";
  EXPECT_EQ(schema["allOf"][3]["then"]["properties"]["pole_pairs"], false);
  EXPECT_EQ(schema["dependentRequired"]["d_axis_inductance_h"][0], "q_axis_inductance_h");
}

}  // namespace
}  // namespace virtdrive
