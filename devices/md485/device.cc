#include "devices/md485/device.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "devices/protocol/binding.h"

namespace virtdrive::md485 {
namespace {

using md::MotorChannel;
using protocol::Binding;
using protocol::Values;
using namespace std::chrono_literals;
using S = md::Settings;

constexpr SimDuration kWriteTime = 5ms;     // of the flash (assumed)
constexpr SimDuration kDefaultTime = 50ms;  // of PID 3 (assumed)
/// What nobody asked for tries again after so long where it found the line taken.
constexpr SimDuration kTryAgain = 1ms;

constexpr std::uint8_t kMonitorPid = 196, kIoMonitorPid = 194, kAckPid = 7;
constexpr std::uint8_t kPntMonitorPid = 216, kPntMainDataPid = 210;
constexpr std::uint8_t kMainDataPid = 193, kCurvePid = 226, kStepPid = 225, kPresetPid = 227;

constexpr auto kHandlers = std::to_array<Binding<Device::Handler>>({
    {3, &Device::default_set},        {4, &Device::request_data},
    {5, &Device::free_all},           {6, &Device::brake_all},
    {10, &Device::command_number},    {12, &Device::reset_alarms},
    {13, &Device::reset_positions},   {14, &Device::main_broadcast},
    {15, &Device::monitor_broadcast}, {30, &Device::save_preset},
    {31, &Device::recall_preset},     {100, &Device::start_stop},
    {130, &Device::velocity},         {131, &Device::velocity2},
    {134, &Device::open_loop},        {140, &Device::torque},
    {164, &Device::request_data},     {174, &Device::pnt_free},
    {175, &Device::pnt_brake},        {184, &Device::function_signal},
    {206, &Device::pnt_move},         {207, &Device::pnt_velocity},
    {208, &Device::pnt_open_loop},    {209, &Device::pnt_torque},
    {215, &Device::pnt_increment},    {217, &Device::set_position},
    {218, &Device::set_position2},    {219, &Device::move},
    {220, &Device::increment},        {242, &Device::pnt_increment_at},
    {243, &Device::move_default},     {244, &Device::increment_default},
    {246, &Device::pnt_move_default}, {251, &Device::increment_default2},
});
static_assert(protocol::covers(kTable.commands, kHandlers),
              "a command that is not rejected has no handler, or the reverse");

constexpr auto kNumbers = std::to_array<Binding<Device::NumberHandler>>({
    {2, &Device::free_all_now},
    {4, &Device::brake_all_now},
    {5, &Device::broadcast<193, true>},
    {6, &Device::broadcast<193, false>},
    {8, &Device::reset_alarms_now},
    {10, &Device::reset_positions_now},
    {11, &Device::broadcast<196, true>},
    {12, &Device::broadcast<196, false>},
    {13, &Device::broadcast<194, true>},
    {14, &Device::broadcast<194, false>},
    {15, &Device::fan<true>},
    {16, &Device::fan<false>},
    {17, &Device::clutch<true>},
    {18, &Device::clutch<false>},
    {20, &Device::clear<&S::tar_vel>},
    {21, &Device::clear<&S::slow_start>},
    {22, &Device::clear<&S::slow_down>},
    {23, &Device::resend_can<true>},
    {24, &Device::resend_can<false>},
    {25, &Device::to_default<&S::max_load>},
    {26, &Device::to_default<&S::enc_ppr>},
    {27, &Device::clear<&S::low_speed_limit>},
    {28, &Device::clear<&S::high_speed_limit>},
    {29, &Device::clear<&S::low_speed_limit, &S::high_speed_limit>},
    {31, &Device::clear_curve},
    {32, &Device::clear<&S::input_type>},
    {44, &Device::let_drive<false>},
    {45, &Device::let_drive<true>},
    {46, &Device::to_default<&S::max_rpm>},
    {47, &Device::to_default<&S::hall_type>},
    {48, &Device::clear<&S::low_volume_limit>},
    {49, &Device::clear<&S::high_volume_limit>},
    {50, &Device::broadcast<200, true>},
    {51, &Device::broadcast<200, false>},
    {52, &Device::broadcast<201, true>},
    {53, &Device::broadcast<201, false>},
    {54, &Device::broadcast<202, true>},
    {55, &Device::broadcast<202, false>},
    {61, &Device::broadcast<210, true>},
    {62, &Device::broadcast<210, false>},
});
static_assert(protocol::covers(kTable.functions, kNumbers),
              "a command number that is not rejected has no handler, or the reverse");

// These carry a return type of their own, or are requests: RETURN_TYPE is not for them.
constexpr std::uint8_t kAnswerThemselves[] = {4, 164, 174, 175, 206, 207, 208, 209, 215, 242, 246};
bool answers_by_itself(std::uint8_t pid) {
  return std::ranges::find(kAnswerThemselves, pid) != std::end(kAnswerThemselves);
}

std::string describe(const Frame& frame) {
  if (frame.command != nullptr) {
    return fmt::format("{} {}", frame.command->name,
                       protocol::describe(frame.command->request, frame.values));
  }
  const bool text = frame.parameter->type == WireType::kText;
  return fmt::format("{} {}", frame.parameter->name,
                     text ? "" : protocol::describe(write_fields(*frame.parameter), frame.values));
}

}  // namespace

Device::Device(EventLoop& loop, SerialPort& port, md::Controller& controller,
               const ModelTable& table, NonVolatileMemory& memory, DeviceOptions options,
               WireListener listener, NoteListener notes)
    : loop_(loop),
      controller_(controller),
      table_(table),
      parameters_(controller, table, memory),
      options_(options),
      log_(loop, std::move(listener), std::move(notes)),
      rs485_(loop, port, log_, taker()),
      work_(loop.add(Phase::kDevice, [this] { work(); })),
      broadcast_(loop.add(Phase::kDevice, [this] { broadcast_due(); })) {}

// --- Listening -----------------------------------------------------------------------------------

Port::Taker Device::taker() {
  return [this](Port& from, const Frame& frame, auto bytes) { take(from, frame, bytes); };
}

SerialReceiver& Device::add_serial(SerialPort& port) {
  return *other_uarts_.emplace_back(std::make_unique<UartPort>(loop_, port, log_, taker()));
}

CanReceiver& Device::add_can(CanPort& port) {
  can_ = std::make_unique<CanBusPort>(loop_, port, log_, taker(),
                                      [this](const CanFrame& frame) { hear_on_can(frame); });
  return *can_;
}

void Device::take(Port& from, const Frame& frame, std::span<const std::uint8_t> bytes) {
  if (frame.route.id != id() && frame.route.id != kAllControllers) return;
  if (queue_.size() >= kMostQueued) {
    log_.tell(WireEvent::Kind::kLost, bytes, "too many frames are waiting");
    return;
  }
  log_.tell(WireEvent::Kind::kRequest, bytes,
            log_.has_listener() ? describe(frame) : std::string());
  queue_.push_back({frame, &from});
  if (work_.due() == kNever) work_.at(loop_.now());
}

// --- One frame after the other -------------------------------------------------------------------

void Device::work() {
  if (reply_) {
    const Reply reply = *std::exchange(reply_, std::nullopt);
    send(reply);
    return;
  }
  while (!queue_.empty()) {
    current_ = queue_.front();
    queue_.pop_front();
    takes_ = {};
    act(current_.frame);
    if (reply_) takes_ += options_.latency;
    if (takes_ > SimDuration{} || reply_) {
      work_.at(loop_.now() + takes_);
      return;
    }
  }
}

void Device::act(const Frame& frame) {
  controller_.frame_came();
  if (frame.command != nullptr) {
    const CommandRow* row = table_.command(frame.pid);
    if (row == nullptr) return;
    (this->**protocol::find(kHandlers, frame.pid))(frame.values);
    if (!answers_by_itself(frame.pid)) answer_by_return_type();
    return;
  }
  if (!parameters_.write(frame.pid, frame.values)) return;
  takes_ = kWriteTime;
  log_.note_use(frame.parameter->name, table_.parameter(frame.pid)->support);
  answer_by_return_type();
}

void Device::answer(std::uint8_t pid, std::uint8_t index) {
  reply_ = Reply{.route = {.host = current_.frame.route.host, .id = id()},
                 .pid = pid,
                 .index = index,
                 .port = current_.from};
}

void Device::answer_by_return_type() {
  constexpr std::array<std::uint8_t, 4> kPids = {0, kMonitorPid, kAckPid, kIoMonitorPid};
  const std::uint8_t pid = kPids[static_cast<std::size_t>(controller_.settings().return_type)];
  if (pid != 0 && current_.frame.route.id != kAllControllers) answer(pid, current_.frame.pid);
}

// Two single controllers that were addressed together would answer together: they do not.
void Device::return_pnt(std::int64_t type) {
  if (!is_dual() && current_.frame.route.id == kAllControllers) return;
  if (type == 1) answer(kPntMonitorPid);
  if (type == 2) answer(kPntMainDataPid);
}

void Device::send(const Reply& reply) {
  const bool acknowledges = reply.pid == kAckPid;
  const auto values =
      acknowledges ? std::optional(Values{reply.index}) : parameters_.read(reply.pid, reply.index);
  const ParameterRow* row =
      acknowledges ? protocol::find(kTable.parameters, kAckPid) : table_.parameter(reply.pid);
  if (!values || row == nullptr) {
    if (!queue_.empty()) work_.at(loop_.now());
    return;
  }
  work_.at(reply.port->send(reply.route, *row, *values));
}

// --- Broadcasts ----------------------------------------------------------------------------------

void Device::set_broadcast(std::uint8_t pid, bool on) {
  const auto it = std::ranges::find(broadcasts_, pid, &Broadcast::pid);
  if (on && it->port == nullptr) it->due = loop_.now() + options_.broadcast_period;
  it->port = on ? current_.from : nullptr;
  it->host = current_.frame.route.host;
  schedule_broadcasts();
}

void Device::schedule_broadcasts() {
  SimTime next = heard_on_can_.empty() ? kNever : loop_.now();
  for (const Broadcast& b : broadcasts_) {
    if (b.port != nullptr) next = std::min(next, b.due);
  }
  if (next == kNever)
    broadcast_.cancel();
  else
    broadcast_.at(std::max(next, loop_.now()));
}

void Device::broadcast_due() {
  if (work_.due() != kNever) {  // an answer goes first
    broadcast_.at(loop_.now() + kTryAgain);
    return;
  }
  bool busy = false;
  for (Broadcast& b : broadcasts_) {
    if (b.port == nullptr || b.due > loop_.now()) continue;
    if (!b.port->is_free()) {
      busy = true;
      continue;
    }
    b.due = std::max(b.due + options_.broadcast_period, loop_.now());
    send({.route = {.host = b.host, .id = id()}, .pid = b.pid, .port = b.port});
  }
  resend();
  schedule_broadcasts();
  if (busy || !heard_on_can_.empty()) broadcast_.at(loop_.now() + kTryAgain);
}

// --- What is heard on CAN (CMD 23) ---------------------------------------------------------------

void Device::hear_on_can(const CanFrame& frame) {
  if (!resend_to_ || !frame.extended || frame.bytes().empty()) return;
  if (heard_on_can_.size() >= kMostHeard) {
    log_.tell(WireEvent::Kind::kLost, frame.bytes(), "RS-485 is slower than CAN");
    return;
  }
  heard_on_can_.push_back(frame);
  schedule_broadcasts();
}

void Device::resend() {
  if (heard_on_can_.empty() || !rs485_.is_free() || work_.due() != kNever) return;
  work_.at(rs485_.send_heard({.host = *resend_to_, .id = id()}, heard_on_can_.front()));
  heard_on_can_.pop_front();
}

// --- Reports -------------------------------------------------------------------------------------

void Device::change(const md::Settings& settings) {
  parameters_.change(settings);
  takes_ = kWriteTime;
}

// --- Commands: the controller as a whole ---------------------------------------------------------

void Device::default_set(const Values& request) {
  if (request[0] != kDefaultCheck) return;
  free_all_now();
  parameters_.to_defaults();
  takes_ = kDefaultTime;
}

void Device::request_data(const Values& request) {
  const auto pid = static_cast<std::uint8_t>(request[0]);
  const bool indexed = request.size() > 1;
  if (indexed && pid != kStepPid && pid != kCurvePid && pid != kPresetPid) return;
  const auto index = indexed ? static_cast<std::uint8_t>(request[1]) : std::uint8_t{1};
  if (parameters_.read(pid, index)) answer(pid, index);
}

void Device::free_all_now() {
  for (std::size_t i = 0; i < controller_.motors(); ++i) controller_.free(i);
}
void Device::brake_all_now() {
  for (std::size_t i = 0; i < controller_.motors(); ++i) controller_.brake(i);
}
void Device::reset_positions_now() {
  for (std::size_t i = 0; i < controller_.motors(); ++i) controller_.set_position(i, 0);
}
void Device::free_all(const Values&) {
  free_all_now();
}
void Device::brake_all(const Values&) {
  brake_all_now();
}
void Device::reset_alarms(const Values&) {
  reset_alarms_now();
}
void Device::reset_positions(const Values&) {
  reset_positions_now();
}

void Device::command_number(const Values& request) {
  const auto number = static_cast<std::uint8_t>(request[0]);
  if (table_.number(number) != nullptr) (this->**protocol::find(kNumbers, number))();
}

void Device::clear_curve() {
  md::Settings settings = controller_.settings();
  settings.curve = {};
  change(settings);
}

void Device::main_broadcast(const Values& request) {
  if (request[0] <= 1) set_broadcast(kMainDataPid, request[0] == 1);
}
void Device::monitor_broadcast(const Values& request) {
  if (request[0] <= 1) set_broadcast(kMonitorPid, request[0] == 1);
}

void Device::save_preset(const Values& request) {
  if (request[0] < 1 || request[0] > static_cast<std::int64_t>(md::kPresets)) return;
  controller_.save_preset(static_cast<std::size_t>(request[0]));
  change(controller_.settings());
}

void Device::recall_preset(const Values& request) {
  if (request[0] < 1 || request[0] > static_cast<std::int64_t>(md::kPresets)) return;
  const auto& preset = controller_.settings().presets[static_cast<std::size_t>(request[0] - 1)];
  for (std::size_t i = 0; i < controller_.motors(); ++i) {
    if (MotorChannel* motor = controller_.by_frame(i)) {
      motor->move_to(preset[i], controller_.settings().tar_posi_vel);
    }
  }
}

void Device::start_stop(const Values& request) {
  if (request[0] <= 2) controller_.start_stop(static_cast<int>(request[0]));
}

void Device::function_signal(const Values& request) {
  controller_.function_signal(request[0] >= 1);
}

void Device::set_position(const Values& request) {
  controller_.set_position(0, static_cast<std::int32_t>(request[0]));
}
void Device::set_position2(const Values& request) {
  controller_.set_position(1, static_cast<std::int32_t>(request[0]));
}

// --- Commands: one motor -------------------------------------------------------------------------

void Device::velocity(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) motor->speed(double(request[0]));
}

void Device::velocity2(const Values& request) {
  constexpr double kRpmOfStep = 10;
  MotorChannel* motor = controller_.by_frame(is_dual() ? 1 : 0);
  if (motor != nullptr) motor->speed(double(request[0]) * (is_dual() ? 1 : kRpmOfStep));
}

void Device::open_loop(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) motor->open_loop(double(request[0]));
}

void Device::torque(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) motor->torque(double(request[0]));
}

namespace {

// A speed of 0 is half of the highest (p. 24).
double move_rpm(const md::Settings& settings, std::int64_t rpm) {
  return rpm != 0 ? double(rpm) : settings.max_rpm / 2.0;
}

}  // namespace

void Device::move(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) {
    motor->move_to(static_cast<std::int32_t>(request[0]),
                   move_rpm(controller_.settings(), request[1]));
  }
}
void Device::increment(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) {
    motor->move_by(static_cast<std::int32_t>(request[0]),
                   move_rpm(controller_.settings(), request[1]));
  }
}
void Device::move_default(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) {
    motor->move_to(static_cast<std::int32_t>(request[0]), controller_.settings().tar_posi_vel);
  }
}
void Device::increment_default(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(0)) {
    motor->move_by(static_cast<std::int32_t>(request[0]), controller_.settings().tar_posi_vel);
  }
}
void Device::increment_default2(const Values& request) {
  if (MotorChannel* motor = controller_.by_frame(1)) {
    motor->move_by(static_cast<std::int32_t>(request[0]), controller_.settings().tar_posi_vel);
  }
}

// --- Commands: two motors, or two controllers (p. 31) --------------------------------------------

// On a dual controller a byte that is not 0 means the motor of its half. A single one is meant by
// the half that holds its ID.
template <class Move>
void Device::for_meant(std::int64_t enable1, std::int64_t enable2, Move&& move) {
  const std::array<std::int64_t, 2> enables = {enable1, enable2};
  for (std::size_t half = 0; half < 2; ++half) {
    if (is_dual() ? enables[half] != 0 : enables[half] == id()) move(is_dual() ? half : 0, half);
  }
}

template <class Move>
void Device::for_halves(std::int64_t enable1, std::int64_t enable2, Move&& move) {
  for_meant(enable1, enable2, [&](std::size_t number, std::size_t half) {
    if (MotorChannel* motor = controller_.by_frame(number)) move(*motor, half);
  });
}

void Device::pnt_free(const Values& request) {
  if (request[0] != 0) controller_.free(0);
  if (request[1] != 0 && is_dual()) controller_.free(1);
  return_pnt(request[2]);
}

void Device::pnt_brake(const Values& request) {
  if (request[0] != 0) controller_.brake(0);
  if (request[1] != 0 && is_dual()) controller_.brake(1);
  return_pnt(request[2]);
}

void Device::pnt_velocity(const Values& request) {
  for_halves(request[0], request[2], [&](MotorChannel& motor, std::size_t half) {
    motor.speed(double(request[1 + 2 * half]));
  });
  return_pnt(request[4]);
}

void Device::pnt_open_loop(const Values& request) {
  for_halves(request[0], request[2], [&](MotorChannel& motor, std::size_t half) {
    motor.open_loop(double(request[1 + 2 * half]));
  });
  return_pnt(request[4]);
}

void Device::pnt_torque(const Values& request) {
  for_halves(request[0], request[2], [&](MotorChannel& motor, std::size_t half) {
    motor.torque(double(request[1 + 2 * half]));
  });
  return_pnt(request[4]);
}

void Device::pnt_move(const Values& request) {
  for_halves(request[0], request[3], [&](MotorChannel& motor, std::size_t half) {
    motor.move_to(static_cast<std::int32_t>(request[1 + 3 * half]),
                  move_rpm(controller_.settings(), request[2 + 3 * half]));
  });
  return_pnt(request[6]);
}

void Device::pnt_increment_at(const Values& request) {
  for_halves(request[0], request[3], [&](MotorChannel& motor, std::size_t half) {
    motor.move_by(static_cast<std::int32_t>(request[1 + 3 * half]),
                  move_rpm(controller_.settings(), request[2 + 3 * half]));
  });
  return_pnt(request[6]);
}

void Device::pnt_increment(const Values& request) {
  for_halves(request[0], request[2], [&](MotorChannel& motor, std::size_t half) {
    motor.move_by(static_cast<std::int32_t>(request[1 + 2 * half]),
                  controller_.settings().tar_posi_vel);
  });
  return_pnt(request[4]);
}

void Device::pnt_move_default(const Values& request) {
  for_halves(request[0], request[2], [&](MotorChannel& motor, std::size_t half) {
    motor.move_to(static_cast<std::int32_t>(request[1 + 2 * half]),
                  controller_.settings().tar_posi_vel);
  });
  if (is_dual())
    return_pnt(request[4]);
  else if (request[4] == id())
    answer(kMonitorPid);
}

}  // namespace virtdrive::md485
