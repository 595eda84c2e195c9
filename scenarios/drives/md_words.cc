#include "scenarios/drives/md_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/md485/client.h"
#include "devices/md485/model_table.h"

namespace virtdrive {
namespace {

using namespace md485;

constexpr std::string_view kPrefix = "PID_";

std::string_view without_prefix(std::string_view name) {
  return name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : name;
}

template <class Row>
const Row& row_named(std::span<const Row> rows, std::string_view kind, std::string_view name) {
  const auto same = [&](const Row& row) {
    return edit_distance(without_prefix(row.name), without_prefix(name)) == 0;
  };
  const auto it = std::ranges::find_if(rows, same);
  if (it != rows.end()) return *it;
  std::vector<std::string_view> names;
  for (const Row& row : rows) names.push_back(without_prefix(row.name));
  throw SetupError(unknown_name(kind, without_prefix(name), names));
}

// As it lies on the wire, "200", or in the field's unit, "20A".
std::int64_t number(std::string_view text, std::string_view digits, const Field& field) {
  double value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  const std::string_view unit(stop, static_cast<std::size_t>(end - stop));
  if (error != std::errc{} || (!unit.empty() && unit != field.unit)) {
    throw SetupError(field.unit.empty()
                         ? fmt::format("{}: '{}' is not a whole number", text, digits)
                         : fmt::format("{}: '{}' is neither a whole number nor a value in {}", text,
                                       digits, field.unit));
  }
  const double raw = unit.empty() ? value : value / field.scale;
  constexpr double kTolerance = 1e-6;
  if (!(std::fabs(raw - std::round(raw)) < kTolerance) || std::fabs(raw) > 1e12) {
    throw SetupError(fmt::format("{}: '{}' is not a whole number of steps", text, digits));
  }
  return std::llround(raw);
}

// NAME or NAME.FIELD, with a name's own dots.
std::pair<std::string_view, std::string_view> split_field(std::string_view text) {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return {text, {}};
  return {text.substr(0, dot), text.substr(dot + 1)};
}

class MdHost final : public HostClient {
 public:
  explicit MdHost(std::unique_ptr<HostTransport> transport)
      : transport_(std::move(transport)), client_(*transport_) {}

  protocol::Values call(std::string_view command, const protocol::Values& request) override {
    const CommandRow& row = row_named(kTable.commands, "command", command);
    if (row.names != Names::kParameter) {
      client_.command(row, request);
      return {};
    }
    const ParameterRow* asked =
        protocol::find(kTable.parameters, static_cast<std::uint16_t>(request[0]));
    if (asked == nullptr) throw SetupError(fmt::format("no PID {}", request[0]));
    return request.size() > 1 ? client_.read(*asked, static_cast<std::uint8_t>(request[1]))
                              : client_.read(*asked);
  }
  Reading get(std::string_view parameter) override {
    const auto [name, field_name] = split_field(parameter);
    const ParameterRow& row = row_named(kTable.parameters, "PID", name);
    const protocol::Values values = client_.read(row);
    const std::vector<Field> fields = protocol::value_fields(row);
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (field_name.empty() || fields[i].name == field_name) {
        return {double(values[i]) * fields[i].scale, std::string(fields[i].unit)};
      }
      names.push_back(fields[i].name);
    }
    throw SetupError(unknown_name(fmt::format("field of {}", row.name), field_name, names));
  }
  void set(std::string_view assignment) override {
    const MdAssignment parsed = parse_md_assignment(assignment);
    protocol::Values values;
    for (std::size_t i = is_checked(parsed.row->id) ? 1 : 0; i < parsed.values.size(); ++i) {
      values.push(parsed.values[i]);
    }
    client_.set(*parsed.row, values);
  }
  std::string setting(std::string_view parameter) override {
    const protocol::Values values = client_.read(row_named(kTable.parameters, "PID", parameter));
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i) {
      text += fmt::format("{}{}", i == 0 ? "" : ",", values[i]);
    }
    return text;
  }
  void start_motor(std::size_t channel, double rpm) override {
    const std::int64_t speed = std::lround(rpm);
    if (channel == 0)
      call("PID_VEL_CMD", {speed});
    else
      call("PID_PNT_VEL_CMD", {0, 0, 1, speed, 0});
  }
  void stop_motor(std::size_t channel) override {
    call("PID_PNT_TQ_OFF", {channel == 0, channel == 1, 0});
  }

 private:
  std::unique_ptr<HostTransport> transport_;
  Client client_;
};

}  // namespace

MdAssignment parse_md_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    throw SetupError(fmt::format("{}: expected NAME=VALUE", text));
  }
  const ParameterRow& row = row_named(kTable.parameters, "parameter", text.substr(0, equals));
  MdAssignment assignment{.row = &row, .values = {}};
  if (is_checked(row.id)) assignment.values.push(kWriteCheck);
  const std::vector<Field> fields = write_fields(row);
  for (std::string_view rest = text.substr(equals + 1); !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const Field& field = fields[std::min(assignment.values.size(), fields.size() - 1)];
    assignment.values.push(number(text, rest.substr(0, comma), field));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  const auto wanted = static_cast<std::size_t>(
      std::ranges::count_if(fields, [](const Field& field) { return !field.optional; }));
  if (assignment.values.size() < wanted || assignment.values.size() > fields.size()) {
    throw SetupError(fmt::format("{}: {} takes {} numbers with commas between them", text, row.name,
                                 wanted - is_checked(row.id)));
  }
  assignment.values.pad(fields);
  return assignment;
}

std::unique_ptr<HostClient> make_md_host(std::unique_ptr<HostTransport> transport) {
  return std::make_unique<MdHost>(std::move(transport));
}

}  // namespace virtdrive
