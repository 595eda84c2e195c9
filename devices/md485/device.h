// A controller on its line: frames in, frames out, around the program of firmware_models/md.
//
// It is silent by default: a command or a write is answered only as RETURN_TYPE (149) asks for it,
// a request for something it has not never. It takes frames for its own ID and for 254. A frame
// acts when the ones before it are done with; the answer leaves 2 ms after the request, where the
// request came from: RS-485, TTL232 or CAN.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "core/event_loop.h"
#include "devices/md485/codec.h"
#include "devices/md485/model_table.h"
#include "devices/md485/parameters.h"
#include "devices/md485/port.h"
#include "devices/serial_port.h"
#include "devices/wire_log.h"
#include "firmware_models/md/controller.h"

namespace virtdrive::md485 {

struct DeviceOptions {
  /// From a request's last bit to the first of its answer. Hosts of today expect 1 .. 5 ms
  /// (assumed).
  SimDuration latency = std::chrono::milliseconds(2);
  /// Between two frames of one broadcast (assumed).
  SimDuration broadcast_period = std::chrono::milliseconds(100);
};

class Device final : public SerialReceiver {
 public:
  Device(EventLoop& loop, SerialPort& port, md::Controller& controller, const ModelTable& table,
         NonVolatileMemory& memory, DeviceOptions options, WireListener listener = nullptr,
         NoteListener notes = nullptr);

  /// At RS-485.
  void receive(std::uint8_t byte) override { rs485_.receive(byte); }
  /// Its receiver at another serial port, or on a CAN bus; both live as long as the device.
  SerialReceiver& add_serial(SerialPort& port);
  CanReceiver& add_can(CanPort& port);
  const WireCounters& counters() const { return log_.counters(); }
  Parameters& parameters() { return parameters_; }
  std::uint8_t id() const { return static_cast<std::uint8_t>(controller_.settings().id); }

  /// A handler reads the request's values; what it says and how long it takes it leaves in answer()
  /// and take().
  using Handler = void (Device::*)(const protocol::Values& request);
  using NumberHandler = void (Device::*)();

  void default_set(const protocol::Values& request);
  void request_data(const protocol::Values& request);
  void free_all(const protocol::Values& request);
  void brake_all(const protocol::Values& request);
  void command_number(const protocol::Values& request);
  void reset_alarms(const protocol::Values& request);
  void reset_positions(const protocol::Values& request);
  void main_broadcast(const protocol::Values& request);
  void monitor_broadcast(const protocol::Values& request);
  void save_preset(const protocol::Values& request);
  void recall_preset(const protocol::Values& request);
  void start_stop(const protocol::Values& request);
  void velocity(const protocol::Values& request);
  void velocity2(const protocol::Values& request);
  void open_loop(const protocol::Values& request);
  void torque(const protocol::Values& request);
  void pnt_free(const protocol::Values& request);
  void pnt_brake(const protocol::Values& request);
  void function_signal(const protocol::Values& request);
  void pnt_move(const protocol::Values& request);
  void pnt_velocity(const protocol::Values& request);
  void pnt_open_loop(const protocol::Values& request);
  void pnt_torque(const protocol::Values& request);
  void pnt_increment(const protocol::Values& request);
  void set_position(const protocol::Values& request);
  void set_position2(const protocol::Values& request);
  void move(const protocol::Values& request);
  void increment(const protocol::Values& request);
  void pnt_increment_at(const protocol::Values& request);
  void move_default(const protocol::Values& request);
  void increment_default(const protocol::Values& request);
  void pnt_move_default(const protocol::Values& request);
  void increment_default2(const protocol::Values& request);

  template <std::uint8_t kPid, bool kOn>
  void broadcast() {
    set_broadcast(kPid, kOn);
  }
  template <bool kOn>
  void fan() {
    controller_.set_fan(kOn);
  }
  template <bool kOn>
  void clutch() {
    controller_.set_clutch(kOn);
  }
  template <bool kFrames>
  void let_drive() {
    controller_.let_frames_drive(kFrames);
  }
  /// Puts settings back to the model's default, or to 0.
  template <std::int32_t md::Settings::*... kMembers>
  void clear() {
    md::Settings settings = controller_.settings();
    ((settings.*kMembers = 0), ...);
    change(settings);
  }
  template <std::int32_t md::Settings::* kMember>
  void to_default() {
    md::Settings settings = controller_.settings();
    settings.*kMember = md::default_settings(controller_.model()).*kMember;
    change(settings);
  }
  void free_all_now();
  void brake_all_now();
  void reset_alarms_now() { controller_.reset_alarms(); }
  void reset_positions_now();
  void clear_curve();
  template <bool kOn>
  void resend_can() {
    resend_to_ = kOn ? std::optional(current_.frame.route.host) : std::nullopt;
    if (!kOn) heard_on_can_.clear();
  }

 private:
  static constexpr std::size_t kMostQueued = 16;  // frames that wait for those before them
  static constexpr std::size_t kMostHeard = 64;   // of CAN, that wait for RS-485

  struct Request {
    Frame frame = {};
    Port* from = nullptr;
  };
  /// PID (and index) to be sent when it is due.
  struct Reply {
    Route route;
    std::uint8_t pid = 0;
    std::uint8_t index = 1;
    Port* port = nullptr;
  };
  struct Broadcast {
    std::uint8_t pid;
    Port* port = nullptr;  // none: off
    std::uint8_t host = 0;
    SimTime due = kNever;
  };

  Port::Taker taker();
  void take(Port& from, const Frame& frame, std::span<const std::uint8_t> bytes);
  void work();
  void act(const Frame& frame);
  void hear_on_can(const CanFrame& frame);
  void resend();
  void act_on_command(const CommandRow& row);
  void answer(std::uint8_t pid, std::uint8_t index = 1);
  void answer_by_return_type();
  void return_pnt(std::int64_t type);
  void send(const Reply& reply);
  void send_acknowledge(const Reply& reply);
  void change(const md::Settings& settings);
  void set_broadcast(std::uint8_t pid, bool on);
  void broadcast_due();
  void schedule_broadcasts();

  /// Calls move(motor channel, 0 or 1 for the half of the frame) for each half that is meant.
  template <class Move>
  void for_halves(std::int64_t enable1, std::int64_t enable2, Move&& move);
  template <class Move>
  void for_meant(std::int64_t enable1, std::int64_t enable2, Move&& move);
  bool is_dual() const { return controller_.motors() > 1; }

  EventLoop& loop_;
  md::Controller& controller_;
  const ModelTable& table_;
  Parameters parameters_;
  DeviceOptions options_;
  WireLog log_;

  UartPort rs485_;
  std::vector<std::unique_ptr<UartPort>> other_uarts_;
  std::unique_ptr<CanBusPort> can_;
  std::deque<Request> queue_;
  Request current_;  // that is acted on
  std::optional<Reply> reply_;
  SimDuration takes_{};  // what the current frame keeps the program busy with
  std::array<Broadcast, 7> broadcasts_{{{193}, {194}, {196}, {200}, {202}, {201}, {210}}};
  std::optional<std::uint8_t> resend_to_;  // CMD 23's host
  std::deque<CanFrame> heard_on_can_;
  Wakeup work_;
  Wakeup broadcast_;
};

}  // namespace virtdrive::md485
