// YAML files that people write by hand, read strictly: what is not understood is refused with its
// place, never guessed.
//
//   const YamlFile file = YamlFile::read("my_motor.yaml");
//   const YamlMap motor = file.root().map({"name", "phase_resistance_ohm"});
//   const double r = motor["phase_resistance_ohm"].number({.minimum = 0, .unit = "Ohm"});
//
// Each error is a SetupError "FILE:LINE:COLUMN: what is wrong, what was expected". Refused beyond
// what YAML forbids: keys given twice, keys that nobody knows (with the nearest one that is known),
// anchors and aliases, tags, several documents in a file, numbers in quotes or with leading zeros
// (YAML 1.1 reads 010 as 8), and files beyond the limits below.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

/// Counted from 1.
struct YamlPosition {
  int line = 1;
  int column = 1;
};

struct YamlNode;  // of the tree that YamlFile owns

enum class YamlKind : std::uint8_t { kNothing, kText, kList, kMap };

struct NumberRange {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool above_minimum = false;  // the minimum itself is out of range
  std::string_view unit;       // for messages

  bool contains(double value) const;
  /// "above 0 up to 1e6 Ohm".
  std::string text() const;
};

class YamlMap;

/// A value with its place. Valid as long as its YamlFile.
class YamlValue {
 public:
  YamlValue(const std::string& file, std::string_view name, const YamlNode& node)
      : file_(&file), name_(name), node_(&node) {}

  /// The key it stands behind; "" for the root and the items of a list.
  std::string_view name() const { return name_; }
  YamlPosition position() const;
  /// Refuses it: throws SetupError "FILE:LINE:COLUMN: message".
  [[noreturn]] void fail(std::string_view message) const;

  YamlKind kind() const;
  /// A text in quotes; its position is that of the first quote.
  bool quoted() const;
  bool is_number() const;
  /// A finite decimal number in range.
  double number(const NumberRange& range = {}) const;
  /// A whole number in range, at most 2^53 in size.
  std::int64_t integer(const NumberRange& range = {}) const;
  /// Text of 1 to `most` bytes, in quotes or not.
  std::string text(std::size_t most = 1000) const;
  /// true or false.
  bool flag() const;
  /// The index of the word among those expected.
  std::size_t word(const std::vector<std::string_view>& expected) const;

  /// A list of `least` to `most` values.
  std::vector<YamlValue> list(std::size_t least = 0,
                              std::size_t most = std::numeric_limits<std::size_t>::max()) const;
  /// A mapping with no other keys than these.
  YamlMap map(const std::vector<std::string_view>& known) const;
  /// A mapping whose keys the caller judges.
  YamlMap map() const;

 private:
  [[noreturn]] void expected(std::string_view what) const;

  const std::string* file_;
  std::string_view name_;
  const YamlNode* node_;
};

class YamlMap {
 public:
  YamlMap(YamlValue self, const YamlNode& node, const std::string& file)
      : self_(self), node_(&node), file_(&file) {}

  bool has(std::string_view key) const;
  /// Fails, at the mapping's place, if the key is missing.
  YamlValue operator[](std::string_view key) const;
  /// The keys in the order of the file.
  std::vector<std::string_view> keys() const;
  /// Refuses a key, at its own place.
  [[noreturn]] void fail_at_key(std::string_view key, std::string_view message) const;
  const YamlValue& self() const { return self_; }

 private:
  YamlValue self_;
  const YamlNode* node_;
  const std::string* file_;
};

class YamlFile {
 public:
  static constexpr std::size_t kMaximumBytes = 1 << 20;
  static constexpr int kMaximumDepth = 16;
  static constexpr std::size_t kMaximumNodes = 200'000;

  /// Parses `text`; `name` is what messages call it.
  YamlFile(std::string name, std::string_view text);
  /// Reads a file; SetupError if it cannot be read.
  static YamlFile read(const std::string& path);
  YamlFile(YamlFile&&) noexcept;
  YamlFile& operator=(YamlFile&&) noexcept;
  ~YamlFile();

  YamlValue root() const;
  const std::string& name() const { return *name_; }

 private:
  std::unique_ptr<const std::string> name_;  // values point to it
  std::unique_ptr<YamlNode> root_;
};

/// The known key that a mistyped one was meant to be, "" if none is near. A key with another unit
/// ("resistance_mohm" for "resistance_ohm") or without one counts as near.
std::string_view nearest_key(std::string_view key, const std::vector<std::string_view>& known);

}  // namespace virtdrive
