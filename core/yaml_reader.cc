#include "core/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive {

struct YamlNode {
  enum class Kind { kNothing, kPlain, kQuoted, kList, kMap };
  struct Key {
    std::string text;
    YamlPosition position;
  };

  Kind kind = Kind::kNothing;
  YamlPosition position;
  std::string text;                                 // kPlain, kQuoted
  std::vector<Key> keys;                            // kMap: one for each child
  std::vector<std::unique_ptr<YamlNode>> children;  // kList, kMap

  const YamlNode* find(std::string_view key) const {
    const auto it = std::ranges::find(keys, key, &Key::text);
    return it == keys.end() ? nullptr : children[static_cast<std::size_t>(it - keys.begin())].get();
  }
};

namespace {

// The parser quotes the character that it does not like, whatever it is.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  }
  return text;
}

using Kind = YamlNode::Kind;

[[noreturn]] void fail_at(const std::string& file, YamlPosition at, std::string_view message) {
  throw SetupError(fmt::format("{}:{}:{}: {}", file, at.line, at.column, message));
}

// As much of a text as a message bears.
std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string out(text.substr(0, kMost));
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return "'" + out + (text.size() > kMost ? "...'" : "'");
}

YamlPosition position_of(const YAML::Mark& mark) {
  return {mark.line + 1, mark.column + 1};
}

// Builds the tree from the parser's events and refuses what a strict file must not have as soon as
// it comes, so that no hostile file grows large or deep.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::string& file) : file_(file) {}

  std::unique_ptr<YamlNode> take_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (root_) fail_at(file_, position_of(mark), "a second document; expected one in a file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(mark, Kind::kNothing, {});
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail_at(file_, position_of(mark), "an alias (*name); write the value itself");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    add(mark, tag == "?" ? Kind::kPlain : Kind::kQuoted, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Kind::kList);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Kind::kMap);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != YAML::NullAnchor) {
      fail_at(file_, position_of(mark), "an anchor (&name); write the value where it is used");
    }
  }
  // The parser says "?" for an untagged plain value and "!" for one in quotes.
  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!") {
      fail_at(file_, position_of(mark), fmt::format("a tag ({}); leave it out", tag));
    }
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Kind kind) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (open_.size() >= YamlFile::kMaximumDepth) {
      fail_at(file_, position_of(mark),
              fmt::format("nested more than {} deep", YamlFile::kMaximumDepth));
    }
    open_.push_back(add(mark, kind, {}));
  }

  YamlNode* add(const YAML::Mark& mark, Kind kind, std::string text) {
    if (++nodes_ > YamlFile::kMaximumNodes) {
      fail_at(file_, position_of(mark),
              fmt::format("more than {} values", YamlFile::kMaximumNodes));
    }
    const YamlPosition at = position_of(mark);
    YamlNode* const parent = open_.empty() ? nullptr : open_.back();
    if (parent != nullptr && parent->kind == Kind::kMap &&
        parent->keys.size() == parent->children.size()) {
      add_key(*parent, at, kind, std::move(text));
      return parent;
    }
    auto node = std::make_unique<YamlNode>();
    node->kind = kind;
    // Nothing has no place of its own: the parser tells that of what comes next.
    node->position = kind == Kind::kNothing && parent != nullptr && parent->kind == Kind::kMap
                         ? parent->keys.back().position
                         : at;
    node->text = std::move(text);
    YamlNode* const added = node.get();
    if (parent != nullptr) {
      parent->children.push_back(std::move(node));
    } else {
      root_ = std::move(node);
    }
    return added;
  }

  void add_key(YamlNode& map, YamlPosition at, Kind kind, std::string text) {
    if (kind != Kind::kPlain && kind != Kind::kQuoted) {
      fail_at(file_, at, "a key must be a name");
    }
    for (const YamlNode::Key& before : map.keys) {
      if (before.text != text) continue;
      fail_at(file_, at,
              fmt::format("key {} is given twice; first on line {}", shown(text),
                          before.position.line));
    }
    map.keys.push_back({std::move(text), at});
  }

  const std::string& file_;
  std::unique_ptr<YamlNode> root_;
  std::vector<YamlNode*> open_;
  std::size_t nodes_ = 0;
};

std::unique_ptr<YamlNode> parse(const std::string& name, std::string_view text) {
  if (text.size() > YamlFile::kMaximumBytes) {
    throw SetupError(fmt::format("{}: {} bytes; at most {} are read", name, text.size(),
                                 YamlFile::kMaximumBytes));
  }
  TreeBuilder builder(name);
  std::istringstream stream{std::string(text)};
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    fail_at(name, error.mark.is_null() ? YamlPosition{} : position_of(error.mark),
            fmt::format("not YAML: {}", printable(error.msg)));
  }
  std::unique_ptr<YamlNode> root = builder.take_root();
  if (!root) fail_at(name, {}, "nothing in it");
  return root;
}

// A decimal number as JSON writes it, but for a leading point or sign that does no harm.
bool parse_number(std::string_view text, double& value) {
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  return error == std::errc{} && end == last && std::isfinite(value);
}

bool has_leading_zero(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9';
}

}  // namespace

bool NumberRange::contains(double value) const {
  return (above_minimum ? value > minimum : value >= minimum) && value <= maximum;
}

std::string NumberRange::text() const {
  std::string out;
  if (std::isfinite(minimum) && std::isfinite(maximum)) {
    out = above_minimum ? fmt::format("above {} up to {}", minimum, maximum)
                        : fmt::format("{} ... {}", minimum, maximum);
  } else if (std::isfinite(minimum)) {
    out = above_minimum ? fmt::format("above {}", minimum) : fmt::format("{} or more", minimum);
  } else if (std::isfinite(maximum)) {
    out = fmt::format("{} or less", maximum);
  }
  if (!out.empty() && !unit.empty()) out += fmt::format(" {}", unit);
  return out;
}

YamlPosition YamlValue::position() const {
  return node_->position;
}

void YamlValue::fail(std::string_view message) const {
  fail_at(*file_, node_->position, message);
}

void YamlValue::expected(std::string_view what) const {
  const std::string name = name_.empty() ? "" : fmt::format("{}: ", name_);
  switch (node_->kind) {
    case Kind::kNothing:
      fail(fmt::format("{}expected {}, found nothing", name, what));
    case Kind::kPlain:
      fail(fmt::format("{}expected {}, not {}", name, what, shown(node_->text)));
    case Kind::kQuoted:
      fail(fmt::format("{}expected {}, not text in quotes", name, what));
    case Kind::kList:
      fail(fmt::format("{}expected {}, not a list", name, what));
    case Kind::kMap:
      fail(fmt::format("{}expected {}, not a mapping", name, what));
  }
  VIRTDRIVE_CHECK(false, "{}", static_cast<int>(node_->kind));
}

YamlKind YamlValue::kind() const {
  switch (node_->kind) {
    case Kind::kNothing:
      return YamlKind::kNothing;
    case Kind::kList:
      return YamlKind::kList;
    case Kind::kMap:
      return YamlKind::kMap;
    default:
      return YamlKind::kText;
  }
}

bool YamlValue::quoted() const {
  return node_->kind == Kind::kQuoted;
}

bool YamlValue::is_number() const {
  double value = 0;
  return node_->kind == Kind::kPlain && parse_number(node_->text, value);
}

double YamlValue::number(const NumberRange& range) const {
  const std::string bounds = range.text();
  double value = 0;
  if (node_->kind != Kind::kPlain || !parse_number(node_->text, value)) {
    expected(bounds.empty() ? "a number" : fmt::format("a number, {}", bounds));
  }
  if (has_leading_zero(node_->text)) {
    fail(fmt::format("{}: {} has a leading zero, which YAML takes for octal; leave it out", name_,
                     shown(node_->text)));
  }
  if (!range.contains(value))
    fail(fmt::format("{} is {}; expected {}", name_, node_->text, bounds));
  return value;
}

std::int64_t YamlValue::integer(const NumberRange& range) const {
  constexpr double kExact = 9007199254740992.0;  // 2^53
  const double value = number(range);
  if (value != std::floor(value) || std::abs(value) > kExact) expected("a whole number");
  return static_cast<std::int64_t>(value);
}

std::string YamlValue::text(std::size_t most) const {
  if (node_->kind != Kind::kPlain && node_->kind != Kind::kQuoted) expected("text");
  if (node_->text.empty()) expected("text");
  if (node_->text.size() > most) {
    fail(fmt::format("{}: {} bytes; at most {}", name_, node_->text.size(), most));
  }
  return node_->text;
}

bool YamlValue::flag() const {
  return word({"false", "true"}) == 1;
}

std::size_t YamlValue::word(const std::vector<std::string_view>& words) const {
  const auto it = node_->kind == Kind::kPlain ? std::ranges::find(words, node_->text) : words.end();
  if (it != words.end()) return static_cast<std::size_t>(it - words.begin());
  if (node_->kind == Kind::kPlain) fail(unknown_name(name_, node_->text, words));
  expected(fmt::format("one of {}", fmt::join(words, ", ")));
}

std::vector<YamlValue> YamlValue::list(std::size_t least, std::size_t most) const {
  if (node_->kind != Kind::kList) expected("a list");
  const std::size_t size = node_->children.size();
  if (size < least || size > most) {
    const std::string wanted = least == most ? fmt::format("{}", least)
                               : most == std::numeric_limits<std::size_t>::max()
                                   ? fmt::format("{} or more", least)
                                   : fmt::format("{} ... {}", least, most);
    fail(fmt::format("{}: {} values; expected {}", name_, size, wanted));
  }
  std::vector<YamlValue> values;
  for (const auto& child : node_->children) values.emplace_back(*file_, name_, *child);
  return values;
}

YamlMap YamlValue::map() const {
  if (node_->kind != Kind::kMap) expected("keys with values (key: value)");
  return {*this, *node_, *file_};
}

YamlMap YamlValue::map(const std::vector<std::string_view>& known) const {
  const YamlMap map = this->map();
  for (const YamlNode::Key& key : node_->keys) {
    if (std::ranges::find(known, key.text) != known.end()) continue;
    const std::string_view near = nearest_key(key.text, known);
    fail_at(*file_, key.position,
            near.empty() ? fmt::format("unknown key {}", shown(key.text))
                         : fmt::format("unknown key {}; did you mean {}? (units are part of the "
                                       "name)",
                                       shown(key.text), near));
  }
  return map;
}

bool YamlMap::has(std::string_view key) const {
  return node_->find(key) != nullptr;
}

YamlValue YamlMap::operator[](std::string_view key) const {
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    if (node_->keys[i].text == key) return {*file_, node_->keys[i].text, *node_->children[i]};
  }
  self_.fail(fmt::format("{} is missing", key));
}

std::vector<std::string_view> YamlMap::keys() const {
  std::vector<std::string_view> keys;
  for (const YamlNode::Key& key : node_->keys) keys.emplace_back(key.text);
  return keys;
}

void YamlMap::fail_at_key(std::string_view key, std::string_view message) const {
  for (const YamlNode::Key& candidate : node_->keys) {
    if (candidate.text == key) fail_at(*file_, candidate.position, message);
  }
  self_.fail(message);
}

YamlFile::YamlFile(std::string name, std::string_view text)
    : name_(std::make_unique<const std::string>(std::move(name))), root_(parse(*name_, text)) {}

YamlFile YamlFile::read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw SetupError(fmt::format("{}: cannot be read", path));
  // One byte more than the limit tells that there is more; a file without end is not read to it.
  std::string text(kMaximumBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw SetupError(fmt::format("{}: cannot be read", path));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return {path, text};
}

YamlFile::YamlFile(YamlFile&&) noexcept = default;
YamlFile& YamlFile::operator=(YamlFile&&) noexcept = default;
YamlFile::~YamlFile() = default;

YamlValue YamlFile::root() const {
  return {*name_, {}, *root_};
}

std::string_view nearest_key(std::string_view key, const std::vector<std::string_view>& known) {
  const auto stem = [](std::string_view name) { return name.substr(0, name.rfind('_')); };
  for (const std::string_view candidate : known) {
    if (stem(candidate) == key || stem(candidate) == stem(key)) return candidate;
  }
  std::string_view best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(key, candidate);
    if (distance <= std::max<std::size_t>(2, candidate.size() / 3) && distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace virtdrive
