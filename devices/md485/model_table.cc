#include "devices/md485/model_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "devices/md485/settings_rows.h"
#include "devices/protocol/payload.h"

namespace virtdrive::md485 {
namespace {

constexpr std::string_view kLater = "later";

// What needs a second motor (p. 16 .. 28; "PNT50 MD750T" stands for all that have two).
constexpr std::uint8_t kSecondMotorPids[] = {39, 200, 201, 202, 241};
constexpr std::uint8_t kSecondMotorCommands[] = {218, 251};
constexpr std::uint8_t kFirstSecondMotorNumber = 50;
constexpr std::uint8_t kClutchNumbers[] = {17, 18};
constexpr std::uint8_t kCanNumbers[] = {23, 24};
// Asked for, a real v7.2 kept silent although V4.4 types them R or R/W.
constexpr std::uint8_t kSilentInV72[] = {146, 147, 152, 160, 198};

bool holds(std::span<const std::uint8_t> list, std::uint16_t pid) {
  return std::ranges::find(list, pid) != list.end();
}

const Setting* setting_of(std::uint16_t pid) {
  return protocol::find(kSettingRows, pid);
}

template <class Row>
const Row* if_there(const Row* row) {
  return row != nullptr && row->support != Support::kRejected ? row : nullptr;
}

}  // namespace

Profile parse_profile(std::string_view text) {
  constexpr std::array<std::string_view, 3> kNames = {"default", "4.4-strict", "v7.2"};
  const auto it = std::ranges::find(kNames, text);
  if (it == kNames.end()) {
    throw SetupError(unknown_name("profile", text, {kNames.begin(), kNames.end()}));
  }
  return static_cast<Profile>(it - kNames.begin());
}

ModelTable::ModelTable(const md::Model& model, Profile profile)
    : model_(model),
      profile_(profile),
      type_text_(std::string(model.title) + "-V4.4"),
      title_(fmt::format("{}, {} {}~{} V, {} A{}, RS-485 V4.4", model.title, model.ac ? "AC" : "DC",
                         model.lowest_v, model.highest_v, model.current_a,
                         model.motors > 1 ? " x 2" : "")),
      parameters_(std::begin(kParameters), std::end(kParameters)),
      commands_(std::begin(kCommands), std::end(kCommands)),
      numbers_(std::begin(kCommandNumbers), std::end(kCommandNumbers)) {
  for (ParameterRow& row : parameters_) adapt(row);
  const bool one_motor = model.motors == 1;
  for (CommandRow& row : commands_) {
    if (one_motor && holds(kSecondMotorCommands, row.code)) row.support = Support::kRejected;
  }
  for (CommandRow& row : numbers_) {
    if ((one_motor && row.code >= kFirstSecondMotorNumber) ||
        (!model.clutch && holds(kClutchNumbers, row.code)) ||
        (!model.can && holds(kCanNumbers, row.code)) ||
        (profile == Profile::kStrict && row.source == kLater)) {
      row.support = Support::kRejected;
    }
  }
  table_.title = title_;
  table_.parameters = parameters_;
  table_.commands = commands_;
  table_.functions = numbers_;
}

void ModelTable::adapt(ParameterRow& row) const {
  const bool one_motor = model_.motors == 1;
  const bool strict = profile_ == Profile::kStrict;
  if ((strict && row.source == kLater) || (one_motor && holds(kSecondMotorPids, row.id))) {
    row.support = Support::kRejected;
  }
  if (profile_ == Profile::kV72 && holds(kSilentInV72, row.id)) row.access = Access::kWriteOnly;
  if (const Setting* setting = setting_of(row.id)) {
    row.factory.value = md::default_settings(model_).**setting;
  }
  switch (row.id) {
    case 18:
      if (one_motor) row.support = Support::kStored;
      break;
    case 24:
      if (strict) row.range = kFlag;
      break;
    case 137:
      if (!model_.can) row.support = Support::kStored;
      break;
    case 143:
      if (model_.ac) row.scale = 1;
      break;
    case 159:
      row.factory.value = md::default_settings(model_).slow_start;
      break;
    case 193:
    case 200:
      if (strict) row.fields = std::span(kMainData).first(std::size(kMainData) - 1);
      break;
    case 197:
      if (strict || one_motor) row.fields = std::span(kPositions).first(1);
      break;
    case 205:
      row.count = type_text_.size();
      break;
    case 211:
      row.range.maximum = static_cast<std::int64_t>(15 * model_.current_a);
      break;
    case 227:
      if (one_motor) row.fields = std::span(kPreset).first(2);
      break;
    default:
      break;
  }
}

const ParameterRow* ModelTable::parameter(std::uint8_t pid) const {
  return if_there(protocol::find(table_.parameters, pid));
}
const CommandRow* ModelTable::command(std::uint8_t pid) const {
  return if_there(protocol::find(table_.commands, pid));
}
const CommandRow* ModelTable::number(std::uint8_t cmd) const {
  return if_there(protocol::find(table_.functions, cmd));
}

std::vector<Field> write_fields(const ParameterRow& row) {
  std::vector<Field> fields = protocol::value_fields(row);
  if (is_checked(row.id)) fields.insert(fields.begin(), kCheck[0]);
  return fields;
}

}  // namespace virtdrive::md485
