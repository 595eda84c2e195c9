// The drive on its serial line: telegrams in, telegrams out, around the firmware model.
//
// It answers as the firmware does: strictly one request at a time, deaf from a request's last byte
// until the answer's last bit is out, silent at unknown commands and wrong end bytes, waiting for
// ever for the rest of a telegram that was cut short.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/event_loop.h"
#include "devices/serial_port.h"
#include "devices/toshiba_mcu/codec.h"
#include "devices/toshiba_mcu/high_speed_stream.h"
#include "devices/toshiba_mcu/parameters.h"
#include "devices/wire_log.h"
#include "firmware_models/toshiba_mcu/firmware.h"

namespace virtdrive::toshiba_mcu {

struct DeviceOptions {
  /// From a request's last bit to the first bit of the answer. The maker's firmware answers within
  /// one turn of its 1 kHz loop: 1 ms (assumed).
  SimDuration latency = std::chrono::milliseconds(1);
  /// Forgives a host what the drive does not: bytes that come while the drive is busy are kept, and
  /// a telegram that was cut short is given up after 100 ms of silence.
  bool lenient = false;
};

class Device final : public SerialReceiver {
 public:
  /// Begins as after a reset: with the settings that `memory` holds. `stream_port` is the second
  /// serial line, 5 Mbit/s, on which ConfigureHsDSO streams; with none the stream leaves on pins
  /// where nobody listens.
  Device(EventLoop& loop, SerialPort& port, Firmware& firmware, NonVolatileMemory& memory,
         DeviceOptions options, WireListener listener = nullptr, NoteListener notes = nullptr,
         SerialPort* stream_port = nullptr);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device() override;

  void receive(std::uint8_t byte) override;
  const WireCounters& counters() const { return log_.counters(); }
  Parameters& parameters() { return parameters_; }
  /// What the second line carried; null without one.
  const HighSpeedStream* stream() const { return stream_ ? &*stream_ : nullptr; }

  /// A handler reads the request's values and appends the reply's. Those of a motor get its board:
  /// a request for a motor that is not there is refused before.
  using Handler = Outcome (Device::*)(const protocol::Values& request, protocol::Values& reply);
  using MotorHandler = Outcome (Device::*)(PowerBoard& board, const protocol::Values& request,
                                           protocol::Values& reply);

  Outcome start_motor(PowerBoard& board, const protocol::Values& request, protocol::Values& reply);
  Outcome stop_motor(PowerBoard& board, const protocol::Values& request, protocol::Values& reply);
  Outcome motor_state(PowerBoard& board, const protocol::Values& request, protocol::Values& reply);
  Outcome start_torque_control(PowerBoard& board, const protocol::Values& request,
                               protocol::Values& reply);
  Outcome set_control_method(PowerBoard& board, const protocol::Values& request,
                             protocol::Values& reply);
  Outcome control_method(PowerBoard& board, const protocol::Values& request,
                         protocol::Values& reply);
  Outcome extended_state(PowerBoard& board, const protocol::Values& request,
                         protocol::Values& reply);
  Outcome configure_snapshot(PowerBoard& board, const protocol::Values& request,
                             protocol::Values& reply);
  Outcome configure_stream(PowerBoard& board, const protocol::Values& request,
                           protocol::Values& reply);
  Outcome do_turn(PowerBoard& board, const protocol::Values& request, protocol::Values& reply);
  Outcome do_linear_motion(PowerBoard& board, const protocol::Values& request,
                           protocol::Values& reply);
  Outcome absolute_position(PowerBoard& board, const protocol::Values& request,
                            protocol::Values& reply);
  Outcome abort_linear_motion(PowerBoard& board, const protocol::Values& request,
                              protocol::Values& reply);
  Outcome encoder_counter(PowerBoard& board, const protocol::Values& request,
                          protocol::Values& reply);

  Outcome store_parameters(const protocol::Values& request, protocol::Values& reply);
  Outcome clear_parameters(const protocol::Values& request, protocol::Values& reply);
  Outcome get_one(const protocol::Values& request, protocol::Values& reply);
  Outcome set_one(const protocol::Values& request, protocol::Values& reply);
  Outcome get_many(const protocol::Values& request, protocol::Values& reply);
  Outcome set_many(const protocol::Values& request, protocol::Values& reply);
  Outcome version(const protocol::Values& request, protocol::Values& reply);
  Outcome snapshot_data(const protocol::Values& request, protocol::Values& reply);
  Outcome set_demo_state(const protocol::Values& request, protocol::Values& reply);
  Outcome demo_state(const protocol::Values& request, protocol::Values& reply);

 private:
  /// Bytes that lenient mode keeps while busy; a hundred of the longest requests.
  static constexpr std::size_t kMostKept = 5400;

  void hear(std::uint8_t byte);
  void keep_or_lose(std::uint8_t byte);
  void answer();
  void answer_request();
  Outcome handle(const Telegram& request, protocol::Values& reply);
  void send(const std::vector<std::uint8_t>& bytes, std::string_view text);
  void listen_again();
  Outcome write(std::uint8_t motor_nr, std::uint8_t id, UnitValue value);
  PowerBoard* board(std::int64_t motor_nr);

  EventLoop& loop_;
  SerialPort& port_;
  Firmware& firmware_;
  Parameters parameters_;
  DeviceOptions options_;
  WireLog log_;
  std::optional<HighSpeedStream> stream_;

  Decoder decoder_{Direction::kRequest};
  bool busy_ = false;
  bool crc_fits_ = true;           // of the telegram to be answered
  std::deque<std::uint8_t> kept_;  // heard while busy: one byte, or all of them when lenient
  Wakeup answer_due_;
  Wakeup answer_out_;
  Wakeup silence_;
};

}  // namespace virtdrive::toshiba_mcu
