#include "core/yaml_reader.h"

#include <cstdio>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive {
namespace {

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const SetupError& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of(std::string_view text) {
  return error_of([text] { const YamlFile file("f.yaml", text); });
}

TEST(YamlReader, ReadsNumbersTextsWordsFlagsAndLists) {
  const YamlFile file("f.yaml",
                      "speed: -1.5e3\ncount: 10\nname: a motor  # with a remark\nquoted: \"010\"\n"
                      "on: true\nmode: fast\npoints: [[0, 1], [2, 3.5]]\n");
  const YamlMap map = file.root().map({"speed", "count", "name", "quoted", "on", "mode", "points"});
  EXPECT_EQ(map["speed"].number(), -1500);
  EXPECT_EQ(map["count"].integer({.minimum = 1, .maximum = 10}), 10);
  EXPECT_EQ(map["name"].text(), "a motor");
  EXPECT_EQ(map["quoted"].text(), "010");
  EXPECT_TRUE(map["on"].flag());
  EXPECT_EQ(map["mode"].word({"slow", "fast"}), 1U);
  const auto points = map["points"].list(2, 2);
  EXPECT_EQ(points[1].list()[1].number(), 3.5);
  EXPECT_EQ(map.keys().front(), "speed");
  EXPECT_FALSE(map.has("missing"));
}

TEST(YamlReader, TellsTheFileTheLineAndTheColumnFromOne) {
  const YamlFile file("dir/f.yaml", "a: 1\nb:\n  - 2\n  - no number\n");
  const YamlMap map = file.root().map({"a", "b"});
  EXPECT_EQ(error_of([&] { map["b"].list()[1].number({.minimum = 0, .unit = "V"}); }),
            "dir/f.yaml:4:5: b: expected a number, 0 or more V, not 'no number'");
  EXPECT_EQ(error_of([&] { static_cast<void>(map["c"]); }), "dir/f.yaml:1:1: c is missing");
  EXPECT_EQ(error_of([&] { map["a"].list(); }), "dir/f.yaml:1:4: a: expected a list, not '1'");
  EXPECT_EQ(error_of([&] { map["b"].list(3, 3); }), "dir/f.yaml:3:3: b: 2 values; expected 3");
  EXPECT_EQ(error_of([&] { map["b"].list(3); }), "dir/f.yaml:3:3: b: 2 values; expected 3 or more");
  EXPECT_EQ(error_of([&] { map["a"].flag(); }),
            "dir/f.yaml:1:4: unknown a '1' (known: false, true)");
}

TEST(YamlReader, RangesSayWhetherTheirEndsBelongToThem) {
  EXPECT_TRUE((NumberRange{.minimum = 0}.contains(0)));
  EXPECT_FALSE((NumberRange{.minimum = 0, .above_minimum = true}.contains(0)));
  EXPECT_FALSE((NumberRange{.maximum = 5}.contains(5.1)));
  EXPECT_EQ((NumberRange{.minimum = 0, .maximum = 1e6, .unit = "Ohm"}.text()), "0 ... 1000000 Ohm");
  EXPECT_EQ((NumberRange{.minimum = 0, .above_minimum = true, .unit = "H"}.text()), "above 0 H");
  EXPECT_EQ((NumberRange{.maximum = 3}.text()), "3 or less");
  EXPECT_EQ(NumberRange{}.text(), "");
}

TEST(YamlReader, AKeyInAnotherUnitOrWithoutOneIsNear) {
  const std::vector<std::string_view> known = {"phase_resistance_ohm", "pole_pairs",
                                               "inertia_kgm2"};
  EXPECT_EQ(nearest_key("phase_resistance_mohm", known), "phase_resistance_ohm");
  EXPECT_EQ(nearest_key("phase_resistance", known), "phase_resistance_ohm");
  EXPECT_EQ(nearest_key("inertia_gcm2", known), "inertia_kgm2");
  EXPECT_EQ(nearest_key("polepairs", known), "pole_pairs");
  EXPECT_EQ(nearest_key("colour", known), "");
}

TEST(YamlReader, RefusesWhatYamlLibrariesLetThrough) {
  EXPECT_EQ(error_of("a: 1\nb: 2\na: 3\n"), "f.yaml:3:1: key 'a' is given twice; first on line 1");
  EXPECT_EQ(error_of("a: {b: 1, b: 2}\n"), "f.yaml:1:11: key 'b' is given twice; first on line 1");
  EXPECT_EQ(error_of("a: &x [1]\nb: *x\n"),
            "f.yaml:1:4: an anchor (&name); write the value where it is used");
  EXPECT_EQ(error_of("a: 1\n---\nb: 2\n"), "f.yaml:2:1: a second document; expected one in a file");
  EXPECT_EQ(error_of("? [a, b]\n: 1\n"), "f.yaml:1:3: a key must be a name");
  EXPECT_NE(error_of("a: !!int 3\n").find("f.yaml:1:4: a tag"), std::string::npos);
}

// The laughing bomb: nine anchors of nine aliases each.
TEST(YamlReader, IsNotBlownUpByAliasesDepthOrSize) {
  std::string bomb = "a: &a [x]\n";
  for (char c = 'b'; c < 'j'; ++c) {
    bomb += std::string(1, c) + ": &" + c + " [*" + static_cast<char>(c - 1) + "]\n";
  }
  EXPECT_NE(error_of(bomb).find("f.yaml:1:4: an anchor"), std::string::npos);
  EXPECT_NE(error_of(std::string(10'000, '[') + std::string(10'000, ']'))
                .find("f.yaml:1:17: nested more than 16 deep"),
            std::string::npos);
  EXPECT_NE(
      error_of("a: [" + std::string(YamlFile::kMaximumBytes, ' ') + "]").find("at most 1048576"),
      std::string::npos);
  std::string many = "[";
  for (std::size_t i = 0; i < YamlFile::kMaximumNodes; ++i) many += "1,";
  EXPECT_NE(error_of(many + "1]").find("more than 200000 values"), std::string::npos);
}

TEST(YamlReader, NumbersAreWhatJsonCallsNumbers) {
  const auto read = [](const char* text) {
    return error_of([text] {
      const YamlFile file("f.yaml", std::string("x: ") + text);
      file.root().map({"x"})["x"].number();
    });
  };
  for (const char* good : {"0", "-0.5", "1e-9", "1E6", "12.", "0.0"}) {
    EXPECT_EQ(read(good), "no error") << good;
  }
  for (const char* bad : {"010", "-01", "0x1F", "0o17", "1_000", "1,5", "+1", ".inf", "inf", "nan",
                          "~", "1e999", "12 V", "'3'", "true", "1:30"}) {
    EXPECT_NE(read(bad), "no error") << bad;
  }
}

TEST(YamlReader, AMessageShowsNoControlCharactersAndNotTheWholeFile) {
  const std::string error = error_of([] {
    const YamlFile file("f.yaml", "\"" + std::string(500, 'k') + "\": 1\n\"a\\x1b[31m\": 2\n");
    file.root().map({"x"});
  });
  EXPECT_LT(error.size(), 120U);
  const std::string colored = error_of([] {
    const YamlFile file("f.yaml", "\"a\\x1b[31m\": 2\n");
    file.root().map({"x"});
  });
  EXPECT_EQ(colored.find('\x1b'), std::string::npos) << colored;
}

TEST(YamlReader, AFileThatCannotBeReadIsNamed) {
  EXPECT_EQ(error_of([] { YamlFile::read("/no/such/file.yaml"); }),
            "/no/such/file.yaml: cannot be read");
  EXPECT_NE(error_of([] { YamlFile::read("/"); }), "no error");
  const std::string endless = error_of([] { YamlFile::read("/dev/zero"); });
  EXPECT_NE(endless.find("/dev/zero: "), std::string::npos) << endless;
}

}  // namespace
}  // namespace virtdrive
