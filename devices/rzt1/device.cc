#include "devices/rzt1/device.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "core/check.h"
#include "devices/protocol/binding.h"

namespace virtdrive::rzt1 {
namespace {

using protocol::Binding;
using protocol::Values;
using Bytes = std::vector<std::uint8_t>;
using namespace std::chrono_literals;

constexpr SimDuration kLenientSilence = 100ms;
/// Before an absolute encoder is set up the firmware waits, its main loop stands still (5.3).
constexpr SimDuration kEncoderWait = 150ms;
/// Bytes that the transmitter buffers; the foreground waits until the rest has found room.
constexpr std::int64_t kTransmitBuffer = 1024;
constexpr int kBitsPerCharacter = 10;

constexpr auto kHandlers = std::to_array<Binding<Device::Handler>>({
    {0, &Device::module_data},
    {1, &Device::report},
    {2, &Device::call_function},
    {3, &Device::init_pvt},
    {4, &Device::stream_pvt},
    {5, &Device::set_parameter},
    {6, &Device::get_parameter},
    {7, &Device::get_trace},
    {15, &Device::set_baud},
});
static_assert(protocol::covers(kTable.commands, kHandlers),
              "a packet that is not rejected has no handler, or the reverse");

constexpr std::uint16_t kGo = 85, kReset = 88, kPlay = 108, kSave = 115, kRestore = 116;
constexpr std::uint16_t kTargetId = 80, kVersionId = 97, kAddressId = 123;

std::string block_name(std::size_t axis) {
  return fmt::format("axis{}", axis + 1);
}

std::string_view name_of(Status status) {
  for (const CodeRow& row : kErrors) {
    if (row.code == static_cast<std::int32_t>(status)) return row.name;
  }
  return "?";
}

std::string describe(const Packet& packet) {
  if (packet.row == nullptr) return fmt::format("unknown code, to {}", packet.address);
  std::string text(packet.row->name);
  if (packet.function != nullptr) text += fmt::format(" {}", packet.function->name);
  if (packet.parameter != nullptr) text += fmt::format(" {}", packet.parameter->name);
  const std::size_t first = packet.row->names == Names::kNothing ? 0 : 1;
  for (std::size_t i = first; i < packet.values.size(); ++i) {
    text += fmt::format(" {}", packet.values[i]);
  }
  return text + fmt::format(" to {}", packet.address);
}

std::string printable(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += byte >= ' ' && byte <= '~' ? static_cast<char>(byte) : '.';
  }
  return text;
}

std::size_t index_of(std::uint32_t axis) {
  return axis - 1;
}

}  // namespace

Settings stored_settings(std::size_t axis, NonVolatileMemory& memory, const NoteListener& notes) {
  const Settings factory = factory_settings(static_cast<int>(axis) + 1);
  const auto block = memory.read(block_name(axis));
  if (!block) return factory;
  Settings settings = factory;
  if (unpack(*block, settings)) return settings;
  if (notes) {
    notes(
        fmt::format("the parameters saved of axis {} are damaged; it has the factory's", axis + 1));
  }
  return factory;
}

// --- A console -----------------------------------------------------------------------------------

class Device::Console final : public SerialReceiver {
 public:
  Console(Device& device, SerialPort* port)
      : device_(device),
        port_(port),
        answer_due_(device.loop_.add(Phase::kDevice, [this] { answer(); })),
        listen_due_(device.loop_.add(Phase::kDevice, [this] { listen_again(); })),
        sent_(device.loop_.add(Phase::kDevice, [this] { after_answer(); })),
        silence_(device.loop_.add(Phase::kDevice, [this] {
          tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "cut short, given up");
          decoder_.reset();
        })) {}

  void receive(std::uint8_t byte) override {
    if (device_.booting()) {
      tell(WireEvent::Kind::kLost, std::span(&byte, 1), "came while the drive was starting");
    } else if (busy_) {
      keep_or_lose(byte);
    } else {
      hear(byte);
    }
  }
  void send(std::span<const std::uint8_t> bytes) {
    if (port_ != nullptr) port_->send(bytes);
  }
  /// As after a reset; what was being said is said to its end.
  void restart() {
    decoder_.reset();
    kept_.clear();
    busy_ = false;
    for (Wakeup* wakeup : {&answer_due_, &listen_due_, &sent_, &silence_}) wakeup->cancel();
    axis = 1;
    set_baud(kBootBaud);
  }
  void wait(SimDuration time) {
    busy_ = true;
    listen_due_.at(device_.loop_.now() + time);
  }

  std::uint32_t axis = 1;  // that a line without one means

 private:
  /// Bytes that lenient mode keeps while busy; the longest request a hundred times.
  static constexpr std::size_t kMostKept = 51200;

  void tell(WireEvent::Kind kind, std::span<const std::uint8_t> bytes, std::string_view text) {
    device_.log_.tell(kind, bytes, text);
  }

  void keep_or_lose(std::uint8_t byte) {
    if (device_.options_.lenient && kept_.size() < kMostKept)
      kept_.push_back(byte);
    else
      tell(WireEvent::Kind::kLost, std::span(&byte, 1), "came while a request was handled");
  }

  void hear(std::uint8_t byte) {
    const Decoder::Event event = decoder_.push(byte);
    if (device_.options_.lenient) {
      if (decoder_.idle())
        silence_.cancel();
      else
        silence_.at(device_.loop_.now() + kLenientSilence);
    }
    if (event == Decoder::Event::kNone) return;
    event_ = event;
    busy_ = true;
    answer_due_.at(device_.loop_.now() + device_.options_.latency);
  }

  void answer() {
    Bytes bytes;
    switch (event_) {
      case Decoder::Event::kNone:
        break;
      case Decoder::Event::kLine:
        bytes = answer_line();
        break;
      case Decoder::Event::kPacket:
        bytes = answer_packet();
        break;
      case Decoder::Event::kBadSum:
        tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "wrong sum");
        if (device_.speaker(decoder_.packet().address)) {
          bytes = encode_refusal(Status::kBadSum, device_.options_.format);
          tell(WireEvent::Kind::kReply, bytes, name_of(Status::kBadSum));
        }
        break;
    }
    baud_due_ = std::exchange(device_.baud_due_, std::nullopt);
    reset_due_ = std::exchange(device_.reset_due_, false);
    const SimTime now = device_.loop_.now();
    const SimTime out = bytes.empty() || port_ == nullptr ? now : port_->send(bytes);
    if (baud_due_ || reset_due_) sent_.at(out);
    const auto character = SimDuration(std::int64_t{1'000'000'000} * kBitsPerCharacter / baud_);
    const SimTime room = out - kTransmitBuffer * character;
    if (room > now)
      listen_due_.at(room);
    else
      listen_again();
  }

  Bytes answer_line() {
    const Line& line = decoder_.line();
    tell(line.accepted ? WireEvent::Kind::kRequest : WireEvent::Kind::kBadFrame, decoder_.bytes(),
         device_.log_.has_listener() ? printable(decoder_.bytes()) : std::string());
    Bytes bytes = device_.answer(*this, line);
    tell(WireEvent::Kind::kReply, bytes,
         device_.log_.has_listener() ? printable(bytes) : std::string());
    return bytes;
  }

  Bytes answer_packet() {
    const Packet& packet = decoder_.packet();
    const bool meant = packet.address == kAllModules || device_.is_meant(0, packet.address) ||
                       device_.is_meant(1, packet.address);
    if (!meant) return {};
    const bool good = packet.status == Status::kOk;
    tell(good ? WireEvent::Kind::kRequest : WireEvent::Kind::kBadFrame, decoder_.bytes(),
         device_.log_.has_listener() ? describe(packet) : std::string());
    Bytes bytes = device_.answer(*this, packet);
    if (!bytes.empty()) {
      tell(WireEvent::Kind::kReply, bytes, name_of(static_cast<Status>(bytes[0])));
    }
    return bytes;
  }

  void listen_again() {
    busy_ = false;
    while (!busy_ && !kept_.empty()) {
      const std::uint8_t byte = kept_.front();
      kept_.pop_front();
      hear(byte);
    }
  }

  void after_answer() {
    if (baud_due_) set_baud(*std::exchange(baud_due_, std::nullopt));
    if (std::exchange(reset_due_, false)) device_.restart();
  }

  void set_baud(int baud) {
    if (std::exchange(baud_, baud) != baud && port_ != nullptr) port_->set_baud(baud);
  }

  Device& device_;
  SerialPort* port_;
  Decoder decoder_;
  Decoder::Event event_{};  // that is to be answered
  bool busy_ = false;
  std::deque<std::uint8_t> kept_;
  int baud_ = kBootBaud;
  std::optional<int> baud_due_;
  bool reset_due_ = false;
  Wakeup answer_due_;
  Wakeup listen_due_;
  Wakeup sent_;
  Wakeup silence_;
};

// --- The board -----------------------------------------------------------------------------------

Device::Device(EventLoop& loop, std::span<SerialPort* const> ports, ServoDrive& servo,
               NonVolatileMemory& memory, DeviceOptions options, SimDuration first_boot,
               WireListener listener, NoteListener notes)
    : loop_(loop),
      servo_(servo),
      memory_(memory),
      variables_(servo),
      options_(options),
      notes_(notes),
      log_(loop, std::move(listener), std::move(notes)),
      boot_(loop.add(Phase::kDevice, [this] { ready(); })) {
  for (std::size_t i = 0; i < kConsoles; ++i) {
    consoles_[i] = std::make_unique<Console>(*this, i < ports.size() ? ports[i] : nullptr);
  }
  boot_.at(loop.now() + first_boot);
}

Device::~Device() = default;

SerialReceiver& Device::console(std::size_t number) {
  return *consoles_.at(number);
}

std::uint32_t Device::default_axis(std::size_t console) const {
  return consoles_.at(console)->axis;
}

// RESET: the bit rates are lost (8.2.1), as is all that was not saved.
void Device::restart() {
  servo_.restart({stored_settings(0, memory_, notes_), stored_settings(1, memory_, notes_)});
  for (const auto& console : consoles_) console->restart();
  boot_.at(loop_.now() + options_.boot_time);
}

void Device::ready() {
  constexpr std::uint8_t kSaid[] = {kReady};
  log_.tell(WireEvent::Kind::kReply, kSaid, "ready");
  consoles_.back()->send(kSaid);
  const auto is_absolute = [&](std::size_t axis) {
    return servo_.axis(axis).settings().etype != 0;
  };
  if (!is_absolute(0) && !is_absolute(1)) return;
  for (const auto& console : consoles_) console->wait(kEncoderWait);
}

// --- Packets -------------------------------------------------------------------------------------

bool Device::is_meant(std::size_t axis, std::uint8_t address) const {
  const Settings& settings = servo_.axis(axis).settings();
  return address == kAllModules || settings.address == address ||
         (settings.group != 0 && settings.group == address);
}

std::optional<std::size_t> Device::speaker(std::uint8_t address) const {
  for (std::size_t axis = 0; axis < ServoDrive::kAxes; ++axis) {
    if (servo_.axis(axis).settings().address == address) return axis;
  }
  if (options_.group_master == 0 || address == kAllModules) return std::nullopt;
  const std::size_t master = index_of(options_.group_master);
  return is_meant(master, address) ? std::optional(master) : std::nullopt;
}

Bytes Device::answer(Console&, const Packet& packet) {
  const auto answers = speaker(packet.address);
  if (packet.status != Status::kOk) {
    return answers ? encode_refusal(packet.status, options_.format) : Bytes{};
  }
  const Handler handler = *protocol::find(kHandlers, packet.row->code);
  Bytes bytes;
  for (std::size_t axis = 0; axis < ServoDrive::kAxes; ++axis) {
    if (!is_meant(axis, packet.address)) continue;
    Task task{.packet = packet, .axis = axis};
    const Status status = (this->*handler)(task);
    if (answers != axis) continue;
    if (status != Status::kOk)
      bytes = encode_refusal(status, options_.format);
    else
      bytes =
          task.bytes ? *std::move(task.bytes) : encode_reply(packet, task.reply, options_.format);
  }
  return bytes;
}

Status Device::module_data(Task& task) {
  for (const std::int64_t number : kVersionNumbers) task.reply.push(number);
  return Status::kOk;
}

Status Device::report(Task& task) {
  const ServoAxis& axis = servo_.axis(task.axis);
  // In the order of the mask's bits (B.2). The digital inputs are the axis' own four.
  const std::int64_t fields[] = {axis.position(),       axis.status(),
                                 axis.position_error(), axis.total_current(),
                                 axis.halls(),          axis.digital_inputs() & 0xF,
                                 axis.pvt_depth(),      axis.scan_depth()};
  for (std::size_t i = 0; i < std::size(fields); ++i) {
    if ((task.packet.values[0] >> i & 1) != 0) task.reply.push(fields[i]);
  }
  return Status::kOk;
}

Status Device::call_function(Task& task) {
  return execute(task.axis, *task.packet.function);
}

Status Device::init_pvt(Task& task) {
  const Values& values = task.packet.values;
  const auto watermark =
      values.size() > 1 ? std::optional(static_cast<std::int32_t>(values[1])) : std::nullopt;
  return status_of(
      servo_.axis(task.axis).init_pvt(static_cast<std::int32_t>(values[0]), watermark));
}

Status Device::stream_pvt(Task& task) {
  std::array<PvtPoint, kMostPoints> points{};
  std::size_t count = 0;
  const Values& values = task.packet.values;
  for (std::size_t i = task.packet.counted ? 1 : 0; i + 1 < values.size(); i += 2) {
    points[count++] = {static_cast<std::int32_t>(values[i]),
                       static_cast<std::int32_t>(values[i + 1])};
  }
  return status_of(servo_.axis(task.axis).push_pvt(std::span(points).first(count)));
}

Status Device::set_parameter(Task& task) {
  const Packet& packet = task.packet;
  if (packet.function != nullptr) return execute(task.axis, *packet.function);
  // Addresses are given over RS-232, in lines (8.2.2).
  if (packet.parameter->id == kAddressId) return Status::kInvalidState;
  return write(task.axis, *packet.parameter, packet.values[1]);
}

Status Device::get_parameter(Task& task) {
  const Reading reading = variables_.read(task.axis, *task.packet.parameter);
  task.reply.push(reading.value);
  return reading.status;
}

Status Device::get_trace(Task& task) {
  const auto request = task.packet.values[0];
  const auto buffer = static_cast<std::size_t>(request & 0xF);
  if (buffer >= Recorder::kChannels) return Status::kOutOfRange;
  const bool wide = (request & 0x80) != 0;
  const Recorder& recorder = servo_.recorder();
  std::vector<std::int32_t> samples;
  for (std::size_t i = 0; i < recorder.sample_count(); ++i) {
    samples.push_back(wide ? recorder.value(buffer, i) : recorder.word(buffer, i));
  }
  task.bytes =
      encode_trace(samples, wide ? TraceWidth::kFourBytes : TraceWidth::kTwoBytes, options_.format);
  return Status::kOk;
}

Status Device::set_baud(Task& task) {
  const auto code = static_cast<std::size_t>(task.packet.values[0]);
  if (code >= std::size(kBauds)) return Status::kOutOfRange;
  baud_due_ = kBauds[code];
  return Status::kOk;
}

// --- Functions and variables ---------------------------------------------------------------------

Status Device::execute(std::size_t axis, const CommandRow& function) {
  if (variables_.has_call(function.code)) return variables_.call(axis, function.code);
  if (function.code == kSave) return save(axis);
  if (function.code == kRestore) return restore(axis);
  if (function.code == kReset) reset_due_ = true;
  return Status::kOk;  // PLAY prints in a line only
}

Status Device::write(std::size_t axis, const ParameterRow& row, std::int64_t value) {
  const Status status = variables_.write(axis, row, value);
  if (status == Status::kOk) log_.note_use(row.name, row.support);
  return status;
}

Status Device::save(std::size_t axis) {
  const bool kept = memory_.write(block_name(axis), pack(servo_.axis(axis).saved()));
  return kept ? Status::kOk : Status::kExecution;
}

Status Device::restore(std::size_t axis) {
  return status_of(servo_.axis(axis).restore(stored_settings(axis, memory_, notes_)));
}

// --- Lines ---------------------------------------------------------------------------------------

Bytes Device::answer(Console& console, const Line& line) {
  const bool axis_alone = line.function == nullptr && line.parameter == nullptr;
  std::string text;
  Status status = line.accepted ? Status::kOk : Status::kBadIndex;
  if (line.accepted && axis_alone) {
    if (line.axis != 0) console.axis = line.axis;
  } else if (line.accepted) {
    status = run_line(index_of(line.axis != 0 ? line.axis : console.axis), line, text);
  }
  return encode_reply(text, status == Status::kOk, options_.prompt_axis ? console.axis : 0);
}

// What a line says, for an axis; the answer's text is appended.
Status Device::run_line(std::size_t axis, const Line& line, std::string& text) {
  if (line.function != nullptr) {
    if (line.function->code == kPlay) {
      text = play();
      return Status::kOk;
    }
    if (line.function->code == kGo && line.argument) {
      const Status status =
          write(axis, *protocol::find(kTable.parameters, kTargetId), *line.argument);
      if (status != Status::kOk) return status;
    }
    return execute(axis, *line.function);
  }
  const ParameterRow& row = *line.parameter;
  if (line.argument) return write(axis, row, *line.argument);
  const Reading reading = variables_.read(axis, row);
  if (reading.status == Status::kOk) {
    text = row.id == kVersionId ? std::string(kVersionText) : to_text(row, reading.value);
  }
  return reading.status;
}

// A sample a line, oldest first.
std::string Device::play() const {
  const Recorder& recorder = servo_.recorder();
  std::string text;
  for (std::size_t i = 0; i < recorder.sample_count(); ++i) {
    text += fmt::format("{},{},{},{}\r\n", recorder.value(0, i), recorder.word(1, i),
                        recorder.word(2, i), recorder.word(3, i));
  }
  return text;
}

}  // namespace virtdrive::rzt1
