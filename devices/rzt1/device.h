// The board on its serial lines: three consoles, each with a receiver, a default axis and a bit
// rate of its own, around one servo firmware.
//
// A request is a line of text or a packet, told apart by its first byte. It acts, and is answered,
// so long after its last byte; what comes in the meantime is lost. A packet that was cut short
// waits for its missing bytes for ever.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "core/nvm.h"
#include "devices/rzt1/codec.h"
#include "devices/rzt1/variables.h"
#include "devices/serial_port.h"
#include "devices/wire_log.h"
#include "firmware_models/rzt1/servo_drive.h"

namespace virtdrive::rzt1 {

struct DeviceOptions {
  /// From a request's last bit to when it acts and its answer begins: a pass of the foreground loop
  /// (assumed).
  SimDuration latency = std::chrono::microseconds(100);
  /// From a reset to the R on console 2 (assumed); until then the board is deaf.
  SimDuration boot_time = std::chrono::milliseconds(100);
  /// Forgives a host what the drive does not: bytes that come while a request is handled are kept,
  /// and a packet or line that was cut short is given up after 100 ms of silence.
  bool lenient = false;

  ReplyFormat format;
  bool prompt_axis = false;        // the axis before the prompt, as a related public firmware does
  std::uint32_t group_master = 0;  // axis that answers for its group, 1 or 2; 0: none does
};

/// What SAVE kept of an axis; the factory's where nothing was, or where it is damaged (told in a
/// note).
Settings stored_settings(std::size_t axis, NonVolatileMemory& memory, const NoteListener& notes);

class Device {
 public:
  /// `ports`: of consoles 0, 1 and 2; null where no line is. `first_boot` is how long the first
  /// start takes. The servo has its settings already.
  Device(EventLoop& loop, std::span<SerialPort* const> ports, ServoDrive& servo,
         NonVolatileMemory& memory, DeviceOptions options, SimDuration first_boot,
         WireListener listener = nullptr, NoteListener notes = nullptr);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  SerialReceiver& console(std::size_t number);
  const WireCounters& counters() const { return log_.counters(); }
  Variables& variables() { return variables_; }
  const DeviceOptions& options() const { return options_; }
  void set_options(const DeviceOptions& options) { options_ = options; }
  /// Axis (1 or 2) that a line without one means.
  std::uint32_t default_axis(std::size_t console) const;

  /// What a packet is about while it is handled, once for each axis that is addressed.
  struct Task {
    const Packet& packet;
    std::size_t axis;
    protocol::Values reply = {};
    std::optional<std::vector<std::uint8_t>> bytes = {};  // in place of `reply`
  };
  using Handler = Status (Device::*)(Task& task);

  Status module_data(Task& task);
  Status report(Task& task);
  Status call_function(Task& task);
  Status init_pvt(Task& task);
  Status stream_pvt(Task& task);
  Status set_parameter(Task& task);
  Status get_parameter(Task& task);
  Status get_trace(Task& task);
  Status set_baud(Task& task);

 private:
  class Console;

  std::vector<std::uint8_t> answer(Console& console, const Packet& packet);
  std::vector<std::uint8_t> answer(Console& console, const Line& line);
  /// The axis that answers for this address; nothing: none does.
  std::optional<std::size_t> speaker(std::uint8_t address) const;
  bool is_meant(std::size_t axis, std::uint8_t address) const;
  Status execute(std::size_t axis, const CommandRow& function);
  Status write(std::size_t axis, const ParameterRow& row, std::int64_t value);
  Status run_line(std::size_t axis, const Line& line, std::string& text);
  std::string play() const;
  Status save(std::size_t axis);
  Status restore(std::size_t axis);
  void restart();
  void ready();
  bool booting() const { return boot_.due() != kNever; }

  EventLoop& loop_;
  ServoDrive& servo_;
  NonVolatileMemory& memory_;
  Variables variables_;
  DeviceOptions options_;
  NoteListener notes_;
  WireLog log_;
  std::array<std::unique_ptr<Console>, kConsoles> consoles_;
  Wakeup boot_;
  // What waits for the end of the answer.
  bool reset_due_ = false;
  std::optional<int> baud_due_;
};

}  // namespace virtdrive::rzt1
