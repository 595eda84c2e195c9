// A drive with its motors, as a bench sees it: what every emulated controller offers whatever its
// protocol. One entry of the catalogue a drive; a new drive is a new file in drives/.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/event_loop.h"
#include "core/nvm.h"
#include "core/random.h"
#include "core/signals.h"
#include "devices/host_transport.h"
#include "devices/protocol/table.h"
#include "devices/protocol/walk.h"
#include "devices/serial_port.h"
#include "devices/wire_log.h"
#include "plant/axis.h"
#include "plant/motor_library.h"
#include "pty/can_bus.h"
#include "pty/serial_line.h"
#include "scenarios/host_client.h"

namespace virtdrive {

/// What a drive is built from.
struct DriveContext {
  EventLoop& loop;
  std::vector<LineEnd*> ports;  // its transmitters, one a port; null where no line is
  CanNode* can = nullptr;       // its place on a CAN bus; null where none is
  const Seed& seed;
  NonVolatileMemory& memory;
  std::span<const Motor> motors;  // one a channel
  std::optional<DcBus> supply;    // shared with others; none: what the kind of drive hangs on
  Integrator integrator = Integrator::kDefault;
  bool ideal_line = false;  // answers at once
  bool lenient = false;
  WireListener listener;
  NoteListener notes;
};

class Drive {
 public:
  virtual ~Drive() = default;

  /// Its end of the line at one of its ports; deaf while there is no power.
  virtual SerialReceiver& receiver(std::size_t port) = 0;
  virtual Axis& axis(std::size_t channel) = 0;

  /// The controller loses its supply: gates off, the program and all that it had in RAM gone.
  virtual void power_off() = 0;
  /// It starts anew with what its non-volatile memory holds. Begins powered.
  virtual void power_on() = 0;

  /// Adds the firmware's own signals and the board's inputs; the plant's are the bench's.
  virtual void register_signals(Registry& registry) = 0;
  /// "NAME=VALUE" as on the command line, e.g. "MaxAngAcc=800" or "2.IqStart=1200mA"; SetupError if
  /// the name is unknown or the value refused.
  virtual void set_parameter(std::string_view assignment) = 0;

  /// The channels that do something, in one line.
  virtual std::string status() = 0;
  virtual WireCounters wire_counters() const = 0;
};

/// A port of a drive, and the line that it is made for. At a CAN port the line is that of an SLCAN
/// adapter on the bus.
struct PortKind {
  std::string_view name;  // as typed
  int baud;
  Duplex duplex = Duplex::kFull;
  Parity parity = Parity::kNone;
  bool can = false;
  std::string_view protocol = {};  // what it speaks; empty: the first port the drive's own, others
                                   // bytes without frames
};

/// An entry of the catalogue.
struct DriveKind {
  std::string_view name;  // as typed: "toshiba-mcu"
  std::string_view default_motor;
  std::vector<PortKind> ports;  // the first one is that of the host
  std::size_t channels;         // motors that it drives
  std::size_t default_channel;  // the motor number of the document's examples
  const protocol::ProtocolTable& table;
  /// The rows of all models that speak it, where `table` is one model's; null: `table` is all.
  const protocol::ProtocolTable* protocol = nullptr;
  std::function<std::unique_ptr<Drive>(const DriveContext&)> make;
  std::function<std::unique_ptr<HostClient>(std::unique_ptr<HostTransport>)> make_host;
  /// What checks a drive against its table, empty if nothing does; the channel that its requests
  /// name, and how long an answer may take.
  std::function<std::unique_ptr<protocol::Dialect>()> make_dialect = {};
  std::uint8_t checked_channel = 1;
  SimDuration checked_patience = std::chrono::milliseconds(500);
};

const std::vector<DriveKind>& drive_catalogue();
/// SetupError with the nearest names for an unknown one.
const DriveKind& find_drive(std::string_view name);
/// The drive of this name, or else the first one that speaks the protocol of this name.
const DriveKind& find_protocol(std::string_view name);

}  // namespace virtdrive
