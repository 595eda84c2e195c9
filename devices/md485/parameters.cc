#include "devices/md485/parameters.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <variant>
#include <vector>

#include "devices/md485/settings_rows.h"
#include "devices/protocol/binding.h"
#include "devices/protocol/checksum.h"

namespace virtdrive::md485 {
namespace {

using md::Controller;
using md::MotorChannel;
using md::Settings;
using protocol::Binding;
using protocol::Values;

// --- What stands behind the rows that are not one setting ----------------------------------------

struct Context {
  const Controller& controller;
  const ModelTable& table;
  std::uint8_t index;

  const Settings& settings() const { return controller.settings(); }
  bool has_second() const { return controller.motors() > 1; }
};

using Read = std::optional<Values> (*)(const Context&);
/// Changes the settings; false if the values are not to be taken.
using Write = bool (*)(Settings&, const Values&);

struct Block {
  Read read;
  Write write = nullptr;
};

std::int64_t deciamperes(const MotorChannel& motor) {
  return std::lround(motor.current_a() * 10);
}
std::int64_t heat_sink(const Context& c) {
  const bool sensor = c.controller.model().temperature_sensor;
  return sensor ? std::clamp(std::lround(c.controller.heat_sink_degc()), 0L, 255L) : 0;
}
std::int64_t supply(const Context& c) {
  return std::lround(c.controller.bus_v() * (c.controller.model().ac ? 1 : 10));
}
// The volumes as one byte of 10 bits.
std::int64_t volume_byte(std::int32_t setting, double volume) {
  const double raw = setting > 0 ? setting : volume * 1023;
  return static_cast<std::int64_t>(raw / 10);
}

template <std::size_t kMotor>
std::optional<Values> main_data(const Context& c) {
  const MotorChannel& m = c.controller.motor(kMotor);
  Values values = {m.rpm(),
                   deciamperes(m),
                   static_cast<std::int64_t>(m.type()),
                   m.reference_rpm(),
                   m.output_counts(),
                   m.status(),
                   m.position(),
                   std::lround(255 * c.controller.brake_duty()),
                   heat_sink(c)};
  if (c.table.parameter(193)->fields.size() > values.size()) values.push(m.status2());
  return values;
}

template <std::size_t kMotor>
std::optional<Values> io_monitor(const Context& c) {
  const MotorChannel& m = c.controller.motor(kMotor);
  const md::Terminals& pins = c.controller.terminals(kMotor);
  const Settings& s = c.settings();
  return Values{m.rpm(),
                deciamperes(m),
                m.status(),
                md::input_byte(pins),
                md::analog_counts(pins),
                0,
                c.controller.hall(kMotor),
                m.status2(),
                md::input_byte(pins),
                supply(c),
                volume_byte(s.slow_start, pins.slow_start_volume),
                volume_byte(s.slow_down, pins.slow_down_volume),
                volume_byte(0, pins.volume)};
}

template <std::size_t kMotor>
std::optional<Values> monitor(const Context& c) {
  const MotorChannel& m = c.controller.motor(kMotor);
  return Values{m.rpm(),    deciamperes(m), std::abs(m.output_counts()),
                m.status(), m.position(),   md::input_byte(c.controller.terminals(kMotor))};
}

std::optional<Values> positions(const Context& c) {
  Values values = {c.controller.motor(0).position()};
  if (c.table.parameter(197)->fields.size() > 1) values.push(c.controller.motor(1).position());
  return values;
}

// A single controller's other half is 0.
template <class Half>
Values both(const Context& c, Half half) {
  Values values;
  for (std::size_t i = 0; i < md::kMostMotors; ++i) {
    const bool there = i < c.controller.motors();
    const Values part = half(c.controller.motor(there ? i : 0));
    for (std::size_t k = 0; k < part.size(); ++k) values.push(there ? part[k] : 0);
  }
  return values;
}

std::optional<Values> pnt_main_data(const Context& c) {
  return both(c, [](const MotorChannel& m) {
    return Values{m.rpm(), deciamperes(m), m.status(), m.position()};
  });
}
std::optional<Values> pnt_monitor(const Context& c) {
  return both(c, [](const MotorChannel& m) { return Values{m.rpm(), m.status(), m.position()}; });
}

std::optional<Values> pnt_io_monitor(const Context& c) {
  const md::Terminals& one = c.controller.terminals(0);
  const md::Terminals& two = c.controller.terminals(1);
  return Values{md::input_byte(one),
                md::input_byte(two),
                c.controller.hall(0),
                c.controller.hall(1),
                md::analog_counts(one),
                md::analog_counts(two),
                supply(c),
                volume_byte(c.settings().slow_start, one.slow_start_volume),
                volume_byte(0, one.volume),
                0};
}

std::optional<Values> in_position(const Context& c) {
  int bits = 0;
  for (std::size_t i = 0; i < c.controller.motors(); ++i) {
    bits |= c.controller.motor(i).in_position() << i;
  }
  return Values{bits};
}

std::optional<Values> last_alarm(const Context& c) {
  int bits = 0;
  for (std::size_t i = 0; i < c.controller.motors(); ++i)
    bits |= c.controller.motor(i).last_alarm();
  return Values{bits};
}

std::optional<Values> type_text(const Context& c) {
  Values values;
  for (const char letter : c.table.type_text()) values.push(letter);
  return values;
}

std::optional<Values> function_type(const Context& c) {
  return Values{c.settings().func_type, 0};
}
bool write_function_type(Settings& s, const Values& v) {
  if (v[0] < 0 || v[0] > 4) return false;
  s.func_type = static_cast<std::int32_t>(v[0]);
  return true;
}

bool write_watch(Settings& s, const Values& v) {
  s.watch_delay = static_cast<std::int32_t>(v[0]);
  return true;
}

std::int32_t positive(std::int64_t v) {
  return static_cast<std::int32_t>(std::max<std::int64_t>(v, 0));
}
std::int32_t ten_bits(std::int64_t v) {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, 0, 1023));
}
std::int32_t low_limit(std::int64_t v) {
  return std::min(ten_bits(v), 512);
}
// 0 is not set; the document's range is 512..1023.
std::int32_t high_limit(std::int64_t v) {
  return v <= 0 ? 0 : std::max(ten_bits(v), 512);
}

bool write_gains(Settings& s, const Values& v) {
  s.pv_gain = positive(v[0]);
  s.p_gain = positive(v[1]);
  s.i_gain = positive(v[2]);
  return true;
}
bool write_torque_gains(Settings& s, const Values& v) {
  s.tq_p_gain = positive(v[0]);
  s.tq_i_gain = positive(v[1]);
  return true;
}
bool write_speed_limits(Settings& s, const Values& v) {
  s.low_speed_limit = low_limit(v[0]);
  s.high_speed_limit = high_limit(v[1]);
  return true;
}
bool write_volume_limits(Settings& s, const Values& v) {
  s.low_volume_limit = low_limit(v[0]);
  s.high_volume_limit = high_limit(v[1]);
  return true;
}
bool write_slow_start_down(Settings& s, const Values& v) {
  s.slow_start = s.slow_down = ten_bits(v[0]);
  return true;
}
bool write_high_limit(Settings& s, const Values& v) {
  s.high_speed_limit = high_limit(v[0]);
  return true;
}

std::optional<Values> step(const Context& c) {
  if (c.index < 1 || c.index > md::kSteps) return std::nullopt;
  return Values{c.index, md::step_rpm(c.settings(), c.index)};
}
bool write_step(Settings& s, const Values& v) {
  if (v[0] < 1 || v[0] > static_cast<std::int64_t>(md::kSteps)) return false;
  s.steps[static_cast<std::size_t>(v[0] - 1)] = static_cast<std::int32_t>(v[1]);
  return true;
}

std::optional<Values> curve_point(const Context& c) {
  if (c.index < 1 || c.index > md::kCurvePoints) return std::nullopt;
  const md::CurvePoint& point = c.settings().curve[c.index - 1U];
  return Values{c.index, point.x, point.y};
}
bool write_curve_point(Settings& s, const Values& v) {
  if (v[0] < 1 || v[0] > static_cast<std::int64_t>(md::kCurvePoints)) return false;
  s.curve[static_cast<std::size_t>(v[0] - 1)] = {ten_bits(v[1]), ten_bits(v[2])};
  return true;
}

std::optional<Values> preset(const Context& c) {
  if (c.index < 1 || c.index > md::kPresets) return std::nullopt;
  const auto& saved = c.settings().presets[c.index - 1U];
  Values values = {c.index, saved[0]};
  if (c.has_second()) values.push(saved[1]);
  return values;
}

bool write_function_speed(Settings& s, const Values& v) {
  s.func_speed = static_cast<std::int32_t>(v[0]);
  s.func_delay = positive(v[1]);
  return true;
}
bool write_function_position(Settings& s, const Values& v) {
  s.func_posi_speed = static_cast<std::int32_t>(v[0]);
  s.func_posi_increment = static_cast<std::int32_t>(v[1]);
  return true;
}

template <Setting... kMembers>
std::optional<Values> settings(const Context& c) {
  return Values{c.settings().*kMembers...};
}

using S = Settings;

constexpr auto kBlocks = std::to_array<Binding<Block>>({
    {1, {[](const Context&) { return std::optional(Values{44}); }}},
    {34, {[](const Context& c) { return std::optional(Values{c.controller.motor(0).status()}); }}},
    {39, {[](const Context& c) { return std::optional(Values{c.controller.motor(1).status()}); }}},
    {48, {[](const Context& c) {
       return std::optional(Values{md::input_byte(c.controller.terminals(0))});
     }}},
    {49, {in_position}},
    {60, {last_alarm}},
    {138, {[](const Context& c) { return std::optional(Values{c.controller.motor(0).rpm()}); }}},
    {139,
     {[](const Context& c) { return std::optional(Values{deciamperes(c.controller.motor(0))}); }}},
    {143, {[](const Context& c) { return std::optional(Values{supply(c)}); }}},
    {158, {settings<&S::high_speed_limit>, write_high_limit}},
    {159, {settings<&S::slow_start>, write_slow_start_down}},
    {166, {[](const Context& c) {
       return std::optional(Values{c.controller.motor(0).reference_rpm()});
     }}},
    // Kept in RAM: Parameters::write gives it to the controller.
    {180, {[](const Context& c) { return std::optional(Values{c.controller.com_tar_speed()}); }}},
    {183, {function_type, write_function_type}},
    {185, {settings<&S::watch_delay>, write_watch}},
    {193, {main_data<0>}},
    {194, {io_monitor<0>}},
    {196, {monitor<0>}},
    {197, {positions}},
    {198, {[](const Context& c) { return std::optional(Values{c.controller.motor(0).rpm()}); }}},
    {200, {main_data<1>}},
    {201, {monitor<1>}},
    {202, {io_monitor<1>}},
    {203, {settings<&S::pv_gain, &S::p_gain, &S::i_gain>, write_gains}},
    {205, {type_text}},
    {210, {pnt_main_data}},
    {216, {pnt_monitor}},
    {222, {settings<&S::low_speed_limit, &S::high_speed_limit>, write_speed_limits}},
    {224, {settings<&S::low_volume_limit, &S::high_volume_limit>, write_volume_limits}},
    {225, {step, write_step}},
    {226, {curve_point, write_curve_point}},
    {227, {preset}},
    {230, {[](const Context& c) {
       return std::optional(Values{c.controller.motor(0).target_position()});
     }}},
    {234, {[](const Context& c) { return std::optional(Values{c.controller.seconds_up()}); }}},
    {235, {settings<&S::tq_p_gain, &S::tq_i_gain>, write_torque_gains}},
    {239, {settings<&S::func_speed, &S::func_delay>, write_function_speed}},
    {241, {pnt_io_monitor}},
    {250, {settings<&S::func_posi_speed, &S::func_posi_increment>, write_function_position}},
});

constexpr std::uint8_t kComTarSpeed = 180;
constexpr std::uint8_t kInputType = 25;
constexpr std::int64_t kNoInputType = 4;  // V4.4 has 0..3 and 5

// In place of find() != nullptr, which g++ takes for no constant where it sanitises.
template <class Bindings>
consteval bool binds(const Bindings& bindings, std::uint16_t id) {
  return std::ranges::any_of(bindings, [id](const auto& binding) { return binding.id == id; });
}

// Every row that is not rejected has a setting or a block behind it, and nothing else has.
consteval bool all_bound() {
  std::size_t blocks = 0, settings = 0;
  for (const ParameterRow& row : kParameters) {
    const bool block = binds(kBlocks, row.id);
    const bool setting = binds(kSettingRows, row.id);
    if ((block || setting) != (row.support != Support::kRejected)) return false;
    blocks += block;
    settings += setting;
  }
  return blocks == kBlocks.size() && settings == kSettingRows.size();
}
static_assert(all_bound(), "a PID that is not rejected has nothing behind it, or the reverse");

// --- The flash -----------------------------------------------------------------------------------

constexpr std::string_view kBlock = "settings";
constexpr std::uint8_t kLayout = 2;

// Every number of the settings, in one order: visit(number).
template <class AnySettings, class Visitor>
void for_each_number(AnySettings& s, Visitor&& visit) {
  for (const Binding<Setting>& row : kSettingRows) visit(s.*row.target);
  for (const Setting other : {&S::low_volume_limit, &S::high_volume_limit, &S::func_speed,
                              &S::func_delay, &S::func_posi_speed, &S::func_posi_increment}) {
    visit(s.*other);
  }
  for (auto& step : s.steps) visit(step);
  for (auto& point : s.curve) {
    visit(point.x);
    visit(point.y);
  }
  for (auto& preset : s.presets) {
    for (auto& position : preset) visit(position);
  }
}

// Layout, the model's name, the numbers, what makes the sum zero.
std::vector<std::uint8_t> to_block(const md::Model& model, const Settings& settings) {
  std::vector<std::uint8_t> block(1 + model.name.size(), kLayout);
  std::ranges::copy(model.name, block.begin() + 1);
  for_each_number(settings, [&](std::int32_t number) {
    block.resize(block.size() + 4);
    protocol::store(std::span(block).last(4), WireType::kI32, kTable.framing.order, number);
  });
  block.push_back(protocol::negated_sum8(block));
  return block;
}

}  // namespace

md::Settings stored_settings(const md::Model& model, NonVolatileMemory& memory,
                             const NoteListener& notes) {
  Settings settings = md::default_settings(model);
  const auto block = memory.read(kBlock);
  if (!block) return settings;
  const std::vector<std::uint8_t> defaults = to_block(model, settings);
  const std::size_t head = 1 + model.name.size();
  const bool whole = !block->empty() && protocol::sum8(*block) == 0;
  const bool of_model =
      block->size() == defaults.size() &&
      std::equal(defaults.begin(), defaults.begin() + std::ptrdiff_t(head), block->begin());
  if (!whole || !of_model) {
    if (notes) {
      notes(fmt::format("the stored settings are {}: {} starts with its own",
                        whole ? "of another model or version" : "damaged", model.name));
    }
    return settings;
  }
  std::span<const std::uint8_t> bytes = std::span(*block).subspan(head);
  for_each_number(settings, [&](std::int32_t& number) {
    number = static_cast<std::int32_t>(
        protocol::load(bytes.first(4), WireType::kI32, kTable.framing.order));
    bytes = bytes.subspan(4);
  });
  return settings;
}

std::optional<Values> Parameters::read(std::uint8_t pid, std::uint8_t index) const {
  const ParameterRow* row = table_.parameter(pid);
  if (row == nullptr || row->access == Access::kWriteOnly) return std::nullopt;
  const Context context{controller_, table_, index};
  if (const Block* block = protocol::find(kBlocks, pid)) {
    auto values = block->read(context);
    if (values) values->pad(protocol::value_fields(*row));
    return values;
  }
  return Values{controller_.settings().**protocol::find(kSettingRows, pid)};
}

bool Parameters::write(std::uint8_t pid, const Values& values) {
  const ParameterRow* row = table_.parameter(pid);
  if (row == nullptr || row->access == Access::kReadOnly) return false;
  if (pid == kComTarSpeed) {
    controller_.set_com_tar_speed(static_cast<std::int32_t>(values[0]));
    return true;
  }
  Settings settings = controller_.settings();
  if (const Block* block = protocol::find(kBlocks, pid)) {
    if (block->write == nullptr || !block->write(settings, values)) return false;
  } else {
    const bool checked = is_checked(pid);
    if (checked && values[0] != kWriteCheck) return false;
    const std::int64_t value = values[checked ? 1 : 0];
    const bool is_number = protocol::width(row->type) > 1;
    if (!is_number && !row->range.contains(value)) return false;
    if (pid == kInputType && value == kNoInputType) return false;
    settings.**protocol::find(kSettingRows, pid) =
        static_cast<std::int32_t>(std::clamp(value, row->range.minimum, row->range.maximum));
  }
  change(settings);
  return true;
}

void Parameters::to_defaults() {
  const Settings& now = controller_.settings();
  Settings settings = md::default_settings(table_.model());
  settings.id = now.id;
  settings.baud_code = now.baud_code;
  settings.can_bitrate = now.can_bitrate;
  change(settings);
}

void Parameters::change(const Settings& settings) {
  controller_.set_settings(settings);
  memory_.write(kBlock, to_block(table_.model(), settings));
}

}  // namespace virtdrive::md485
