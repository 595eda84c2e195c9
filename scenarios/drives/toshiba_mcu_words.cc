#include "scenarios/drives/toshiba_mcu_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/toshiba_mcu/client.h"

namespace virtdrive {
namespace {

using namespace toshiba_mcu;

// The motor number of the document's examples.
constexpr std::size_t kDefaultChannel = 1;

const ParameterRow& row_named(std::string_view text, std::string_view name) {
  const auto same = [&](const ParameterRow& row) { return edit_distance(row.name, name) == 0; };
  const auto it = std::ranges::find_if(kTable.parameters, same);
  if (it != kTable.parameters.end()) return *it;
  std::vector<std::string_view> names;
  for (const ParameterRow& row : kTable.parameters) names.push_back(row.name);
  throw SetupError(fmt::format("{}: {}; 'virtdrive list parameters toshiba-mcu' shows them all",
                               text, unknown_name("parameter", name, names)));
}

std::int8_t unit_labelled(std::string_view text, const ParameterRow& row, std::string_view label) {
  if (label.empty()) return row.factory.unit;
  std::vector<std::string_view> labels;
  for (const UnitCode& unit : row.units) {
    if (edit_distance(unit.label, label) == 0) return unit.code;
    labels.push_back(unit.label);
  }
  if (labels.empty() && edit_distance(row.unit, label) == 0 && !row.unit.empty()) return 0;
  if (labels.empty()) labels.push_back(row.unit.empty() ? "none" : row.unit);
  throw SetupError(fmt::format("{}: {}", text,
                               unknown_name(fmt::format("unit of {}", row.name), label, labels)));
}

struct Name {
  std::optional<std::size_t> channel;
  const ParameterRow* row;
};

// [CHANNEL.]NAME; `text` is what the user wrote, for the error.
Name parse_name(std::string_view text, std::string_view name) {
  Name parsed{};
  if (const std::size_t dot = name.find('.'); dot != std::string_view::npos) {
    std::size_t channel = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + dot, channel);
    if (error != std::errc{} || end != name.data() + dot || channel >= kChannels) {
      throw SetupError(fmt::format("{}: channel '{}' is not 0 ... {}", text, name.substr(0, dot),
                                   kChannels - 1));
    }
    parsed.channel = channel;
    name.remove_prefix(dot + 1);
  }
  parsed.row = &row_named(text, name);
  return parsed;
}

std::uint8_t motor_nr(std::size_t channel) {
  return static_cast<std::uint8_t>(channel);
}

std::string unit_text(const ParameterRow& row, std::int8_t code) {
  for (const UnitCode& unit : row.units) {
    if (unit.code == code) return std::string(unit.label);
  }
  return std::string(row.unit);
}

class ToshibaMcuHost final : public HostClient {
 public:
  explicit ToshibaMcuHost(std::unique_ptr<HostTransport> transport)
      : transport_(std::move(transport)), client_(*transport_) {}

  protocol::Values call(std::string_view command, const protocol::Values& request) override {
    const auto it = std::ranges::find(kTable.commands, command, &CommandRow::name);
    if (it != kTable.commands.end()) {
      return client_.call(static_cast<std::uint8_t>(it->code), request);
    }
    std::vector<std::string_view> names;
    for (const CommandRow& row : kTable.commands) names.push_back(row.name);
    throw SetupError(unknown_name("command", command, names));
  }
  Reading get(std::string_view parameter) override {
    const auto [channel, row] = parse_name(parameter, parameter);
    const UnitValue read = client_.get(motor_nr(channel.value_or(kDefaultChannel)), row->name);
    return {double(read.value) * row->scale, unit_text(*row, read.unit)};
  }
  void set(std::string_view assignment) override {
    const auto [channel, row, value] = parse_toshiba_mcu_assignment(assignment);
    client_.set(motor_nr(channel.value_or(kDefaultChannel)), row->name, value);
  }
  std::string setting(std::string_view parameter) override {
    const auto [channel, row] = parse_name(parameter, parameter);
    const UnitValue read = client_.get(motor_nr(channel.value_or(kDefaultChannel)), row->name);
    return fmt::format("{}{}", read.value, row->units.empty() ? "" : unit_text(*row, read.unit));
  }
  void start_motor(std::size_t channel, double rpm) override {
    client_.set(motor_nr(channel), "Speed", {static_cast<std::int32_t>(std::lround(rpm)), 0});
    client_.start_motor(motor_nr(channel));
  }
  void stop_motor(std::size_t channel) override { client_.stop_motor(motor_nr(channel)); }

 private:
  std::unique_ptr<HostTransport> transport_;
  Client client_;
};

}  // namespace

ToshibaMcuAssignment parse_toshiba_mcu_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    throw SetupError(fmt::format("{}: expected [CHANNEL.]NAME=VALUE[UNIT]", text));
  }
  const auto [channel, row] = parse_name(text, text.substr(0, equals));
  ToshibaMcuAssignment assignment{.channel = channel, .row = row, .value = {}};
  const std::string_view value = text.substr(equals + 1);
  const char* const value_end = value.data() + value.size();
  const auto [end, error] = std::from_chars(value.data(), value_end, assignment.value.value);
  if (error != std::errc{}) {
    throw SetupError(fmt::format("{}: '{}' is not a whole number within 32 bits", text, value));
  }
  assignment.value.unit = unit_labelled(text, *row, std::string_view(end, value_end));
  return assignment;
}

std::unique_ptr<HostClient> make_toshiba_mcu_host(std::unique_ptr<HostTransport> transport) {
  return std::make_unique<ToshibaMcuHost>(std::move(transport));
}

}  // namespace virtdrive
