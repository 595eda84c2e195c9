#include "devices/protocol/walk.h"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <utility>

namespace virtdrive::protocol {
namespace {

using Kind = Answer::Kind;

constexpr std::size_t kMostDrained = 4096;  // of a drive that does not stop talking
constexpr int kBackToBack = 3;
constexpr Setting kWords{0x64636261, 0};  // "abcd", to be written into a text

std::string hex(std::span<const std::uint8_t> bytes) {
  return bytes.empty() ? "nothing" : fmt::format("{:02x}", fmt::join(bytes, " "));
}

std::string name_of(const CommandRow& row) {
  return fmt::format("command {:02X} {}", row.code, row.name);
}
std::string name_of(const ParameterRow& row) {
  return fmt::format("parameter {:02X} {}", row.id, row.name);
}

std::string name_of(const Answer& answer) {
  switch (answer.kind) {
    case Kind::kSilence:
      return "silence";
    case Kind::kValues:
      return "an answer";
    case Kind::kRefused:
      return fmt::format("refusal {}", answer.code);
    case Kind::kDamaged:
      break;
  }
  return "no answer to this";
}

std::string_view name_of(Damage damage) {
  constexpr std::string_view kNames[] = {"a wrong checksum", "a wrong end", "a byte too many",
                                         "a byte too few"};
  return kNames[static_cast<std::size_t>(damage)];
}

bool same(const Answer& a, const Answer& b) {
  return a.kind == b.kind && (a.kind != Kind::kRefused || a.code == b.code);
}

// What the wire can carry.
Range limits(WireType type) {
  const std::size_t bits = 8 * width(type);
  const std::int64_t span = std::int64_t{1} << bits;
  return is_signed(type) ? Range{-span / 2, span / 2 - 1} : Range{0, span - 1};
}

bool is_number(const ParameterRow& row) {
  return row.type != WireType::kText && row.fields.empty() && row.count == 1;
}

std::vector<std::int8_t> listed_units(const ParameterRow& row) {
  std::vector<std::int8_t> codes;
  for (const UnitCode& unit : row.units) codes.push_back(unit.code);
  if (codes.empty()) codes.push_back(row.factory.unit);
  return codes;
}

// The extremes, and the neighbours of those that are listed.
std::set<std::int8_t> unlisted_units(const ParameterRow& row) {
  std::set<std::int8_t> codes = {std::numeric_limits<std::int8_t>::min(),
                                 std::numeric_limits<std::int8_t>::max()};
  for (const UnitCode& unit : row.units) {
    codes.insert(static_cast<std::int8_t>(unit.code - 1));
    codes.insert(static_cast<std::int8_t>(unit.code + 1));
  }
  std::erase_if(codes, [&](std::int8_t code) { return has_unit(row, code); });
  return codes;
}

Bytes joined(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

class Walk {
 public:
  Walk(const Dialect& dialect, HostTransport& transport, const WalkOptions& options)
      : dialect_(dialect), table_(dialect.table()), transport_(transport), options_(options) {}

  WalkReport run();

 private:
  struct Heard {
    Answer answer;
    Bytes bytes;
  };

  struct Reading {
    std::optional<Setting> setting;
    std::string exchange;  // for the report
  };

  // --- Rows ---
  void commands(Effect effect);
  void command_row(const CommandRow& row, const Values& values);
  void good_requests(const CommandRow& row, const Bytes& request, const Answer& expected);
  void spoilt_requests(const std::string& row, const Bytes& request);
  void unknown_commands();

  void parameters(Effect effect);
  void parameter_row(const ParameterRow& row);
  bool may_write(const ParameterRow& row) const;
  void is_read(const ParameterRow& row, const std::string& when);
  void readable(const ParameterRow& row);
  void writable(const ParameterRow& row);
  void numbers(const ParameterRow& row, std::optional<Setting> before);
  void no_such_parameter(const ParameterRow& row, const std::string& name, std::uint8_t channel,
                         const std::string& where);
  void unknown_parameters();

  // --- Steps ---
  void accept(const ParameterRow& row, Setting setting, const std::string& what);
  void refuse(const ParameterRow& row, Setting setting, Refusal refusal,
              std::optional<Setting> before, const std::string& what);
  void reads_back(const ParameterRow& row, Setting expected, const std::string& what);
  Reading read(const ParameterRow& row);
  void listens(const std::string& row, const std::string& after);
  void expect(const std::string& row, const std::string& what, const Bytes& request,
              const Answer& expected);
  void judge(const std::string& row, const std::string& what, const Bytes& request,
             const Answer& expected, const Heard& heard);
  void note(const std::string& row, const std::string& what, bool passed, std::string detail);

  // --- Bytes ---
  Heard ask(const Bytes& request, const Answer& expected);
  Heard listen(const Bytes& request, SimDuration patience);
  bool drain(Bytes& heard);
  void send_all(const std::vector<Bytes>& requests);
  void resynchronise();
  SimDuration patience_for(const Answer& expected) const {
    return expected.kind == Kind::kSilence ? options_.silence : options_.patience;
  }

  const Dialect& dialect_;
  const ProtocolTable& table_;
  HostTransport& transport_;
  const WalkOptions options_;
  WalkReport report_;
  std::string_view source_;  // of the row that is walked
  std::size_t failures_ = 0;
};

constexpr Answer kAnswered{.kind = Kind::kValues};
constexpr Answer kSilent{.kind = Kind::kSilence};

WalkReport Walk::run() {
  resynchronise();
  listens("drive", "the start");
  if (options_.allow == Allow::kMoves) {
    commands(Effect::kNone);
    unknown_commands();
  } else {
    spoilt_requests("drive", dialect_.probe());
    for (const CommandRow& row : table_.commands) report_.skipped.push_back(name_of(row));
  }
  parameters(Effect::kNone);
  unknown_parameters();
  parameters(Effect::kLast);
  if (options_.allow == Allow::kMoves) commands(Effect::kLast);
  listens("drive", "the walk");
  return std::move(report_);
}

// --- Commands ------------------------------------------------------------------------------------

void Walk::commands(Effect effect) {
  for (const CommandRow& row : table_.commands) {
    if (report_.given_up) return;
    const Effect its = dialect_.effect(row);
    const auto values = dialect_.sample(row, options_.channel);
    const bool skip = its == Effect::kSkip || !values;
    if (skip && effect == Effect::kNone) report_.skipped.push_back(name_of(row));
    if (!skip && its == effect) command_row(row, *values);
  }
}

void Walk::command_row(const CommandRow& row, const Values& values) {
  source_ = row.source;
  const Answer refused = dialect_.refusal(Refusal::kUnknown);
  const Answer expected = row.support == Support::kRejected ? refused
                          : row.replies                     ? kAnswered
                                                            : kSilent;
  good_requests(row, dialect_.command(row, values), expected);
  spoilt_requests(name_of(row), dialect_.command(row, values));
  if (!dialect_.names_channel(row)) return;
  for (const std::uint8_t channel : dialect_.unknown_channels()) {
    if (const auto there = dialect_.sample(row, channel)) {
      expect(name_of(row), fmt::format("is refused on channel {}", channel),
             dialect_.command(row, *there), refused);
    }
  }
}

void Walk::good_requests(const CommandRow& row, const Bytes& request, const Answer& expected) {
  const std::string name = name_of(row);
  const auto between = [&](auto&& step) {
    if (report_.given_up) return;
    send_all(dialect_.before(row, options_.channel));
    step();
    send_all(dialect_.after(row, options_.channel));
  };
  const std::string verb = row.support == Support::kRejected ? "is refused" : "is answered";

  between([&] { expect(name, verb, request, expected); });
  between([&] {
    transport_.write(joined(dialect_.noise(), request));
    judge(name, verb + " behind noise", request, expected, listen(request, patience_for(expected)));
  });
  between([&] {
    transport_.write(joined(request, dialect_.noise()));
    judge(name, verb + " before noise", request, expected, listen(request, patience_for(expected)));
    listens(name, "noise behind it");
  });
  for (std::size_t cut = 1; cut < request.size(); ++cut) {
    between([&] {
      transport_.write(std::span(request).first(cut));
      Bytes early;
      if (const auto byte = transport_.read(options_.pause)) early.push_back(*byte);
      note(name, fmt::format("nothing is said to its first {} bytes", cut), early.empty(),
           fmt::format("sent {}, heard {}", hex(std::span(request).first(cut)), hex(early)));
      transport_.write(std::span(request).subspan(cut));
      judge(name, fmt::format("{} with a pause after {} bytes", verb, cut), request, expected,
            listen(request, patience_for(expected)));
    });
  }
  if (report_.given_up || dialect_.effect(row) != Effect::kNone || !row.replies) return;
  for (int i = 1; i <= kBackToBack; ++i) {
    // The next request leaves with the last byte of the answer.
    transport_.write(request);
    judge(name, fmt::format("{} back to back, {} of {}", verb, i, kBackToBack), request, expected,
          listen(request, options_.patience));
  }
  Bytes more;
  note(name, "is answered once each", !drain(more), fmt::format("then heard {}", hex(more)));
}

void Walk::spoilt_requests(const std::string& row, const Bytes& request) {
  for (std::size_t cut = 1; cut < request.size(); ++cut) {
    expect(row, fmt::format("cut after {} bytes gets no answer", cut),
           Bytes(request.begin(), request.begin() + cut), kSilent);
    resynchronise();
    listens(row, fmt::format("a cut after {} bytes", cut));
  }
  for (const Damage damage :
       {Damage::kChecksum, Damage::kEnd, Damage::kByteTooMany, Damage::kByteTooFew}) {
    const auto spoilt = dialect_.spoil(request, damage);
    if (!spoilt) continue;
    const Answer reaction = dialect_.reaction(damage);
    expect(row, fmt::format("with {} gets {}", name_of(damage), name_of(reaction)), *spoilt,
           reaction);
    if (reaction.kind == Kind::kSilence) resynchronise();
    listens(row, std::string(name_of(damage)));
  }
}

void Walk::unknown_commands() {
  source_ = {};
  for (unsigned code = 0; code <= dialect_.highest_command(); ++code) {
    const CommandRow row{.code = static_cast<std::uint16_t>(code), .name = "(unknown)"};
    if (find(table_.commands, row.code) != nullptr) continue;
    const Answer expected = dialect_.to_unknown_command();
    expect(name_of(row), "gets " + name_of(expected), dialect_.command(row, {}), expected);
    listens(name_of(row), "it");
  }
}

// --- Parameters ----------------------------------------------------------------------------------

void Walk::parameters(Effect effect) {
  for (const ParameterRow& row : table_.parameters) {
    if (report_.given_up) return;
    const Effect its = dialect_.effect(row);
    if (its == Effect::kSkip && effect == Effect::kNone) report_.skipped.push_back(name_of(row));
    if (its == effect) parameter_row(row);
  }
}

void Walk::parameter_row(const ParameterRow& row) {
  source_ = row.source;
  const std::string name = name_of(row);
  for (const std::uint8_t channel : dialect_.unknown_channels()) {
    no_such_parameter(row, name, channel, fmt::format(" on channel {}", channel));
  }
  if (row.support == Support::kRejected) {
    no_such_parameter(row, name, options_.channel, "");
    return;
  }
  if (!may_write(row)) {
    if (row.access == Access::kWriteOnly)
      report_.skipped.push_back(name);
    else
      is_read(row, "");
    return;
  }
  std::vector<std::pair<const ParameterRow*, Setting>> found;
  for (const auto& [id, setting] : dialect_.needs(row)) {
    const ParameterRow* needed = find(table_.parameters, id);
    const auto before = needed == nullptr ? std::nullopt : read(*needed).setting;
    if (!before) continue;
    found.emplace_back(needed, *before);
    send_all({dialect_.write(*needed, options_.channel, setting)});
  }
  if (row.access == Access::kReadOnly)
    readable(row);
  else
    writable(row);
  for (const auto& [needed, before] : found) {
    send_all({dialect_.write(*needed, options_.channel, before)});
  }
}

bool Walk::may_write(const ParameterRow& row) const {
  if (options_.allow == Allow::kReads) return false;
  return options_.allow == Allow::kMoves || !dialect_.moves(row);
}

void Walk::is_read(const ParameterRow& row, const std::string& when) {
  if (!is_number(row)) {
    expect(name_of(row), "is read" + when, dialect_.read(row, options_.channel), kAnswered);
    return;
  }
  const Reading got = read(row);
  note(name_of(row), "is read within its range" + when,
       got.setting && row.range.contains(got.setting->value),
       fmt::format("{}, which is not in {} ... {}", got.exchange, row.range.minimum,
                   row.range.maximum));
}

// Twice: a write between them must not change more than time does.
void Walk::readable(const ParameterRow& row) {
  is_read(row, " at first");
  expect(name_of(row), "is read-only", dialect_.write(row, options_.channel, {1, row.factory.unit}),
         dialect_.refusal(Refusal::kReadOnly));
  is_read(row, " after a write");
}

void Walk::writable(const ParameterRow& row) {
  const std::string name = name_of(row);
  std::optional<Setting> before;
  if (row.access == Access::kWriteOnly) {
    expect(name, "is write-only", dialect_.read(row, options_.channel),
           dialect_.refusal(Refusal::kWriteOnly));
  } else {
    const Reading got = read(row);
    note(name, "is read", got.setting.has_value(), got.exchange);
    if (!got.setting) return;
    before = got.setting;
  }
  if (row.type == WireType::kText) {
    accept(row, kWords, "text");
  } else if (is_number(row)) {
    const Setting factory{row.factory.value, row.factory.unit};
    if (options_.at_factory && before) {
      note(name, "has its factory setting", *before == factory,
           fmt::format("{} unit {} instead of {} unit {}", before->value, before->unit,
                       factory.value, factory.unit));
    }
    numbers(row, before);
  }
  if (!before && !is_number(row)) return;
  const Setting last = before.value_or(Setting{row.factory.value, row.factory.unit});
  if (report_.given_up)
    send_all({dialect_.write(row, options_.channel, last)});
  else
    accept(row, last, "as it was");
}

void Walk::numbers(const ParameterRow& row, std::optional<Setting> before) {
  const Range range = dialect_.range(row);
  const Range wire = limits(row.type);
  const bool readable = before.has_value();
  for (const std::int8_t unit : listed_units(row)) {
    const auto at = [&](std::int64_t value) { return Setting{value, unit}; };
    const auto kept = [&](std::int64_t value) {
      return readable ? std::optional(at(value)) : std::nullopt;
    };
    accept(row, at(row.factory.value), "factory value");
    accept(row, at(range.minimum), "minimum");
    if (range.minimum > wire.minimum) {
      refuse(row, at(range.minimum - 1), Refusal::kOutOfRange, kept(range.minimum),
             "below its minimum");
    }
    accept(row, at(range.maximum), "maximum");
    if (range.maximum < wire.maximum) {
      refuse(row, at(range.maximum + 1), Refusal::kOutOfRange, kept(range.maximum),
             "above its maximum");
    }
  }
  const Setting last{range.maximum, listed_units(row).back()};
  for (const std::int8_t unit : unlisted_units(row)) {
    refuse(row, {row.factory.value, unit}, Refusal::kUnit,
           readable ? std::optional(last) : std::nullopt, "an unlisted unit");
  }
}

void Walk::no_such_parameter(const ParameterRow& row, const std::string& name, std::uint8_t channel,
                             const std::string& where) {
  const Answer refused = dialect_.refusal(Refusal::kUnknown);
  const Setting factory{row.factory.value, row.factory.unit};
  expect(name, "is refused to be read" + where, dialect_.read(row, channel), refused);
  if (options_.allow == Allow::kReads) return;
  expect(name, "is refused to be written" + where, dialect_.write(row, channel, factory), refused);
}

void Walk::unknown_parameters() {
  source_ = {};
  for (unsigned id = 0; id <= dialect_.highest_id(); ++id) {
    const ParameterRow row{.id = static_cast<std::uint16_t>(id), .name = "(unknown)"};
    if (find(table_.parameters, row.id) != nullptr) continue;
    no_such_parameter(row, name_of(row), options_.channel, "");
  }
}

// --- Steps ---------------------------------------------------------------------------------------

void Walk::accept(const ParameterRow& row, Setting setting, const std::string& what) {
  const std::string value = fmt::format("{}, {} unit {}", what, setting.value, setting.unit);
  expect(name_of(row), "takes " + value, dialect_.write(row, options_.channel, setting),
         dialect_.written());
  if (row.access == Access::kReadWrite) reads_back(row, setting, "reads back " + value);
}

void Walk::refuse(const ParameterRow& row, Setting setting, Refusal refusal,
                  std::optional<Setting> before, const std::string& what) {
  const std::string value = fmt::format("{}, {} unit {}", what, setting.value, setting.unit);
  expect(name_of(row), "refuses " + value, dialect_.write(row, options_.channel, setting),
         dialect_.refusal(refusal));
  if (!before) return;
  const auto settled =
      refusal == Refusal::kOutOfRange ? dialect_.settles(row, setting) : std::nullopt;
  if (settled)
    reads_back(row, *settled, "keeps to its range at " + value);
  else
    reads_back(row, *before, "is unchanged by " + value);
}

void Walk::reads_back(const ParameterRow& row, Setting expected, const std::string& what) {
  const Reading got = read(row);
  note(name_of(row), what, got.setting == expected,
       fmt::format("{} instead of {} unit {}", got.exchange, expected.value, expected.unit));
}

Walk::Reading Walk::read(const ParameterRow& row) {
  if (report_.given_up) return {};
  const Bytes request = dialect_.read(row, options_.channel);
  const Heard heard = ask(request, kAnswered);
  Reading reading{.exchange = fmt::format("sent {}, heard {}", hex(request), hex(heard.bytes))};
  if (heard.answer.kind == Kind::kValues) reading.setting = dialect_.setting(heard.answer.values);
  if (!reading.setting) resynchronise();
  return reading;
}

void Walk::listens(const std::string& row, const std::string& after) {
  expect(row, "the drive listens after " + after, dialect_.probe(), kAnswered);
}

void Walk::expect(const std::string& row, const std::string& what, const Bytes& request,
                  const Answer& expected) {
  if (report_.given_up) return;
  judge(row, what, request, expected, ask(request, expected));
}

void Walk::judge(const std::string& row, const std::string& what, const Bytes& request,
                 const Answer& expected, const Heard& heard) {
  const bool passed = same(heard.answer, expected);
  note(row, what, passed,
       fmt::format("sent {}, expected {}, heard {}: {}", hex(request), name_of(expected),
                   hex(heard.bytes), name_of(heard.answer)));
  if (!passed) resynchronise();
}

void Walk::note(const std::string& row, const std::string& what, bool passed, std::string detail) {
  if (report_.given_up) return;
  report_.checks.push_back(
      {row, what, source_, passed, passed ? std::string() : std::move(detail)});
  if (!passed) report_.given_up = ++failures_ >= options_.most_failures;
}

// --- Bytes ---------------------------------------------------------------------------------------

Walk::Heard Walk::ask(const Bytes& request, const Answer& expected) {
  transport_.write(request);
  Heard heard = listen(request, patience_for(expected));
  if (heard.answer.kind != Kind::kSilence && drain(heard.bytes)) {
    heard.answer = {.kind = Kind::kDamaged};
  }
  return heard;
}

Walk::Heard Walk::listen(const Bytes& request, SimDuration patience) {
  Heard heard;
  while (const auto byte = transport_.read(patience)) {
    heard.bytes.push_back(*byte);
    if (const auto answer = dialect_.decode(request, heard.bytes)) {
      heard.answer = *answer;
      return heard;
    }
    if (heard.bytes.size() >= table_.framing.longest) break;
  }
  if (!heard.bytes.empty()) heard.answer = {.kind = Kind::kDamaged};
  return heard;
}

// True if there was anything.
bool Walk::drain(Bytes& heard) {
  const std::size_t before = heard.size();
  while (heard.size() < before + kMostDrained) {
    const auto byte = transport_.read(options_.silence);
    if (!byte) break;
    heard.push_back(*byte);
  }
  return heard.size() > before;
}

void Walk::send_all(const std::vector<Bytes>& requests) {
  for (const Bytes& request : requests) ask(request, kAnswered);
}

void Walk::resynchronise() {
  if (report_.given_up) return;
  Bytes ignored;
  transport_.write(dialect_.resynchronise());
  drain(ignored);
}

}  // namespace

std::size_t WalkReport::failures() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(checks, [](const Check& check) { return !check.passed; }));
}

WalkReport walk(const Dialect& dialect, HostTransport& transport, const WalkOptions& options) {
  return Walk(dialect, transport, options).run();
}

std::string text(const WalkReport& report) {
  std::set<std::string_view> rows;
  for (const Check& check : report.checks) rows.insert(check.row);
  std::string text = fmt::format("{} checks of {} rows, {} failed, {} rows left out{}\n",
                                 report.checks.size(), rows.size(), report.failures(),
                                 report.skipped.size(), report.given_up ? ", given up" : "");
  for (const Check& check : report.checks) {
    if (!check.passed) {
      text += fmt::format("FAILED {}: {}: {}\n", check.row, check.what, check.detail);
    }
  }
  for (const std::string& row : report.skipped) text += fmt::format("left out {}\n", row);
  return text;
}

}  // namespace virtdrive::protocol
