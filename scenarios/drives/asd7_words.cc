#include "scenarios/drives/asd7_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/names.h"
#include "devices/asd7/client.h"
#include "devices/asd7_modbus/client.h"
#include "firmware_models/asd7/trip.h"
#include "scenarios/scenario/quantity.h"

namespace virtdrive {
namespace {

using asd7::kTable;
using asd7::ParameterRow;

constexpr std::uint16_t kCommand = 0xFA00, kFrequency = 0xFA01, kFirstVolatile = 0xFA00;
constexpr int kPolePairs = 2;  // of the three sizes' motors

const ParameterRow& row_of(std::uint16_t number) {
  const ParameterRow* row = protocol::find(kTable.parameters, number);
  VIRTDRIVE_CHECK(row != nullptr, "no number {:04X}", number);
  return *row;
}

// "F803" and "0803" are the number 0803.
std::optional<std::uint16_t> number_in(std::string_view name) {
  std::string digits(name);
  if (name.size() == 4 && (name[0] == 'F' || name[0] == 'f') && name[1] <= '9') digits[0] = '0';
  if (digits.size() != 4) return std::nullopt;
  unsigned number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, number, 16);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return static_cast<std::uint16_t>(number);
}

const ParameterRow& row_named(std::string_view name) {
  const auto same = [&](const ParameterRow& row) { return row.name == name; };
  const auto like = [&](const ParameterRow& row) { return edit_distance(row.name, name) == 0; };
  auto it = std::ranges::find_if(kTable.parameters, same);
  if (it == kTable.parameters.end()) it = std::ranges::find_if(kTable.parameters, like);
  if (it != kTable.parameters.end()) return *it;
  if (const auto number = number_in(name)) {
    if (const ParameterRow* row = protocol::find(kTable.parameters, *number)) return *row;
  }
  std::vector<std::string_view> names;
  for (const ParameterRow& row : kTable.parameters) names.push_back(row.name);
  throw SetupError(
      fmt::format("{}; 'virtdrive list parameters asd7' shows them all, and F803 or FA01 will do",
                  unknown_name("parameter", name, names)));
}

struct Name {
  std::optional<std::uint8_t> number;
  const ParameterRow* row;
};

Name parse_name(std::string_view text) {
  Name name{};
  if (const std::size_t dot = text.find('.'); dot != std::string_view::npos) {
    std::uint8_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + dot, number);
    if (error != std::errc{} || end != text.data() + dot) {
      throw SetupError(fmt::format("{}: '{}' is not a drive's number", text, text.substr(0, dot)));
    }
    name.number = number;
    text.remove_prefix(dot + 1);
  }
  name.row = &row_named(text);
  return name;
}

std::int64_t parse_value(std::string_view text, const ParameterRow& row, std::string_view value) {
  if (value.starts_with("0x") || value.starts_with("0X")) {
    std::uint32_t word = 0;
    const char* const end = value.data() + value.size();
    const auto [stop, error] = std::from_chars(value.data() + 2, end, word, 16);
    if (error != std::errc{} || stop != end) {
      throw SetupError(fmt::format("{}: '{}' is not a hexadecimal number", text, value));
    }
    return word;
  }
  const auto quantity = parse_quantity(value);
  if (!quantity) throw SetupError(fmt::format("{}: '{}' is not a number", text, value));
  const auto in_row = quantity->unit.empty() ? std::optional(quantity->value)
                                             : convert(quantity->value, quantity->unit, row.unit);
  if (!in_row) {
    throw SetupError(fmt::format("{}: {} is in {}", text, row.name,
                                 row.unit.empty() ? "no unit" : units_like(row.unit)));
  }
  const double steps = *in_row / row.scale;
  const double whole = std::round(steps);
  if (!(std::abs(steps) < 1e9) || std::abs(steps - whole) > 1e-6 * std::max(1.0, whole)) {
    throw SetupError(
        fmt::format("{}: {} counts in steps of {} {}", text, row.name, row.scale, row.unit));
  }
  return static_cast<std::int64_t>(whole);
}

// The two protocols as the words need them.
class OwnProtocol {
 public:
  explicit OwnProtocol(HostTransport& transport) : client_(transport) {}

  static const protocol::ProtocolTable& table() { return asd7::kTable; }
  void address(std::optional<std::uint8_t> number) {
    if (number && *number > 99) throw SetupError("a drive's number is 0 to 99 in ASCII");
    const auto digit = [](int d) { return static_cast<std::uint8_t>(d); };
    client_.set_number(number ? std::optional(asd7::AsdNumber{.tens = digit(*number / 10),
                                                              .units = digit(*number % 10)})
                              : std::nullopt);
  }
  std::int64_t read(const ParameterRow& row) { return client_.read(row); }
  void write(const ParameterRow& row, std::int64_t value) {
    client_.write(row, value, row.id < kFirstVolatile);
  }
  protocol::Values call(const protocol::CommandRow& row, const protocol::Values& request) {
    return client_.call(row, request);
  }

 private:
  asd7::Client client_;
};

class ModbusProtocol {
 public:
  explicit ModbusProtocol(HostTransport& transport) : client_(transport) {}

  static const protocol::ProtocolTable& table() { return asd7_modbus::kTable; }
  void address(std::optional<std::uint8_t> unit) {
    client_.set_unit(unit.value_or(asd7_modbus::kFactoryUnit));
  }
  std::int64_t read(const ParameterRow& row) { return client_.read(row); }
  void write(const ParameterRow& row, std::int64_t value) { client_.write(row, value); }
  protocol::Values call(const protocol::CommandRow& row, const protocol::Values& request) {
    return client_.call(row, request);
  }

 private:
  asd7_modbus::Client client_;
};

template <class Protocol>
class Asd7Host final : public HostClient {
 public:
  explicit Asd7Host(std::unique_ptr<HostTransport> transport)
      : transport_(std::move(transport)), protocol_(*transport_) {}

  protocol::Values call(std::string_view command, const protocol::Values& request) override {
    const auto rows = Protocol::table().commands;
    const auto it = std::ranges::find(rows, command, &protocol::CommandRow::name);
    if (it != rows.end()) return protocol_.call(*it, request);
    std::vector<std::string_view> names;
    for (const protocol::CommandRow& row : rows) names.push_back(row.name);
    throw SetupError(unknown_name("command", command, names));
  }
  Reading get(std::string_view parameter) override {
    const auto [number, row] = parse_name(parameter);
    protocol_.address(number);
    // Divided, so that 48 tenths are 4.8 to the last bit.
    const double value = double(protocol_.read(*row));
    return {row->scale < 1 ? value / std::round(1 / row->scale) : value * row->scale,
            std::string(row->unit)};
  }
  void set(std::string_view assignment) override {
    const Asd7Assignment parsed = parse_asd7_assignment(assignment);
    protocol_.address(parsed.number);
    protocol_.write(*parsed.row, parsed.value);
  }
  // The frequency whose synchronous speed it is, and both priorities.
  void start_motor(std::size_t, double rpm) override {
    const double centihertz = std::abs(rpm) / 60 * kPolePairs * 100;
    protocol_.address(std::nullopt);
    protocol_.write(row_of(kFrequency), std::lround(centihertz));
    protocol_.write(row_of(kCommand),
                    kPriorities | asd7::kCommandRun | (rpm < 0 ? asd7::kCommandReverse : 0));
  }
  void stop_motor(std::size_t) override {
    protocol_.address(std::nullopt);
    protocol_.write(row_of(kCommand), kPriorities);
  }

 private:
  static constexpr int kPriorities = asd7::kCommandPriority | asd7::kCommandFrequencyPriority;

  std::unique_ptr<HostTransport> transport_;
  Protocol protocol_;
};

}  // namespace

Asd7Assignment parse_asd7_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    throw SetupError(fmt::format("{}: expected [NUMBER.]NAME=VALUE[UNIT]", text));
  }
  const auto [number, row] = parse_name(text.substr(0, equals));
  return {number, row, parse_value(text, *row, text.substr(equals + 1))};
}

std::unique_ptr<HostClient> make_asd7_host(std::unique_ptr<HostTransport> transport) {
  return std::make_unique<Asd7Host<OwnProtocol>>(std::move(transport));
}

std::unique_ptr<HostClient> make_asd7_modbus_host(std::unique_ptr<HostTransport> transport) {
  return std::make_unique<Asd7Host<ModbusProtocol>>(std::move(transport));
}

}  // namespace virtdrive
