#include "devices/toshiba_mcu/device.h"

#include <cstdlib>
#include <fmt/format.h>
#include <utility>
#include <variant>

#include "devices/protocol/binding.h"

namespace virtdrive::toshiba_mcu {
namespace {

using protocol::Values;
using namespace std::chrono_literals;

constexpr SimDuration kLenientSilence = 100ms;
constexpr std::int64_t kCrcError = 1;
constexpr std::int64_t kInvalidParameter = 1;

using Target = std::variant<Device::Handler, Device::MotorHandler>;

constexpr auto kHandlers = std::to_array<protocol::Binding<Target>>({
    {0x00, &Device::start_motor},
    {0x01, &Device::stop_motor},
    {0x02, &Device::motor_state},
    {0x03, &Device::store_parameters},
    {0x04, &Device::clear_parameters},
    {0x05, &Device::configure_snapshot},
    {0x06, &Device::snapshot_data},
    {0x07, &Device::configure_stream},
    {0x08, &Device::do_turn},
    {0x09, &Device::get_one},
    {0x0A, &Device::set_one},
    {0x0B, &Device::get_many},
    {0x0C, &Device::set_many},
    {0x0D, &Device::do_linear_motion},
    {0x0E, &Device::absolute_position},
    {0x0F, &Device::abort_linear_motion},
    {0x10, &Device::start_torque_control},
    {0x11, &Device::control_method},
    {0x12, &Device::set_control_method},
    {0x13, &Device::encoder_counter},
    {0x14, &Device::version},
    {0x21, &Device::set_demo_state},
    {0x22, &Device::demo_state},
    {0x23, &Device::extended_state},
});
static_assert(protocol::covers(kTable.commands, kHandlers),
              "a command that is not rejected has no handler, or the reverse");

constexpr std::int64_t error_code(Outcome outcome) {
  return outcome == Outcome::kNotReady ? -2 : -1;
}

}  // namespace

Device::Device(EventLoop& loop, SerialPort& port, Firmware& firmware, NonVolatileMemory& memory,
               DeviceOptions options, WireListener listener, NoteListener notes,
               SerialPort* stream_port)
    : loop_(loop),
      port_(port),
      firmware_(firmware),
      parameters_(firmware, memory),
      options_(options),
      log_(loop, std::move(listener), std::move(notes)),
      answer_due_(loop.add(Phase::kDevice, [this] { answer(); })),
      answer_out_(loop.add(Phase::kDevice, [this] { listen_again(); })),
      silence_(loop.add(Phase::kDevice, [this] {
        log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "cut short, given up");
        decoder_.reset();
      })) {
  parameters_.restore();
  if (stream_port == nullptr) return;
  stream_.emplace(loop, *stream_port);
  firmware_.stream_scope().set_sink(
      [this](std::uint16_t timestamp, std::span<const std::int16_t> values) {
        stream_->send(timestamp, values);
      });
}

Device::~Device() {
  firmware_.stream_scope().set_sink(nullptr);
}

// --- Listening -----------------------------------------------------------------------------------

void Device::receive(std::uint8_t byte) {
  if (busy_)
    keep_or_lose(byte);
  else
    hear(byte);
}

void Device::keep_or_lose(std::uint8_t byte) {
  // The receive interrupt is off while a request is handled: the UART's register holds one byte.
  const std::size_t room = options_.lenient ? kMostKept : 1;
  if (kept_.size() < room) {
    kept_.push_back(byte);
    return;
  }
  log_.tell(WireEvent::Kind::kLost, std::span(&byte, 1), "came while the drive was busy");
}

void Device::hear(std::uint8_t byte) {
  using Event = Decoder::Event;
  const Event event = decoder_.push(byte);
  if (options_.lenient) {
    if (decoder_.idle())
      silence_.cancel();
    else
      silence_.at(loop_.now() + kLenientSilence);
  }
  switch (event) {
    case Event::kNone:
      return;
    case Event::kNoise:
      log_.tell(WireEvent::Kind::kBadFrame, std::span(&byte, 1), "outside of a telegram");
      return;
    case Event::kUnknownCommand:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "unknown command, no answer");
      return;
    case Event::kBadEnd:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "wrong end byte, no answer");
      return;
    case Event::kBadCrc:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "wrong CRC");
      break;
    case Event::kTelegram: {
      const Telegram& telegram = decoder_.telegram();
      log_.tell(WireEvent::Kind::kRequest, decoder_.bytes(),
                log_.has_listener() ? fmt::format("{} {}", telegram.row->name,
                                                  describe(telegram.row->request, telegram.values))
                                    : std::string());
      break;
    }
  }
  busy_ = true;
  crc_fits_ = event == Event::kTelegram;
  answer_due_.at(loop_.now() + options_.latency);
}

// --- Answering -----------------------------------------------------------------------------------

void Device::answer() {
  if (crc_fits_)
    answer_request();
  else
    send(encode_reply(kErrorReply, {kCrcError}), "Error crc");
}

void Device::answer_request() {
  const Telegram& request = decoder_.telegram();
  Values reply;
  const Outcome outcome = handle(request, reply);
  if (outcome != Outcome::kDone) {
    send(encode_reply(kErrorReply, {error_code(outcome)}),
         outcome == Outcome::kRefused ? "Error refused" : "Error not ready");
    return;
  }
  log_.note_use(request.row->name, request.row->support);
  reply.pad(request.row->reply);
  send(encode_reply(*request.row, reply),
       log_.has_listener()
           ? fmt::format("{} {}", request.row->name, describe(request.row->reply, reply))
           : std::string());
}

Outcome Device::handle(const Telegram& request, Values& reply) {
  const Target* target = protocol::find(kHandlers, request.row->code);
  if (target == nullptr) return Outcome::kRefused;
  if (const Handler* handler = std::get_if<Handler>(target)) {
    return (this->**handler)(request.values, reply);
  }
  PowerBoard* const board = this->board(request.values[0]);
  if (board == nullptr) return Outcome::kRefused;
  return (this->*std::get<MotorHandler>(*target))(*board, request.values, reply);
}

void Device::send(const std::vector<std::uint8_t>& bytes, std::string_view text) {
  log_.tell(WireEvent::Kind::kReply, bytes, text);
  answer_out_.at(port_.send(bytes));
}

void Device::listen_again() {
  busy_ = false;
  while (!busy_ && !kept_.empty()) {
    const std::uint8_t byte = kept_.front();
    kept_.pop_front();
    hear(byte);
  }
}

// --- Commands ------------------------------------------------------------------------------------

PowerBoard* Device::board(std::int64_t motor_nr) {
  const auto channel = static_cast<std::size_t>(motor_nr);
  return channel < firmware_.channels() ? &firmware_.board(channel) : nullptr;
}

Outcome Device::start_motor(PowerBoard& board, const Values&, Values&) {
  return board.start();
}

Outcome Device::stop_motor(PowerBoard& board, const Values&, Values&) {
  return board.stop();
}

Outcome Device::motor_state(PowerBoard& board, const Values&, Values& reply) {
  const MotorChannel& channel = board.channel();
  reply = {channel.actual_rpm(), channel.target_rpm(), channel.current_ma(), channel.torque(),
           firmware_.tick()};
  return Outcome::kDone;
}

Outcome Device::control_method(PowerBoard& board, const Values&, Values& reply) {
  reply.push(static_cast<std::int64_t>(board.channel().method()));
  return Outcome::kDone;
}

Outcome Device::extended_state(PowerBoard& board, const Values& request, Values& reply) {
  const MotorChannel& channel = board.channel();
  if (channel.method() != Method::kTorque) {
    motor_state(board, request, reply);
  } else {
    reply = {channel.torque(), channel.target_torque(), channel.current_ma(),
             std::abs(channel.actual_rpm()), firmware_.tick()};
  }
  return control_method(board, request, reply);
}

Outcome Device::start_torque_control(PowerBoard& board, const Values&, Values&) {
  return board.start_torque_control();
}

Outcome Device::set_control_method(PowerBoard& board, const Values& request, Values& reply) {
  const auto method = static_cast<Method>(request[1]);
  const bool valid = method == Method::kSpeed || method == Method::kTorque;
  if (valid) board.set_method(method);
  reply.push(valid ? 0 : kInvalidParameter);
  return Outcome::kDone;
}

Outcome Device::store_parameters(const Values& request, Values&) {
  const bool stored =
      board(request[0]) != nullptr && parameters_.store(static_cast<std::size_t>(request[0]));
  return stored ? Outcome::kDone : Outcome::kRefused;
}

Outcome Device::clear_parameters(const Values&, Values&) {
  return parameters_.clear() ? Outcome::kDone : Outcome::kRefused;
}

// --- Oscilloscopes -------------------------------------------------------------------------------

Outcome Device::configure_snapshot(PowerBoard&, const Values& request, Values& reply) {
  reply.push(firmware_.snapshot_scope().arm({.motor = static_cast<std::size_t>(request[0]),
                                             .selected = static_cast<std::uint32_t>(request[1]),
                                             .trigger_on = static_cast<std::uint32_t>(request[2]),
                                             .mode = static_cast<std::uint8_t>(request[3]),
                                             .level = static_cast<std::int16_t>(request[4]),
                                             .spread = static_cast<std::uint8_t>(request[5])}));
  return Outcome::kDone;
}

Outcome Device::snapshot_data(const Values&, Values& reply) {
  std::array<std::int16_t, SnapshotScope::kBlock> block{};
  const Outcome outcome = firmware_.snapshot_scope().next_block(block);
  if (outcome == Outcome::kDone) {
    for (const std::int16_t value : block) reply.push(value);
  }
  return outcome;
}

Outcome Device::configure_stream(PowerBoard&, const Values& request, Values&) {
  StreamScope& scope = firmware_.stream_scope();
  if (request[1] == 0) {
    scope.disable();
    return Outcome::kDone;
  }
  if (!stream_) log_.note("ConfigureHsDSO streams on a second line that is not wired");
  return scope.enable(static_cast<std::size_t>(request[0]), static_cast<std::uint32_t>(request[2]),
                      static_cast<std::uint8_t>(request[3]));
}

// --- Motion --------------------------------------------------------------------------------------

Outcome Device::do_turn(PowerBoard& board, const Values& request, Values&) {
  return board.do_turn(static_cast<std::int32_t>(request[1]),
                       static_cast<std::int32_t>(request[2]));
}

Outcome Device::do_linear_motion(PowerBoard& board, const Values& request, Values& reply) {
  const bool taken = board.do_linear_motion(static_cast<std::uint32_t>(request[1]),
                                            static_cast<std::int32_t>(request[2]));
  reply.push(taken ? 0 : kInvalidParameter);
  return Outcome::kDone;
}

Outcome Device::absolute_position(PowerBoard& board, const Values&, Values& reply) {
  reply.push(board.absolute_position());
  return Outcome::kDone;
}

Outcome Device::abort_linear_motion(PowerBoard& board, const Values&, Values&) {
  board.abort_linear_motion();
  return Outcome::kDone;
}

Outcome Device::encoder_counter(PowerBoard& board, const Values&, Values& reply) {
  reply.push(board.encoder_count());
  return Outcome::kDone;
}

// --- The system ----------------------------------------------------------------------------------

Outcome Device::set_demo_state(const Values& request, Values&) {
  firmware_.set_demo_state(static_cast<std::uint8_t>(request[0]));
  return Outcome::kDone;
}

Outcome Device::demo_state(const Values&, Values& reply) {
  reply.push(firmware_.demo_state());
  return Outcome::kDone;
}

Outcome Device::version(const Values&, Values& reply) {
  reply = {kIdentity.version_major, kIdentity.version_minor};
  return Outcome::kDone;
}

Outcome Device::get_one(const Values& request, Values& reply) {
  UnitValue result;
  const Outcome outcome =
      parameters_.read(static_cast<std::uint8_t>(request[0]), static_cast<std::uint8_t>(request[1]),
                       static_cast<std::uint8_t>(request[2]), result);
  reply = {result.value, result.unit};
  return outcome;
}

Outcome Device::write(std::uint8_t motor_nr, std::uint8_t id, UnitValue value) {
  const Outcome outcome = parameters_.write(motor_nr, id, value);
  if (outcome == Outcome::kDone) {
    const ParameterRow& row = *protocol::find(kTable.parameters, id);
    log_.note_use(row.name, row.support);
  }
  return outcome;
}

Outcome Device::set_one(const Values& request, Values&) {
  return write(static_cast<std::uint8_t>(request[0]), static_cast<std::uint8_t>(request[1]),
               {static_cast<std::int32_t>(request[3]), static_cast<std::int8_t>(request[2])});
}

Outcome Device::get_many(const Values& request, Values& reply) {
  // error, offset, then the slots: the first that fails ends the work, its index is the offset.
  const auto entries = static_cast<std::size_t>(request[1]);
  const auto motor_nr = static_cast<std::uint8_t>(request[0]);
  if (board(motor_nr) == nullptr && motor_nr != kAllMotors) return Outcome::kRefused;
  if (entries < 1 || entries > kTransferCount) {
    reply = {1, 0};
    return Outcome::kDone;
  }
  Values slots;
  std::size_t done = 0;
  for (; done < entries; ++done) {
    UnitValue result;
    if (parameters_.read(motor_nr, static_cast<std::uint8_t>(request[2 + 2 * done]),
                         static_cast<std::uint8_t>(request[3 + 2 * done]),
                         result) != Outcome::kDone) {
      break;
    }
    slots.push(result.value);
    slots.push(result.unit);
  }
  const bool failed = done < entries;
  reply = {failed ? 1 : 0, failed ? static_cast<std::int64_t>(done) : 0};
  for (std::size_t i = 0; i < slots.size(); ++i) reply.push(slots[i]);
  return Outcome::kDone;
}

Outcome Device::set_many(const Values& request, Values& reply) {
  const auto entries = static_cast<std::size_t>(request[1]);
  const auto motor_nr = static_cast<std::uint8_t>(request[0]);
  if (board(motor_nr) == nullptr) return Outcome::kRefused;
  if (entries < 1 || entries > kTransferCount) {
    reply = {1, 0};
    return Outcome::kDone;
  }
  for (std::size_t i = 0; i < entries; ++i) {
    const UnitValue value{static_cast<std::int32_t>(request[4 + 3 * i]),
                          static_cast<std::int8_t>(request[3 + 3 * i])};
    if (write(motor_nr, static_cast<std::uint8_t>(request[2 + 3 * i]), value) != Outcome::kDone) {
      reply = {1, static_cast<std::int64_t>(i)};
      return Outcome::kDone;
    }
  }
  reply = {0, 0};
  return Outcome::kDone;
}

}  // namespace virtdrive::toshiba_mcu
