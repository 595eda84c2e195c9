#include "scenarios/drives/rzt1_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/rzt1/client.h"

namespace virtdrive {
namespace {

using namespace rzt1;
using namespace std::chrono_literals;

constexpr std::string_view kInLines = "ascii";
constexpr std::int64_t kServoOnBit = 1 << 1;
constexpr std::int64_t kPhasedBit = 1 << 7;
constexpr std::int64_t kBusyBit = 1 << 8;
/// How long --start waits for the phasing: 0.5 s with the factory's settings.
constexpr int kMostPolls = 500;
constexpr SimDuration kPoll = 10ms;

template <class Row>
const Row& row_named(std::span<const Row> rows, std::string_view kind, std::string_view name) {
  const auto same = [&](const Row& row) { return edit_distance(row.name, name) == 0; };
  const auto it = std::ranges::find_if(rows, same);
  if (it != rows.end()) return *it;
  std::vector<std::string_view> names;
  for (const Row& row : rows) names.push_back(row.name);
  throw SetupError(fmt::format("{}; 'virtdrive list parameters rzt1' shows them all",
                               unknown_name(kind, name, names)));
}

const ParameterRow& variable_named(std::string_view name) {
  return row_named(kTable.parameters, "variable", name);
}

class Rzt1Host final : public HostClient {
 public:
  explicit Rzt1Host(std::unique_ptr<HostTransport> transport)
      : transport_(std::move(transport)), client_(*transport_) {}

  protocol::Values call(std::string_view command, const protocol::Values& request) override {
    const Rzt1Name name = parse_rzt1_name(command);
    address(name);
    const auto packet = std::ranges::find(kTable.commands, name.name, &CommandRow::name);
    if (packet != kTable.commands.end() && !name.in_lines) return send(*packet, request);
    const CommandRow& function = row_named(kTable.functions, "function", name.name);
    if (name.in_lines)
      client_.line(line(name, function.name));
    else
      client_.call(function.name);
    return {};
  }
  virtdrive::Reading get(std::string_view parameter) override {
    const Rzt1Name name = parse_rzt1_name(parameter);
    const ParameterRow& row = variable_named(name.name);
    address(name);
    if (!name.in_lines) return {double(client_.get(row.name)), ""};
    const std::string text = client_.line(line(name, row.name));
    const auto value = from_text(row, text);
    if (!value) throw ClientError(fmt::format("{}: '{}' is no number", row.name, text));
    return {double(*value), ""};
  }
  void set(std::string_view assignment) override {
    const Rzt1Assignment parsed = parse_rzt1_assignment(assignment);
    address(parsed.name);
    if (!parsed.name.in_lines) return client_.set(parsed.row->name, parsed.value);
    client_.line(fmt::format("{} {}", line(parsed.name, parsed.row->name), parsed.value));
  }
  // Servo on, phased if it is not, then a jog.
  void start_motor(std::size_t channel, double rpm) override {
    client_.set_address(static_cast<std::uint8_t>(channel + 1));
    if ((client_.get("STA") & kServoOnBit) == 0) client_.call("ON");
    for (int i = 0; i < kMostPolls; ++i) {
      const std::int64_t status = client_.get("STA");
      if ((status & kPhasedBit) != 0 && (status & kBusyBit) == 0) break;
      transport_->read(kPoll);
    }
    const double counts_per_s = std::abs(rpm) / 60 * double(client_.get("ECPR"));
    client_.set("VEL", velocity_units(counts_per_s, client_.get("DS") * 50us));
    client_.call(rpm < 0 ? "REV" : "FWD");
  }
  void stop_motor(std::size_t channel) override {
    client_.set_address(static_cast<std::uint8_t>(channel + 1));
    client_.call("STOP");
  }

 private:
  void address(const Rzt1Name& name) {
    if (!name.in_lines) client_.set_address(name.number.value_or(1));
  }
  static std::string line(const Rzt1Name& name, std::string_view word) {
    return name.number ? fmt::format("{}{}", *name.number, word) : std::string(word);
  }
  // Without the optional fields that are 0.
  protocol::Values send(const CommandRow& row, const protocol::Values& request) {
    std::size_t size = request.size();
    std::size_t needed = 0;
    for (const Field& field : row.request) needed += field.optional ? 0 : 1;
    if (needed > 0) {
      while (size > needed && request[size - 1] == 0) --size;
    } else if (size > 0) {  // points: as many as their count says
      size =
          std::min(size, 1 + 2 * static_cast<std::size_t>(std::max<std::int64_t>(request[0], 0)));
    }
    protocol::Values values;
    for (std::size_t i = 0; i < size; ++i) values.push(request[i]);
    return client_.send(row, values);
  }

  std::unique_ptr<HostTransport> transport_;
  Client client_;
};

}  // namespace

Rzt1Name parse_rzt1_name(std::string_view text) {
  Rzt1Name parsed;
  std::string_view rest = text;
  const auto part = [&]() -> std::optional<std::string_view> {
    const std::size_t dot = rest.find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    const std::string_view before = rest.substr(0, dot);
    rest.remove_prefix(dot + 1);
    return before;
  };
  std::optional<std::string_view> before = part();
  if (before == kInLines) {
    parsed.in_lines = true;
    before = part();
  }
  if (before) {
    unsigned number = 0;
    const char* const last = before->data() + before->size();
    const auto [end, error] = std::from_chars(before->data(), last, number);
    if (error != std::errc{} || end != last || number < 1 || number > 255) {
      throw SetupError(fmt::format("{}: '{}' is no address or axis, 1 ... 255", text, *before));
    }
    parsed.number = static_cast<std::uint8_t>(number);
  }
  parsed.name = rest;
  return parsed;
}

Rzt1Assignment parse_rzt1_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    throw SetupError(fmt::format("{}: expected [AXIS.]NAME=VALUE", text));
  }
  Rzt1Assignment assignment{.name = parse_rzt1_name(text.substr(0, equals)), .row = {}, .value = 0};
  assignment.row = &variable_named(assignment.name.name);
  const std::string_view digits = text.substr(equals + 1);
  const auto value = parse_number(digits);
  if (!value) throw SetupError(fmt::format("{}: '{}' is not a whole number", text, digits));
  assignment.value = *value;
  return assignment;
}

std::unique_ptr<HostClient> make_rzt1_host(std::unique_ptr<HostTransport> transport) {
  return std::make_unique<Rzt1Host>(std::move(transport));
}

}  // namespace virtdrive
